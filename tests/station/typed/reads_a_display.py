"""Somebody who stands at an emulated tracker and writes its display down in a field book.

The emulated unit is used through its line, by the automatic technician; what goes into the book is
only what a display of few decimals would show.
"""

from dataclasses import dataclass, field

import msgspec

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink
from solarcal.mount.formula import Coefficients
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    Initialised,
    PointRecord,
    Record,
    RefCheck,
    SunOffset,
    UploadRecord,
)
from solarcal.station.clocks import EmulatedClock
from solarcal.station.described_unit import described_by_session
from solarcal.station.procedure import Station
from solarcal.station.state import StationState
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import format_utc, parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Status, Truth

AX_DECIMALS = 2
OFFSET_DECIMALS = 3


@dataclass
class Notebook:
    """Lines as they are written; the day above the first of each."""

    zone_west_h: float
    counts: bool = False
    lines: list[str] = field(default_factory=list)
    day: str = ""

    def write(self, utc_s: float, words: str) -> None:
        utc = format_utc(utc_s)
        if utc[:10] != self.day:
            self.day = utc[:10]
            self.lines.append(self.day)
        self.lines.append(f"{utc[11:19]} {words}")

    def clock(self, unit_utc_s: float) -> str:
        return format_utc(unit_utc_s - 3600.0 * self.zone_west_h, 0)[11:19]

    def text(self) -> str:
        return "\n".join(self.lines) + "\n"


