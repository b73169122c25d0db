"""When does the controller move next? The target over time, and its crossings.

The controller moves in steps: once the Sun has run half the update range ahead of an axis, the
axis drives half the range ahead of the Sun and waits for it again. Between two such instants
nothing happens, so they are looked for instead of ticked through: the target is computed at nodes
fixed in time, a block at once, and interpolated between them (cubic; 1e-7 deg from the target
itself but very near the zenith). The nodes do not depend on who asks or when, so neither do the
instants found.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from solarcal.units import FloatArray

NODE_S = 30.0
"""Spacing of the nodes: (30 s * 15 deg/h)^4 / 384 of a radian is 2e-12 deg of interpolation error
far from the primary axis, 1e-7 deg where AX1 runs ten times as fast."""
BLOCK = 120
SEARCH_BLOCKS = 24
"""A day of nodes: what does not happen within it is looked for again after it."""


NEVER_S = math.inf


class _Block(NamedTuple):
    """Nodes first-1 .. first+BLOCK+1: targets (2, n), also as lists, and the room (n,)."""

    targets: FloatArray
    lists: tuple[list[float], list[float]]
    room: FloatArray


class TargetCurve:
    """The readings to drive to as a function of time, for one state of clock, site, P and O.

    ``targets(now_s)`` gives, for an array (n,) of seconds since the start, the readings (2, n) and
    the room (n,): degrees to the nearest limit or to the horizon, negative beyond.
    """

    def __init__(self, targets: Callable[[FloatArray], tuple[FloatArray, FloatArray]]) -> None:
        self._targets = targets
        self._blocks: dict[int, _Block] = {}

    def target_deg(self, axis: int, now_s: float) -> float:
        """Reading the axis (0 or 1) belongs at, interpolated."""
        return self._at(axis, math.floor(now_s / NODE_S), now_s)

    def sense(self, axis: int, now_s: float) -> int:
        """Which way the target moves now."""
        node = math.floor(now_s / NODE_S)
        nodes, k = self._lists(axis, node)
        return 1 if nodes[k + 1] >= nodes[k] else -1

    def next_update_s(self, axis: int, reading_deg: float, half_deg: float, now_s: float) -> float:
        """First time, not before ``now_s``, at which the axis lags by half the update range.

        The end of the search where that does not happen within a day: look again then.
        """
        first = math.floor(now_s / NODE_S)
        for number in range(first // BLOCK, first // BLOCK + SEARCH_BLOCKS):
            targets = self._block(number).targets[axis, 1:-1]
            start = number * BLOCK
            skip = max(first - start, 0)
            ends = targets[skip + 1 :]
            lag = (ends - reading_deg) * np.where(ends >= targets[skip:-1], 1.0, -1.0)
            found = lag >= half_deg
            hit = int(found.argmax())
            if found[hit]:
                return self._lagging_s(axis, start + skip + hit, reading_deg, half_deg, now_s)
        return _search_ends_s(first)

    def next_change_s(self, within: bool, now_s: float) -> float:
        """First time from ``now_s`` at which the target leaves (or enters) limits and horizon.

        The end of the search where that does not happen within a day: look again then.
        """
        first = math.floor(now_s / NODE_S)
        for number in range(first // BLOCK, first // BLOCK + SEARCH_BLOCKS):
            start = number * BLOCK
            skip = max(first - start, 0)
            changed = (self._block(number).room[skip + 2 : -1] >= 0.0) != within
            hit = int(changed.argmax())
            if changed[hit]:
                return self._changing_s(start + skip + hit, within, now_s)
        return _search_ends_s(first)

    def is_within(self, now_s: float) -> bool:
        """Whether the target lies within limits and the Sun above the horizon."""
        return bool(self._targets(np.array([now_s]))[1][0] >= 0.0)

    def _lagging_s(
        self, axis: int, node: int, reading_deg: float, half_deg: float, now_s: float
    ) -> float:
        """Root of lag = half the range between two nodes."""
        low, high = max(now_s, node * NODE_S), (node + 1) * NODE_S
        nodes, k = self._lists(axis, node)
        sense = 1.0 if nodes[k + 1] >= nodes[k] else -1.0

        def excess(at_s: float) -> float:
            return (self._at(axis, node, at_s) - reading_deg) * sense - half_deg

        below, above = excess(low), excess(high)
        if below >= 0.0 or low >= high:
            return low
        # False position with the Illinois rule: the curve is nearly straight, three steps do.
        side = 0
        while high - low > 1e-6:
            middle = high - above * (high - low) / (above - below)
            value = excess(middle)
            if abs(value) < 1e-10:
                return middle
            if value > 0.0:
                high, above = middle, value
                below *= 0.5 if side == 1 else 1.0
                side = 1
            else:
                low, below = middle, value
                above *= 0.5 if side == -1 else 1.0
                side = -1
        return high

    def _changing_s(self, node: int, within: bool, now_s: float) -> float:
        low, high = max(now_s, node * NODE_S), (node + 1) * NODE_S
        while high - low > 1e-3:
            middle = 0.5 * (low + high)
            if self.is_within(middle) == within:
                low = middle
            else:
                high = middle
        return high

    def _at(self, axis: int, node: int, at_s: float) -> float:
        nodes, k = self._lists(axis, node)
        before, here, there, after = nodes[k - 1 : k + 3]
        if max(before, here, there, after) - min(before, here, there, after) > 180.0:
            # The Sun crosses the end of the branch: no curve runs through such a jump.
            return float(self._targets(np.array([at_s]))[0][axis, 0])
        u = at_s / NODE_S - node
        return (
            -u * (u - 1.0) * (u - 2.0) / 6.0 * before
            + (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0 * here
            - (u + 1.0) * u * (u - 2.0) / 2.0 * there
            + (u + 1.0) * u * (u - 1.0) / 6.0 * after
        )

    def _lists(self, axis: int, node: int) -> tuple[list[float], int]:
        """The block's targets as plain floats, and where in it the node stands."""
        number, k = divmod(node, BLOCK)
        return self._block(number).lists[axis], k + 1

    def _block(self, number: int) -> _Block:
        block = self._blocks.get(number)
        if block is None:
            nodes = np.arange(number * BLOCK - 1.0, (number + 1) * BLOCK + 2.0)
            targets, room = self._targets(nodes * NODE_S)
            lists = (targets[0].tolist(), targets[1].tolist())
            block = self._blocks[number] = _Block(targets, lists, room)
        return block


def _search_ends_s(first_node: int) -> float:
    return (first_node // BLOCK + SEARCH_BLOCKS) * BLOCK * NODE_S
