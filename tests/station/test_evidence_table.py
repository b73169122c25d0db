"""Every comparison of ``docs/judgement.md``: guilty and innocent, live on a line and from files.

Each guilty day is made by an emulated unit on a real pseudo-terminal (elsewhere: on loopback) and
judged live, from its file, taken up again by the next process, and, where a points file holds what
is compared, after export and import.
"""

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_here
from solarcal.errors import ProcedureRefused
from solarcal.model.analysis import Analysis
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.interchange import read_table, session_from_table, write_table
from solarcal.session.journal import Journal
from solarcal.session.records import PointRecord
from solarcal.session.view import SessionView, read_session
from solarcal.site import Site
from solarcal.station.analysing import analyse_files, analyse_session, read_files
from solarcal.station.clocks import EmulatedClock
from solarcal.station.connect import open_tracker
from solarcal.station.procedure import Station
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.station.uploading import offer_upload
from solarcal.timescale import parse_utc

PAGE = Path(__file__).parents[2] / "docs" / "judgement.md"
START = "start=2026-06-03T16:00:00Z"


class Day:
    """An emulated unit on a line, a station and a technician; time moves by the station's clock."""

    def __init__(self, path: Path, url: str, emulator: Emulator, site: Site | None) -> None:
        self.path, self.url, self.emulator, self.site = path, url, emulator, site
        self.station, self.technician = self.connected()
        self.station.open_session(lambda header: Journal.create(path, header))

    def connected(self) -> tuple[Station, AutomaticTechnician]:
        tracker = open_tracker(self.url)
        tracker.open()
        emulation = tracker.emulation
        assert emulation is not None
        station = Station(tracker, EmulatedClock(emulation), site=self.site)
        station.connect()
        technician = AutomaticTechnician(station, emulation.spot, Schedule(), eye_sigma_deg=0.02)
        return station, technician

    def check(self) -> None:
        self.station.ref_check()
        self.station.track()
        self.station.clock.wait(120.0)

    def points(self, count: int, every_s: float = 2400.0) -> None:
        for _ in range(count):
            assert self.technician.take_point() is not None
            self.station.clock.wait(every_s)

    def prepared(self, set_clock: bool = True) -> None:
        if set_clock:
            self.station.set_unit_clock()
        self.check()
        self.station.initialise(confirmed=True)

    def taken_up(self) -> SessionView:
        """The session, by the next process on the same unit."""
        self.station.leave()
        self.station.tracker.close()
        self.station, self.technician = self.connected()
        journal = Journal.resume(self.path)
        self.station.resume_session(journal)
        session = self.station.session
        self.station.leave()
        return session

    def close(self) -> None:
        self.station.leave()
        self.station.tracker.close()


def good(day: Day) -> None:
    day.prepared()
    day.points(5)


def clock_never_set(day: Day) -> None:
    day.prepared(set_clock=False)
    day.points(4)


def counts_missed(day: Day) -> None:
    day.prepared()
    day.points(3)
    day.emulator.lose_counts(2, 60)
    day.points(2)
    day.check()


def counts_before_a_noticed_restart(day: Day) -> None:
    day.prepared()
    day.points(3)
    day.emulator.reboot()
    day.station.poll()
    day.check()
    day.points(2)


def memory_changed(day: Day) -> None:
    good(day)
    day.station.upload(analysed(day.station.session).solution.coefficients(), method="robust")
    day.station.tracker.write_coefficients(Coefficients(P2=1.0), Offsets())
    day.station.compare_in_force()


def memory_kept(day: Day) -> None:
    good(day)
    day.station.upload(analysed(day.station.session).solution.coefficients(), method="robust")
    assert day.technician.sight.centre()
    day.station.set_sun_offset()
    day.station.compare_in_force()


def time_signal(day: Day) -> None:
    day.prepared()
    day.points(4)
    day.station.set_unit_clock(30.0, 0.5)


def time_signal_agrees(day: Day) -> None:
    day.prepared()
    day.points(4)
    day.station.set_unit_clock(0.2, 0.3)


def clamp_moved(day: Day) -> None:
    day.prepared()
    day.points(4)
    day.emulator.lose_counts(2, 200)
    day.points(5)


def both_sides(day: Day) -> None:
    day.prepared()
    day.points(3, 600.0)
    for _ in range(60):
        if across(day):
            break
        day.station.clock.wait(600.0)
    day.points(3, 600.0)


