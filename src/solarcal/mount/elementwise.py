"""One equation for one angle or for many: ``math`` for floats, numpy for arrays.

The controller and the world of the emulator ask for single angles some 1e5 times a day. A numpy
function takes about a microsecond for a float, its namesake in ``math`` a twentieth of that.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from solarcal.units import wrap_deg

Value: TypeAlias = Any
"""A float or a float64 array, whichever the caller of the equation came with."""

Vector: TypeAlias = tuple[Value, Value, Value]
"""Three components, each a float or an array; kept apart because (..., 3) arrays are slower."""


def _choose(condition: bool, if_true: float, if_false: float) -> float:
    return if_true if condition else if_false


def _wrap_float_deg(angle_deg: float, centre_deg: float = 0.0) -> float:
    return float(wrap_deg(angle_deg, centre_deg))


class Maths(NamedTuple):
    """The functions the mount's equations need, under numpy's names."""

    sin: Callable[[Value], Value]
    cos: Callable[[Value], Value]
    arctan2: Callable[[Value, Value], Value]
    arccos: Callable[[Value], Value]
    hypot: Callable[[Value, Value], Value]
    sqrt: Callable[[Value], Value]
    where: Callable[[Value, Value, Value], Value]
    wrap_deg: Callable[..., Value]
    any: Callable[[Value], bool]


_FLOATS = Maths(
    math.sin,
    math.cos,
    math.atan2,
    math.acos,
    math.hypot,
    math.sqrt,
    _choose,
    _wrap_float_deg,
    bool,
)
_ARRAYS = Maths(
    np.sin,
    np.cos,
    np.arctan2,
    np.arccos,
    np.hypot,
    np.sqrt,
    np.where,
    wrap_deg,
    lambda condition: bool(np.any(condition)),
)


def maths_for(*values: Value) -> Maths:
    """``math`` when every value is a plain number, numpy when any is an array."""
    for value in values:
        if not isinstance(value, (float, int)):
            return _ARRAYS
    return _FLOATS


def dot(a: Vector, b: Vector) -> Value:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit_vector(m: Maths, ax1_rad: Value, ax2_rad: Value) -> Vector:
    """Direction of longitude ``ax1`` and polar distance ``ax2``."""
    sin2 = m.sin(ax2_rad)
    return sin2 * m.cos(ax1_rad), sin2 * m.sin(ax1_rad), m.cos(ax2_rad)
