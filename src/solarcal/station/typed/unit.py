"""The ``Tracker`` made of what a person types: the controller itself is never heard.

Its ``ideal`` angles are computed here for its clock, as the controller computes them. Between two
forms nothing is asked: a status tells what was typed last, when, and where the unit should stand.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, Offsets
from solarcal.profiles import MountDescription
from solarcal.session.records import TYPED_FIRMWARE
from solarcal.site import Site
from solarcal.station.described_unit import TypedControllerModel, unit_parameters, unit_site
from solarcal.station.typed import entry_forms
from solarcal.station.typed.forms import Display, DisplayForm, Doubting, TypedAnswer, Value, Values
from solarcal.station.typed.plausibility import clock_doubts, key_in_doubts, reading_sheet_doubts
from solarcal.timescale import Clock, second_of_day
from solarcal.unit.tracker import (
    TYPED,
    Capabilities,
    Emulation,
    Mode,
    RefCheckResult,
    Status,
    Stored,
    UnitIdentity,
    UnitParameters,
    UnitSite,
)

MODEL = "SolarTrak"
FORMS_REMEMBERED = 50
"""How many ``recent_traffic`` tells of."""

PRESS_STOP = "PRESS STOP ON THE UNIT: there is no line to it, this program cannot stop it"


class TypedUnit:
    """A controller at hand, its display read by a person.

    Parameters
    ----------
    site, mount : where it stands and how it is set up; it cannot be asked.
    display : who answers.
    clock : the laptop's.
    """

    def __init__(self, site: Site, mount: MountDescription, display: Display, clock: Clock) -> None:
        self._mount = mount
        self._display = display
        self._clock = clock
        self._held = TypedControllerModel(
            unit_site(mount, site),
            unit_parameters(mount, site),
            shows_counts=mount.display == "counts",
        )
        self._permanent = (Coefficients(), Offsets())
        self._known = False
        self._reading: tuple[Pair, tuple[int, int], float] | None = None
        self._came = (0, 0)
        self._offset_read = False
        self._ref_check = RefCheckResult(0, False, None, None)
        self._answers: list[TypedAnswer] = []
        self._heard: Callable[[TypedAnswer], object] | None = None
        self._told: deque[str] = deque(maxlen=FORMS_REMEMBERED)

    # -- what a tracker is ---------------------------------------------------------------------

    @property
    def emulation(self) -> Emulation | None:
        return None

    @property
    def display(self) -> "TypedUnit":
        return self

    @property
    def capabilities(self) -> Capabilities:
        return TYPED

    @property
    def identity(self) -> UnitIdentity:
        """As it is described, before anything was typed."""
        return UnitIdentity(MODEL, self._mount.unit_name or "by hand", TYPED_FIRMWARE)

    def open(self) -> UnitIdentity:
        """Ask what the unit holds and what its clock says; once."""
        if not self._known and not self._answers:
            self._ask_open()
        return self.identity

    def close(self) -> None:
        """There is no line."""

    def site(self) -> UnitSite:
        return self._held.unit_site

    def parameters(self) -> UnitParameters:
        return self._held.parameters

    def status(self) -> Status:
        """What was typed last, and where the unit should stand now. Asks nothing."""
        return self._status(self._clock.utc_s())

    def set_clock(self, utc_s: float) -> None:
        """Have the unit's clock set, and compared."""
        ahead_s = utc_s - self._clock.utc_s()
        wanted = "at the foot of this form"
        if abs(ahead_s) >= 0.05:
            wanted = f"below, {'plus' if ahead_s > 0 else 'minus'} {abs(ahead_s):.1f} s"
        form = entry_forms.clock_form(wanted, partial(clock_doubts, self._held))
        self._compare_clocks(*self._ask(form))

    def set_mode(self, mode: Mode) -> None:
        """Nothing: the person who types has set the unit."""
        del mode

    def stop(self) -> None:
        raise ProcedureRefused(PRESS_STOP)

    def stow(self) -> None:
        raise ProcedureRefused("stow the unit by its own keys: there is no line to it")

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        del target1_deg, target2_deg
        raise ProcedureRefused("jog at the unit's own keys: there is no line to it")

    def set_sun_offset(self) -> Status:
        """What the display shows after a Set Sun Offset at the unit."""
        self._demand_known()
        now_s = self._clock.utc_s()
        form = entry_forms.offset_form(
            self._held.shows_counts,
            self._mount.display_sun,
            self._held.senses(now_s, self._came),
            partial(reading_sheet_doubts, self._held, offset_just_set=True),
        )
        answer, values = self._ask(form)
        self._came = (_whole(values["came1"]), _whole(values["came2"]))
        return self._take_reading(answer, values)

    def read_display(self) -> Status:
        self._demand_known()
        form = entry_forms.point_form(
            self._held.shows_counts,
            self._mount.display_sun,
            partial(reading_sheet_doubts, self._held, offset_just_set=False),
        )
        return self._take_reading(*self._ask(form))

    def start_ref_check(self) -> None:
        """Have a reference check done at the unit, and its counts typed."""
        _, values = self._ask(entry_forms.ref_check_form())
        found = (values["found1"], values["found2"])
        difference1, difference2 = (None if one is None else _whole(one) for one in found)
        self._ref_check = RefCheckResult(
            self._ref_check.number + 1, bool(values["complete"]), difference1, difference2
        )
        # The axes stand at their switches; what was read before says nothing any more.
        self._reading = None

    def ref_check_result(self) -> RefCheckResult:
        return self._ref_check

    def stored(self) -> Stored:
        """As typed last; asked again where what was keyed in was never read back."""
        self._demand_known()
        return Stored(self._held.coefficients, self._held.offsets, *self._permanent)

    def write_coefficients(
        self, coefficients: Coefficients, offsets: Offsets, *, store: bool = True
    ) -> Stored:
        """Have them keyed in, stored, and typed back from the display."""
        del store
        told = self._held.parameters
        decimals = (told.tilt_decimals, told.scale_decimals)
        doubts: Doubting = lambda texts, read_utc_s: key_in_doubts(form.key_in, texts)  # noqa: E731
        if self._known and self._offset_read and coefficients == self._held.coefficients:
            form = entry_forms.zero_form(offsets, decimals, doubts)
        else:
            form = entry_forms.key_in_form(coefficients, offsets, decimals, doubts)
        # Half keyed in and given up, the unit holds nobody knows what.
        self._known = False
        _, values = self._ask(form)
        self._offset_read = False
        self._take_held(values, stored=bool(values["stored"]))
        return self.stored()

    def recent_traffic(self) -> tuple[str, ...]:
        """Forms as they were answered, oldest first."""
        return tuple(self._told)

    # -- asking --------------------------------------------------------------------------------

    def listen(self, heard: Callable[[TypedAnswer], object]) -> None:
        self._heard = heard
        for answer in self._answers:
            heard(answer)
        self._answers = []

    def _ask(self, form: DisplayForm) -> tuple[TypedAnswer, Values]:
        form = replace(form, zone_west_h=self._held.unit_site.zone_west_h)
        answer = self._display.ask(form)
        typed = " ".join(f"{name} {text}" for name, text in answer.texts.items() if text)
        self._told.append(f"{second_of_day(answer.read_utc_s)}  {form.word}: {typed}")
        if self._heard is None:
            self._answers.append(answer)
        else:
            self._heard(answer)
        return answer, answer.values

    def _ask_open(self) -> None:
        form = entry_forms.open_form(partial(clock_doubts, self._held))
        answer, values = self._ask(form)
        self._take_held(values)
        self._compare_clocks(answer, values)

    def _demand_known(self) -> None:
        if not self._known:
            self._take_held(self._ask(entry_forms.held_form())[1])

    # -- what was typed ------------------------------------------------------------------------

    def _take_held(self, values: Values, *, stored: bool = True) -> None:
        """P and O as the display shows them, or O alone."""
        coefficients = self._held.coefficients
        if "p1" in values:
            coefficients = Coefficients(*(_real(values[p.lower()]) for p in COEFFICIENT_NAMES))
        offsets = Offsets(_real(values["o1"]), _real(values["o2"]))
        self._held = replace(self._held, coefficients=coefficients, offsets=offsets)
        if stored:
            self._permanent = (coefficients, offsets)
        self._known = True

    def _compare_clocks(self, answer: TypedAnswer, values: Values) -> None:
        alike = replace(self._held, unit_minus_laptop_s=0.0)
        off_s = alike.clock_off_s(_real(values["clock"]), answer.read_utc_s)
        self._held = replace(self._held, unit_minus_laptop_s=round(off_s, 3))

    def _take_reading(self, answer: TypedAnswer, values: Values) -> Status:
        moment_s = self._held.moment_s(values, answer.read_utc_s)
        shown = (_real(values["ax1"]), _real(values["ax2"]))
        reading = (self._held.reading_deg(0, shown[0]), self._held.reading_deg(1, shown[1]))
        counts = (self._held.counts(0, reading[0]), self._held.counts(1, reading[1]))
        if self._held.shows_counts:
            counts = (round(shown[0]), round(shown[1]))
        self._reading = (reading, counts, moment_s)
        self._offset_read = True
        offsets = Offsets(_real(values["o1"]), _real(values["o2"]))
        self._held = replace(self._held, offsets=offsets)
        return self._status(moment_s)

    def _status(self, laptop_utc_s: float) -> Status:
        held = self._held
        ideal, target = held.ideal_deg(laptop_utc_s), held.target_deg(laptop_utc_s)
        # Before anything was typed the axes are taken to stand where the unit drives them.
        reading, counts, typed_utc_s = self._reading or (
            target,
            (held.counts(0, target[0]), held.counts(1, target[1])),
            None,
        )
        return Status(
            mode=Mode.TRACK,
            unit_utc_s=held.unit_utc_s(laptop_utc_s),
            ideal1_deg=ideal[0],
            ideal2_deg=ideal[1],
            reading1_deg=reading[0],
            reading2_deg=reading[1],
            counts1=counts[0],
            counts2=counts[1],
            target1_deg=target[0],
            target2_deg=target[1],
            offsets=held.offsets,
            moving=(0, 0),
            approach=self._came,
            update_phase=0.0,
            referenced=self._ref_check.complete,
            unlocked_s=0.0,
            memories_differ=self._permanent != (held.coefficients, held.offsets),
            typed_utc_s=typed_utc_s,
        )


def _real(value: Value) -> float:
    return float(value or 0.0)


def _whole(value: Value) -> int:
    return int(value or 0)
