"""What every screen and dialog holds, whichever it is: it fits, its fields keep their letters, and
the way out and STOP are the same everywhere."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from procedure_bench import (
    SMALL,
    bench,
    settled_text,
    shows,
    take_points,
    until,
    upload_and_check,
    workstation,
)
from textual.containers import ScrollableContainer
from textual.scroll_view import ScrollView
from textual.widget import Widget
from textual.widgets import Input, Static
from typed_screens import workstation_by_hand

from solarcal.config import Choice
from solarcal.instruments.catalogue import INSTRUMENTS
from solarcal.tui.app import SolarcalApp
from solarcal.tui.calculators import open_calculator
from solarcal.tui.dialogs.dialog import Dialog
from solarcal.tui.keys import ACTIONS
from solarcal.tui.widgets.lines import HeadLine
from solarcal.tui.workstation.screen import WorkstationScreen

LETTERS = (
    *sorted(key for action in ACTIONS for key in action.keys if len(key) == 1),
    "question_mark", "full_stop", "plus", "minus", "1", "x",
)  # fmt: skip


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A day that has everything in it: points, an upload, check points."""
    path = tmp_path_factory.mktemp("day") / "calibration.jsonl"
    station, _ = bench(path, start="2026-06-03T14:00:00Z")
    take_points(station, 7, 45.0)
    upload_and_check(station, 2)
    return station, path


@asynccontextmanager
async def on_a_line(size, station):
    """The workstation, and how each screen is opened on it: by keys, one after the other."""
    async with workstation(station, size) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK")
        await until(pilot, lambda: app.judgement is not None)

        async def open_screen(name):
            await pressed(pilot, *LIVE[name])

        yield app, pilot, open_screen


@asynccontextmanager
async def calculating(size, _):
    app = SolarcalApp()
    by_name = {f"calculator-{one.id}": one for one in INSTRUMENTS}
    async with app.run_test(size=size) as pilot:

        async def open_screen(name):
            open_calculator(app, by_name[name])
            await settled_text(pilot, 3)

        yield app, pilot, open_screen


@asynccontextmanager
async def by_hand(size, _):
    async with workstation_by_hand(size, 1) as (app, pilot, _, _):

        async def open_screen(name):
            await pressed(pilot, *BY_HAND[name])

        yield app, pilot, open_screen


@asynccontextmanager
async def starting(size, _):
    app = SolarcalApp()
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "Emulated trackers")

        async def open_screen(name):
            await pressed(pilot, *STARTING[name])

        yield app, pilot, open_screen


@asynccontextmanager
async def replaying(size, path):
    app = SolarcalApp(start=Choice(replay=str(path)))
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "REPLAY")

        async def open_screen(name):
            await pressed(pilot, *REPLAYING[name])

        yield app, pilot, open_screen


async def pressed(pilot, *keys):
    """Each on what the one before opened."""
    for key in keys:
        await pilot.press(key)
        await settled_text(pilot, 3)


LIVE = {
    "workstation-now": (), "workstation-points": ("2",), "workstation-coefficients": ("3",),
    "workstation-plot": ("4",), "workstation-checks": ("5",), "link": ("f2",),
    "initialise": ("f3",), "plan": ("f4",), "ref-check": ("f5",), "sun-offset": ("f6",),
    "sun-offset-digits": ("f6", "B"), "check-or-data-point": ("f7",), "upload": ("f8",),
    "recompute": ("f9",), "clock": ("f10",), "calculators": ("f11",), "help": ("f1",),
    "report": ("e",), "before-and-after": ("e", "v"), "void": ("x",), "void-reason": ("x", "enter"),
    "note": ("n",), "point": ("2", "up", "enter"), "point-reason": ("2", "up", "enter", "x"),
}  # fmt: skip
BY_HAND = {
    "by-hand": (), "by-hand-offset": ("f6",), "by-hand-offset-form": ("f6", "enter"),
    "by-hand-ref-check": ("f5",), "by-hand-ref-check-form": ("f5", "enter"),
    "by-hand-clock": ("f10",), "by-hand-link": ("f2",),
}  # fmt: skip
STARTING = {"start": (), "start-address": ("a",), "profile": ("e",)}
REPLAYING = {"replay": (), "jump": ("j",)}
WAYS = {
    "on a line": (on_a_line, LIVE), "by hand": (by_hand, BY_HAND), "start": (starting, STARTING),
    "replay": (replaying, REPLAYING),
    "calculators": (calculating, [f"calculator-{one.id}" for one in INSTRUMENTS]),
}  # fmt: skip


