"""The emulator on a real pseudo-terminal, on TCP and in process, spoken to in raw lines."""

import os
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.line_faults import FaultyLine, LineFaults
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink, exposure, serve_pty, serve_tcp, tcp_address
from solarcal.errors import ConfigurationError, LinkError
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.frames import Request, decode_reply, encode_request
from solarcal.unit.link import SerialLink
from solarcal.unit.tracker import Mode

ID = encode_request(Request(1, "ID"))
STATUS = encode_request(Request(2, "STATUS"))


@pytest.fixture
def emulator():
    return Emulator(load_scenario("tijeras-azel"))


def answer(link, frame: bytes):
    link.write(frame)
    line = link.read_line(5.0)
    assert line is not None
    return decode_reply(line)


def test_the_same_lines_in_process_on_a_pty_and_on_a_socket(emulator, tmp_path):
    frames = [
        encode_request(Request(number, *text.split(" ", 1)[:1], tuple(text.split()[1:])))
        for number, text in enumerate(
            ("OPEN 0123ABCD", "UNLOCK", "REF START", "X ADVANCE 50", "MODE TRACK",
             "X ADVANCE 3600.5", "X SPOT", "STATUS", "X TRUTH"),
            start=10,
        )
    ]  # fmt: skip

    def said(link):
        replies = [answer(link, frame) for frame in frames]
        link.close()
        return replies

    scenario = load_scenario("tijeras-azel")
    in_process = said(InProcessLink(emulator))
    with serve_pty(Emulator(scenario), tmp_path / "tracker") as port:
        on_a_pty = said(SerialLink(port))
    with serve_tcp(Emulator(scenario)) as url:
        on_a_socket = said(SerialLink(url))
    assert in_process[-2].fields[0] == "TRACK"
    assert in_process == on_a_pty == on_a_socket


def test_a_pty_survives_its_station_and_its_link_goes_with_it(emulator, tmp_path):
    link = tmp_path / "tracker"
    with serve_pty(emulator, link) as port:
        assert Path(port) == link
        assert link.is_symlink()
        for _ in range(3):
            line = SerialLink(port)
            assert answer(line, ID).fields[0] == "SOLARTRAK-EMU"
            line.close()
    assert not link.is_symlink()


def test_a_pty_without_a_link_has_a_name(emulator):
    with serve_pty(emulator) as port:
        line = SerialLink(port)
        assert answer(line, STATUS).fields[0] == "MANUAL"
        line.close()


def test_a_link_that_exists_is_not_overwritten_but_a_dead_one_is(emulator, tmp_path):
    taken = tmp_path / "file"
    taken.write_text("mine")
    with pytest.raises(ConfigurationError, match="exists already"), serve_pty(emulator, taken):
        pass
    assert taken.read_text() == "mine"
    dead = tmp_path / "dead"
    dead.symlink_to(tmp_path / "gone")
    with serve_pty(emulator, dead):
        assert os.readlink(dead) != str(tmp_path / "gone")


def test_tcp_stations_may_come_one_after_the_other(emulator):
    with serve_tcp(emulator) as url:
        for _ in range(3):
            line = SerialLink(url)
            assert answer(line, ID).fields[0] == "SOLARTRAK-EMU"
            line.close()


def test_a_second_simultaneous_tcp_station_is_told_and_closed(emulator):
    with serve_tcp(emulator) as url:
        address = ("127.0.0.1", int(url.rpartition(":")[2]))
        first = SerialLink(url)
        answer(first, ID)
        with socket.create_connection(address, timeout=5.0) as second:
            said = b""
            while chunk := second.recv(100):
                said += chunk
        assert said == b"# busy: one station at a time\r\n"
        assert answer(first, STATUS).fields[0] == "MANUAL"
        first.close()


