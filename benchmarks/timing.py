"""How a benchmark times: several runs, the quickest and the middle one of them.

The quickest is what the work costs; how far the middle one lies from it is how busy the machine
was. Ratios are of the quickest, of runs taken in turn.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median


@dataclass(frozen=True)
class Timing:
    """Seconds of one piece of work."""

    least_s: float
    median_s: float

    def per(self, count: int, unit_s: float) -> str:
        """``least (median)`` for one of ``count``, in units of so many seconds."""
        return f"{self.least_s / count / unit_s:.3g} ({self.median_s / count / unit_s:.3g})"

    def ms(self) -> str:
        return self.per(1, 1e-3)


def timed(*works: Callable[[], object], runs: int = 7, least_s: float = 0.02) -> list[Timing]:
    """Each of these, in turn so that a busy moment hits all; quick work is repeated in a run.

    A single run is of work that takes so long that nothing need be warm.
    """
    repeats = [_repeats(work, least_s) if runs > 1 else 1 for work in works]
    seconds: list[list[float]] = [[] for _ in works]
    for _ in range(runs):
        for work, number, found in zip(works, repeats, seconds, strict=True):
            started = time.perf_counter()
            for _ in range(number):
                work()
            found.append((time.perf_counter() - started) / number)
    return [Timing(min(found), median(found)) for found in seconds]


def _repeats(work: Callable[[], object], least_s: float) -> int:
    work()
    started = time.perf_counter()
    work()
    once = max(time.perf_counter() - started, 1e-6)
    return max(1, int(least_s / once))


def table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> list[str]:
    """Columns, the first to the left, the others to the right."""
    widths = [max(len(row[i]) for row in (head, *rows)) for i in range(len(head))]
    return [
        "  ".join(
            cell.ljust(width) if i == 0 else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in (head, *rows)
    ]