def across(day: Day) -> bool:
    first = day.station.session.accepted[0].ideal_deg
    now = day.station.poll().ideal1_deg
    return first is not None and abs(now - first[0]) > 180.0 and abs(now) < 165.0


def many(day: Day) -> None:
    day.prepared()
    day.points(13, 2100.0)


def frozen(day: Day) -> None:
    """As recorded: live, a frozen read-out contradicts E + O before it is stored."""
    good(day)
    session = day.station.session
    still = session.accepted[0].reading_deg
    assert still is not None
    rewritten(day, session, lambda p: {"reading_deg": (still[0], p.reading_deg[1])})


def offset_recorded(day: Day) -> None:
    """As recorded: live, such a point is refused."""
    good(day)
    rewritten(
        day, day.station.session, lambda p: {"offsets": Offsets(p.offsets.O1, p.offsets.O2 + 0.5)}
    )


def rewritten(day: Day, session: SessionView, change: Callable[[PointRecord], dict]) -> None:
    """The session with its accepted points changed, in the place of what was recorded."""
    day.station.leave()
    day.path.unlink()
    with Journal.create(day.path, session.header) as journal:
        for record in session.records:
            bad = record in session.accepted
            journal.append(msgspec.structs.replace(record, **change(record)) if bad else record)
    day.station.connect()
    day.station.resume_session(Journal.resume(day.path))


@dataclass(frozen=True)
class Row:
    """One row of the page: ``kind`` of the finding, and the days with it and without."""

    compared: str
    kind: str
    guilty: Callable[[Day], None]
    innocent: Callable[[Day], None] = good
    scenario: str = "tijeras-azel"
    settings: tuple[str, ...] = ()
    site: Site | None = None
    state: str = ""
    imported: bool = field(default=False, kw_only=True)


HERE = Site(35.04, -106.51, 1700.0)
ROWS = (
    Row(
        "time stamps and ideal angles", "time_stamps", clock_never_set,
        settings=("truth.unit_offset_s=480",), imported=True,
    ),
    Row(
        "counts at two reference checks", "missed_counts", counts_missed,
        counts_before_a_noticed_restart,
    ),
    Row("coefficients uploaded and in force", "not_held", memory_changed, memory_kept),
    Row(
        "clocks of unit and laptop", "clock_drift", clock_never_set,
        settings=("truth.unit_drift_s_per_day=400",),
    ),
    Row(
        "laptop and time signal", "laptop_clock", time_signal, time_signal_agrees,
        state="does_not_fit",
    ),
    Row(
        "site and Sun of the unit", "unit_sun", clock_never_set,
        settings=("unit.latitude_deg=36",), site=HERE, state="does_not_fit",
    ),
    Row("read-outs and the Sun's motion", "frozen", frozen, state="does_not_fit"),
    Row("read-outs, ideal angles and E(P) + O", "offsets", offset_recorded, state="does_not_fit"),
    Row("both sides of axis 1's branch", "branch", both_sides, scenario="tropical", imported=True),
    Row("runs of points before and after", "step", clamp_moved, imported=True,
        state="does_not_fit"),
    Row(
        "residuals and causes outside P1..P6", "collimation", many, many,
        settings=("truth.collimation_deg=1.5", "truth.noise_deg=0.005"), imported=True,
    ),
)  # fmt: skip


@pytest.fixture
def day_of(tmp_path: Path) -> Iterator[Callable[..., Day]]:
    with ExitStack() as open_days:

        def make(scenario: str, *settings: str, site: Site | None = None) -> Day:
            start = () if scenario == "tropical" else (START,)
            emulator = Emulator(load_scenario(scenario, [*start, *settings]), seed=7)
            url = open_days.enter_context(serve_here(emulator))
            day = Day(tmp_path / f"{len(list(tmp_path.iterdir()))}.jsonl", url, emulator, site)
            open_days.callback(day.close)
            return day

        yield make


def analysed(session: SessionView) -> Analysis:
    analysis = analyse_session(session)
    assert analysis is not None
    return analysis


def found(analysis: Analysis) -> set[str]:
    return {f.kind for f in analysis.findings if f.certainty == "found"}


def from_file(path: Path) -> Analysis:
    return analyse_files(read_files([path], {})).of_the_controller()


