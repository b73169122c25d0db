"""Following the Sun in steps: when the controller moves next, and what happens at a limit.

The controller moves in steps: once the Sun has run half the update range ahead of an axis, the
axis drives half the range ahead of the Sun and waits for it again. Between two such instants
nothing happens, so they are looked for instead of ticked through: the target is computed at nodes
fixed in time, a block at once, and interpolated between them (cubic; 1e-7 deg from the target
itself but very near the zenith). The nodes do not depend on who asks or when, so neither do the
instants found.
"""

import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import numpy as np

from solarcal.emulator.controller_model import AxisControl, EmulatedControllerModel
from solarcal.units import FloatArray

NODE_S = 30.0
"""Spacing of the nodes: (30 s * 15 deg/h)^4 / 384 of a radian is 2e-12 deg of interpolation error
far from the primary axis, 1e-7 deg where AX1 runs ten times as fast."""
BLOCK = 480
FEW_NODES = 8
UPDATE_S, CHANGE_S = 1e-6, 1e-3
"""How well the instant of an update and that of a limit are found."""
SEARCH_BLOCKS = 6
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
        self._cubics: dict[tuple[int, int], Callable[[float], float]] = {}

    def target_deg(self, axis: int, now_s: float) -> float:
        """Reading the axis (0 or 1) belongs at, interpolated."""
        return self._curve_from(axis, math.floor(now_s / NODE_S))(now_s)

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
        # Nearly always it is one of the next nodes: these are looked at without arrays.
        nodes, k = self._lists(axis, first)
        for ahead in range(min(FEW_NODES, BLOCK + 1 - k)):
            here, there = nodes[k + ahead], nodes[k + ahead + 1]
            if (there - reading_deg) * (1.0 if there >= here else -1.0) >= half_deg:
                return self._lagging_s(axis, first + ahead, reading_deg, half_deg, now_s)
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
        at = self._curve_from(axis, node)

        def excess(at_s: float) -> float:
            return (at(at_s) - reading_deg) * sense - half_deg

        if low >= high or excess(low) >= 0.0:
            return low
        return _root(excess, low, high, UPDATE_S)

    def _changing_s(self, node: int, within: bool, now_s: float) -> float:
        """Just after the room between two nodes changes its sign."""
        low, high = max(now_s, node * NODE_S), (node + 1) * NODE_S

        def room(at_s: float) -> float:
            return float(self._targets(np.array([at_s]))[1][0])

        if low >= high or (room(low) >= 0.0) != within:
            return low
        return min(_root(room, low, high, CHANGE_S) + CHANGE_S, high)

    def _curve_from(self, axis: int, node: int) -> Callable[[float], float]:
        """The curve between a node and the next as a function of time: asked for some times."""
        cubic = self._cubics.get((axis, node))
        if cubic is None:
            cubic = self._cubics[axis, node] = self._cubic(axis, node)
        return cubic

    def _cubic(self, axis: int, node: int) -> Callable[[float], float]:
        nodes, k = self._lists(axis, node)
        before, here, there, after = nodes[k - 1 : k + 3]
        if max(before, here, there, after) - min(before, here, there, after) > 180.0:
            # The Sun crosses the end of the branch: no curve runs through such a jump.
            return lambda at_s: float(self._targets(np.array([at_s]))[0][axis, 0])
        # The cubic through four nodes, in nodes from the second of them.
        third = (after - before) / 6.0 - 0.5 * (there - here)
        second = 0.5 * (before + there) - here
        first = there - here - second - third

        def at(at_s: float) -> float:
            u = at_s / NODE_S - node
            return here + u * (first + u * (second + u * third))

        return at

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


def _root(of: Callable[[float], float], low: float, high: float, within_s: float) -> float:
    """Where the sign changes; at the later end where, of two ways to compute it, one says there."""
    if (of(low) >= 0.0) == (of(high) >= 0.0):
        return high
    # scipy takes long to import; an emulator that follows nothing does without it.
    from scipy.optimize import brentq  # noqa: PLC0415

    return float(brentq(of, low, high, xtol=within_s))


