"""Against Hamlib's own ``rotctld`` with its dummy rotator, where it is installed.

The dummy turns 6 deg a second of real time, so the Sun is one that stands low over the rotator's
resting place: 60 deg South in June, at noon. Waiting for the Sun leaps over the time.
"""

import re
import shutil
import socket
import subprocess

import numpy as np
import pytest

from solarcal.emulator.rotator import EmulatedRotator
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import LinkError, UnitRefused
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.profiles import MountDescription, Profile
from solarcal.session.journal import Journal
from solarcal.site import Site
from solarcal.station.connect import Connection, open_tracker
from solarcal.station.fitting import solve
from solarcal.station.procedure import Station
from solarcal.station.software_controller.coefficient_store import FileStore
from solarcal.station.software_controller.rotator_tracker import RotatorTracker
from solarcal.sun import sun_position
from solarcal.timescale import SystemClock, parse_utc
from solarcal.unit.drivers.rotctld import LINES_KEPT, RotctldRotator
from solarcal.unit.tracker import Mode

ROTCTLD = shutil.which("rotctld")
pytestmark = pytest.mark.skipif(
    ROTCTLD is None, reason="Hamlib's rotctld is not installed (Debian: libhamlib-utils)"
)

SITE = Site(-60.0, -68.0, 20.0)
NOON = parse_utc("2026-06-21T16:10:00Z")
LEAN = Coefficients(P1=0.35, P2=-0.4, P3=-0.2, P4=0.3)
PATIENCE = 600
"""Looks, a twentieth of a second each, before a test gives the rotator up."""


class Server:
    """A rotctld of our own."""

    def __init__(self, port):
        self.port = port
        self.address = f"127.0.0.1:{self.port}"
        self._process = None
        self.start()

    def start(self):
        command = [ROTCTLD, "-m", "1", "-T", "127.0.0.1", "-t", str(self.port)]
        self._process = subprocess.Popen(
            command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        for _ in range(PATIENCE):
            assert self._process.poll() is None, "rotctld ended by itself"
            try:
                self.say("+\\get_pos")
                return
            except ConnectionRefusedError:
                SystemClock().wait(0.05)
        raise AssertionError("rotctld does not listen")

    def stop(self):
        self._process.kill()
        self._process.wait()

    def say(self, *lines):
        """What rotctld itself answers, line by line; it has ended the connection afterwards."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=10.0) as connection:
            stream = connection.makefile("rw", encoding="ascii", newline="\n")
            answers = []
            for text in lines:
                stream.write(text + "\n")
                stream.flush()
                answer = []
                while not answer or not answer[-1].startswith("RPRT"):
                    line = stream.readline()
                    assert line, f"rotctld hung up on {text}"
                    answer.append(line.rstrip("\n"))
                answers.append(answer)
            stream.write("q\n")
            stream.flush()
            assert stream.read() == ""
            return answers


@pytest.fixture
def server(free_port):
    running = Server(free_port())
    yield running
    running.stop()


class LeapingClock:
    """Leaps over waits of a second and more; shorter ones are for the rotator, and are real."""

    def __init__(self, utc_s):
        self._real = SystemClock()
        self._ahead_s = utc_s - self._real.utc_s()

    def utc_s(self):
        return self._real.utc_s() + self._ahead_s

    def wait(self, seconds):
        if seconds >= 1.0:
            self._ahead_s += seconds
        else:
            self._real.wait(seconds)


class Bench:
    def __init__(self, server, folder):
        self.clock = LeapingClock(NOON)
        way = Connection()
        self.tracker = RotatorTracker(
            RotctldRotator(
                way.link(f"socket://{server.address}", lines_kept=LINES_KEPT), server.address
            ),
            "dummy",
            MountDescription(reference1_deg=179.9, reference2_deg=84.0),
            SITE,
            self.clock,
            lambda model, serial: FileStore(folder / "dummy.toml"),
        )
        self.station = Station(self.tracker, self.clock, site=SITE, operator="test")
        self.station.connect()

    def rests(self):
        for _ in range(PATIENCE):
            status = self.station.poll()
            if status.moving == (0, 0) and status.mode not in (Mode.JOG, Mode.REF):
                return status
            self.clock.wait(0.05)
        raise AssertionError(f"never at rest: {status}")

    def go(self, target1, target2):
        for _ in range(PATIENCE):
            self.station.jog(target1, target2)
            self.clock.wait(0.05)
            status = self.station.poll()
            off = max(abs(status.reading1_deg - target1), abs(status.reading2_deg - target2))
            if off <= 0.011:
                return self.rests()
        raise AssertionError(f"never there: {status}")

    def onto_the_sun(self):
        """Where a tower that leans sees it: the technician's eye."""
        sun = sun_position("solartrak", self.clock.utc_s(), SITE)
        ax1, ax2 = self.station.geometry.axes_from_horizontal(sun.azimuth_deg, sun.zenith_deg)
        e1, e2 = correction_deg(LEAN, ax1, ax2)
        return self.go(float(ax1 + e1), float(ax2 + e2))

    def point(self, *, check=False):
        station = self.station
        self.onto_the_sun()
        station.set_sun_offset()
        station.track()
        self.rests()
        station.begin_point(check=check)
        for _ in range(3):
            station.answer(True)
        station.gather_point()
        return station.store(True)


def test_the_whole_procedure_on_hamlibs_dummy_rotator(server, tmp_path):
    bench = Bench(server, tmp_path)
    station = bench.station
    assert station.state.live.identity.model == "Hamlib Dummy"
    station.open_session(lambda header: Journal.create(tmp_path / "day.jsonl", header))
    station.set_unit_clock()
    # Near it already: the waits of a check are leapt over, and the dummy would not get there.
    bench.go(180.0, 84.2)
    station.tracker.start_ref_check()
    bench.rests()
    check = station.ref_check()
    assert check.complete
    assert max(map(abs, check.difference_counts)) <= 1
    station.track()
    bench.rests()
    station.initialise(confirmed=True)
    points = []
    for _ in range(3):
        points.append(bench.point())
        bench.clock.wait(600.0)
    solution = solve(station.session, "linear")
    for point in points:
        assert np.array(point.error_deg) == pytest.approx(
            [float(e) for e in correction_deg(LEAN, *point.ideal_deg)], abs=0.02
        )
        assert solution.predict_deg(*map(np.asarray, point.ideal_deg)) == pytest.approx(
            point.error_deg, abs=0.02
        )
    # What these few points over the shortest day give would be no good elsewhere: the true lean.
    upload = station.upload(LEAN, method="linear")
    assert upload.verified
    left = bench.point(check=True)
    assert left.sky_error_deg < 0.03
    station.track()
    status = bench.rests()
    e1, e2 = correction_deg(LEAN, status.ideal1_deg, status.ideal2_deg)
    assert status.reading1_deg - status.ideal1_deg == pytest.approx(float(e1), abs=0.08)
    assert status.reading2_deg - status.ideal2_deg == pytest.approx(float(e2), abs=0.08)
    station.stop()
    station.close()
    again = Bench(server, tmp_path)
    assert again.tracker.stored().coefficients == LEAN
    again.tracker.close()


def test_connecting_leads_to_it_and_its_limits_are_the_rotators(server, monkeypatch, tmp_path):
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path))
    profile = Profile(site=Site(35.0, -106.0), mount=MountDescription(unit_name="roof"))
    tracker = open_tracker(server.address, "rotctld", profile=profile)
    parameters = tracker.parameters()
    assert (parameters.limits.axis1.low_deg, parameters.limits.axis1.high_deg) == (-180.0, 180.0)
    assert (parameters.limits.axis2.low_deg, parameters.limits.axis2.high_deg) == (0.0, 90.0)
    with pytest.raises(UnitRefused, match="beyond"):
        tracker.jog(0.0, 91.0)
    tracker.close()