def scrolls(widget: Widget) -> bool:
    return isinstance(widget, ScrollView | ScrollableContainer) and widget.max_scroll_y >= 0


def clipped(app) -> AsyncIterator[str]:
    """What is not seen whole and cannot be scrolled to."""
    screen = app.screen
    for widget in screen.walk_children(Widget):
        if not widget.display or not widget.size or widget.has_class("-textual-system"):
            continue
        if any(not up.display for up in widget.ancestors if isinstance(up, Widget)):
            continue
        within = [up for up in widget.ancestors if isinstance(up, Widget) and scrolls(up)]
        at = screen.find_widget(widget)
        region, seen = at.region, at.visible_region
        cut = not seen.contains_region(region) or not screen.region.contains_region(region)
        if cut and not [up for up in within if up is not screen]:
            yield f"{widget!r} at {region} is seen in {seen} only"
        if isinstance(widget, Static) and not isinstance(widget, HeadLine) and not within:
            width = widget.content_size.width
            needs = widget.get_content_height(widget.size, screen.size, width) if width else 0
            if needs > widget.content_size.height and widget.styles.text_wrap != "nowrap":
                yield f"{widget!r} needs {needs} rows and has {widget.content_size.height}"


def watched(app, monkeypatch):
    """The actions asked for from now on, none of them done."""
    performed: list[str] = []

    def perform(action_id: str) -> None:
        performed.append(action_id)

    monkeypatch.setattr(app, "action_perform", perform)
    return performed


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
async def test_it_fits_80x24_its_fields_keep_their_letters_and_the_way_out_is_the_same(
    way, recorded, monkeypatch
):
    """Every widget is seen whole, or lies in what scrolls by keys; a letter typed in a field opens,
    moves and stops nothing; F12 and Ctrl+S stop and Ctrl+Q leaves, with a field focused too."""
    station, path = recorded
    opener, names = WAYS[way]
    async with opener(SMALL, station if way == "on a line" else path) as (app, pilot, open_screen):
        below, kinds, alike = len(app.screen_stack), set(), set()
        for name in names:
            with monkeypatch.context() as patched:
                await open_screen(name)
                # The calculators are one screen with other fields: every letter in one of them.
                letters = ("s", "x") if type(app.screen) in kinds else LETTERS
                kinds.add(type(app.screen))
                await as_every_screen(app, pilot, name, letters, alike, patched)
            while len(app.screen_stack) > below:
                await app.pop_screen()
            app.set_focus(None)


async def as_every_screen(app, pilot, name, letters, alike, monkeypatch):
    """``alike``: the fields tried so far. The first of each screen, and of those which differ in
    nothing but their names the first of each kind of screen, is typed into."""
    screen, text = app.screen, await settled_text(pilot, 3)
    assert list(clipped(app)) == [], name
    assert "STOP" in text, name
    assert all(len(line) <= SMALL[0] for line in text.split("\n")), name
    if isinstance(screen, Dialog):
        assert "Esc" in text, name
        assert screen.query_one("#keys").region.bottom <= SMALL[1], name
    performed = watched(app, monkeypatch)
    fields = [field for field in screen.query(Input) if field.focusable]
    for number, field in enumerate(fields):
        kind = (type(screen), type(field), field.type, field.restrict, field.max_length)
        if number and kind in alike:
            continue
        alike.add(kind)
        screen.set_focus(field)
        await pilot.press(*(letters if not number else ("s", "x")))
        assert app.screen is screen, name
        assert app.focused is field, name
        if field.type == "text" and field.restrict is None and not field.max_length:
            assert field.value.endswith("x"), name
    assert performed == [], name
    for focused in [None, *fields[:1]]:
        screen.set_focus(focused)
        await pilot.press("f12", "ctrl+s", "ctrl+q")
        assert performed == ["stop", "stop", "quit"], name
        performed.clear()