class HandReader:
    """An emulated day, seen by a technician with a notebook."""

    def __init__(
        self,
        scenario: str = "tijeras-azel",
        *settings: str,
        points: int = 6,
        every_min: float = 45.0,
        seed: int = 5,
        noise_deg: float = 0.01,
        counts: bool = False,
    ) -> None:
        emulator = Emulator(load_scenario(scenario, list(settings)), seed=seed, noise_deg=noise_deg)
        unit = SolarTrakUnit(lambda: InProcessLink(emulator))
        unit.open()
        emulation = unit.emulation
        assert emulation is not None
        self.emulation = emulation
        sky = emulation.sky()
        self.station = Station(
            unit, EmulatedClock(emulation), weather=sky.weather, true_sun=sky.sun
        )
        self.station.connect()
        self.station.open_session(Journal.memory)
        self.header = self.station.session.header
        self.book = Notebook(self.header.unit.zone_west_h, counts)
        self._told = 0
        self.station.subscribe(self._see)
        status = self.station.poll()
        self._open(status)
        self.technician = AutomaticTechnician(
            self.station,
            emulation.spot,
            Schedule(points=points, every_min=every_min),
            eye_sigma_deg=noise_deg,
        )

    @property
    def profile(self) -> Profile:
        """What a technician would have filled in of this tracker."""
        nameless = Profile(
            name="by-hand",
            operator="hand reader",
            driver="typed",
            site=self.header.site,
            weather=self.header.weather,
        )
        described = described_by_session(nameless, self.header)
        mount = msgspec.structs.replace(
            described.mount, unit_name="4711", display="counts" if self.book.counts else "angles"
        )
        return msgspec.structs.replace(described, mount=mount)

    def take_points(self) -> None:
        self.technician.prepare()
        self.technician.take_points()

    def upload_and_check(self, coefficients: Coefficients) -> Truth:
        """Key them in, and prove them; the truth afterwards."""
        self.station.upload(coefficients, method="robust")
        self.station.track()
        self.technician.take_checks()
        return self.emulation.truth()

    # -- writing down ----------------------------------------------------------------------------

    def _open(self, status: Status) -> None:
        stored = self.station.tracker.stored()
        assert stored.coefficients == Coefficients()
        laptop_s = self.station.clock.utc_s()
        self.book.write(laptop_s, f"open clock {self.book.clock(status.unit_utc_s)}")

    def _see(self, state: StationState) -> None:
        records = state.session.records if state.session is not None else ()
        new, self._told = records[self._told :], len(records)
        for record in new:
            self._write(record, state)

    def _write(self, record: Record, state: StationState) -> None:
        utc_s = parse_utc(record.utc)
        match record:
            case ClockSet():
                self.book.write(utc_s, f"clock clock {self.book.clock(utc_s + record.after_s)}")
            case RefCheck(complete=complete, difference_counts=found):
                assert found is not None
                self.book.write(
                    utc_s,
                    f"reference complete {'yes' if complete else 'no'} found1 {found[0]} "
                    f"found2 {found[1]}",
                )
            case SunOffset():
                came = "".join(
                    f" came{axis} {'+' if sense > 0 else '-'}"
                    for axis, sense in enumerate(record.approach, start=1)
                    if sense
                )
                shown = self._shown(record.reading_deg, record.counts)
                offsets = _offsets(record.offsets.O1, record.offsets.O2)
                self.book.write(utc_s, f"offset {shown} {offsets}{came}")
            case Initialised():
                self.book.write(utc_s, "initialise")
            case PointRecord() | CheckRecord():
                self._write_point(record, state)
            case UploadRecord():
                values = zip(
                    ("p1", "p2", "p3", "p4", "p5", "p6"),
                    record.new_coefficients.as_tuple(),
                    (4, 4, 4, 4, 6, 6),
                    strict=True,
                )
                typed = " ".join(f"{name} {value:+.{places}f}" for name, value, places in values)
                self.book.write(utc_s, f"upload {typed} o1 0 o2 0 stored yes")
            case _:
                pass

    def _write_point(self, record: PointRecord | CheckRecord, state: StationState) -> None:
        step = "check" if isinstance(record, CheckRecord) else "point"
        answers = " ".join(
            "yes" if answer else "no"
            for answer in (
                record.answers.ref_check,
                record.answers.sun_offset,
                record.answers.tracking,
            )
            if answer is not None
        )
        if record.status == "aborted":
            self.book.write(parse_utc(record.utc), f"{step} {answers}")
            return
        live = state.live
        assert live.status is not None
        assert live.laptop_utc_s is not None
        status = live.status
        shown = self._shown(
            (status.reading1_deg, status.reading2_deg), (status.counts1, status.counts2)
        )
        offsets = _offsets(status.offsets.O1, status.offsets.O2)
        decision = "store" if record.status == "accepted" else f"reject {record.reason}"
        self.book.write(live.laptop_utc_s, f"{step} {answers} {shown} {offsets} {decision}")
        if step == "check" and record.status == "accepted":
            self.book.write(live.laptop_utc_s + 20.0, "zero o1 0 o2 0 stored yes")

    def _shown(self, reading: tuple[float, float], counts: tuple[int, int]) -> str:
        if self.book.counts:
            return f"ax1 {counts[0]} ax2 {counts[1]}"
        return f"ax1 {reading[0]:.{AX_DECIMALS}f} ax2 {reading[1]:.{AX_DECIMALS}f}"


def _offsets(o1: float, o2: float) -> str:
    return f"o1 {o1:+.{OFFSET_DECIMALS}f} o2 {o2:+.{OFFSET_DECIMALS}f}"


def with_slips(text: str) -> str:
    """The same day as it is really written down: an attempt given up, slips put right below.

    An offset has two digits of AX1 exchanged, the third point the sign of O1 wrong, and
    before the fourth offset an attempt ended at the second question.
    """
    lines: list[str] = []
    offsets = points = 0
    slipped = False
    for line in text.splitlines():
        words = line.split()
        step = words[1] if len(words) > 1 else ""
        offsets += step == "offset"
        points += step == "point"
        ax1 = words[3] if step == "offset" else "00"
        if not slipped and ax1[0] in "123456789" and ax1[1] not in f"0{ax1[0]}.":
            slipped, right = True, ax1
            swapped = right[1] + right[0] + right[2:]
            lines += [line.replace(right, swapped), f"{words[0]} again ax1 {right}"]
        elif step == "point" and points == 3:
            right = words[words.index("o1") + 1]
            wrong = right.replace("-", "+") if "-" in right else right.replace("+", "-")
            lines += [line.replace(right, wrong), f"{words[0]} again o1 {right}"]
        elif step == "offset" and offsets == 4:
            lines += [f"{words[0]} point yes no", line]
        else:
            lines.append(line)
    return "\n".join(lines) + "\n"
