"""A client written from docs/protocol.md alone: page and emulated unit agree to the letter.

Nothing of the program's own protocol code is used here: frames, values and ranges are the page's.
"""

import math
import socket
import zlib

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import serve_tcp

NAMES = (
    "mode", "local_time", "ideal1", "ideal2", "reading1", "reading2", "counts1", "counts2",
    "target1", "target2", "O1", "O2", "motion", "approach", "phase", "flags", "unlocked",
)  # fmt: skip
"""Fields of STATUS, in order."""


def framed(body):
    return f"{body}*{zlib.crc32(body.encode('latin-1')):08X}"


class Client:
    """A station as the page describes one; ``code`` is that of the last refusal."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10.0)
        self.lines = self.socket.makefile("rb")
        self.number = 0

    def raw(self, line):
        """Send a line as it stands; the line that comes back."""
        self.socket.sendall(line.encode("latin-1") + b"\r\n")
        return self.lines.readline().decode("ascii").rstrip("\r\n")

    def body(self, line):
        """What a frame says, its checksum checked."""
        body, _, crc = line.rpartition("*")
        assert framed(body) == f"{body}*{crc}"
        return body

    def ask(self, text, number=None):
        """The fields of the result, or the code of the refusal."""
        if number is None:
            self.number = number = (self.number + 1) & 0xFFFF
        seq = f"{number:04X}"
        body = self.body(self.raw(framed(f">{seq} {text}")))
        assert body.startswith(f"<{seq} "), body
        kind, _, rest = body[6:].partition(" ")
        if kind == "NO":
            return int(rest.split(" ")[0])
        assert kind == "OK"
        return rest.split(" ") if rest else []

    def unlocked(self, text):
        assert self.ask("UNLOCK") == ["60"]
        return self.ask(text)

    def status(self):
        fields = self.ask("STATUS")
        assert len(fields) == len(NAMES)
        return dict(zip(NAMES, fields, strict=True))

    def close(self):
        self.lines.close()
        self.socket.close()


@pytest.fixture
def port():
    with serve_tcp(Emulator(load_scenario("tijeras-azel", []), seed=1)) as url:
        yield int(url.rpartition(":")[2])


@pytest.fixture
def client(port):
    client = Client(port)
    assert client.ask("OPEN 5C0FFEE5") == ["5C0FFEE5"]
    yield client
    client.close()


def referenced(client):
    """Through a reference check, the time let pass by the emulator."""
    assert client.unlocked("REF START") == ["1"]
    assert client.status()["mode"] == "REF"
    for _ in range(60):
        client.ask("X ADVANCE 30")
        if client.status()["mode"] != "REF":
            break
    number, state, _, _ = client.ask("REF")
    assert (number, state) == ("1", "DONE")
    assert client.status()["mode"] == "MANUAL"


def test_the_page_s_own_frames_have_the_page_s_checksums(client):
    assert framed(">0001 OPEN 5C0FFEE5") == ">0001 OPEN 5C0FFEE5*030B2BD5"
    assert client.raw(">0001 OPEN 5C0FFEE5*030B2BD5") == "<0001 OK 5C0FFEE5*E83D4172"
    assert client.ask("ID", 2)[3:] == ["1", "X"]
    locked = "COEF SET 0.0512 -0.1200 0.3000 0.0411 0.000300 -0.000100 0.0000 0.0000"
    assert client.raw(framed(f">0003 {locked}")) == "<0003 NO 20 locked*AA9B56D0"


@pytest.mark.parametrize(
    "line",
    [
        ">0005 ID*00000000",
        framed(">0005  ID"),
        framed(">0005 ID "),
        framed(">0005 CLOCK\tSET"),
        framed(">0005 ID\x07"),
        framed(">00aF ID"),
        framed("0005 ID"),
        framed(">0005"),
        "hello",
        "x" * 400,
    ],
)
def test_what_is_no_frame_is_damaged_whatever_its_checksum(client, line):
    assert client.body(client.raw(line)) == "<---- NO 10 damaged frame"


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("HELLO", 11),
        ("ID please", 13),
        ("OPEN 123", 13),
        ("OPEN 5c0ffee5", 13),
        ("PARAM nothing", 13),
        ("MODE SLEEP", 13),
        ("JOG 1.0", 13),
        ("JOG 1e1 2.0", 13),
        ("JOG +1.0 2.0", 13),
        ("JOG 10.0 40.0", 20),
        ("COEF SET 0 0 0 0 0 0 0 0", 20),
        ("STORE", 20),
        ("X ADVANCE 86400.5", 13),
        ("X ADVANCE -1", 13),
        ("X SPEED 1000001", 13),
        ("X NOTHING", 11),
        ("X FAULT flood", 13),
    ],
)
def test_refusals_have_the_page_s_codes(client, text, code):
    assert client.ask(text) == code


@pytest.mark.parametrize(
    ("text", "answer"),
    [
        ("SITE SET 35.0 -180.0 1800.0 7.00", "-180.00000"),
        ("SITE SET 35.0 360.0 1800.0 7.00", "360.00000"),
        ("SITE SET 35.0 253.52 1800.0 7.00", "253.52000"),
        ("SITE SET 35.0 -181.0 1800.0 7.00", 13),
        ("SITE SET 35.0 361.0 1800.0 7.00", 13),
        ("SITE SET 91.0 0.0 1800.0 7.00", 13),
        ("SITE SET 35.0 0.0 9001.0 7.00", 13),
        ("SITE SET 35.0 0.0 1800.0 15.01", 13),
        ("PARAM update_range 5.1", 13),
        ("PARAM update_range 0", 13),
        ("PARAM axis1.limits -541:100", 13),
        ("PARAM axis2.limits 10:361", 13),
        ("PARAM axis2.reference 361", 13),
        ("PARAM tilt_decimals 3", 13),
        ("CLOCK SET 20260230T000000.000", 13),
        ("CLOCK SET 20260603T000000", 13),
        ("CLOCK SET 260603T000000.000", 13),
    ],
)
def test_ranges_are_the_page_s(client, text, answer):
    found = client.unlocked(text)
    assert (found[1] if isinstance(answer, str) else found) == answer


@pytest.mark.parametrize("year", ["0001", "0999", "1999", "2026", "9999"])
def test_years_have_four_digits(client, year):
    wanted = f"{year}0603T120000.000"
    assert client.unlocked(f"CLOCK SET {wanted}") == [wanted, "7.00"]
    assert client.ask("CLOCK")[0] == wanted


def test_a_repeated_number_is_answered_from_memory_and_another_request_is_refused(client):
    assert client.ask("X ADVANCE 10", 0x100) == client.ask("X ADVANCE 10", 0x100)
    assert client.ask("X ADVANCE 20", 0x100) == 12
    before = client.ask("X TIME")[0]
    client.ask("X ADVANCE 0")
    assert client.ask("X TIME")[0] == before
    assert client.ask("OPEN 0000000A", 0x100) == ["0000000A"]


def test_the_unlock_runs_out_after_a_minute_and_every_use_starts_it_anew(client):
    assert client.unlocked("MODE MANUAL") == ["MANUAL"]
    client.ask("X ADVANCE 59")
    assert client.ask("MODE MANUAL") == ["MANUAL"]
    client.ask("X ADVANCE 59")
    assert int(client.status()["unlocked"]) == 1
    client.ask("X ADVANCE 2")
    assert client.ask("MODE MANUAL") == 20
    assert client.unlocked("MODE MANUAL") == ["MANUAL"]
    assert client.ask("LOCK") == []
    assert client.ask("MODE MANUAL") == 20


def test_nothing_moves_that_is_not_referenced_or_is_beyond_a_limit(client):
    assert client.unlocked("JOG 10.0 40.0") == 24
    assert client.unlocked("MODE TRACK") == 24
    assert client.unlocked("OFFSET SET") == 24
    referenced(client)
    low, high = client.ask("PARAM axis1.limits")[0].split(":")
    assert float(low) < float(high)
    assert client.unlocked(f"JOG {float(high) + 1:.5f} 40.0") == 21


def test_a_jog_ends_five_seconds_after_it_was_last_sent(client):
    referenced(client)
    assert client.unlocked("JOG 0.00000 40.00000") == ["0.00000", "40.00000"]
    client.ask("X ADVANCE 4")
    assert client.status()["mode"] == "JOG"
    client.ask("X ADVANCE 2")
    status = client.status()
    assert (status["mode"], status["motion"]) == ("MANUAL", "..")
    assert float(status["reading1"]) > 1.0


def test_stop_needs_no_unlock_and_stays_until_mode(client):
    referenced(client)
    assert client.unlocked("JOG 0.0 40.0")
    assert client.ask("STOP") == ["STOP"]
    assert client.status()["mode"] == "STOP"
    assert client.unlocked("JOG 0.0 40.0") == 26
    assert client.unlocked("MODE MANUAL") == ["MANUAL"]
    assert client.unlocked("JOG 0.0 40.0") == ["0.00000", "40.00000"]
    assert client.ask("STOW") == ["STOW"]
    assert client.status()["mode"] == "STOW"


def test_it_drives_to_ideal_plus_e_plus_o_with_the_page_s_e(client):
    referenced(client)
    p = (0.3, -0.36, 0.5, 0.2, 0.0008, -0.0006)
    o = (0.25, -0.125)
    texts = [f"{v:.4f}" for v in p[:4]] + [f"{v:.6f}" for v in p[4:]] + [f"{v:.4f}" for v in o]
    assert client.unlocked("COEF SET " + " ".join(texts)) == texts
    assert client.ask("COEF") == texts
    assert client.ask("COEF STORED") != texts
    assert client.status()["flags"] == "03"
    assert client.ask("STORE") == ["1"]
    assert client.ask("COEF STORED") == texts
    status = client.status()
    assert status["flags"] == "01"
    one, two = float(status["ideal1"]), float(status["ideal2"])
    a, b = math.radians(one), math.radians(two)
    e1 = -p[0] * math.sin(a) / math.tan(b) + p[1] - p[2] * math.cos(a) / math.tan(b) - p[4] * one
    e2 = p[0] * math.cos(a) - p[2] * math.sin(a) + p[3] - p[5] * two
    assert float(status["target1"]) == pytest.approx(one + e1 + o[0], abs=2e-5)
    assert float(status["target2"]) == pytest.approx(two + e2 + o[1], abs=2e-5)


def test_set_sun_offset_makes_that_hold_where_the_axes_stand(client):
    referenced(client)
    fields = client.unlocked("OFFSET SET")
    status = dict(zip(NAMES, fields, strict=True))
    for axis in ("1", "2"):
        wanted = float(status["ideal" + axis]) + float(status["O" + axis])
        assert wanted == pytest.approx(float(status["reading" + axis]), abs=1e-4)


def test_a_second_station_is_told_that_the_unit_is_busy(client, port):
    with socket.create_connection(("127.0.0.1", port), timeout=10.0) as second:
        lines = second.makefile("rb")
        assert lines.readline() == b"# busy: one station at a time\r\n"
        second.sendall(framed(">0001 ID").encode() + b"\r\n")
        assert lines.readline() == b"# busy: one station at a time\r\n"
    assert client.ask("ID")[3] == "1"


def test_open_ends_a_jog_and_locks(client):
    referenced(client)
    client.unlocked("JOG 0.0 40.0")
    assert client.ask("OPEN 0000000B") == ["0000000B"]
    assert client.status()["mode"] == "MANUAL"
    assert client.ask("STORE") == 20
