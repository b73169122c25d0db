"""Bytes flipped, dropped, doubled, late and lost: no wrong value is accepted, the day gets done."""

import tracemalloc

import pytest
from faulty_bench import PersistentTechnician, calibrated, faulty_line, refused

from solarcal.emulator.line_faults import LineFaults, line_faults
from solarcal.emulator.server import serve_pty, serve_tcp
from solarcal.errors import (
    ConfigurationError,
    LinkError,
    ProcedureRefused,
    ProtocolError,
    SolarcalError,
    UnitRefused,
)
from solarcal.session.records import RefCheck, SunOffset
from solarcal.session.view import read_session
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import LINES_KEPT, SerialLink

ONE_PERCENT = [
    LineFaults(flipped=0.01),
    LineFaults(dropped=0.01),
    LineFaults(doubled=0.01),
    LineFaults(flipped=0.004, dropped=0.003, doubled=0.003),
]
PIECES = [
    LineFaults(halved=0.03),
    LineFaults(silent=0.03),
    LineFaults(delayed=0.2),
    LineFaults(babbled=0.2),
    LineFaults(flipped=0.002, dropped=0.001, doubled=0.001, halved=0.005, silent=0.005,
               delayed=0.05, babbled=0.05),
]  # fmt: skip


def named(faults: LineFaults) -> str:
    told = [name for name in LineFaults.__slots__ if getattr(faults, name)]
    return "-".join(told)


@pytest.fixture(scope="module")
def clean(tmp_path_factory) -> bytes:
    """The session of the same day over a line without faults."""
    return calibrated(faulty_line(), tmp_path_factory.mktemp("clean") / "s.jsonl")[1]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("faults", ONE_PERCENT, ids=named)
def test_at_one_percent_damaged_bytes_the_session_is_the_clean_lines_to_the_last_byte(
    tmp_path, clean, faults, seed
):
    line = faulty_line(faults, seed)
    done, session = calibrated(line, tmp_path / "s.jsonl")
    assert line.damages > 1000
    assert done.completed
    assert session == clean


@pytest.mark.parametrize("faults", PIECES, ids=named)
def test_half_lines_silence_stale_replies_and_babble_change_nothing(tmp_path, clean, faults):
    line = faulty_line(faults, 1)
    done, session = calibrated(line, tmp_path / "s.jsonl")
    assert line.damages > 10
    assert done.completed
    assert session == clean


def test_a_line_too_bad_to_work_on_is_given_up_in_one_line_and_the_session_says_so(tmp_path):
    path = tmp_path / "s.jsonl"
    line = faulty_line(LineFaults(flipped=0.002, silent=0.4), 1)
    with pytest.raises(LinkError, match="check") as lost:
        calibrated(line, path)
    assert "\n" not in str(lost.value)


def test_a_bad_line_with_interruptions_still_gets_its_points_one_by_one(tmp_path):
    """Where the repeats do not suffice either, the technician connects again and goes on."""
    line = faulty_line(LineFaults(flipped=0.01, halved=0.02, silent=0.02, delayed=0.02), 5)
    technician = PersistentTechnician(line, tmp_path / "s.jsonl", lambda step: None)
    session = technician.whole_procedure(points=2)
    assert technician.losses
    offsets = {(r.utc, r.reading_deg) for r in session.records if isinstance(r, SunOffset)}
    accepted = [p for p in session.points if p.status == "accepted"]
    assert len(accepted) == 2
    assert all((p.read_utc, p.reading_deg) in offsets for p in accepted)


@pytest.mark.parametrize("serve", [serve_pty, serve_tcp])
def test_over_a_real_line_with_damaged_bytes_every_status_is_the_units(serve):
    line = faulty_line(LineFaults(flipped=0.003, dropped=0.002, doubled=0.002), 4)
    truth = SolarTrakUnit(faulty_line().connect)
    truth.open()
    with serve(line) as url:
        # A reply takes far less on this machine; a busy one may need a repeat, and has it.
        unit = SolarTrakUnit(lambda: SerialLink(url), timing=Timing(0.1, 0.3, 20, 60))
        unit.open()
        for _ in range(12):
            assert unit.status() == truth.status()
            assert unit.emulation.advance(60.0) == truth.emulation.advance(60.0)
        assert unit.parameters() == truth.parameters()
        unit.close()
    assert line.damages > 20


# -- babble --------------------------------------------------------------------------------------


