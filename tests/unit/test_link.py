"""SerialLink over a real pseudo-terminal and a real loopback socket."""

import contextlib
import os
import re
import socket
import threading
import tty

import pytest
from scripted_link import SITE
from test_fields import STATUS, STATUS_TEXT

from solarcal.errors import ConfigurationError, LinkError, ProtocolError
from solarcal.station.connect import open_tracker
from solarcal.unit.conversation import Timing
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.frames import LineBuffer, Reply, decode_request, encode_reply
from solarcal.unit.link import LINES_KEPT, SerialLink, _names_a_tcp_port

LONG_S = 10.0
"""Never waited for: what is expected comes at once."""


class Far:
    """The far end of a line: what the unit's side reads and writes."""

    def __init__(self, url, read, write, hang_up):
        self.url = url
        self.read = read
        self.write = write
        self.hang_up = hang_up
        self.servants = []

    def read_all(self, length):
        got = b""
        while len(got) < length:
            got += self.read(4096)
        return got


@pytest.fixture
def pty_end():
    if not hasattr(os, "openpty"):
        pytest.skip("no pseudo-terminals on this system")
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    open_ends = [ours, theirs]

    def hang_up():
        while open_ends:
            os.close(open_ends.pop())

    far = Far(
        os.ttyname(theirs),
        lambda n: os.read(ours, n),
        lambda data: os.write(ours, data),
        hang_up,
    )
    yield far
    # The last user of the other side gone, a servant's read ends; only then may its file close.
    if open_ends:
        os.close(open_ends.pop())
    for servant in far.servants:
        servant.join(LONG_S)
        assert not servant.is_alive()
    hang_up()


@pytest.fixture
def tcp_end():
    listener = socket.create_server(("127.0.0.1", 0))
    listener.settimeout(LONG_S)
    accepted = []

    def peer():
        if not accepted:
            accepted.append(listener.accept()[0])
        return accepted[0]

    far = Far(
        f"socket://127.0.0.1:{listener.getsockname()[1]}",
        lambda n: peer().recv(n),
        lambda data: peer().sendall(data),
        lambda: peer().close(),
    )
    yield far
    for servant in far.servants:
        servant.join(LONG_S)
        assert not servant.is_alive()
    for each in (*accepted, listener):
        each.close()


@pytest.fixture(params=["pty_end", "tcp_end"])
def far(request):
    return request.getfixturevalue(request.param)


def test_bytes_go_out_and_whole_lines_come_in(far):
    link = SerialLink(far.url)
    link.write(b">0001 ID*........\r\n")
    assert far.read_all(19) == b">0001 ID*........\r\n"
    far.write(b"<0001 O")
    assert link.read_line(0.0) is None
    far.write(b"K*........\r\n<0002 ")
    assert link.read_line(LONG_S) == b"<0001 OK*........"
    far.write(b"OK*........\n\r\n<0003 OK*........\r\n")
    assert link.read_line(LONG_S) == b"<0002 OK*........"
    assert link.read_line(LONG_S) == b"<0003 OK*........"
    assert link.read_line(0.0) is None
    link.close()


def test_a_hang_up_ends_reading_and_writing(far):
    link = SerialLink(far.url)
    far.write(b"last words\n")
    assert link.read_line(LONG_S) == b"last words"
    far.hang_up()
    with pytest.raises(LinkError, match="was lost; check the cable") as lost:
        link.read_line(LONG_S)
    assert far.url in str(lost.value)
    with pytest.raises(LinkError, match="was lost"):
        link.write(b">0001 ID*........\r\n")
    link.close()


def test_what_came_before_a_hang_up_can_still_be_read(pty_end):
    link = SerialLink(pty_end.url)
    pty_end.write(b"one\ntwo\n")
    assert link.read_line(LONG_S) == b"one"
    pty_end.hang_up()
    assert link.read_line(LONG_S) == b"two"
    with pytest.raises(LinkError):
        link.read_line(LONG_S)
    link.close()