def _search_ends_s(first_node: int) -> float:
    return (first_node // BLOCK + SEARCH_BLOCKS) * BLOCK * NODE_S


_ROUNDING_DEG: Final = 1e-6
"""The instant of an update is found to better than this."""
_TRY_AGAIN_S: Final = 1.0


class SunFollower:
    """Mode ``TRACK`` of a controller, for both axes. Times are seconds since the start."""

    def __init__(
        self, model: EmulatedControllerModel, axes: Sequence[AxisControl], update_range_deg: float
    ) -> None:
        self._model = model
        self._axes = axes
        self.update_range_deg = update_range_deg
        self._curve = TargetCurve(model.targets_deg)
        self.within = False
        """The target lies within limits, the Sun above the horizon."""
        self._change_s = NEVER_S
        self._updates_s = [NEVER_S, NEVER_S]
        self._updated_s = 0.0

    def begin(self, now_s: float) -> None:
        """Follow from now on."""
        self._updated_s = now_s
        self.reconsider(now_s)

    def reconsider(self, now_s: float) -> None:
        """Think anew where clock, site, P, O or limits are others or a limit is met."""
        self._curve = TargetCurve(self._model.targets_deg)
        self.within = self._curve.is_within(now_s)
        self._change_s = self._curve.next_change_s(self.within, now_s)
        self._updates_s = [NEVER_S, NEVER_S]
        for index, axis in enumerate(self._axes):
            if self.within:
                self.keep_up(index, now_s)
            else:
                axis.stop(now_s)

    def next_event_s(self) -> float:
        return min(self._change_s, *self._updates_s)

    def limit_due(self, now_s: float) -> bool:
        """Whether the target now crosses a limit, in or out."""
        return self._change_s <= now_s

    def update_due(self, now_s: float) -> None:
        for index, due_s in enumerate(self._updates_s):
            if due_s <= now_s:
                self.keep_up(index, now_s)

    def updated(self, index: int, now_s: float) -> None:
        """An axis has arrived half the range ahead of the Sun."""
        self._updated_s = now_s
        if self._axes[index].fell_short(now_s):
            self._updates_s[index] = now_s + _TRY_AGAIN_S
        else:
            self.keep_up(index, now_s)

    def keep_up(self, index: int, now_s: float) -> None:
        """Drive half the update range ahead of the Sun if an axis (0, 1) is due, else wait."""
        axis = self._axes[index]
        if not self.within or not axis.at_rest:
            self._updates_s[index] = NEVER_S
            return
        half_deg = 0.5 * self.update_range_deg
        # The loop closes on the encoder, not on a read-out that may be frozen.
        stands_deg = axis.encoder_reading_deg(now_s)
        sense = self._curve.sense(index, now_s)
        target_deg = self._curve.target_deg(index, now_s)
        lag_deg = (target_deg - stands_deg) * sense
        too_far_ahead = -lag_deg > half_deg + 2.0 * axis.count_deg()
        if lag_deg < half_deg - _ROUNDING_DEG and not too_far_ahead:
            self._updates_s[index] = self._curve.next_update_s(index, stands_deg, half_deg, now_s)
            return
        limits = (self._model.limits.axis1, self._model.limits.axis2)[index]
        aim_deg = limits.clamped_deg(target_deg + sense * half_deg)
        if axis.drive_to(aim_deg, now_s):
            self._updates_s[index] = NEVER_S
        else:
            # One count is more than the range: look again when the Sun has moved on.
            self._updates_s[index] = now_s + _TRY_AGAIN_S

    def phase(self, now_s: float) -> float:
        """How far the wait for the next update has gone, 0..1; 0 while both axes move."""
        due_s = min(self._updates_s)
        if not self._updated_s < due_s < NEVER_S:
            return 0.0
        return (now_s - self._updated_s) / (due_s - self._updated_s)
