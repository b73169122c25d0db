"""``python -m solarcal`` and the ``solarcal`` script."""

import gc
import os
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
    from solarcal.cli import run_command
    from solarcal.cli.process import demand_streams, end_by_signals

    gc.set_threshold(ALLOCATIONS_BETWEEN_COLLECTIONS)
    demand_streams()
    end_by_signals()
    return run_command(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())