def test_close_ends_a_waiting_reader_and_may_be_repeated(pty_end):
    link = SerialLink(pty_end.url)
    ended = []

    def wait():
        with pytest.raises(LinkError, match="closed"):
            link.read_line(LONG_S)
        ended.append(True)

    reader = threading.Thread(target=wait)
    reader.start()
    link.close()
    reader.join(LONG_S)
    assert ended == [True]
    link.close()
    for use in (lambda: link.write(b"x"), lambda: link.read_line(0.0)):
        with pytest.raises(LinkError, match="closed"):
            use()


def test_babble_is_kept_in_bounded_memory_and_the_line_recovers(pty_end):
    link = SerialLink(pty_end.url)
    for _ in range(200):
        pty_end.write(b"x" * 1000)
    for k in range(LINES_KEPT * 5):
        pty_end.write(b"\nline %d" % k)
    pty_end.write(b"\nthe last\n")
    # Read only once all has arrived: what matters is how much was stored unread.
    with link._arrived:
        assert link._arrived.wait_for(lambda: b"the last" in link._lines, LONG_S)
    kept = []
    while (line := link.read_line(0.0)) is not None:
        kept.append(line)
    assert len(kept) == LINES_KEPT
    assert kept[-1] == b"the last"
    link.close()


def test_a_port_open_elsewhere_is_called_busy(pty_end):
    link = SerialLink(pty_end.url)
    with pytest.raises(LinkError, match=r"in use by another program"):
        SerialLink(pty_end.url)
    link.close()
    SerialLink(pty_end.url).close()


def test_ports_that_cannot_be_opened_say_why_in_one_line(tmp_path):
    no_port = tmp_path / "ttyNONE"
    plain_file = tmp_path / "plain"
    plain_file.touch()
    with socket.create_server(("127.0.0.1", 0)) as listener:
        nobody = f"127.0.0.1:{listener.getsockname()[1]}"
    for url, reason in (
        (str(no_port), "does not exist; `solarcal ports` lists"),
        (str(plain_file), "is not a serial port"),
        (str(tmp_path), "is not a serial port"),
        (f"socket://{nobody}", "no answer from"),
        (f"rfc2217://{nobody}", "no answer from"),
        ("socket://127.0.0.1", "write it as socket://host:port"),
        ("socket://127.0.0.1:99999", "with a port from 1 to 65535"),
        ("carrier-pigeon://roof", "carrier-pigeon://roof cannot be opened: "),
    ):
        with pytest.raises(LinkError, match=re.escape(reason)) as failed:
            SerialLink(url)
        assert "\n" not in str(failed.value)
        assert url in str(failed.value)


def test_a_port_without_permission_says_which_group_to_join(tmp_path, monkeypatch):
    import serial

    def refuse(*_args, **_options):
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(LinkError, match="join the group"):
        SerialLink("/dev/ttyUSB0")


def test_loop_answers_itself():
    link = SerialLink("loop://")
    link.write(b"echo\r\n")
    assert link.read_line(LONG_S) == b"echo"
    link.close()


def test_the_trace_is_a_readable_transcript(pty_end, tmp_path):
    trace = tmp_path / "trace.txt"
    link = SerialLink(pty_end.url, trace=trace)
    link.write(b">0001 ID*CA388350\r\n")
    pty_end.write(b"<0001 \xff\x07bad\r\n")
    link.read_line(LONG_S)
    link.close()
    SerialLink(pty_end.url, trace=trace).close()
    lines = trace.read_text(encoding="ascii").splitlines()
    assert lines[0].startswith(f"# {pty_end.url}, opened 20")
    assert re.fullmatch(r" +\d+\.\d{3} sent     >0001 ID\*CA388350", lines[1])
    assert re.fullmatch(r" +\d+\.\d{3} received <0001 \\xff\\x07bad", lines[2])
    assert any(line.startswith("#") for line in lines[3:])


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="this system has no /dev/full")
def test_a_disk_that_is_full_ends_the_trace_and_not_the_conversation(pty_end, tmp_path):
    with pytest.raises(
        ConfigurationError, match="trace file /dev/full cannot be written: No space"
    ):
        SerialLink("loop://", trace="/dev/full")
    link = SerialLink(pty_end.url, trace=tmp_path / "trace.txt")
    assert link._transcript is not None
    full = os.open("/dev/full", os.O_WRONLY)
    os.dup2(full, link._transcript._file.fileno())
    os.close(full)
    for _ in range(2):
        link.write(b"hello\r\n")
        assert pty_end.read_all(7) == b"hello\r\n"
    pty_end.write(b"answer\r\n")
    assert link.read_line(LONG_S) == b"answer"
    link.close()


