"""For all tests: the same cases every time, nobody waits for the medium or a second thread."""

import functools
import gc
import gettext
import itertools
import os
import signal
import socket
import sys
from collections.abc import Callable

import hypothesis
import pytest

# The same cases in every run, however slow the machine is; new ones are looked for by `make fuzz`.
hypothesis.settings.register_profile("same every time", derandomize=True, deadline=None)
hypothesis.settings.load_profile("same every time")

# Until all tests are collected: what is loaded by then stays, see `pytest_collection_finish`.
gc.disable()

# As the program itself starts: see solarcal.__main__. Two workers with two threads each on two
# cores wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell starts what runs in the background deaf to Ctrl-C, and so all that a test starts.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Bytecode is kept, whatever the shell says: without it each worker rewrites the assertions of all
# tests anew, and every program that a test starts compiles itself before it begins.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


@pytest.fixture(scope="session", autouse=True)
def no_waiting_for_the_medium():
    """A sync of the test run's own process returns at once: thousands of them cost minutes.

    What a sync protects from is a power cut, which no test can make; that each record is synced
    before it is acknowledged, and what a failed sync leaves, is proven by the recording `Disk` of
    the journal's tests. Programs that tests start in processes of their own sync as ever.
    """
    patched = pytest.MonkeyPatch()
    patched.setattr(os, "fsync", lambda descriptor: None)
    yield
    patched.undo()


@pytest.fixture(scope="session", autouse=True)
def translations_are_looked_for_once():
    """argparse asks the file system for a translation of each word of every parser it makes; a
    program makes one parser, a test run a thousand."""
    patched = pytest.MonkeyPatch()
    patched.setattr(gettext, "find", functools.cache(gettext.find))
    yield
    patched.undo()


@pytest.fixture(scope="session")
def free_port() -> Callable[[], int]:
    """Gives ports for servers that must be told theirs, each port once.

    They lie below those that the system gives to whoever asks for any: between the look and the
    server's own binding no other test's connection can have taken one, and a client that knocks
    before the server listens cannot be connected to itself.
    """
    candidates = itertools.count(os.getpid() * 61)

    def port() -> int:
        for candidate in itertools.islice(candidates, 1000):
            number = 20_000 + candidate % 10_000
            with socket.socket() as one:
                try:
                    one.bind(("127.0.0.1", number))
                except OSError:
                    continue
                return number
        raise AssertionError("no port is free between 20000 and 30000")

    return port


def pytest_collection_finish() -> None:
    """Modules and collected tests live until the end: the garbage collector need not look at half
    a million objects again and again, only at what tests make."""
    gc.enable()
    gc.freeze()
    gc.set_threshold(1_000_000, 20, 50)


def pytest_sessionfinish() -> None:
    """What nobody waited for or closed is found by one look; pytest would look five times."""
    gc.collect()
    gc.freeze()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What waits for real processes begins first: begun last it would be waited for alone.

    All workers are given as many tests, in this order. One half of what waits begins on the first,
    the other on the second: on one worker it takes as long as everything else on the others.
    """
    waits = [item for item in items if item.get_closest_marker("slow") is not None]
    others = [item for item in items if item.get_closest_marker("slow") is None]
    share = len(items) // int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    half = len(waits) // 2
    items[:] = [*waits[:half], *others]
    items[share:share] = waits[half:]
