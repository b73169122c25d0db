"""Repeats, timeouts and matching by sequence number, as transcripts. Silence takes no time here."""

import threading

import pytest
from scripted_link import NOISE, OPENING, HandFedLink, ScriptedLink, sealed

from solarcal.errors import LinkError, ProcedureRefused, ProtocolError, UnitRefused
from solarcal.unit.conversation import Conversation, Timing

TIMING = Timing(repeats_after_silence=3, repeats_after_damage=60)


def talk_over(link, last_seq=0, timing=TIMING):
    return Conversation(link, "/dev/ttyTEST", timing, last_seq)


def test_sequence_numbers_grow_by_one_and_wrap():
    link = ScriptedLink(
        ("FFFE CLOCK", "FFFE OK a b"),
        ("FFFF CLOCK", "FFFF OK a b"),
        ("0000 CLOCK", "0000 OK a b"),
        ("0001 CLOCK", "0001 OK a b"),
    )
    talk = talk_over(link, last_seq=0xFFFD)
    for _ in range(4):
        assert talk.ask("CLOCK") == ("a", "b")
    link.assert_finished()


def test_stale_replies_are_ignored():
    link = ScriptedLink(
        ("0006 CLOCK", "0005 OK old", "0004 NO 20 locked", "FFFF OK", "0006 OK new"),
    )
    assert talk_over(link, last_seq=5).ask("CLOCK") == ("new",)
    link.assert_finished()


def test_a_second_reply_to_an_answered_request_is_ignored():
    link = ScriptedLink(
        ("0001 CLOCK", "0001 OK first", "0001 OK second"),
        ("0002 CLOCK", "0002 OK third"),
    )
    talk = talk_over(link)
    assert talk.ask("CLOCK") == ("first",)
    assert talk.ask("CLOCK") == ("third",)
    link.assert_finished()


def test_a_unit_that_refuses_to_open_is_not_asked_again():
    link = ScriptedLink(("0001 OPEN ?", "0001 OK 01234567", "0001 NO 22 busy"))
    with pytest.raises(UnitRefused, match="busy"):
        talk_over(link).open("5C0FFEE5")
    link.assert_finished()


def test_a_damaged_reply_is_repeated_with_the_same_number():
    damaged = sealed("<0001 OK 10.5").replace(b"10.5", b"19.5")
    link = ScriptedLink(("0001 CLOCK", damaged), ("0001 CLOCK", "0001 OK 10.5"))
    assert talk_over(link).ask("CLOCK") == ("10.5",)
    link.assert_finished()


def test_a_request_the_unit_got_damaged_is_repeated_with_the_same_number():
    link = ScriptedLink(
        ("0001 CLOCK", "---- NO 10 damaged frame"),
        ("0001 CLOCK", "---- NO 10 damaged frame"),
        ("0001 CLOCK", "0001 OK x"),
    )
    assert talk_over(link).ask("CLOCK") == ("x",)
    link.assert_finished()


def test_a_server_that_turns_away_is_named_and_later_the_same_words_are_noise():
    link = ScriptedLink(("0001 CLOCK", b"# busy: another station is connected"))
    with pytest.raises(LinkError, match="/dev/ttyTEST is in use by another station"):
        talk_over(link).ask("CLOCK")
    link = ScriptedLink(
        ("0001 CLOCK", "0001 OK x"), ("0002 CLOCK", b"# busy"), ("0002 CLOCK", "0002 OK y")
    )
    talk = talk_over(link)
    assert (talk.ask("CLOCK"), talk.ask("CLOCK")) == (("x",), ("y",))
    link.assert_finished()


@pytest.mark.parametrize("said", [[b"# busy"], [NOISE, b"# busy"], [], [LinkError("gone")]])
def test_a_server_that_hung_up_has_said_why_before(said):
    class HungUp(ScriptedLink):
        def write(self, data):
            raise LinkError("broken pipe")

        def read_line(self, timeout_s):
            line = super().read_line(timeout_s)
            if isinstance(line, LinkError):
                raise line
            return line

    link = HungUp()
    link.inbox += said
    why = "is in use by another station" if b"# busy" in said else "broken pipe"
    with pytest.raises(LinkError, match=why):
        talk_over(link).ask("CLOCK")
    assert link.inbox == []


def test_noise_in_several_pieces_costs_one_repeat():
    link = ScriptedLink(("0001 CLOCK", NOISE, NOISE, NOISE), ("0001 CLOCK", "0001 OK x"))
    assert talk_over(link).ask("CLOCK") == ("x",)
    link.assert_finished()


def test_a_reply_behind_noise_is_taken_without_a_repeat():
    link = ScriptedLink(("0001 CLOCK", NOISE, "0001 OK x"))
    assert talk_over(link).ask("CLOCK") == ("x",)
    link.assert_finished()


