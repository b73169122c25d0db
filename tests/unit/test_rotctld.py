"""Conversations with rotctld, as transcripts; one that is not read to its end fails."""

import threading

import pytest
from rotctld_script import AT_REST, CAPS, OPENING, STATE
from scripted_link import ScriptedLines

from solarcal.errors import (
    ConfigurationError,
    LinkError,
    ProcedureRefused,
    ProtocolError,
    UnitRefused,
)
from solarcal.mount.geometry import AxisLimits
from solarcal.unit.drivers.rotctld import RotctldRotator, _Waiting, rotctld_address
from solarcal.unit.drivers.rotctld_replies import ReplyReader, request


def opened(*exchanges):
    link = ScriptedLines(*OPENING, *exchanges)
    rotator = RotctldRotator(lambda: link, "roof:4533")
    rotator.open()
    return rotator, link


# -- who is there ------------------------------------------------------------------------------


def test_it_says_who_it_is_and_how_far_it_turns():
    link = ScriptedLines(*OPENING)
    told = RotctldRotator(lambda: link, "roof:4533").open()
    assert (told.model, told.version) == ("Yaesu GS-232B", "20220109.0")
    assert (told.azimuth, told.elevation) == (AxisLimits(0.0, 450.0), AxisLimits(0.0, 180.0))
    link.assert_finished()


def test_an_older_rotctld_that_tells_less_is_understood():
    old = tuple(line for line in STATE if not line.startswith(("South", "rot_type", "done")))
    link = ScriptedLines(
        ("+\\dump_state", *old), ("+\\dump_caps", "dump_caps:", "RPRT 0"), OPENING[2]
    )
    assert RotctldRotator(lambda: link, "roof:4533").open().model == "Hamlib model 603"
    link.assert_finished()


@pytest.mark.parametrize(
    ("line", "instead", "words"),
    [
        (
            "Maximum Azimuth: 450.000000",
            "Maximum Azimuth: inf",
            "Maximum Azimuth 'inf' is no angle",
        ),
        ("Maximum Azimuth: 450.000000", "Maximum Azimuth: -5", "lower one comes first"),
        ("Minimum Elevation: 0.000000", "Min El: 0", "Minimum Elevation is missing"),
        ("dump_state:", "SSH-2.0-OpenSSH_9.2", "'SSH-2.0-OpenSSH_9.2' is not what rotctld answers"),
    ],
)
def test_what_cannot_be_rotctld_is_not_believed(line, instead, words):
    state = [instead if each == line else each for each in STATE]
    link = ScriptedLines(("+\\dump_state", *state), *OPENING[1:])
    with pytest.raises(ProtocolError, match="roof:4533, reply to dump_state") as caught:
        RotctldRotator(lambda: link, "roof:4533").open()
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_rotator_of_one_axis_is_refused():
    caps = ["Rot type:\t\tAzimuth" if line.startswith("Rot type") else line for line in CAPS]
    link = ScriptedLines(OPENING[0], ("+\\dump_caps", *caps), OPENING[2])
    with pytest.raises(ConfigurationError, match="turns in azimuth only"):
        RotctldRotator(lambda: link, "roof:4533").open()


def test_a_rotator_that_is_off_behind_its_rotctld_is_a_lost_link():
    link = ScriptedLines(*OPENING[:2], ("+\\get_pos", "get_pos:", "RPRT -5"))
    with pytest.raises(LinkError, match=r"roof:4533, get_pos: the rotator does not answer.*-5"):
        RotctldRotator(lambda: link, "roof:4533").open()


# -- what it is asked and told -----------------------------------------------------------------


def test_position_motion_stop_and_park():
    rotator, link = opened(
        ("+\\get_pos", "get_pos:", "Azimuth: 123.45", "Elevation: -0.50", "RPRT 0"),
        ("+\\set_pos 93.250000 31.125000", "set_pos: 93.250000 31.125000", "RPRT 0"),
        ("+\\stop", "stop:", "RPRT 0"),
        ("+\\park", "park:", "RPRT 0"),
    )
    assert rotator.position_deg() == (123.45, -0.5)
    rotator.go_to(93.25, 31.125, rotator.stops())
    rotator.stop()
    rotator.park()
    link.assert_finished()
    assert rotator.recent_traffic()[-3:] == ("> +\\park", "< park:", "< RPRT 0")


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (1, "beyond the rotator's range"),
        (4, "cannot do that"),
        (9, "rejects the command"),
        (11, "cannot do that"),
        (999, "an unknown error code"),
    ],
)
def test_a_refusal_is_a_sentence_and_leaves_the_line_open(number, words):
    rotator, link = opened(
        ("+\\set_pos 9.000000 9.000000", "set_pos: 9.000000 9.000000", f"RPRT -{number}"),
        ("+\\get_pos", *AT_REST),
    )
    with pytest.raises(UnitRefused, match=words) as caught:
        rotator.go_to(9.0, 9.0, rotator.stops())
    assert caught.value.code == -number
    assert rotator.position_deg() == (180.0, 45.0)
    link.assert_finished()


