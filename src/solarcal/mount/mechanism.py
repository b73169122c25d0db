"""The exact kinematics of a mechanism that is not what the drawing says.

A mechanism leans (P1, P3), its encoders are off by constants (P2, P4) and scales (P5, P6), its
second axis is not quite perpendicular to the first (N), the collector does not look quite along
its arm (C), and its weight bends it (sag); the air bends the ray otherwise than assumed, and an
axis reads otherwise after a motion in the other sense (backlash). Its first-order form is
``formula.correction_deg``.

References
----------
Luque-Heredia et al. (2007), in Concentrator Photovoltaics, ch. 11: a tracker's error model with
lean, zeros, squareness and collimation as rotations. Rodrigues (1840), J. Math. Pures Appl. 5,
380: a rotation about an axis. To first order C and N are the TPOINT terms CA and NPAE (Wallace).
"""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import ARRAYS, Maths, MountGeometry, Value, Vector, maths_for
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

_LARGEST_ANGLE_DEG = 45.0
_LARGEST_SCALE = 0.5
_LARGEST = {
    "P1": _LARGEST_ANGLE_DEG,
    "P2": 360.0,
    "P3": _LARGEST_ANGLE_DEG,
    "P4": 360.0,
    "P5": _LARGEST_SCALE,
    "P6": _LARGEST_SCALE,
    "collimation_deg": _LARGEST_ANGLE_DEG,
    "nonperpendicularity_deg": _LARGEST_ANGLE_DEG,
    "sag_deg": _LARGEST_ANGLE_DEG,
    "air": 100.0,
    "backlash1_deg": 360.0,
    "backlash2_deg": 360.0,
}
_LEAN = ("P1", "P3")
_STEPS = {
    **dict.fromkeys(_LEAN, 1e-4),
    "collimation_deg": 1e-3,
    "nonperpendicularity_deg": 1e-3,
    "sag_deg": 1e-3,
    "air": 1e-2,
}
"""Of the differences that slopes are made of; whatever is not named here acts linearly."""
# A search may wander: it is held to what can be computed.
_LEAN_HELD_DEG = 40.0
_ZERO_HELD_DEG = 359.0
_SCALE_HELD = 0.49
_CONVERGED_DEG = 1e-11
_CONVERGED_RAD = 1e-15
_MAX_ITERATIONS = 60
# Closer to its own primary axis than this (6e-10 deg) axis 1 is rounding noise.
_AXIS_RAD = 1e-11


class Circumstances(NamedTuple):
    """What air and backlash do depends on more than the direction.

    ``approach`` (2, ..., n): sense of each axis' last motion, +1, -1 or 0 (unknown). ``lifted``:
    (AX1, AX2) that belong to the same Sun seen through so much more of the assumed air.
    """

    approach: NDArray[np.int_]
    lifted: Callable[[Value], tuple[Value, Value]]


class Linearised(NamedTuple):
    """A mechanism at some directions, and what a little more of some of its numbers would do.

    ``errors`` (2, ..., n) axis degrees; ``slopes`` (k, 2, ..., n) axis degrees per unit; ``sky``
    (2, ..., n) what turns axis degrees into degrees on sky: the sine of the mechanism's own
    axis 2, and one.
    """

    errors: FloatArray
    slopes: FloatArray
    sky: FloatArray

    @property
    def sky_slopes(self) -> FloatArray:
        """(k, 2, ..., n) degrees on sky per unit."""
        on_sky: FloatArray = self.slopes * self.sky
        return on_sky


