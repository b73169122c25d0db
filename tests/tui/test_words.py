"""Words said again cost nothing; the screen is laid out anew only for more rows or fewer."""

from textual.app import App
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import Static

from solarcal.tui.widgets.lines import Words


class Page(App):
    CSS = "#above { height: auto; } #fixed { height: 2; }"

    def compose(self):
        with Vertical(id="all"):
            yield Words("one", id="above", markup=False)
            yield Words("", id="fixed", markup=False)
            yield Static("below", id="below")

    def on_mount(self):
        self.layouts = 0
        self.screen.screen_layout_refresh_signal.subscribe(self, self.laid_out)

    def laid_out(self, screen):
        self.layouts += 1


def shown(app):
    return [
        "".join(segment.text for segment in strip).rstrip()
        for strip in app.screen._compositor.render_strips()
    ]


async def test_as_many_rows_are_drawn_without_laying_out():
    async with Page().run_test(size=(20, 6)) as pilot:
        await pilot.pause()
        before = pilot.app.layouts
        pilot.app.query_one("#above").update("two")
        await pilot.pause()
        assert shown(pilot.app)[:4] == ["two", "", "", "below"]
        assert pilot.app.layouts == before


async def test_more_rows_push_down_what_is_below_and_fewer_let_it_up():
    async with Page().run_test(size=(20, 6)) as pilot:
        await pilot.pause()
        pilot.app.query_one("#above").update("more words than one row holds")
        await pilot.pause()
        assert shown(pilot.app)[:5] == ["more words than one", "row holds", "", "", "below"]
        pilot.app.query_one("#above").update("few")
        await pilot.pause()
        assert shown(pilot.app)[:4] == ["few", "", "", "below"]


async def test_a_fixed_height_is_never_laid_out_anew():
    async with Page().run_test(size=(20, 6)) as pilot:
        await pilot.pause()
        before = pilot.app.layouts
        pilot.app.query_one("#fixed").update("a\nb\nc\nd")
        await pilot.pause()
        assert shown(pilot.app)[:4] == ["one", "a", "b", "below"]
        assert pilot.app.layouts == before


async def test_the_same_words_are_not_drawn_again_and_other_colours_are():
    async with Page().run_test(size=(20, 6)) as pilot:
        words = pilot.app.query_one("#above")
        words.update(Content.assemble(("warm", "bold")))
        await pilot.pause()
        visual = words.visual
        words.update(Content.assemble(("warm", "bold")))
        assert words.visual is visual
        words.update(Content.assemble(("warm", "italic")))
        assert words.visual is not visual


async def test_said_while_hidden_it_has_its_rows_when_shown():
    async with Page().run_test(size=(20, 6)) as pilot:
        await pilot.pause()
        everything = pilot.app.query_one("#all")
        everything.display = False
        await pilot.pause()
        pilot.app.query_one("#above").update("more words than one row holds")
        await pilot.pause()
        everything.display = True
        await pilot.pause()
        assert shown(pilot.app)[:5] == ["more words than one", "row holds", "", "", "below"]
