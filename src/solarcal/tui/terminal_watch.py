"""A terminal that is gone ends the program, as a hang-up does.

Where the program is no child of its terminal the system sends no hang-up when that is closed. It
would then read an end of file for ever, as fast as it can, and hold the unit's line and the session
file. Everything recorded is on the disk already; the start screen offers to go on.
"""

import os
import select
import signal
import threading


def end_with_terminal(descriptor: int) -> None:
    """Raise SIGHUP in this process when the terminal at ``descriptor`` is gone.

    Does nothing where the system has no ``poll`` or no hang-ups.
    """
    if not hasattr(select, "poll") or not hasattr(signal, "SIGHUP"):
        return
    watch = threading.Thread(
        target=_wait_for_hang_up, args=(descriptor,), name="terminal watch", daemon=True
    )
    watch.start()


def _wait_for_hang_up(descriptor: int) -> None:
    poll = select.poll()
    # No event is asked for: a hang-up and an error are told all the same, a key is not.
    poll.register(descriptor, 0)
    if poll.poll():
        os.kill(os.getpid(), signal.SIGHUP)