@pytest.mark.parametrize("number", [5, 6, 8, 13, 14])
def test_trouble_between_rotctld_and_rotator_is_a_lost_link(number):
    rotator, _ = opened(("+\\get_pos", "get_pos:", f"RPRT -{number}"))
    with pytest.raises(LinkError, match=r"check the rotator's power"):
        rotator.position_deg()


@pytest.mark.parametrize("number", [4, 11])
def test_a_rotator_that_cannot_stop_is_sent_to_where_it_stands(number):
    """Hamlib's RIG_ENIMPL and RIG_ENAVAIL: not implemented, not available."""
    rotator, link = opened(
        ("+\\stop", "stop:", f"RPRT -{number}"),
        ("+\\get_pos", *AT_REST),
        ("+\\set_pos 180.000000 45.000000", "set_pos: 180.000000 45.000000", "RPRT 0"),
    )
    rotator.stop()
    link.assert_finished()


# -- what goes wrong ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "lines",
    [
        (),
        ("get_pos:",),
        ("get_pos:", "Azimuth: 180.00"),
        ("get_pos:", "Azimuth: 180.00", "Elevation: 45.00"),
    ],
)
def test_silence_anywhere_in_a_reply_ends_the_connection(lines):
    rotator, link = opened(("+\\get_pos", *lines))
    with pytest.raises(LinkError, match="no answer from rotctld at roof:4533 to get_pos"):
        rotator.position_deg()
    assert link.closed
    # What comes late on the old connection is never taken for the answer to something new.
    with pytest.raises(LinkError, match="no answer from rotctld"):
        rotator.position_deg()


def test_a_line_lost_while_an_answer_is_waited_for_stays_lost(monkeypatch):
    rotator, link = opened(("+\\get_pos", *AT_REST))

    def lost(timeout_s):
        # Before the request goes out nothing stray is there.
        if timeout_s:
            raise LinkError("roof:4533: connection reset")

    monkeypatch.setattr(link, "read_line", lost)
    for _ in range(2):
        with pytest.raises(LinkError, match="roof:4533: connection reset"):
            rotator.position_deg()
        assert link.closed


@pytest.mark.parametrize(
    "lines",
    [
        ("RPRT 0",),
        ("180.00", "45.00"),
        (b"\xff\xfe\x00",),
        ("stop:", "RPRT 0"),
        ("get_pos:", *["babble"] * 300),
        ("get_pos:", "Azimuth: 180.00", "Elevation: 45.00", "RPRT zero", "x" * 250),
    ],
)
def test_garbage_is_never_read_as_a_position(lines):
    rotator, link = opened(("+\\get_pos", *lines))
    with pytest.raises(LinkError):
        rotator.position_deg()
    assert link.closed


@pytest.mark.parametrize(
    "lines",
    [
        ("get_pos:", "RPRT 0"),
        ("get_pos:", "Azimuth: 180.00", "RPRT 0"),
        ("get_pos:", "Azimuth: nan", "Elevation: 45.00", "RPRT 0"),
        ("get_pos:", "Azimuth: 1e9", "Elevation: 45.00", "RPRT 0"),
        ("get_pos:", "Azimuth: 180,00", "Elevation: 45.00", "RPRT 0"),
    ],
)
def test_a_whole_reply_without_a_position_in_it_is_none(lines):
    rotator, _ = opened(("+\\get_pos", *lines))
    with pytest.raises(ProtocolError, match="reply to get_pos"):
        rotator.position_deg()


def test_a_reply_that_is_awaited_is_not_stray_for_the_next_request():
    """Two threads ask; the second writes while the first's reply is there and nobody reads yet."""
    rotator, link = opened(("+\\get_pos", *AT_REST), ("+\\get_pos", *AT_REST))
    asked = [_Waiting(ReplyReader("get_pos", "roof:4533")) for _ in range(2)]
    for waiting in asked:
        rotator._send(waiting, request("get_pos"), None, interrupts=False)
    for waiting in asked:
        rotator._await(waiting)
        assert waiting.reply.outcome() is None
    link.assert_finished()


def test_a_reply_that_comes_twice_is_not_taken_for_the_next_answer():
    rotator, link = opened(("+\\get_pos", *AT_REST, *AT_REST))
    assert rotator.position_deg() == (180.0, 45.0)
    with pytest.raises(ProtocolError, match="'get_pos:' without a request"):
        rotator.position_deg()
    assert link.closed


