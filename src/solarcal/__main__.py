"""``python -m solarcal`` and the ``solarcal`` script."""

import gc
import os
import signal
import sys

# All our matrices are small: a second thread of the linear algebra library is waited for longer
# than it works, ten times so where another program has the other core. Before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

ALLOCATIONS_BETWEEN_COLLECTIONS = 50_000
"""A file of many rows makes hundreds of thousands of small objects and no circle among them."""


def main() -> int:
    if "_ARGCOMPLETE" in os.environ:
        from solarcal.cli.completion import complete

        complete()
    # Nothing is open yet: an interrupt ends the process, with no traceback of imports.
    _on_interrupt(signal.SIG_DFL)
    from solarcal.cli import run_command
    from solarcal.cli.process import demand_streams, end_by_signals

    gc.set_threshold(ALLOCATIONS_BETWEEN_COLLECTIONS)
    demand_streams()
    end_by_signals()
    try:
        return run_command(sys.argv[1:])
    finally:
        # Everything is done: the exit code stays that of the command.
        _on_interrupt(signal.SIG_IGN)


def _on_interrupt(how: signal.Handlers) -> None:
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, how)


if __name__ == "__main__":
    sys.exit(main())