class Mechanism(msgspec.Struct, frozen=True):
    """What is wrong with a mount. P1..P4 and angles in degrees, P5 and P6 in degrees per degree.

    ``sag_deg`` is how far gravity pulls down a collector that looks at the horizon; at the zenith
    angle z it is sag * sin(z), in the vertical plane. ``air``: refraction there is beyond the
    assumed, as a part of it. ``backlash1_deg``, ``backlash2_deg``: how much more an axis reads
    after a motion in the positive sense than after one in the negative.

    Each is a float, or an array (s, 1) for s mechanisms side by side: directions are then (s, n).

    Raises
    ------
    ConfigurationError
        A value that is not finite or beyond 45 deg (P1, P3, C, N, sag) or 0.5 (P5, P6).
    """

    P1: Value = 0.0
    P2: Value = 0.0
    P3: Value = 0.0
    P4: Value = 0.0
    P5: Value = 0.0
    P6: Value = 0.0
    collimation_deg: Value = 0.0
    nonperpendicularity_deg: Value = 0.0
    sag_deg: Value = 0.0
    air: Value = 0.0
    backlash1_deg: Value = 0.0
    backlash2_deg: Value = 0.0

    def __post_init__(self) -> None:
        for name, largest in _LARGEST.items():
            value = getattr(self, name)
            within = abs(value) <= largest
            if not (within if isinstance(within, bool) else np.all(within)):
                values = np.ravel(value)
                worst = float(values[np.abs(values).argmax()])
                raise ConfigurationError(
                    f"a mechanism with {name} = {worst:g} cannot be: not within +-{largest:g}"
                )

    @classmethod
    def of(cls, values: FloatArray, **others: float) -> "Mechanism":
        """P1..P6 from an array (..., 6), held to what can be computed; others by name.

        One mechanism for (6,); s of them side by side for (s, 6).
        """
        if values.ndim == 1:
            P1, P2, P3, P4, P5, P6 = values.tolist()
            shrink = min(1.0, _LEAN_HELD_DEG / max(math.hypot(P1, P3), 1e-12))
        else:
            P1, P2, P3, P4, P5, P6 = np.moveaxis(values, -1, 0)[..., np.newaxis]
            shrink = np.minimum(1.0, _LEAN_HELD_DEG / np.maximum(np.hypot(P1, P3), 1e-12))
        return cls(
            P1 * shrink,
            _held(P2, _ZERO_HELD_DEG),
            P3 * shrink,
            _held(P4, _ZERO_HELD_DEG),
            _held(P5, _SCALE_HELD),
            _held(P6, _SCALE_HELD),
            **others,
        )

    def errors_deg(
        self, geometry: MountGeometry, ax1_deg: Angles, ax2_deg: Angles
    ) -> tuple[Angles, Angles]:
        """Axis errors (reading - ideal) with which the collector looks at an ideal direction.

        E1 lies in (-180, 180] plus offset and scale; scales act on the ideal branch angle. There
        is neither other air nor backlash in them.

        Raises
        ------
        ConfigurationError
            A direction on the leaning primary axis, or so near that C and N put it out of reach.
        """
        m = maths_for(ax1_deg, ax2_deg)
        on_branch = m.wrap_deg(ax1_deg, geometry.ax1_centre_deg)
        return self._assumed_air_deg(m, geometry, on_branch, ax2_deg)

    def _errors_seen_deg(
        self,
        geometry: MountGeometry,
        ax1_deg: FloatArray,
        ax2_deg: FloatArray,
        seen: Circumstances | None,
    ) -> FloatArray:
        """The same (2, ..., n) at directions on the branch, with other air and backlash."""
        lifted1, lifted2 = ax1_deg, ax2_deg
        if seen is not None and _any(self.air):
            lifted1, lifted2 = seen.lifted(self.air)
            # Where nothing is lifted the way there and back would only round.
            lifted1 = np.where(self.air == 0.0, ax1_deg, lifted1)
            lifted2 = np.where(self.air == 0.0, ax2_deg, lifted2)
        errors = np.stack(self._assumed_air_deg(ARRAYS, geometry, lifted1, lifted2))
        if seen is not None:
            errors[0] += _short_way(ARRAYS, lifted1 - ax1_deg)
            errors[0] += 0.5 * self.backlash1_deg * seen.approach[0]
            errors[1] += lifted2 - ax2_deg
            errors[1] += 0.5 * self.backlash2_deg * seen.approach[1]
        return errors

    @classmethod
    def linearised(
        cls,
        values: FloatArray,
        geometry: MountGeometry,
        ax1_deg: FloatArray,
        ax2_deg: FloatArray,
        names: Sequence[str] = COEFFICIENT_NAMES,
        seen: Circumstances | None = None,
        **others: float,
    ) -> Linearised:
        """Errors, their slopes with respect to these of a mechanism's numbers, and axis to sky.

        Parameters
        ----------
        values, others : the mechanism, as in ``of``.
        ax1_deg, ax2_deg : (..., n), on the branch; (s, n) for s mechanisms side by side, which may
            be of different mounts as long as nothing sags.
        names : k attributes of a mechanism.
        seen : without it there is neither other air nor backlash.

        Raises
        ------
        ConfigurationError
            As ``errors_deg``.
        """
        mechanism = cls.of(values, **others)
        bent = [name for name in names if name in _STEPS]
        steps = [mechanism._step(name) for name in bent]
        # One call for the mechanism and its neighbours: of few points the calls are what costs.
        bending = mechanism._neighbours(bent, steps) if bent else mechanism
        there = bending._errors_seen_deg(geometry, ax1_deg, ax2_deg, seen)
        errors, *nearby = np.moveaxis(there, 1, 0) if bent else there[np.newaxis]
        slopes = np.zeros((len(names), *errors.shape))
        for slope, name in zip(slopes, names, strict=True):
            if name in ("P2", "backlash1_deg"):
                slope[0] = 1.0 if name == "P2" or seen is None else 0.5 * seen.approach[0]
            elif name in ("P4", "backlash2_deg"):
                slope[1] = 1.0 if name == "P4" or seen is None else 0.5 * seen.approach[1]
            elif name == "P5":
                slope[0] = -ax1_deg
            elif name == "P6":
                slope[1] = -ax2_deg
            else:
                change = nearby[bent.index(name)] - errors
                change[0] = _short_way(ARRAYS, change[0])
                np.divide(change, steps[bent.index(name)], out=slope)
        sky = np.ones_like(errors)
        sky[0] = mechanism.sin_ax2(ax2_deg, errors[1])
        return Linearised(errors, slopes, sky)

    def _step(self, name: str) -> Value:
        """By how much a number is changed; a lean towards zero: its largest is not stepped over."""
        step = _STEPS[name]
        return np.where(getattr(self, name) > 0.0, -step, step) if name in _LEAN else step

    def _neighbours(self, names: Sequence[str], steps: Sequence[Value]) -> "Mechanism":
        """This one and, for each name, one a step away: (1 + k, 1) or (1 + k, s, 1)."""
        values = np.broadcast_arrays(*(np.atleast_1d(getattr(self, name)) for name in names))
        moved: dict[str, Value] = {}
        for place, (name, value, step) in enumerate(zip(names, values, steps, strict=True), 1):
            moved[name] = np.repeat(value[np.newaxis], 1 + len(names), axis=0)
            moved[name][place] += step
        return msgspec.structs.replace(self, **moved)

    def sin_ax2(self, ax2_deg: FloatArray, error2_deg: FloatArray) -> FloatArray:
        """Sine of the mechanism's OWN axis 2 (..., n): what turns axis 1 degrees into sky degrees.

        Near the primary axis a lean makes it quite another number than the sine of ideal AX2.
        """
        own_deg = ax2_deg + error2_deg - self.P4 + self.P6 * ax2_deg
        sine: FloatArray = np.sin(own_deg * RAD_PER_DEG)
        return sine

    def _assumed_air_deg(
        self, m: Maths, geometry: MountGeometry, ax1_deg: Value, ax2_deg: Value
    ) -> tuple[Value, Value]:
        ax1, ax2 = ax1_deg * RAD_PER_DEG, ax2_deg * RAD_PER_DEG
        sin2 = m.sin(ax2)
        aim = self._raised(m, (sin2 * m.cos(ax1), sin2 * m.sin(ax1), m.cos(ax2)), geometry)
        x, y, z = self._own_axes(m)
        axis1, axis2 = self._axes_aiming_along(m, (_dot(x, aim), _dot(y, aim), _dot(z, aim)))
        e1 = _short_way(m, axis1 / RAD_PER_DEG - ax1_deg) + self.P2 - self.P5 * ax1_deg
        e2 = axis2 / RAD_PER_DEG - ax2_deg + self.P4 - self.P6 * ax2_deg
        return e1, e2

    def readings_deg(
        self, geometry: MountGeometry, ax1_deg: Angles, ax2_deg: Angles
    ) -> tuple[Angles, Angles]:
        """Axis read-outs at which the collector looks at an ideal direction; see ``errors_deg``."""
        e1, e2 = self.errors_deg(geometry, ax1_deg, ax2_deg)
        return geometry.branch(ax1_deg) + e1, ax2_deg + e2

    def pointing_deg(
        self, geometry: MountGeometry, reading1_deg: Angles, reading2_deg: Angles
    ) -> tuple[Angles, Angles]:
        """(AX1 on the branch, AX2) of the direction the collector looks at with these read-outs.

        The inverse of ``readings_deg`` to 1e-9 deg. Read-outs give the angles of the mechanism
        but for the scales, which act on the ideal angles looked for: a fixed point, reached in a
        few steps because scales are small.

        Raises
        ------
        ConfigurationError
            The iteration does not settle (a large scale error very near the primary axis).
        """
        m = maths_for(reading1_deg, reading2_deg)
        rows, up = self._own_axes(m), geometry.up_components()
        want1, want2 = reading1_deg - self.P2, reading2_deg - self.P4
        per_deg1, per_deg2 = 1.0 - self.P5, 1.0 - self.P6
        axis1, axis2 = want1, want2
        for _ in range(_MAX_ITERATIONS):
            ax1, ax2 = self._looked_at(m, rows, up, axis1, axis2)
            miss1 = want1 - (axis1 - self.P5 * ax1)
            miss2 = want2 - (axis2 - self.P6 * ax2)
            if not m.any((abs(miss1) > _CONVERGED_DEG) | (abs(miss2) > _CONVERGED_DEG)):
                return m.wrap_deg(ax1, geometry.ax1_centre_deg), ax2
            axis1 = axis1 + miss1 / per_deg1
            axis2 = axis2 + miss2 / per_deg2
        raise ConfigurationError(
            f"no direction found for the axis read-outs after {_MAX_ITERATIONS} steps: scale "
            f"errors P5 = {self.P5:g}, P6 = {self.P6:g} are too large so near the primary axis "
            "(shift the read-outs away from AX2 = 0 or 180, or correct the gear ratio)"
        )

    def _own_axes(self, m: Maths) -> tuple[Vector, Vector, Vector]:
        """The mechanism's own x, y, z in native components: rotated by omega = (-P3, -P1, 0)."""
        x, y = -self.P3 * RAD_PER_DEG, -self.P1 * RAD_PER_DEG
        angle = m.hypot(x, y)
        if isinstance(angle, float) and angle == 0.0:
            return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
        # Rodrigues' formula for an axis (x, y, 0) in the plane; without a lean any axis will do.
        straight = m.where(angle == 0.0, 1.0, angle)
        x, y = x / straight, y / straight
        cos, sin = m.cos(angle), m.sin(angle)
        rest = 1.0 - cos
        return (
            (cos + rest * x * x, rest * x * y, -sin * y),
            (rest * x * y, cos + rest * y * y, sin * x),
            (sin * y, -sin * x, cos),
        )

    def _axes_aiming_along(self, m: Maths, direction: Vector) -> tuple[Value, Value]:
        """A1, A2 (rad) that solve Rz(A1) Rx(N) Ry(A2) Rx(C) z = direction, A2 in [0, 180] deg.

        The third component gives A2, the other two A1. sin A2 comes from the components across
        the axis, because 1 - cos^2 would lose half the digits near it.
        """
        x, y, z = direction
        if self._plain():
            square = x * x + y * y
            if m.any(square < _AXIS_RAD * _AXIS_RAD):
                self._refuse_axis()
            return m.arctan2(y, x), m.arctan2(m.sqrt(square), z)
        sin_c, _, sin_n, _ = self._sines(m)
        square = x * x + y * y - sin_c * sin_c - sin_n * sin_n - 2.0 * z * sin_c * sin_n
        if m.any(square < _AXIS_RAD * _AXIS_RAD):
            self._refuse_axis()
        axis2 = m.arctan2(m.sqrt(square), z + sin_c * sin_n)
        across, along = self._arm(m, axis2)
        return m.arctan2(y, x) - m.arctan2(across, along), axis2

    def _plain(self) -> bool:
        """Neither collimation nor non-perpendicularity: half of the trigonometry is zeros."""
        return not (_any(self.collimation_deg) or _any(self.nonperpendicularity_deg))

    def _refuse_axis(self) -> None:
        raise ConfigurationError(
            "a direction on the leaning primary axis, or so near that collimation "
            f"{float(np.max(self.collimation_deg)):g} and non-perpendicularity "
            f"{float(np.max(self.nonperpendicularity_deg)):g} deg put it out of reach: axis 1 is "
            "undetermined"
        )

    def _arm(self, m: Maths, axis2: Value) -> tuple[Value, Value]:
        """y and x component of Rx(N) Ry(A2) Rx(C) z: how far axis 1 misses the collector."""
        sin_c, cos_c, sin_n, cos_n = self._sines(m)
        return -sin_c * cos_n - m.cos(axis2) * cos_c * sin_n, m.sin(axis2) * cos_c

    def _sines(self, m: Maths) -> tuple[Value, Value, Value, Value]:
        c = self.collimation_deg * RAD_PER_DEG
        n = self.nonperpendicularity_deg * RAD_PER_DEG
        return m.sin(c), m.cos(c), m.sin(n), m.cos(n)

    def _looked_at(
        self,
        m: Maths,
        rows: tuple[Vector, Vector, Vector],
        up: Vector,
        axis1_deg: Value,
        axis2_deg: Value,
    ) -> tuple[Value, Value]:
        """Ideal angles of the collector's direction at axis angles free of offset and scale.

        AX1 comes within 180 deg of the axis, not on the branch: a gear does not jump there.
        """
        axis1, axis2 = axis1_deg * RAD_PER_DEG, axis2_deg * RAD_PER_DEG
        sin_c, cos_c, sin_n, cos_n = self._sines(m)
        across, along = self._arm(m, axis2)
        sin1, cos1 = m.sin(axis1), m.cos(axis1)
        x = cos1 * along - sin1 * across
        y = sin1 * along + cos1 * across
        z = m.cos(axis2) * cos_c * cos_n - sin_c * sin_n
        own_x, own_y, own_z = rows
        aim = (
            x * own_x[0] + y * own_y[0] + z * own_z[0],
            x * own_x[1] + y * own_y[1] + z * own_z[1],
            x * own_x[2] + y * own_y[2] + z * own_z[2],
        )
        x, y, z = self._lowered(m, aim, up)
        polar = m.hypot(x, y)
        # On Earth's primary axis every AX1 is the same direction: keep where axis 1 stands.
        longitude = m.where(polar < 1e-14, axis1, m.arctan2(y, x)) / RAD_PER_DEG
        return axis1_deg - m.wrap_deg(axis1_deg - longitude), m.arctan2(polar, z) / RAD_PER_DEG

    def _raised(self, m: Maths, look: Vector, geometry: MountGeometry) -> Vector:
        """Where a stiff arm must aim for a bending one to look at ``look``: sag*sin(z) higher."""
        if not _any(self.sag_deg):
            return look
        up = geometry.up_components()
        cos_z = _dot(look, up)
        rise = _across(up, look, cos_z)
        sin_z = m.sqrt(_dot(rise, rise))
        return _turned(m, look, rise, sin_z, self.sag_deg * RAD_PER_DEG * sin_z)

    def _lowered(self, m: Maths, aim: Vector, up: Vector) -> Vector:
        """Where a bending arm looks when a stiff one aims at ``aim``: the inverse of ``_raised``.

        The zenith angle looked at solves z - sag*sin(z) = z_aim (Kepler's equation, by Newton).
        """
        if not _any(self.sag_deg):
            return aim
        sag = self.sag_deg * RAD_PER_DEG
        cos_aim = _dot(aim, up)
        rise = _across(up, aim, cos_aim)
        sin_aim = m.sqrt(_dot(rise, rise))
        z_aim = m.arctan2(sin_aim, cos_aim)
        z = z_aim + sag * m.sin(z_aim)
        for _ in range(_MAX_ITERATIONS):
            step = (z - sag * m.sin(z) - z_aim) / (1.0 - sag * m.cos(z))
            z = z - step
            if not m.any(abs(step) > _CONVERGED_RAD):
                break
        return _turned(m, aim, rise, sin_aim, z_aim - z)


