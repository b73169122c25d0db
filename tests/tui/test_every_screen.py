"""What every screen and dialog holds, whichever it is: it fits, its fields keep their letters, and
the way out and STOP are the same everywhere."""

from collections.abc import AsyncIterator, Callable
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
from solarcal.tui.calculators.list import open_calculator
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
async def on_a_line(size, station, *keys, words=()):
    """Those keys pressed one after the other on the workstation, each on what the one before
    opened."""
    async with workstation(station, size) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK")
        if station.session.accepted:
            await until(pilot, lambda: app.judgement is not None)
        for key in keys:
            await pilot.press(key)
            await settled_text(pilot, 3)
        await shows(pilot, *words)
        yield app, pilot


@asynccontextmanager
async def calculating(size, instrument):
    app = SolarcalApp()
    async with app.run_test(size=size) as pilot:
        open_calculator(app, instrument)
        await settled_text(pilot, 3)
        yield app, pilot


@asynccontextmanager
async def by_hand(size, *keys):
    async with workstation_by_hand(size, 1) as (app, pilot, _, _):
        for key in keys:
            await pilot.press(key)
            await settled_text(pilot, 3)
        yield app, pilot


@asynccontextmanager
async def starting(size, *keys):
    app = SolarcalApp()
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "Emulated trackers")
        for key in keys:
            await pilot.press(key)
        await settled_text(pilot, 3)
        yield app, pilot


@asynccontextmanager
async def replaying(size, path, *keys):
    app = SolarcalApp(start=Choice(replay=str(path)))
    async with app.run_test(size=size) as pilot:
        await shows(pilot, "REPLAY")
        for key in keys:
            await pilot.press(key)
        await settled_text(pilot, 3)
        yield app, pilot


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
NAMES = [
    *LIVE, *BY_HAND, "start", "start-address", "profile", "replay", "jump",
    *(f"calculator-{one.id}" for one in INSTRUMENTS),
]  # fmt: skip


@asynccontextmanager
async def opened(name, size, recorded):
    station, path = recorded
    by_id: dict[str, Callable[[], object]] = {
        f"calculator-{one.id}": lambda one=one: calculating(size, one) for one in INSTRUMENTS
    }
    others = {
        "start": lambda: starting(size),
        "start-address": lambda: starting(size, "a"),
        "profile": lambda: starting(size, "e"),
        "replay": lambda: replaying(size, path),
        "jump": lambda: replaying(size, path, "j"),
        **by_id,
    }
    if name in LIVE:
        way = on_a_line(size, station, *LIVE[name])
    elif name in BY_HAND:
        way = by_hand(size, *BY_HAND[name])
    else:
        way = others[name]()
    async with way as (app, pilot):
        yield app, pilot


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


@pytest.mark.parametrize("name", NAMES)
async def test_it_fits_80x24_its_fields_keep_their_letters_and_the_way_out_is_the_same(
    name, recorded, monkeypatch
):
    """Every widget is seen whole, or lies in what scrolls by keys; a letter typed in a field opens,
    moves and stops nothing; F12 and Ctrl+S stop and Ctrl+Q leaves, with a field focused too."""
    async with opened(name, SMALL, recorded) as (app, pilot):
        screen, text = app.screen, await settled_text(pilot, 3)
        assert list(clipped(app)) == []
        assert "STOP" in text
        assert all(len(line) <= SMALL[0] for line in text.split("\n"))
        if isinstance(screen, Dialog):
            assert "Esc" in text
            assert screen.query_one("#keys").region.bottom <= SMALL[1]
        performed = watched(app, monkeypatch)
        fields = [field for field in screen.query(Input) if field.focusable]
        for number, field in enumerate(fields):
            screen.set_focus(field)
            await pilot.press(*(LETTERS if not number else ("s", "x")))
            assert app.screen is screen
            assert app.focused is field
            if field.type == "text" and field.restrict is None and not field.max_length:
                assert field.value.endswith("x")
        assert performed == []
        for focused in [None, *fields[:1]]:
            screen.set_focus(focused)
            await pilot.press("f12", "ctrl+s", "ctrl+q")
            assert performed == ["stop", "stop", "quit"]
            performed.clear()
