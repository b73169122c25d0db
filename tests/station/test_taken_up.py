"""A headless calibration whose line is lost goes on; one that was ended is taken up again."""

from functools import partial

import msgspec
import pytest

from direct_line import OrderedLine
from solarcal.cli import run_command
from solarcal.config import Choice
from solarcal.emulated_units import open_choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.line_faults import LineFaults
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import LinkError, ProcedureRefused
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import LinkLost, LinkRestored, PointRecord, RefCheck
from solarcal.session.view import read_session
from solarcal.station import headless
from solarcal.station.headless import GIVE_UP_S
from solarcal.station.technician import Schedule
from solarcal.timescale import parse_utc
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.tracker import Mode

SCHEDULE = Schedule(points=5, every_min=30.0, checks=1)
calibrate = partial(headless.calibrate, force="two hours are too few to be sure")


class Pauses:
    """Waits for a lost line without waiting; may put the plug back."""

    def __init__(self, then=lambda waited_s: None):
        self.waited = []
        self.tries_s = 0.0
        self._then = then

    def utc_s(self):
        return sum(self.waited) + self.tries_s

    def wait(self, seconds):
        self.waited.append(seconds)
        self._then(sum(self.waited))


def emulated(serial="0001", scenario="tijeras-azel", *settings):
    return Emulator(load_scenario(scenario, [f"unit.serial={serial}", *settings]), seed=5)


def accepted(path):
    records = read_session(path).records
    return [r for r in records if isinstance(r, PointRecord) and r.status == "accepted"]


def interrupted_after(points, path, emulator):
    """A calibration that Ctrl-C ends when it has so many points."""

    def say(sentence):
        if path.exists() and len(accepted(path)) == points:
            raise KeyboardInterrupt

    unit = SolarTrakUnit(OrderedLine(emulator).connect)
    with pytest.raises(KeyboardInterrupt):
        calibrate(unit, lambda header: Journal.create(path, header), SCHEDULE, say=say)


def test_an_ended_calibration_is_taken_up_where_it_stood(tmp_path):
    path, emulator = tmp_path / "day.jsonl", emulated()
    interrupted_after(2, path, emulator)
    before = read_session(path).records
    done = calibrate(
        SolarTrakUnit(OrderedLine(emulator).connect), Journal.memory, SCHEDULE, resume=path
    )
    assert done.completed
    assert done.path == path
    after = read_session(path).records
    assert after[: len(before)] == before
    assert len(accepted(path)) == 5
    assert [record.seq for record in after] == list(range(1, len(after) + 1))
    assert done.truth_after.day_rms_deg < 0.5 * done.truth_before.day_rms_deg


@pytest.mark.parametrize("driver", ["solartrak", "rotctld"])
def test_an_emulated_unit_that_takes_over_holds_what_was_uploaded(tmp_path, driver):
    path = tmp_path / "day.jsonl"
    day = ["--points", "3", "--every", "20", "--force", "short", "-o", str(path)]
    assert run_command(["calibrate", "--scenario", "tijeras-azel", "--driver", driver, *day]) == 0
    *killed, closed = path.read_text().splitlines(keepends=True)
    assert '"type":"closed"' in closed
    path.write_text("".join(killed))
    last = read_session(path)
    choice = Choice(scenario="tijeras-azel", driver=driver, session=str(path), speed=0.0)
    line = open_choice(choice, Profile())
    try:
        held, written = line.station.tracker.stored(), last.uploads[-1]
        assert held.coefficients == held.permanent_coefficients == written.new_coefficients
        assert held.offsets == written.new_offsets
        assert line.station.session.holds_upload
        assert line.station.clock.utc_s() >= parse_utc(last.records[-1].utc) - 1.0
    finally:
        line.close()


def left_in_a_reference_check(emulator):
    """A program was killed while the unit looked for its switches; 40 counts were missed before."""
    emulator.lose_counts(1, 40)
    unit = SolarTrakUnit(OrderedLine(emulator).connect)
    unit.open()
    unit.start_ref_check()
    unit.emulation.advance(2.0)
    assert unit.status().mode is Mode.REF
    unit.close()


WAITED_FOR = "the unit is in a reference check already; its end is waited for"


def test_a_calibration_killed_in_a_reference_check_waits_for_its_end_and_goes_on(tmp_path):
    path, emulator, said = tmp_path / "day.jsonl", emulated(), []
    interrupted_after(2, path, emulator)
    before = read_session(path).records
    left_in_a_reference_check(emulator)
    calibrate(
        SolarTrakUnit(OrderedLine(emulator).connect), Journal.memory, SCHEDULE,
        resume=path, say=said.append,
    )  # fmt: skip
    assert said.count(WAITED_FOR) == 1
    assert len(accepted(path)) == 5
    # The check that was under way is the evidence: a second one would find none of the 40 counts.
    check = next(r for r in read_session(path).records[len(before) :] if isinstance(r, RefCheck))
    assert check.complete
    assert abs(abs(check.difference_counts[0]) - 40) < 10


def test_a_new_calibration_of_a_unit_in_a_reference_check_waits_for_its_end(tmp_path):
    path, emulator, said = tmp_path / "day.jsonl", emulated(), []
    left_in_a_reference_check(emulator)
    unit = SolarTrakUnit(OrderedLine(emulator).connect)
    calibrate(unit, lambda header: Journal.create(path, header), SCHEDULE, say=said.append)
    assert said.count(WAITED_FOR) == 1
    assert len(accepted(path)) == 5


