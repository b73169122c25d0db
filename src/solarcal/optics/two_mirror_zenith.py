"""Near the zenith: the azimuth is calculated, and never turns back.

Near its primary axis a tracker's azimuth follows from the diode only with much noise, and the Sun
passes it faster than the axis turns. Within a few degrees the azimuth therefore goes by
calculation, in the one sense in which the Sun turns there, at the best rate of the axis.
"""

import itertools
import math
from collections.abc import Sequence


def sense_of_turn(azimuths_deg: Sequence[float]) -> int:
    """+1 or -1: the sense of a path of calculated azimuths, each the short way from the last."""
    steps = (
        math.remainder(after - before, 360.0) for before, after in itertools.pairwise(azimuths_deg)
    )
    return -1 if sum(steps) < 0.0 else 1


class ZenithPassage:
    """One passage: the azimuth asked of axis 1, monotone from entry to exit.

    Parameters
    ----------
    axis1_deg : where axis 1 stands at the entry, unwrapped.
    path_deg : calculated azimuths from entry to exit, dense enough to tell the sense.
    """

    def __init__(self, axis1_deg: float, path_deg: Sequence[float]) -> None:
        self.sense = sense_of_turn(path_deg)
        self._asked_deg = axis1_deg

    def azimuth_deg(self, calculated_deg: float) -> float:
        """The next azimuth to ask for, unwrapped: the calculated one, or where it already was."""
        ahead = math.remainder(calculated_deg - self._asked_deg, 360.0)
        if ahead * self.sense > 0.0:
            self._asked_deg += ahead
        return self._asked_deg

    def rate_deg_s(self, axis1_deg: float, asked_deg: float, period_s: float) -> float:
        """Rate of axis 1 that brings it there in one period; never backward."""
        rate = (asked_deg - axis1_deg) / period_s
        return rate if rate * self.sense > 0.0 else 0.0
