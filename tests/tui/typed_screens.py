"""The workstation on a unit by hand, whose display shows what a unit that obeys its law would."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from procedure_bench import plain_start, until
from textual.pilot import Pilot
from textual.widgets import Input

from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.profiles import MountDescription
from solarcal.session.journal import Journal
from solarcal.site import Site
from solarcal.station.described_unit import TypedControllerModel, unit_parameters, unit_site
from solarcal.station.procedure import Station
from solarcal.station.typed.forms import DisplayForm, TypedAnswer, WaitingDisplay
from solarcal.station.typed.unit import TypedUnit
from solarcal.timescale import parse_utc
from solarcal.tui.app import SolarcalApp
from solarcal.tui.base import FormAsked, Told
from solarcal.tui.widgets.lines import Field
from solarcal.tui.workstation.screen import WorkstationScreen

NOON = parse_utc("2026-06-03T17:00:00Z")
SITE = Site(35.05, -106.48, 1830.0)
MOUNT = MountDescription(
    unit_name="4711",
    drive1="rotary:1000",
    drive2="rotary:1000",
    limits1_deg=(-128.0, 128.0),
    limits2_deg=(2.0, 88.0),
    reference1_deg=118.0,
    zone_west_h=7.0,
)
BELIEFS = TypedControllerModel(unit_site(MOUNT, SITE), unit_parameters(MOUNT, SITE))
TRUTH = Coefficients(0.2817, -0.35, 0.5298, 0.22, 0.0008, -0.0006)


class TestClock:
    """Stands until a test moves it."""

    __test__ = False

    def __init__(self) -> None:
        self.now_s = NOON

    def utc_s(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        self.now_s += seconds


class Reader:
    """Reads the display by itself until it is told to leave that to the screen."""

    def __init__(self, screen: WaitingDisplay, clock: TestClock) -> None:
        self.screen = screen
        self.clock = clock
        self.by_itself = True

    def ask(self, form: DisplayForm) -> TypedAnswer:
        if not self.by_itself:
            return self.screen.ask(form)
        shown = dict(zip(("ax1", "ax2", "o1", "o2"), displayed(self.clock.now_s), strict=True))
        typed = {
            "open": {"clock": "10:00:00"},
            "clock": {"clock": "10:00:00"},
            "reference": {"complete": "yes", "found1": "3", "found2": "-1"},
            "offset": {**shown, "came1": "-", "came2": "-"},
            "point": shown,
        }.get(form.word, {name.lower(): value for name, value in form.key_in})
        return TypedAnswer(form, form.texts(typed), self.clock.utc_s())


def error_deg(utc_s: float) -> tuple[float, float]:
    """The error a leaning tower has there, as O would show it."""
    e1, e2 = correction_deg(TRUTH, *BELIEFS.ideal_deg(utc_s))
    return round(float(e1), 3), round(float(e2), 3)


def displayed(utc_s: float, offsets: tuple[float, float] | None = None) -> tuple[str, ...]:
    """AX1, AX2, O1, O2 as the display shows them while the unit tracks the Sun exactly."""
    o1, o2 = offsets or error_deg(utc_s)
    reading = BELIEFS.target_deg(utc_s, Offsets(o1, o2))
    return f"{reading[0]:.2f}", f"{reading[1]:.2f}", f"{o1:.3f}", f"{o2:.3f}"


def take_points(station: Station, clock: TestClock, points: int, every_s: float) -> None:
    """A check, the data file begun, and points on a Sun that goes on."""
    station.set_unit_clock()
    station.ref_check()
    station.initialise(confirmed=True)
    for number in range(points):
        if number:
            clock.wait(every_s)
        station.set_sun_offset()
        station.begin_point()
        for _ in range(3):
            station.answer(True)
        station.gather_point()
        station.store(True)


@asynccontextmanager
async def workstation_by_hand(
    size: tuple[int, int] = (80, 24),
    points: int = 0,
    *,
    offset_set: bool = False,
    uploaded: Coefficients | None = None,
) -> AsyncIterator[tuple[SolarcalApp, Pilot[int], Station, TestClock]]:
    """Connected, its session in memory; from here on forms are answered at the keys.

    Parameters
    ----------
    points : stored before, 75 minutes apart.
    offset_set : a Set Sun Offset was made just now.
    uploaded : these were keyed in before it.
    """
    clock = TestClock()
    app = plain_start()
    async with app.run_test(size=size) as pilot:
        screen = WaitingDisplay(lambda asked: app.post_message(Told(FormAsked(asked))), clock)
        reader = Reader(screen, clock)
        station = Station(TypedUnit(SITE, MOUNT, reader, clock), clock, site=SITE)
        station.connect()
        station.open_session(Journal.memory)
        if points or offset_set:
            take_points(station, clock, points, 4500.0)
        if uploaded is not None:
            station.upload(uploaded, method="robust")
        if offset_set:
            station.set_sun_offset()
            clock.wait(90.0)
        station.poll()
        reader.by_itself = False
        app.adopt(station)
        await app.push_screen(WorkstationScreen())
        await pilot.pause()
        try:
            yield app, pilot, station, clock
        finally:
            # As on the way out: what still comes is not for screens that are taken down.
            app._leaving = True
            screen.close()
            if app.worker is not None:
                app.worker.close()


async def type_in(pilot: Pilot[int], *values: str) -> None:
    """Each value key by key, Enter behind it, once a field takes the keys."""
    for value in values:
        # A form that was asked for in another thread shows its words before it has the focus.
        await until(pilot, lambda: isinstance(pilot.app.focused, Input))
        await pilot.press(*value, "enter")


async def fill(pilot: Pilot[int], **values: str) -> None:
    """Values into fields at once, as if typed very fast, once the fields are there."""
    await until(pilot, lambda: all(pilot.app.screen.query(f"#typed-{name}") for name in values))
    for name, value in values.items():
        pilot.app.screen.query_one(f"#typed-{name}", Field).input.value = value
    await pilot.pause()