def test_after_silence_the_request_is_repeated_three_times():
    link = ScriptedLink(
        ("0001 CLOCK",), ("0001 CLOCK",), ("0001 CLOCK",), ("0001 CLOCK", "0001 OK x")
    )
    assert talk_over(link).ask("CLOCK") == ("x",)
    link.assert_finished()


def test_a_unit_that_stays_silent_is_a_link_error_that_names_the_port():
    link = ScriptedLink(*[("0001 CLOCK",)] * 4)
    with pytest.raises(LinkError, match=r"no answer from /dev/ttyTEST to CLOCK") as caught:
        talk_over(link).ask("CLOCK")
    assert not isinstance(caught.value, ProtocolError)
    assert "\n" not in str(caught.value)
    link.assert_finished()


def test_damage_up_to_sixty_repeats_does_not_count_as_silence():
    link = ScriptedLink(*[("0001 CLOCK", NOISE)] * 60, ("0001 CLOCK", "0001 OK x"))
    assert talk_over(link).ask("CLOCK") == ("x",)
    link.assert_finished()


def test_a_port_that_answers_only_noise_is_not_a_solartrak():
    link = ScriptedLink(*[("0001 CLOCK", NOISE)] * 61)
    with pytest.raises(ProtocolError, match="/dev/ttyTEST answers, but not in the SolarTrak"):
        talk_over(link).ask("CLOCK")
    link.assert_finished()


def test_a_port_that_babbles_and_then_falls_silent_is_not_a_solartrak_either():
    link = ScriptedLink(("0001 CLOCK", NOISE), *[("0001 CLOCK",)] * 4)
    with pytest.raises(ProtocolError, match="not in the SolarTrak protocol"):
        talk_over(link).ask("CLOCK")
    link.assert_finished()


def test_a_line_gone_bad_in_mid_conversation_is_called_noisy():
    link = ScriptedLink(("0001 CLOCK", "0001 OK x"), *[("0002 CLOCK", NOISE)] * 61)
    talk = talk_over(link)
    talk.ask("CLOCK")
    with pytest.raises(ProtocolError, match="too noisy"):
        talk.ask("CLOCK")
    link.assert_finished()


def test_a_refusal_carries_code_and_text():
    link = ScriptedLink(("0001 JOG 200.0 0.0", "0001 NO 21 beyond limit axis 1"))
    with pytest.raises(UnitRefused, match=r"JOG 200.0 0.0: beyond limit axis 1 \(code 21\)") as no:
        talk_over(link).ask("JOG", "200.0", "0.0")
    assert no.value.code == 21
    link.assert_finished()


def test_a_locked_request_unlocks_and_asks_anew_with_a_new_number():
    link = ScriptedLink(
        ("0001 STORE", "0001 NO 20 locked"),
        ("0002 UNLOCK", "0002 OK 60"),
        ("0003 STORE", "0003 OK 1"),
        ("0004 STORE", "0004 OK 1"),
    )
    talk = talk_over(link)
    assert talk.command("STORE") == ("1",)
    assert talk.command("STORE") == ("1",)
    link.assert_finished()


def test_a_unit_that_stays_locked_is_asked_once_more_only():
    link = ScriptedLink(
        ("0001 STORE", "0001 NO 20 locked"),
        ("0002 UNLOCK", "0002 OK 60"),
        ("0003 STORE", "0003 NO 20 locked"),
    )
    with pytest.raises(UnitRefused, match="locked"):
        talk_over(link).command("STORE")
    link.assert_finished()


def test_reading_never_unlocks():
    link = ScriptedLink(("0001 CLOCK", "0001 NO 20 locked"))
    with pytest.raises(UnitRefused):
        talk_over(link).ask("CLOCK")
    link.assert_finished()


def test_the_reply_to_an_earlier_open_is_stale():
    link = ScriptedLink(("0001 OPEN ?", "0001 OK 00000000", "0001 OK ?"))
    talk_over(link).open("0BADCAFE")
    assert link.nonce == "0BADCAFE"
    link.assert_finished()
    assert OPENING[0][0] == "0001 OPEN ?"


class Asked(threading.Thread):
    """A request in a thread of its own; ``outcome`` is its fields or what it raised."""

    def __init__(self, ask, *arguments, **options):
        super().__init__(daemon=True)
        self.call = lambda: ask(*arguments, **options)
        self.outcome = None
        self.start()

    def run(self):
        try:
            self.outcome = self.call()
        except (LinkError, ProcedureRefused, UnitRefused) as error:
            self.outcome = error

    def result(self):
        self.join(timeout=10)
        assert not self.is_alive()
        return self.outcome