def test_a_lost_tcp_station_ends_its_jog(emulator):
    emulator.controller.unlock(0.0)
    emulator.controller.start_ref_check(0.0)
    emulator.advance(60.0)
    with serve_tcp(emulator) as url:
        line = SerialLink(url)
        for number, text in enumerate(("UNLOCK", "JOG 60.0 60.0"), start=20):
            verb, *arguments = text.split()
            assert not answer(line, encode_request(Request(number, verb, tuple(arguments)))).refused
        line.close()
        # The next station is served only after the former one has been seen off.
        line = SerialLink(url)
        status = answer(line, STATUS).fields
        line.close()
    assert status[0] == Mode.MANUAL
    assert status[12] == ".."


def test_an_in_process_link_is_silent_when_the_unit_is(emulator):
    link = InProcessLink(emulator)
    answer(link, encode_request(Request(3, "X", ("FAULT", "mute"))))
    link.write(ID)
    assert link.read_line(1.0) is None
    link.close()
    with pytest.raises(LinkError):
        link.write(ID)
    with pytest.raises(LinkError):
        link.read_line(1.0)


@pytest.mark.parametrize("text", ["nowhere", "host:", "host:seven", "host:70000"])
def test_an_address_must_be_host_and_port(text):
    with pytest.raises(ConfigurationError, match="HOST:PORT"):
        tcp_address(text)


def test_addresses():
    assert tcp_address(":7000") == ("127.0.0.1", 7000)
    assert tcp_address("[::1]:7000") == ("::1", 7000)


def test_an_address_in_use_is_refused_in_one_line(emulator):
    with (
        serve_tcp(emulator) as url,
        pytest.raises(ConfigurationError, match=r"cannot serve on 127\.0\.0\.1"),
        serve_tcp(emulator, "127.0.0.1", int(url.rpartition(":")[2])),
    ):
        pass


def test_the_command_serves_until_terminated_and_cleans_up(tmp_path):
    link = tmp_path / "tracker"
    process = subprocess.Popen(
        [sys.executable, "-m", "solarcal", "emulate", "--pty", str(link), "--scenario", "southern"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None
        assert process.stdout.readline() == f"connect to {link}\n"
        line = SerialLink(str(link))
        assert answer(line, encode_request(Request(1, "SITE"))).fields[0] == "-33.90000"
        line.close()
    finally:
        process.terminate()
        process.wait(timeout=10.0)
        process.stdout.close()
    assert process.returncode == 0
    assert not link.is_symlink()


# -- a bad line, and who can reach it --------------------------------------------------------------


def test_a_line_that_hangs_up_ends_the_connection_and_takes_the_next():
    emulator = Emulator(load_scenario("tijeras-azel"))
    line = FaultyLine(emulator, LineFaults(hung_up=0.3), seed=1)
    losses = 0
    with serve_tcp(line) as url:
        unit = SolarTrakUnit(lambda: SerialLink(url), timing=Timing(0.2, 0.2, 20, 60))
        for _ in range(4):
            try:
                unit.open()
                unit.status()
            except LinkError:
                losses += 1
        unit.close()
    assert 0 < losses == line.damages


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost", "127.0.0.53", "no such host"])
def test_serving_this_machine_alone_exposes_nothing(host):
    assert exposure(host) == ""


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.7"])
def test_serving_the_network_is_said_with_what_it_exposes(host):
    said = exposure(host)
    assert host in said
    assert "move the emulated unit's axes" in said
    assert "no password" in said


def test_a_link_whose_pseudo_terminal_is_anothers_by_now_is_replaced(tmp_path, emulator):
    """Numbers are given again: what a killed emulator left points to somebody's new terminal."""
    link = tmp_path / "tracker"
    other, terminal = os.openpty()
    try:
        link.symlink_to(os.ttyname(terminal))
        # In use since before the link was made: not to be taken away.
        with pytest.raises(ConfigurationError, match="exists already"), serve_pty(emulator, link):
            pass
        os.utime(link, ns=(0, 0), follow_symlinks=False)
        with serve_pty(emulator, link) as name:
            assert name == str(link)
            assert link.readlink() != Path(os.ttyname(terminal))
        assert not link.is_symlink()
    finally:
        os.close(other)
        os.close(terminal)