def test_what_a_reference_check_finds_is_kept_where_the_line_is_lost_in_it(tmp_path):
    path, emulator = tmp_path / "day.jsonl", emulated()
    line = OrderedLine(emulator)
    unit, started = SolarTrakUnit(line.connect), 0
    start = unit.start_ref_check

    def start_ref_check():
        nonlocal started
        started += 1
        if started == 2:
            emulator.lose_counts(1, 40)
            start()
            line.hang_up(2)
        else:
            start()

    unit.start_ref_check = start_ref_check
    calibrate(unit, lambda h: Journal.create(path, h), SCHEDULE, pauses=Pauses())
    records = read_session(path).records
    lost = next(i for i, r in enumerate(records) if isinstance(r, LinkLost))
    check = next(r for r in records[lost:] if isinstance(r, RefCheck))
    assert abs(abs(check.difference_counts[0]) - 40) < 10


def test_a_reference_check_that_never_ends_is_stopped_after_an_hour(tmp_path):
    emulator = emulated()
    left_in_a_reference_check(emulator)
    unit = SolarTrakUnit(OrderedLine(emulator).connect)
    status = unit.status
    unit.status = lambda: msgspec.structs.replace(status(), mode=Mode.REF)
    with pytest.raises(ProcedureRefused, match="did not end within an hour and was stopped"):
        calibrate(unit, lambda h: Journal.create(tmp_path / "day.jsonl", h), SCHEDULE)
    unit.open()
    assert status().mode is Mode.STOP


def test_a_finished_session_and_another_unit_are_refused(tmp_path):
    path, emulator = tmp_path / "day.jsonl", emulated()
    interrupted_after(2, path, emulator)
    with pytest.raises(ProcedureRefused, match="belongs to unit SOLARTRAK-EMU 0001"):
        calibrate(
            SolarTrakUnit(OrderedLine(emulated("0002")).connect),
            Journal.memory, SCHEDULE, resume=path,
        )  # fmt: skip
    unit = SolarTrakUnit(OrderedLine(emulator).connect)
    calibrate(unit, Journal.memory, SCHEDULE, resume=path)
    with pytest.raises(ProcedureRefused, match=r"is finished \(calibration finished\)"):
        calibrate(unit, Journal.memory, SCHEDULE, resume=path)


@pytest.mark.parametrize(
    ("scenario", "setting", "told"),
    [
        (
            "ns-tiltroll",
            "unit.update_range_deg=0.1",
            r"geometry now \(tiltroll-ns\) than .*\(azel\)",
        ),
        ("tijeras-azel", "unit.reference1_deg=117", r"another reference position of axis 1"),
        ("tijeras-azel", "unit.drive1=rotary:999", r"another drive of axis 1 now .* 999"),
        ("tijeras-azel", "unit.latitude_deg=36", "another latitude"),
    ],
)
def test_a_unit_set_up_otherwise_is_refused_and_nothing_is_written(
    tmp_path, scenario, setting, told
):
    path = tmp_path / "day.jsonl"
    interrupted_after(2, path, emulated())
    before = path.read_bytes()
    unit = SolarTrakUnit(OrderedLine(emulated("0001", scenario, setting)).connect)
    with pytest.raises(ProcedureRefused, match=told):
        calibrate(unit, Journal.memory, SCHEDULE, resume=path)
    assert path.read_bytes() == before


@pytest.mark.parametrize("seed", [1, 2])
def test_a_line_that_hangs_up_again_and_again_costs_no_point(tmp_path, seed):
    path = tmp_path / "day.jsonl"
    line = OrderedLine(emulated(), LineFaults(hung_up=0.02), seed=seed)
    done = calibrate(
        SolarTrakUnit(line.connect), lambda header: Journal.create(path, header), SCHEDULE,
        pauses=Pauses(),
    )  # fmt: skip
    assert line.damages > 3
    assert done.completed
    assert len(accepted(path)) == 5
    kinds = [type(record) for record in read_session(path).records]
    assert kinds.count(LinkLost) == kinds.count(LinkRestored) > 0


def test_a_line_that_stays_away_is_given_up_and_the_session_can_be_gone_on_with(tmp_path):
    path, line, pauses = tmp_path / "day.jsonl", OrderedLine(emulated()), Pauses()
    pulled = False

    def connect():
        if pulled:
            pauses.tries_s += 4.0
            raise LinkError("port /dev/ttyUSB0 does not exist")
        return line.connect()

    def say(sentence):
        nonlocal pulled
        if path.exists() and len(accepted(path)) == 2 and not pulled:
            pulled = True
            line.hang_up()

    with pytest.raises(LinkError, match=r"does not exist; given up after 120 s"):
        calibrate(
            SolarTrakUnit(connect), lambda header: Journal.create(path, header), SCHEDULE,
            say=say, pauses=pauses,
        )  # fmt: skip
    assert pauses.waited[:5] == [1.0, 2.0, 4.0, 8.0, 15.0]
    # A try takes four seconds where nothing answers: they count.
    assert GIVE_UP_S <= pauses.utc_s() < GIVE_UP_S + 19.0
    assert isinstance(read_session(path).records[-1], LinkLost)
    pulled = False
    assert calibrate(SolarTrakUnit(connect), Journal.memory, SCHEDULE, resume=path).completed
    assert len(accepted(path)) == 5


def test_the_command_takes_a_session_up_and_says_what_cannot_be(tmp_path, capsys):
    path = tmp_path / "day.jsonl"
    interrupted_after(2, path, emulated())
    resume = ["calibrate", "--resume", str(path), "--points", "5"]
    assert run_command([*resume, "-o", "x.jsonl"]) == 2
    assert "--resume FILE goes on in that file" in capsys.readouterr().err
    assert run_command([*resume, "--tolerance", "0.2"]) == 2
    assert "a continued session has its own" in capsys.readouterr().err
    assert run_command([*resume, "--seed", "5"]) == 0
    assert len(accepted(path)) == 5
    assert run_command(resume) == 1
    assert "is finished" in capsys.readouterr().err
