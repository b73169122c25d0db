"""Nothing moves, is written or runs but by the technician's word; strangers' text stays text."""

import os
import re
import zipfile
from pathlib import Path

import msgspec
import pytest
from faulty_bench import PersistentTechnician, faulty_line, refused

from soak.journal_writer import HEADER
from solarcal.cli import run_command
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.rotator import EmulatedRotator
from solarcal.emulator.rotator_protocols import EasyCommProtocol, RotctldProtocol
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink, serve_pty, serve_tcp
from solarcal.errors import ConfigurationError, LinkError, UnitRefused, harmless
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.profiles import Profile, load_profile, save_profile
from solarcal.session.journal import Journal
from solarcal.session.lines import sealed
from solarcal.session.records import Answers, Note, PointRecord
from solarcal.session.view import read_session
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.easycomm import EasyCommRotator
from solarcal.unit.drivers.rotctld import RotctldRotator
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.frames import decode_request
from solarcal.unit.link import SerialLink
from solarcal.unit.tracker import Mode

SAVED = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"


# -- by word of command only -----------------------------------------------------------------------


class Overheard(InProcessLink):
    """A line in this process that keeps what the station said."""

    def __init__(self, emulator: Emulator) -> None:
        super().__init__(emulator)
        self.said: list[str] = []

    def write(self, data: bytes) -> None:
        self.said.append(decode_request(data).text)
        super().write(data)


def commands(said: list[str]) -> list[str]:
    """Of what was said, all that writes or moves."""
    asks = ("OPEN ", "ID", "STATUS", "COEF STORED", "X TIME", "X SPOT", "X SKY", "X TRUTH")
    reads = ("CLOCK", "SITE", "REF", "COEF")
    return [
        text
        for text in said
        if not text.startswith(asks)
        and text not in reads
        and not (text.startswith("PARAM ") and text.count(" ") == 1)
    ]


def test_connecting_looking_and_leaving_commands_nothing(tmp_path):
    line = faulty_line()
    link = Overheard(line.emulator)
    technician = PersistentTechnician(line, tmp_path / "s.jsonl", lambda step: None)
    station = technician.station
    station.tracker = SolarTrakUnit(lambda: link)
    station.connect()
    station.poll()
    station.note("only looking")
    assert "needs" in refused(lambda: station.initialise(confirmed=False))
    station.close()
    assert "STATUS" in link.said
    assert commands(link.said) == []
    # The measure sees what does command.
    assert commands(["UNLOCK", "MODE TRACK", "STATUS", "PARAM update_range 0.2"]) == [
        "UNLOCK",
        "MODE TRACK",
        "PARAM update_range 0.2",
    ]


def test_a_jog_beyond_the_limits_never_reaches_the_line(tmp_path):
    """Also where the unit itself would allow it."""
    line = faulty_line()
    technician = PersistentTechnician(line, tmp_path / "s.jsonl", lambda step: None)
    technician.step("reference check", technician.reference_check)
    frames = line.frames
    said = refused(lambda: technician.station.jog(500.0, 45.0))
    assert "beyond a limit" in said
    assert line.frames == frames
    technician.station.jog(-10.0, 45.0)
    assert line.frames > frames


def test_an_unlock_runs_out_and_is_asked_for_anew():
    link = Overheard(Emulator(load_scenario("tijeras-azel")))
    unit = SolarTrakUnit(lambda: link)
    unit.open()
    for waited_s, unlocks in ((0.0, 1), (30.0, 1), (61.0, 2)):
        assert unit.emulation is not None
        unit.emulation.advance(waited_s)
        unit.write_coefficients(Coefficients(P1=0.1), Offsets())
        assert link.said.count("UNLOCK") == unlocks
    unit.emulation.advance(61.0)
    # Without the unlock the unit does nothing, whatever asks.
    with pytest.raises(UnitRefused, match="locked"):
        unit._talk.ask("MODE", "TRACK")


# -- one station a port ----------------------------------------------------------------------------


def test_a_second_station_on_a_serial_line_is_refused():
    with serve_pty(Emulator(load_scenario("tijeras-azel"))) as port:
        first = SerialLink(port)
        with pytest.raises(LinkError, match="in use by another program; close that one first"):
            SerialLink(port)
        first.close()
        SerialLink(port).close()


def test_a_second_station_on_a_socket_is_refused_and_told_why():
    with serve_tcp(Emulator(load_scenario("tijeras-azel"))) as url:
        first = SolarTrakUnit(lambda: SerialLink(url), port=url)
        first.open()
        second = SolarTrakUnit(lambda: SerialLink(url), port=url, timing=Timing(2.0, 2.0, 1, 5))
        with pytest.raises(LinkError, match="in use by another station; close that one first"):
            second.open()
        second.close()
        assert first.status().mode in Mode
        first.close()


@pytest.mark.parametrize(
    ("driver", "protocol"), [(RotctldRotator, RotctldProtocol), (EasyCommRotator, EasyCommProtocol)]
)
def test_a_second_station_on_the_socket_of_a_rotator_is_told_why(driver, protocol):
    rotator = EmulatedRotator(load_scenario("tijeras-azel"))
    rotator.protocol = protocol()
    with serve_tcp(rotator) as url:
        first = driver(lambda: SerialLink(url), "roof")
        first.open()
        second = driver(lambda: SerialLink(url), "roof")
        with pytest.raises(LinkError, match="roof is in use by another station; close that one"):
            second.open()
        second.close()
        first.position_deg()
        first.close()