class Babbling:
    """Noise of a line nobody terminates, ``total`` bytes a request, with or without line ends."""

    def __init__(self, total: int, line_ends: bool) -> None:
        piece = b"\xa5\x00babble*<>" * 400
        self._pieces = [piece + b"\n" if line_ends else piece] * (total // len(piece))

    def handle_input(self, data: bytes) -> list[bytes]:
        return self._pieces

    def catch_up(self) -> None: ...

    def link_lost(self) -> None: ...


@pytest.mark.parametrize("line_ends", [False, True], ids=["endless-line", "lines"])
def test_under_babble_memory_is_bounded_and_the_port_is_named(line_ends):
    with serve_tcp(Babbling(4_000_000, line_ends)) as url:
        unit = SolarTrakUnit(lambda: SerialLink(url), port=url, timing=Timing(0.2, 1.0, 1, 5))
        tracemalloc.start()
        try:
            with pytest.raises(ProtocolError, match="not in the SolarTrak protocol") as refusal:
                unit.open()
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
            unit.close()
    assert url in str(refusal.value)
    assert peak < 1_500_000
    assert peak > LINES_KEPT * 300  # the measure itself sees what is kept


def test_the_unit_keeps_no_more_of_babble_than_one_line():
    line = faulty_line()
    babble = b"x" * 65536
    tracemalloc.start()
    try:
        before, _ = tracemalloc.get_traced_memory()
        replies = [line.emulator.handle_input(babble) for _ in range(100)]
        after, _ = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert sum(len(some) for some in replies) == 1  # told of the damage once
    assert after - before < 200_000


# -- the unit itself -----------------------------------------------------------------------------


def test_another_unit_after_reconnection_is_refused_and_the_right_one_taken_again(tmp_path):
    line = faulty_line()
    technician = PersistentTechnician(line, tmp_path / "s.jsonl", lambda step: None)
    station = technician.station
    technician.step("reference check", technician.reference_check)
    other = faulty_line(None, 0, "unit.serial=EMU-9999")
    right, line.emulator = line.emulator, other.emulator
    line.hang_up()
    with pytest.raises(LinkError) as lost:
        station.poll()
    station.link_lost(lost.value)
    said = refused(station.reconnect)
    assert "another unit answers" in said
    assert "EMU-9999" in said
    assert "needs a connected unit" in refused(station.ref_check)
    with pytest.raises(LinkError, match="not open"):
        station.track()
    line.emulator = right
    assert station.reconnect().serial != "EMU-9999"
    technician.step("reference check", technician.reference_check)


def test_a_unit_that_reboots_before_any_step_gives_no_point_that_is_not_true(tmp_path):
    """It comes back unreferenced, without its offsets: the point is refused, not taken wrong."""
    for at in ("centre", "sun offset", "watch", "questions", "gather", "store"):
        line = faulty_line()
        rebooted: list[str] = []

        def reboot(step: str, at=at, line=line, rebooted=rebooted) -> None:
            if step == at and not rebooted:
                rebooted.append(step)
                line.emulator.reboot()

        path = tmp_path / f"{at}.jsonl"
        technician = PersistentTechnician(line, path, reboot)
        technician.step("reference check", technician.reference_check)
        technician.step("clock", technician.station.set_unit_clock)
        technician.step("initialise", lambda t=technician: t.station.initialise(confirmed=True))
        technician.station.clock.wait(120.0)
        stands = technician.station.poll()
        assert stands.referenced
        if at == "store":
            # Gathered before the power went: the readings were good.
            technician.point(check=False)
            assert len(technician.station.session.accepted) == 1
            continue
        with pytest.raises((UnitRefused, ProcedureRefused)):
            technician.point(check=False)
        assert rebooted == [at]
        assert technician.station.session.accepted == ()
        if technician.station.state.attempt is not None:
            technician.station.abort_attempt("the unit had no power")
        technician.step("reference check", technician.reference_check)
        technician.point(check=False)
        assert len(technician.station.session.accepted) == 1


def test_a_unit_that_reboots_again_and_again_is_referenced_anew_and_no_point_is_untrue(tmp_path):
    """Where it reboots too often the technician gives up in words; what was stored is true."""
    completed, reboots, checks = 0, 0, 0
    given_up: list[str] = []
    for seed in (2, 3, 5):
        line = faulty_line(LineFaults(rebooted=0.003), seed)
        path = tmp_path / f"{seed}.jsonl"
        try:
            done, _ = calibrated(line, path)
        except SolarcalError as error:
            given_up.append(str(error))
        else:
            completed += 1
            assert len(done.session.accepted) == 4
        session = read_session(path)
        reboots += line.damages
        checks += sum(isinstance(r, RefCheck) for r in session.records)
        offsets = {(r.utc, r.reading_deg) for r in session.records if isinstance(r, SunOffset)}
        accepted = [p for p in session.points if p.status == "accepted"]
        assert all((p.read_utc, p.reading_deg) in offsets for p in accepted)
    assert completed
    assert not any("\n" in words for words in given_up)
    assert reboots > 5
    # Three belong to every undisturbed day.
    assert checks > 9


def test_faults_are_written_as_pairs_of_name_and_probability():
    assert line_faults("flipped=0.01, silent=0.2") == LineFaults(flipped=0.01, silent=0.2)
    for text, said in (
        ("flipped", "needs a probability"),
        ("flipped=x", "needs a probability"),
        ("eaten=0.1", "no line fault 'eaten'; there is: flipped, dropped"),
        ("flipped=nan", "flipped is a probability"),
        ("", "no line fault ''"),
    ):
        with pytest.raises(ConfigurationError, match=said):
            line_faults(text)


def test_faults_are_probabilities():
    with pytest.raises(ConfigurationError, match="flipped is a probability"):
        LineFaults(flipped=1.5)
    with pytest.raises(ConfigurationError, match="more than all bytes"):
        LineFaults(flipped=0.5, dropped=0.4, doubled=0.3)


def test_the_same_seed_damages_the_same_bytes():
    said = []
    for seed in (1, 1, 2):
        line = faulty_line(LineFaults(flipped=0.05, delayed=0.1, babbled=0.1), seed)
        said.append([line.handle_input(b">0001 ID*00000000\r\n") for _ in range(30)])
    assert said[0] == said[1] != said[2]