def _any(value: Value) -> bool:
    return value != 0.0 if isinstance(value, (float, int)) else bool(np.any(value))


def _short_way(m: Maths, turn_deg: Value) -> Value:
    """An angle without its whole turns, in (-180, 180]."""
    return turn_deg - 360.0 * m.ceil(turn_deg / 360.0 - 0.5)


def _dot(a: Vector, b: Vector) -> Value:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _held(value: Value, largest: float) -> Value:
    if isinstance(value, float):
        return min(max(value, -largest), largest)
    return np.clip(value, -largest, largest)


def _across(up: Vector, direction: Vector, cosine: Value) -> Vector:
    """The part of ``up`` square to a direction: points up the sky, sin(z) long."""
    return (
        up[0] - cosine * direction[0],
        up[1] - cosine * direction[1],
        up[2] - cosine * direction[2],
    )


def _turned(m: Maths, direction: Vector, rise: Vector, sin_z: Value, angle_rad: Value) -> Vector:
    """A direction turned up the sky by an angle (down when negative); at the zenith that is 0."""
    cos, sin = m.cos(angle_rad), m.sin(angle_rad) / m.where(sin_z < 1e-14, 1.0, sin_z)
    return (
        cos * direction[0] + sin * rise[0],
        cos * direction[1] + sin * rise[1],
        cos * direction[2] + sin * rise[2],
    )
