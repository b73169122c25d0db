"""The exact errors of a mechanism and their slopes, on sky: what every exact fit is made of."""

import math

import numpy as np

from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.units import RAD_PER_DEG, FloatArray

LEAN_STEP_DEG = 1e-4
"""Step of the differences with respect to lean; the other four parameters are exactly linear."""

LARGEST_LEAN_DEG = 40.0
"""A search may wander: the mechanism itself refuses 45."""

_LARGEST_ZERO_DEG = 359.0
_LARGEST_SCALE = 0.49


def mechanism_of(values: FloatArray) -> Mechanism:
    """The mechanism of six numbers (6,), lean held to what can be computed."""
    P1, P2, P3, P4, P5, P6 = values.tolist()
    shrink = min(1.0, LARGEST_LEAN_DEG / max(math.hypot(P1, P3), 1e-12))
    return Mechanism(
        P1 * shrink,
        _held(P2, _LARGEST_ZERO_DEG),
        P3 * shrink,
        _held(P4, _LARGEST_ZERO_DEG),
        _held(P5, _LARGEST_SCALE),
        _held(P6, _LARGEST_SCALE),
    )


def _held(value: float, largest: float) -> float:
    return min(max(value, -largest), largest)


def axis_errors_deg(
    values: FloatArray, geometry: MountGeometry, ax1_deg: FloatArray, ax2_deg: FloatArray
) -> FloatArray:
    """E1, E2 of the mechanism of six numbers at true directions, (2, n), axis degrees."""
    return np.stack(mechanism_of(values).errors_deg(geometry, ax1_deg, ax2_deg))


def errors_and_slopes(
    values: FloatArray, geometry: MountGeometry, ax1_deg: FloatArray, ax2_deg: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Errors (2, n) and their slopes (6, 2, n), axis degrees (per unit of P1..P6)."""
    errors = axis_errors_deg(values, geometry, ax1_deg, ax2_deg)
    slopes = np.zeros((6, *errors.shape))
    for index in (0, 2):
        nearby = values.copy()
        # Towards zero, so that a lean at its largest is not stepped over.
        step = -LEAN_STEP_DEG if values[index] > 0.0 else LEAN_STEP_DEG
        nearby[index] += step
        change = axis_errors_deg(nearby, geometry, ax1_deg, ax2_deg) - errors
        change[0] -= 360.0 * np.round(change[0] / 360.0)
        slopes[index] = change / step
    slopes[1, 0] = 1.0
    slopes[3, 1] = 1.0
    slopes[4, 0] = -ax1_deg
    slopes[5, 1] = -ax2_deg
    return errors, slopes


def own_sine(values: FloatArray, ax2_deg: FloatArray, error2_deg: FloatArray) -> FloatArray:
    """Sine of the mechanism's OWN axis 2 angle (n,): what turns axis 1 degrees into sky degrees.

    Near the primary axis a lean makes it quite another number than the sine of ideal AX2.
    """
    own_deg = ax2_deg + error2_deg - values[3] + values[5] * ax2_deg
    sine: FloatArray = np.sin(own_deg * RAD_PER_DEG)
    return sine