def imported(path: Path) -> Analysis:
    points, again = path.with_suffix(".csv"), path.with_name("imported.jsonl")
    write_table(read_session(path).table, points)
    session_from_table(read_table(points), again, utc_s=parse_utc("2026-07-01"))
    return from_file(again)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.kind)
def test_guilty_by_every_door(row: Row, day_of) -> None:
    day = day_of(row.scenario, *row.settings, site=row.site)
    row.guilty(day)
    doors = {"live": analysed(day.station.session), "file": from_file(day.path)}
    if row.imported:
        doors["import"] = imported(day.path)
    doors["taken up"] = analysed(day.taken_up())
    for door, analysis in doors.items():
        assert row.kind in found(analysis), door
        assert analysis.verdict.state != "done", door
        if row.state:
            assert analysis.verdict.state == row.state, door
    assert doors["live"].verdict.reasons == doors["file"].verdict.reasons


@pytest.mark.parametrize(
    "innocent", {row.innocent: row for row in ROWS}.values(), ids=lambda row: row.innocent.__name__
)
def test_the_innocent_explanation_is_no_finding(innocent: Row, day_of) -> None:
    day = day_of("tijeras-azel")
    innocent.innocent(day)
    excused = {row.kind for row in ROWS if row.innocent is innocent.innocent}
    for analysis in (analysed(day.station.session), from_file(day.path), analysed(day.taken_up())):
        assert not excused & found(analysis)
        assert analysis.verdict.state != "does_not_fit"


@pytest.mark.parametrize("off_deg", [0.5, 500.0])
def test_what_a_unit_says_twice_is_compared_before_a_point_is_stored(day_of, off_deg, monkeypatch):
    """The rows of the page that no record can be guilty of: such a point is never accepted."""
    day = day_of("tijeras-azel")
    day.prepared()
    tracker = day.station.tracker
    honest = tracker.status

    def lying():
        told = honest()
        return msgspec.structs.replace(told, offsets=Offsets(told.offsets.O1 + off_deg, 0.0))

    assert day.technician.sight.centre()
    day.station.set_sun_offset()
    assert day.technician.sight.watch()
    monkeypatch.setattr(tracker, "status", lying)
    day.station.begin_point()
    for _ in range(3):
        day.station.answer(True)
    with pytest.raises(ProcedureRefused, match="axis 1: the read-out less the ideal angle"):
        day.station.gather_point()
    assert day.station.session.accepted == ()


def test_the_year_in_force_forbids_an_upload_that_gains_nothing(day_of) -> None:
    day = day_of("tijeras-azel")
    day.prepared()
    day.points(3, 1200.0)
    analysis = analysed(day.station.session)
    truth = day.emulator.truth().coefficients
    offer = offer_upload(analysis, day.station.session.header.unit, (truth, Offsets()))
    assert offer.against
    assert "no improvement beyond its uncertainty" in offer.against[-1]


RECORDS = "tests/model/test_recorded_twice.py"
ELSEWHERE = {
    "counts and read-outs": RECORDS,
    "a point and its Set Sun Offset": RECORDS,
    "answers and status of a point": RECORDS,
    "units on the line": RECORDS,
    "a restart and the next reference check": RECORDS,
    "the two records of an upload": RECORDS,
    "O at a point and all O before it": RECORDS,
    "a reference check broken off and the points after it": RECORDS,
    "a check point's errors, sky error, O, P, Sun and answers": RECORDS,
    "a check point and the upload, restarts, missed counts and the unit on the line": RECORDS,
    "kind of ideal angles and stamps": "tests/model/test_time_stamps.py",
    "sessions of one unit": "tests/model/test_earlier_sessions.py",
    "sessions that overlap in time": "tests/model/test_overlapping_sessions.py",
    "two readings of one instant": "tests/model/test_overlapping_sessions.py",
    "check points and the tolerance": "tests/report/test_certificate.py",
    "the year with what was uploaded": "tests/report/test_certificate.py",
}
HERE_ALONE = {"error and half a turn, read-outs and limits", "the year in force and proposed"}


def test_every_row_of_the_page_has_its_test() -> None:
    table = PAGE.read_text().split("| compared | where |")[1].split("\n\n")[0]
    named = {cells.group(1).strip() for cells in re.finditer(r"^\| ([^|]+)\|", table, re.M)}
    named -= {"---"}
    assert named == {row.compared for row in ROWS} | set(ELSEWHERE) | HERE_ALONE
    for path in ELSEWHERE.values():
        assert (PAGE.parents[1] / path).exists()