def test_after_a_lost_line_a_new_one_is_believed():
    links = [ScriptedLines(*OPENING, ("+\\get_pos",)), ScriptedLines(*OPENING)]
    first, second = links
    rotator = RotctldRotator(lambda: links.pop(0), "roof:4533")
    rotator.open()
    with pytest.raises(LinkError):
        rotator.position_deg()
    rotator.open()
    assert first.closed
    second.assert_finished()


def test_nothing_is_asked_before_the_line_is_open():
    rotator = RotctldRotator(lambda: ScriptedLines(), "roof:4533")
    with pytest.raises(LinkError, match="the line to roof:4533 is not open; connect first"):
        rotator.stop()


# -- STOP --------------------------------------------------------------------------------------


def test_no_motion_decided_before_a_stop_goes_out_after_it():
    rotator, link = opened(("+\\stop", "stop:", "RPRT 0"))
    decided = rotator.stops()
    rotator.stop()
    with pytest.raises(ProcedureRefused, match="stopped or parked meanwhile"):
        rotator.go_to(10.0, 10.0, decided)
    link.assert_finished()


class SlowRotctld(ScriptedLines):
    """Answers to ``get_pos`` come only once STOP has been written."""

    def __init__(self, *exchanges):
        super().__init__(*exchanges)
        self.asked = threading.Event()
        self.stopped = threading.Event()
        self.held = False

    def write(self, data):
        super().write(data)
        if self.held:
            self.asked.set()
        if data == b"+\\stop\n":
            self.stopped.set()

    def read_line(self, timeout_s):
        if self.held and timeout_s > 0.0:
            assert self.stopped.wait(10.0)
        return super().read_line(timeout_s)


def test_stop_goes_out_past_a_request_that_is_waiting():
    link = SlowRotctld(*OPENING, ("+\\get_pos", *AT_REST), ("+\\stop", "stop:", "RPRT 0"))
    rotator = RotctldRotator(lambda: link, "roof:4533")
    rotator.open()
    link.held = True
    stood = []
    waiting = threading.Thread(target=lambda: stood.append(rotator.position_deg()))
    waiting.start()
    assert link.asked.wait(10.0)
    rotator.stop()
    waiting.join(10.0)
    assert stood == [(180.0, 45.0)]
    link.assert_finished()


# -- addresses ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("localhost", "localhost:4533"),
        ("roof.example:4600", "roof.example:4600"),
        ("socket://10.0.0.7:4533", "10.0.0.7:4533"),
        ("socket://10.0.0.7", "10.0.0.7:4533"),
        ("host:1", "host:1"),
        ("host:65535", "host:65535"),
        ("[::1]:4533", "[::1]:4533"),
        (" [fe80::1] ", "[fe80::1]:4533"),
    ],
)
def test_addresses_of_rotctld(text, address):
    assert rotctld_address(text) == address


@pytest.mark.parametrize(
    "text", ["/dev/ttyUSB0", "host:0", "host:65536", "rfc2217://host:1", "a b", "", "host:port"]
)
def test_what_is_no_address_is_said_with_what_to_do(text):
    with pytest.raises(ConfigurationError, match=r"start rotctld -m MODEL -r DEVICE first"):
        rotctld_address(text)


def test_a_request_that_an_interrupt_broke_off_takes_no_reply_of_the_next():
    """Whether it went out is not known: the line is given up, and STOP goes out on a new one."""
    links = [ScriptedLines(*OPENING), ScriptedLines(*OPENING, ("+\\stop", "stop:", "RPRT 0"))]
    rotator = RotctldRotator(lambda: links.pop(0), "roof:4533")
    rotator.open()
    first, second = rotator._link, links[0]

    def interrupted(data):
        raise KeyboardInterrupt

    first.write = interrupted
    with pytest.raises(KeyboardInterrupt):
        rotator.go_to(170.0, 40.0, rotator.stops())
    assert first.closed
    with pytest.raises(LinkError, match="a request to roof:4533 was interrupted"):
        rotator.stop()
    rotator.open()
    rotator.stop()
    second.assert_finished()


def test_an_interrupt_after_reading_leaves_the_line_to_the_next(monkeypatch):
    rotator, _ = opened(("+\\get_pos", *AT_REST))
    acquire, calls = rotator._state.acquire, []

    def interrupted():
        acquire()
        calls.append(1)
        if len(calls) == len(AT_REST):
            raise KeyboardInterrupt

    monkeypatch.setattr(rotator._state, "acquire", interrupted)
    with pytest.raises(KeyboardInterrupt):
        rotator.position_deg()
    assert not rotator._someone_reads
