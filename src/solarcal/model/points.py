"""The points a model is fitted to."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from solarcal.errors import FitError
from solarcal.model.finding import points_named
from solarcal.model.repeats import ANGLES, Copy, repeats
from solarcal.mount.geometry import MountGeometry
from solarcal.units import FloatArray

Mask: TypeAlias = NDArray[np.bool_]

POLE_MARGIN_DEG = 0.01
"""Nearer than this to AX2 = 0 or 180 deg an axis 1 error says nothing and may be anything."""

SIGMA_LOW_DEG, SIGMA_HIGH_DEG = 1e-9, 360.0
"""Sigmas a pointing error can have; outside, squares of weights leave the range of float64."""


def _column(values: object, name: str, n: int | None) -> FloatArray:
    column = np.array(values, dtype=np.float64)
    if column.ndim != 1:
        raise FitError(f"{name} must be one number per point, not an array of shape {column.shape}")
    if n is not None and len(column) != n:
        raise FitError(f"{name} has {len(column)} numbers for {n} points")
    # Points are shared by fits and screens: nobody may change them under another's feet.
    column.flags.writeable = False
    return column


@dataclass(frozen=True, eq=False, kw_only=True)
class Points:
    """Points of one mount, checked once so that every fit may trust them.

    Parameters
    ----------
    geometry : the mount; AX1 is brought onto its branch.
    ax1_deg, ax2_deg : (n,), IDEAL Sun angles in the native frame, degrees.
    err1_deg, err2_deg : (n,), axis errors, reading minus ideal, in AXIS degrees (not on sky).
    sigma_deg : (n,), standard deviation of one point ON SKY, per axis.
    labels : n integers by which messages call the points: sequence or line numbers. Default 1..n.
    utc_s : (n,), POSIX seconds, NaN where unknown.

    Raises
    ------
    FitError
        One line naming the first point that is not finite, at a pole of axis 2, off by more than
        half a turn, or whose sigma is not positive.
    """

    geometry: MountGeometry
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    sigma_deg: FloatArray | None = None
    labels: tuple[int, ...] = ()
    utc_s: FloatArray | None = None
    moved_to_branch: tuple[int, ...] = field(init=False, default=())
    """Labels of points whose AX1 was given off the mount's branch and was moved by whole turns."""
    copies: tuple[Copy, ...] = ()
    """Labels of points left out because they repeat a point, that point's, and their difference on
    the sky, 0 where it is small."""

    def __post_init__(self) -> None:
        keep = object.__setattr__
        n = None
        for name in COLUMNS:
            values = getattr(self, name)
            if values is not None:
                column = _column(values, name, n)
                n = len(column)
                keep(self, name, column)
        keep(self, "labels", tuple(self.labels) or tuple(range(1, len(self) + 1)))
        if len(self.labels) != len(self):
            raise FitError(f"{len(self.labels)} labels were given for {len(self)} points")
        self._refuse_unusable()
        on_branch = np.asarray(self.geometry.branch(self.ax1_deg), dtype=np.float64)
        moved = on_branch != self.ax1_deg
        if moved.any():
            on_branch.flags.writeable = False
            keep(self, "ax1_deg", on_branch)
            keep(self, "moved_to_branch", tuple(self.labels[i] for i in np.flatnonzero(moved)))

    def __len__(self) -> int:
        return len(self.ax1_deg)

    @property
    def in_time(self) -> NDArray[np.intp] | None:
        """Positions (n,) in the order of time; None where a time is not known."""
        if self.utc_s is None or not np.isfinite(self.utc_s).all():
            return None
        return np.argsort(self.utc_s, kind="stable")

    def _refuse_unusable(self) -> None:
        for name in (name for name in COLUMNS if name != "utc_s"):
            column = getattr(self, name)
            if column is not None:
                self._refuse(~np.isfinite(column), f"{name} is {{}}, not a number", column)
        ax1, ax2 = self.ax1_deg, self.ax2_deg
        self._refuse(np.abs(ax1) > 720.0, "AX1 {:g} deg is more than two turns", ax1)
        self._refuse((ax2 < 0.0) | (ax2 > 180.0), "AX2 {:g} is not between 0 and 180 deg", ax2)
        self._refuse(
            np.minimum(ax2, 180.0 - ax2) < POLE_MARGIN_DEG,
            "AX2 {:g} deg is at a pole of axis 2, where axis 1 has no direction; leave it out",
            ax2,
        )
        for axis, error in ((1, self.err1_deg), (2, self.err2_deg)):
            self._refuse(
                np.abs(error) > 180.0,
                f"the axis {axis} error of {{:g}} deg is more than half a turn; "
                "reading and ideal angle lie on different branches",
                error,
            )
        if self.sigma_deg is not None:
            self._refuse(
                (self.sigma_deg < SIGMA_LOW_DEG) | (self.sigma_deg > SIGMA_HIGH_DEG),
                f"sigma {{:g}} deg must be greater than zero, from {SIGMA_LOW_DEG:g} to "
                f"{SIGMA_HIGH_DEG:g} deg",
                self.sigma_deg,
            )

    def _refuse(self, bad: Mask, complaint: str, column: FloatArray) -> None:
        indices = np.flatnonzero(bad)
        if len(indices):
            first = indices[0]
            raise FitError(f"point {self.labels[first]}: {complaint.format(column[first])}")

    def replace(self, **columns: FloatArray | None) -> "Points":
        """The same points with these columns instead, checked as new ones."""
        return replace(self, **columns)  # type: ignore[arg-type]

    def subset(self, indices: Sequence[int] | Mask) -> "Points":
        """The points at these positions (integers, or a boolean mask), in that order."""
        # An empty list would come as floats, which index nothing.
        positions = np.asarray(indices, dtype=None if len(indices) else np.intp)
        chosen = np.arange(len(self))[positions]
        given: dict[str, Any] = {name: getattr(self, name) for name in COLUMNS}
        columns: dict[str, Any] = {
            name: column if column is None else column[chosen] for name, column in given.items()
        }
        labels = tuple(self.labels[i] for i in chosen)
        return Points(geometry=self.geometry, labels=labels, **columns)

    @classmethod
    def joined(cls, parts: "Sequence[Points]") -> "Points":
        """The points of all, one after the other; columns that all of them have."""
        columns: dict[str, Any] = dict.fromkeys(COLUMNS)
        for name in COLUMNS:
            given = [getattr(part, name) for part in parts]
            if all(column is not None for column in given):
                columns[name] = np.concatenate(given)
        for name in ("labels", "copies"):
            columns[name] = tuple(one for part in parts for one in getattr(part, name))
        return cls(geometry=parts[0].geometry, **columns)

    def distinct(self) -> "Points":
        """The points, each measurement taken once: see ``repeats``."""
        utc_s = np.full(len(self), np.nan) if self.utc_s is None else self.utc_s
        angles_deg = np.column_stack([getattr(self, name) for name in ANGLES])
        found = tuple(repeats(utc_s, angles_deg, self.sigma_deg))
        if not found:
            return self
        once = self.subset(np.delete(np.arange(len(self)), [row for row, _, _ in found]))
        labels = self.labels
        copies = tuple((labels[row], labels[first], apart) for row, first, apart in found)
        return replace(once, copies=copies)

    def remarks(self) -> tuple[str, ...]:
        """Sentences about points that can be fitted but deserve a second look."""
        return (*self._remark_moved(), *self._remark_repeated(), *self._remark_branch_crossed())

    def _remark_moved(self) -> list[str]:
        if not self.moved_to_branch:
            return []
        centre = self.geometry.ax1_centre_deg
        return [
            f"AX1 of {points_named(self.moved_to_branch)} was given off the mount's branch "
            f"({centre - 180.0:g}, {centre + 180.0:g}] deg and was moved onto it by whole turns"
        ]

    def _remark_repeated(self) -> list[str]:
        if not self.copies:
            return []
        others, firsts, _ = zip(*self.copies, strict=True)
        return [
            f"{points_named(others)} repeat{'s' * (len(others) == 1)} "
            f"{points_named(tuple(dict.fromkeys(firsts)))}: a measurement counts once"
        ]

    def _remark_branch_crossed(self) -> list[str]:
        order = self.in_time
        # Only a path in time crosses anything: a telescope's grid of stars lies all round.
        if order is None:
            return []
        # A step of more than 270 deg along the branch is a short one across its ends.
        steps = np.flatnonzero(np.abs(np.diff(self.ax1_deg[order])) > 270.0)
        end = self.geometry.ax1_centre_deg + 180.0
        return [
            f"between points {self.labels[order[i]]} and {self.labels[order[i + 1]]} axis 1 passes "
            f"the end of its branch at {end:g} deg; the two sides need a calibration of their own"
            for i in steps[:1]
        ]


COLUMNS = ("ax1_deg", "ax2_deg", "err1_deg", "err2_deg", "sigma_deg", "utc_s")
"""What a ``Points`` has one number of for each point, or for none."""