def test_a_rotctld_that_ends_is_a_lost_line_and_its_successor_is_found(server, tmp_path):
    bench = Bench(server, tmp_path)
    server.stop()
    with pytest.raises(LinkError):
        bench.tracker.status()
    with pytest.raises(LinkError, match="no answer from"):
        bench.tracker.open()
    server.start()
    assert bench.tracker.open().model == "Hamlib Dummy"
    assert bench.tracker.status().mode is Mode.MANUAL
    bench.tracker.close()


def test_what_hamlib_refuses_comes_as_a_refusal(server):
    link = Connection().link(f"socket://{server.address}", lines_kept=LINES_KEPT)
    rotator = RotctldRotator(link, server.address)
    rotator.open()
    with pytest.raises(UnitRefused, match=r"beyond the rotator's range \(code -1\)"):
        rotator.go_to(10.0, 95.0, rotator.stops())
    assert rotator.position_deg() == (0.0, 0.0)
    rotator.close()


def test_the_emulated_rotator_speaks_as_hamlibs_own_does(server):
    ours = EmulatedRotator(load_scenario("tijeras-azel", []))
    asked = (
        "+\\get_pos", "+\\dump_state", "+\\stop", "+\\park", "+\\set_pos 90.5 20",
        "+\\set_pos 999 20", "+\\set_pos 90.5 95", "+\\set_pos 90.5",
    )  # fmt: skip
    for text, theirs in zip(asked, server.say(*asked[:-1]), strict=False):
        lines = ours.handle_input(text.encode() + b"\n")
        assert [_shape(line.decode().strip()) for line in lines] == [
            _shape(line) for line in theirs
        ], text


def _shape(line):
    """A reply line with its own numbers taken out, but for those of RPRT and an echo."""
    if line.startswith(("RPRT", "set_pos")):
        return line
    return re.sub(r"-?[0-9]+(\.([0-9]+))?", lambda found: "#" * len(found[2] or ""), line)
