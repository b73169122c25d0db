"""Lines of text that fold to the width of their pane."""

from procedure_bench import on_loop, screen_text
from textual.app import App, ComposeResult

from solarcal.tui.widgets.text_lines import TextLines


class Pane(App[None]):
    def compose(self) -> ComposeResult:
        yield TextLines(wrap=True)


@on_loop
async def test_a_folded_line_ends_before_the_scrollbar_the_first_time_too() -> None:
    async with Pane().run_test(size=(20, 4)) as pilot:
        pane = pilot.app.query_one(TextLines)
        pane.show(["short"])
        await pilot.pause()
        # The second word would fit the pane, and not what the scrollbar leaves of it.
        pane.show(["first line number 20"] * 5)
        await pilot.pause()
        assert pane.show_vertical_scrollbar
        assert max(map(len, pane.lines)) <= pane.scrollable_content_region.width


@on_loop
async def test_the_mark_of_what_follows_covers_no_words() -> None:
    async with Pane().run_test(size=(20, 3)) as pilot:
        pane = pilot.app.query_one(TextLines)
        pane.show(["1", "2", "a line of 19 cells", "4"])
        await pilot.pause()
        assert screen_text(pilot.app).split("\n")[2].strip(" ▁▂▃▄▅▆▇█") == "▼ 2 more"
        pane.show(["1", "2", "three", "4"])
        await pilot.pause()
        assert screen_text(pilot.app).split("\n")[2].startswith("three")
        assert "▼ 1 more" in screen_text(pilot.app)


@on_loop
async def test_a_bullet_that_is_folded_hangs() -> None:
    async with Pane().run_test(size=(20, 4)) as pilot:
        pane = pilot.app.query_one(TextLines)
        pane.show(["- a reason of more than one row"])
        await pilot.pause()
        assert pane.lines == ("- a reason of more", "  than one row")
