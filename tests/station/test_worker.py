"""The thread that talks to the station: what it posts, and what becomes of steps that wait."""

import queue
import threading

import pytest
from emulated_station import emulated_station

from solarcal.errors import LinkError, ProcedureRefused
from solarcal.session.records import LinkLost, Note, Void
from solarcal.station.news import Done, Reconnected, StatusRead, StepFailed
from solarcal.station.worker import FIRST_RETRY_S, StationWorker


class Asked(Done[int], name="question"): ...


def answers(posted: queue.Queue, wanted: int) -> list:
    """The outcomes of steps, in order, without states and progress."""
    found = []
    for _ in range(1000):
        news = posted.get(timeout=20.0)
        if isinstance(news, Done | StepFailed):
            found.append(news)
        if len(found) == wanted:
            break
    return found


@pytest.fixture
def working(monkeypatch):
    monkeypatch.setattr("solarcal.station.worker.POLL_S", 0.001)
    station, _ = emulated_station()
    posted = queue.Queue()
    worker = StationWorker(station, posted.put)
    worker.start()
    yield station, worker, posted
    worker.close()


def test_every_step_is_answered_in_order_and_a_status_between_them_is_not(working, monkeypatch):
    station, worker, posted = working
    polled = threading.Event()
    honest = station.poll

    def poll():
        polled.set()
        return honest()

    monkeypatch.setattr(station, "poll", poll)

    def refused(_):
        raise ProcedureRefused("not now")

    worker.submit(Asked, lambda _: 7)
    worker.submit(Asked, refused)
    assert polled.wait(20.0)
    worker.submit(Asked, lambda _: 8)
    first, second, third = answers(posted, 3)
    assert (first.result, third.result) == (7, 8)
    assert str(second.error) == "not now"
    assert not any(isinstance(news, StatusRead) for news in (first, second, third))


def test_steps_that_wait_while_the_line_is_lost_are_refused_and_the_line_is_opened_again(working):
    _, worker, posted = working
    waiting = threading.Event()
    done = []

    def cut(_):
        assert waiting.wait(20.0)
        raise LinkError("the line is cut")

    worker.submit(Asked, cut)
    worker.submit(Asked, lambda _: done.append(1))
    worker.submit(Asked, lambda _: done.append(2))
    worker.reconnect_now()
    waiting.set()
    first, second, third, last = answers(posted, 4)
    assert str(first.error) == "the line is cut"
    assert isinstance(last, Reconnected)
    for refused in (second, third):
        assert str(refused.error) == "question: not done, the link is down"
    assert done == []


def test_a_step_asked_for_while_the_line_is_lost_is_refused_at_once():
    station, _ = emulated_station()
    posted = queue.Queue()
    worker = StationWorker(station, posted.put)
    station.link_lost(LinkError("the line is cut"))
    worker.submit(Asked, lambda _: 7)
    (refused,) = answers(posted, 1)
    assert str(refused.error) == "question: not done, the link is down"
    assert not worker.busy


class Remarked(Done[Note], name="remark"): ...


@pytest.fixture
def cut_off(monkeypatch):
    """A worker whose line is lost and does not come back."""
    station, _ = emulated_station()
    posted = queue.Queue()
    worker = StationWorker(station, posted.put)

    def never():
        raise LinkError("still cut")

    monkeypatch.setattr(station, "reconnect", never)
    station.link_lost(LinkError("the line is cut"))
    worker.start()
    yield station, worker, posted
    worker.close()


def test_what_only_the_file_needs_is_done_while_the_line_is_lost(cut_off):
    station, worker, posted = cut_off
    worker.submit(Asked, lambda _: 7)
    worker.submit(Remarked, lambda station: station.note("the cable came off"), needs_unit=False)
    refused, written = answers(posted, 2)
    assert str(refused.error) == "question: not done, the link is down"
    worker.submit(Done, lambda station: station.void(written.result.seq, "typo"), needs_unit=False)
    (struck,) = answers(posted, 1)
    kinds = [type(record) for record in station.session.records[-3:]]
    assert kinds == [LinkLost, Note, Void]
    assert struck.result.voids == written.result.seq


def test_a_try_asked_for_does_not_wait_for_its_pause(cut_off, monkeypatch):
    station, worker, posted = cut_off
    monkeypatch.setattr(station, "reconnect", lambda: None)
    worker.reconnect_now()
    (back,) = answers(posted, 1)
    assert isinstance(back, Reconnected)


@pytest.mark.parametrize("comes_back", [False, True])
def test_pauses_between_tries_double_up_to_a_quarter_of_a_minute(monkeypatch, comes_back):
    """Also while the line comes back for moments: it is not opened anew every second."""
    station, _ = emulated_station()
    worker = StationWorker(station, lambda news: None)

    def reconnect():
        if not comes_back:
            raise LinkError("still cut")

    monkeypatch.setattr(station, "reconnect", reconnect)
    pauses = [FIRST_RETRY_S]
    for _ in range(5):
        worker.reconnect_now()
        pauses.append(worker._try_again(pauses[-1]))
    assert pauses == [1.0, 2.0, 4.0, 8.0, 15.0, 15.0]