def test_stop_goes_out_at_once_past_a_waiting_request_and_finds_its_own_reply():
    link = HandFedLink()
    talk = talk_over(link, timing=Timing(answer_s=30.0))
    waiting = Asked(talk.ask, "X", "ADVANCE", "3600", answer_s=60.0)
    assert link.next_sent() == ">0001 X ADVANCE 3600"
    stop = Asked(talk.interrupt, "STOP")
    assert link.next_sent() == ">0002 STOP"
    link.answer("0002 OK STOP")
    assert stop.result() == ("STOP",)
    assert waiting.is_alive()
    link.answer("0001 OK then now")
    assert waiting.result() == ("then", "now")


def test_replies_in_the_wrong_order_find_their_requests():
    link = HandFedLink()
    talk = talk_over(link, timing=Timing(answer_s=30.0))
    waiting = Asked(talk.ask, "CLOCK")
    link.next_sent()
    stow = Asked(talk.interrupt, "STOW")
    link.next_sent()
    link.answer("0001 OK clock")
    assert waiting.result() == ("clock",)
    link.answer("0002 OK STOW")
    assert stow.result() == ("STOW",)


def test_a_jog_lost_before_a_stop_is_not_repeated_after_it():
    link = HandFedLink()
    talk = talk_over(link, timing=Timing(answer_s=30.0))
    jog = Asked(talk.command, "JOG", "10.0", "20.0", moves=True)
    assert link.next_sent() == ">0001 JOG 10.0 20.0"
    stop = Asked(talk.interrupt, "STOP")
    assert link.next_sent() == ">0002 STOP"
    link.answer("0002 OK STOP")
    assert stop.result() == ("STOP",)
    link.be_silent()
    outcome = jog.result()
    assert isinstance(outcome, ProcedureRefused)
    assert "JOG 10.0 20.0 was given up" in str(outcome)
    assert link.sent.empty()


def test_a_jog_waiting_for_its_unlock_does_not_follow_a_stop():
    link = HandFedLink()
    talk = talk_over(link, timing=Timing(answer_s=30.0))
    jog = Asked(talk.command, "JOG", "10.0", "20.0", moves=True)
    link.next_sent()
    link.answer("0001 NO 20 locked")
    assert link.next_sent() == ">0002 UNLOCK"
    stop = Asked(talk.interrupt, "STOP")
    assert link.next_sent() == ">0003 STOP"
    link.answer("0002 OK 60")
    assert isinstance(jog.result(), ProcedureRefused)
    link.answer("0003 OK STOP")
    assert stop.result() == ("STOP",)
    assert link.sent.empty()


def test_what_does_not_move_the_axes_survives_a_stop():
    link = HandFedLink()
    talk = talk_over(link, timing=Timing(answer_s=30.0))
    store = Asked(talk.command, "STORE")
    link.next_sent()
    stop = Asked(talk.interrupt, "STOP")
    link.next_sent()
    link.answer("0002 OK STOP")
    stop.result()
    link.be_silent()
    assert link.next_sent() == ">0001 STORE"
    link.answer("0001 OK 1")
    assert store.result() == ("1",)


class OneAtATimeLink:
    """Answers every request at once, and fails when two are under way."""

    def __init__(self):
        self.under_way = []
        self.served = 0

    def write(self, data):
        self.under_way.append(data[1:5].decode())
        assert len(self.under_way) == 1

    def read_line(self, timeout_s):
        self.served += 1
        return sealed(f"<{self.under_way.pop()} OK done")

    def close(self):
        pass


def test_requests_of_several_threads_take_turns():
    link = OneAtATimeLink()
    talk = talk_over(link)
    threads = [
        Asked(lambda: [talk.ask("CLOCK") for _ in range(50)] == [("done",)] * 50) for _ in range(4)
    ]
    assert [thread.result() for thread in threads] == [True] * 4
    assert link.served == 200


def test_an_undamaged_frame_that_is_no_reply_is_a_fault_of_the_protocol_and_not_noise():
    link = ScriptedLink(("0001 CLOCK", "0001 YES 10.5"))
    with pytest.raises(ProtocolError, match=r"breaks the protocol.*with a right checksum"):
        talk_over(link).ask("CLOCK")
    link.assert_finished()


def test_its_own_request_coming_back_answers_nothing():
    link = ScriptedLink(("0001 CLOCK", sealed(">0001 CLOCK"), "0001 OK 10.5"))
    assert talk_over(link).ask("CLOCK") == ("10.5",)
    link.assert_finished()


def test_a_line_that_only_repeats_is_named():
    echo = ("0001 CLOCK", sealed(">0001 CLOCK"))
    link = ScriptedLink(*[echo] * 4)
    with pytest.raises(LinkError, match="/dev/ttyTEST only repeats what is sent to it"):
        talk_over(link).ask("CLOCK")
    link.assert_finished()
