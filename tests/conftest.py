"""For all tests: nobody waits for the medium."""

import os

import pytest


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