@pytest.mark.parametrize(
    "port", ["spy:///dev/ttyS0?file={}", "alt:///dev/ttyS0?class=X", "SPY://x"]
)
def test_a_ports_name_writes_no_file(tmp_path, port):
    """pyserial's spy:// would open any file for writing, and a profile names the port."""
    target = tmp_path / "precious"
    target.write_text("precious")
    with pytest.raises(LinkError, match="cannot be opened: give a device"):
        SerialLink(port.format(target))
    assert target.read_text() == "precious"


# -- files name no places and run nothing ----------------------------------------------------------


@pytest.mark.parametrize("name", ["../evil", "/tmp/evil", "a/b", "..", "a\x00b", "x" * 41])
def test_a_profiles_name_leads_nowhere_else(tmp_path, monkeypatch, name):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path / "config"))
    with pytest.raises(ConfigurationError, match="letters, digits, spaces"):
        save_profile(Profile(name=name))
    with pytest.raises(ConfigurationError, match="letters, digits, spaces"):
        load_profile(name)
    assert list(tmp_path.rglob("*")) == []


def hostile_session(path: Path) -> str:
    """A session whose every text tries something; the words that must come out as they are."""
    evil = (
        "\x1b[2J\x1b]0;owned\x07<script>alert(1)</script><img src=x onerror=alert(1)>"
        "[link](javascript:alert(1)) | `x` ../../../../etc/evil \u202eetirw"
    )
    lines = SAVED.read_bytes().splitlines(keepends=True)
    header = msgspec.json.decode(lines[0])
    for field in ("operator", "pointing_device", "continues", "software"):
        header[field] = evil
    header["unit"] |= {"model": evil, "serial": evil, "firmware": evil}
    header["site"]["name"] = evil
    path.write_bytes(sealed(msgspec.json.encode(header)) + b"".join(lines[1:-1]))
    with Journal.resume(path) as journal:
        utc = journal.records[-1].utc
        journal.append(Note(seq=journal.next_seq, utc=utc, text=evil))
        journal.append(
            PointRecord(
                seq=journal.next_seq, utc=utc, status="aborted", answers=Answers(), reason=evil
            )
        )
    return evil


def test_what_a_session_says_is_text_on_every_output(tmp_path, monkeypatch, capsys):
    folder = tmp_path / "in"
    folder.mkdir()
    path = folder / "hostile.jsonl"
    hostile_session(path)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(folder))
    outputs = [folder / f"c.{ending}" for ending in ("html", "md", "svg", "txt")]
    for output in outputs:
        assert run_command(["report", str(path), "-o", str(output), "--zip"]) in (0, 1)
    for words in (
        ["fit", str(path)],
        ["fit", str(path), "--json"],
        ["replay", str(path), "--headless"],
        ["forecast", str(path)],
        ["export", str(path), str(folder / "out.csv")],
    ):
        assert run_command(words) in (0, 1)
        said = capsys.readouterr()
        assert harmless(said.out) == said.out, words
        assert harmless(said.err) == said.err, words
    for output in (*outputs, folder / "out.csv"):
        text = output.read_text(encoding="utf-8")
        assert harmless(text) == text, output
        if output.suffix in (".html", ".md", ".svg"):
            # Markdown puts a backslash before what would be markup.
            assert not re.search(r"(?<!\\)<(script|img)", text), output
            assert not re.search(r"(?<!\\)\]\(javascript", text) or output.suffix != ".md"
    with zipfile.ZipFile(folder / "c.zip") as archive:
        assert all(os.path.basename(name) == name for name in archive.namelist())
    # Nothing was written but beside what was asked for.
    assert sorted(p.name for p in tmp_path.iterdir()) == ["in"]
    assert sorted(p.name for p in folder.iterdir()) == sorted(
        [path.name, "c.zip", "out.csv", *(output.name for output in outputs)]
    )


def test_going_on_with_a_hostile_session_keeps_to_its_folder(tmp_path):
    path = tmp_path / "s.jsonl"
    hostile_session(path)
    session = read_session(path)
    assert harmless(session.header.operator) == session.header.operator
    assert r"\x1b[2J" in session.header.operator
    with Journal.resume(path) as journal:
        assert journal.header == session.header
    assert [p.name for p in tmp_path.iterdir()] == ["s.jsonl"]


def test_a_scenario_reads_no_device_and_says_what_it_extends(tmp_path):
    path = tmp_path / "s.toml"
    for target, said in (
        ("/dev/zero", "cannot be read: it is"),
        ("../nowhere", "is missing: no such file"),
    ):
        path.write_text(f'extends = "{target}"\n')
        with pytest.raises(ConfigurationError, match=said) as refusal:
            load_scenario(path)
        assert str(path) in str(refusal.value)


def test_an_error_message_is_one_harmless_line(capsys):
    assert run_command(["fit", "no\x1b[2J\nsuch\x9b.csv"]) == 2
    said = capsys.readouterr().err
    assert harmless(said) == said
    assert said.count("\n") == 1
    assert r"\x1b[2J" in said


def test_a_header_of_a_stranger_is_what_it_was_but_harmless(tmp_path):
    path = tmp_path / "s.jsonl"
    with Journal.create(path, msgspec.structs.replace(HEADER, operator="J\tSmith\nIII")):
        pass
    assert read_session(path).header.operator == "J\tSmith\nIII"