def test_a_trace_that_cannot_be_written_is_one_clear_line(tmp_path):
    with pytest.raises(ConfigurationError, match="trace file"):
        SerialLink("loop://", trace=tmp_path / "nowhere" / "trace.txt")


ANSWERS = {"ID": "SOLARTRAK 1 1.0 1 -", "SITE": SITE[3:], "STATUS": STATUS_TEXT}


def serve(far, answer):
    """A small unit at the far end, until one side hangs up."""

    def run():
        buffer = LineBuffer()
        # The other side's hang-up reads as an error on a pty, as the end on a socket.
        with contextlib.suppress(OSError):
            while data := far.read(4096):
                for line in buffer.feed(data):
                    far.write(answer(decode_request(line)))

    far.servants.append(threading.Thread(target=run, daemon=True))
    far.servants[-1].start()


def good_answer(request):
    text = request.arguments[0] if request.verb == "OPEN" else ANSWERS[request.verb]
    return encode_reply(Reply(request.seq, tuple(text.split())))


def test_the_driver_talks_over_a_real_line(far):
    serve(far, good_answer)
    unit = open_tracker(far.url)
    assert [unit.status() for _ in range(20)] == [STATUS] * 20
    unit.close()


def test_a_unit_that_goes_away_is_a_link_error_at_once(pty_end):
    def leave_in_mid_request(request):
        if request.verb == "STATUS":
            pty_end.hang_up()
        return good_answer(request)

    serve(pty_end, leave_in_mid_request)
    unit = open_tracker(pty_end.url)
    with pytest.raises(LinkError, match="was lost"):
        unit.status()
    unit.close()


def test_a_port_that_answers_garbage_is_closed_again(pty_end):
    serve(pty_end, lambda request: b"$GPGGA,noise\r\n")
    with pytest.raises(ProtocolError, match="not in the SolarTrak protocol"):
        open_tracker(pty_end.url)
    SerialLink(pty_end.url).close()


def test_a_mute_port_is_given_up_after_the_repeats(pty_end):
    heard = []
    serve(pty_end, lambda request: heard.append(request.verb) or b"")
    unit = SolarTrakUnit(
        lambda: SerialLink(pty_end.url), port=pty_end.url, timing=Timing(answer_s=0.02)
    )
    with pytest.raises(LinkError, match="no answer"):
        unit.open()
    assert set(heard) <= {"OPEN"}
    unit.close()


def test_a_frame_cut_in_two_by_the_line_is_one_frame(pty_end):
    def halves(request):
        whole = good_answer(request)
        pty_end.write(whole[:7])
        return whole[7:]

    serve(pty_end, halves)
    unit = open_tracker(pty_end.url)
    assert unit.status() == STATUS
    unit.close()


@pytest.mark.parametrize(
    ("url", "names_one"),
    [
        ("socket://host:1", True), ("socket://host:65535", True), ("socket://host:65536", False),
        ("socket://host:0", False), ("socket://host", False), ("socket://host:4533/x", False),
    ],
)  # fmt: skip
def test_a_tcp_port_is_between_1_and_65535(url, names_one):
    assert _names_a_tcp_port(url) == names_one
