"""A unit by hand whose answers a test gives, at a time a test sets."""

from collections.abc import Mapping

from solarcal.errors import ProcedureRefused
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.profiles import MountDescription
from solarcal.site import Site
from solarcal.station.described_unit import TypedControllerModel as Model
from solarcal.station.described_unit import unit_parameters, unit_site
from solarcal.station.typed.forms import DisplayForm, TypedAnswer
from solarcal.station.typed.unit import TypedUnit
from solarcal.timescale import parse_utc

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
MORNING = parse_utc("2026-06-03T16:00:00Z")
NOTHING = {f"p{i}": "0" for i in range(1, 7)} | {"o1": "0", "o2": "0"}


class SetClock:
    """Stands where it is put."""

    def __init__(self, utc_s: float = MORNING) -> None:
        self.now_s = utc_s

    def utc_s(self) -> float:
        return self.now_s

    def wait(self, seconds: float) -> None:
        self.now_s += seconds


class Answering:
    """A ``Display`` that types what a test has prepared for a form; notes what is asked."""

    def __init__(self, clock: SetClock, prepared: Mapping[str, Mapping[str, str]]) -> None:
        self.clock = clock
        self.prepared = dict(prepared)
        self.asked: list[str] = []

    def ask(self, form: DisplayForm) -> TypedAnswer:
        self.asked.append(form.word)
        if form.word not in self.prepared:
            raise ProcedureRefused("given up")
        texts = form.texts(self.prepared[form.word])
        form.values(texts)
        return TypedAnswer(form, texts, self.clock.utc_s())


def typed_unit(
    mount: MountDescription = MOUNT, **prepared: Mapping[str, str]
) -> tuple[TypedUnit, Answering, SetClock]:
    """Opened at 16:00 UTC with nothing in force, its clock right."""
    clock = SetClock()
    opened = {"open": {**NOTHING, "clock": "09:00:00"}, **prepared}
    display = Answering(clock, opened)
    unit = TypedUnit(SITE, mount, display, clock)
    unit.open()
    return unit, display, clock


def unit_model(
    mount: MountDescription = MOUNT,
    coefficients: Coefficients = Coefficients(),  # noqa: B008
    offsets: Offsets = Offsets(),  # noqa: B008
) -> Model:
    return Model(
        unit_site(mount, SITE),
        unit_parameters(mount, SITE),
        shows_counts=mount.display == "counts",
        coefficients=coefficients,
        offsets=offsets,
    )


def displayed(
    held: Model,
    utc_s: float,
    o1: float,
    o2: float,
    lag: tuple[float, float] = (0.0, 0.0),
) -> dict[str, str]:
    """What a display of two decimals shows of a unit that obeys its own law."""
    at = held.ideal_deg(utc_s)
    e1, e2 = correction_deg(held.coefficients, *at)
    reading = (at[0] + e1 + o1 + lag[0], at[1] + e2 + o2 + lag[1])
    if held.shows_counts:
        shown = [str(held.counts(axis, reading[axis])) for axis in (0, 1)]
    else:
        shown = [f"{angle:.2f}" for angle in reading]
    return {"ax1": shown[0], "ax2": shown[1], "o1": f"{o1:.3f}", "o2": f"{o2:.3f}"}
