"""Counts to axis angle and back: gears, and linear actuators (screwjacks).

A screwjack stands between two pivots, R1 and R2 from the axis, and turns the axis by its length.
The axis is the third corner of the triangle; its corner there is S + beta when the jack's length L
grows with the axis angle S (sign -), and 180 - (S + beta) when it shrinks (sign +). R3 is the
offset of the jack tube's centreline from the base pivot:

    SJP1 = beta    SJP2 = sign 2 R1 R2    SJP3 = R1^2 + R2^2 - R3^2
    L = sqrt(SJP3 + SJP2 cos(S + beta))          (10-physics, section 5)

Lengths are in any one unit, inches in the field.

A heliostat on two screwjacks has its first axis fixed to Earth and pointing East, the second
carried by it and pointing up where the first is at zero; the mirror looks South there. In the
frame of a `tiltroll-ew` mount the normal stands at AX1 = joint 1 + 90 deg (0 straight up, positive
South) and AX2 = 90 deg - joint 2 (from East), so that its errors are those of any mechanism: leans
of the first axis, zeros, scales, axes not square. Each jack closes a triangle with its pivot
radius and the distance between the pivots: L^2 = offset^2 + radius^2 - 2 offset radius
cos(corner), L = initial stroke + steps / increment.
"""

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import Value, maths_for
from solarcal.units import RAD_PER_DEG, Angles, FloatArray

DEAD_POINT_MARGIN_DEG = 0.1
"""S + beta must stay so far from 0 and 180, where the jack pushes through the axis."""


class RotaryDrive(msgspec.Struct, frozen=True, tag="rotary"):
    """counts = counts_per_deg * angle; ``counts_per_deg`` is signed."""

    counts_per_deg: float

    def __post_init__(self) -> None:
        _require_gear_ratio(self.counts_per_deg, "rotary drive", "counts/deg")

    def counts(self, angle_deg: Angles) -> Angles:
        """Counts at an axis angle, not rounded."""
        return self.counts_per_deg * angle_deg

    def angle_deg(self, counts: Angles) -> Angles:
        """Axis angle at so many counts."""
        return counts / self.counts_per_deg


class ScrewjackDrive(msgspec.Struct, frozen=True, tag="screwjack"):
    """counts = counts_per_length * L(angle); ``counts_per_length`` is signed.

    ``sign`` is that of SJP2: -1 where the axis angle grows with L, +1 where it shrinks.

    Raises
    ------
    ConfigurationError
        Lengths that no triangle has, a gear ratio of zero; from the methods: a length or angle
        at which the triangle cannot close, or at a dead point.
    """

    R1: float
    R2: float
    R3: float
    beta_deg: float
    counts_per_length: float
    sign: Literal[-1, 1] = -1

    def __post_init__(self) -> None:
        _require_gear_ratio(self.counts_per_length, "screwjack", "counts per unit of length")
        if self.sign not in (-1, 1):
            raise ConfigurationError(
                f"a screwjack's sign is -1 (angle grows with length) or +1, not {self.sign}"
            )
        if not math.isfinite(self.beta_deg):
            raise ConfigurationError(f"a screwjack cannot have beta = {self.beta_deg:g} deg")
        if not (0.0 < self.R1 < math.inf and 0.0 < self.R2 < math.inf):
            raise ConfigurationError(
                f"a screwjack's pivots must lie away from the axis: R1 = {self.R1:g}, "
                f"R2 = {self.R2:g} must be positive lengths"
            )
        if not 0.0 <= abs(self.R3) < self.R1 + self.R2:
            raise ConfigurationError(
                f"a screwjack triangle with R1 = {self.R1:g}, R2 = {self.R2:g} and the tube offset "
                f"R3 = {self.R3:g} cannot close: R3 must be less than R1 + R2"
            )

    @property
    def SJP1(self) -> float:
        """beta, degrees."""
        return self.beta_deg

    @property
    def SJP2(self) -> float:
        return self.sign * 2.0 * self.R1 * self.R2

    @property
    def SJP3(self) -> float:
        return self.R1 * self.R1 + self.R2 * self.R2 - self.R3 * self.R3

    def length(self, angle_deg: Angles) -> Angles:
        """Length L of the jack at an axis angle, along the tube's centreline."""
        m = maths_for(angle_deg)
        corner_deg = angle_deg + self.beta_deg
        too_near = (corner_deg < DEAD_POINT_MARGIN_DEG) | (
            corner_deg > 180.0 - DEAD_POINT_MARGIN_DEG
        )
        if m.any(too_near):
            raise ConfigurationError(
                f"axis angle {_first(angle_deg, too_near):.3f} deg is at or beyond a dead point of "
                f"the screwjack: with beta = {self.beta_deg:g} it must lie between "
                f"{DEAD_POINT_MARGIN_DEG - self.beta_deg:.3f} and "
                f"{180.0 - DEAD_POINT_MARGIN_DEG - self.beta_deg:.3f} deg"
            )
        square = self.SJP3 + self.SJP2 * m.cos(corner_deg * RAD_PER_DEG)
        short = square <= 0.0
        if m.any(short):
            raise ConfigurationError(
                f"the screwjack triangle R1 = {self.R1:g}, R2 = {self.R2:g}, R3 = {self.R3:g} "
                f"cannot close at axis angle {_first(angle_deg, short):.3f} deg: the pivots come "
                "closer together than the tube offset R3"
            )
        return m.sqrt(square)  # type: ignore[no-any-return]

    def angle_from_length_deg(self, length: Angles) -> Angles:
        """Axis angle at a length L of the jack."""
        return _corner_deg(self, length) - self.beta_deg  # type: ignore[no-any-return]

    def counts(self, angle_deg: Angles) -> Angles:
        """Counts at an axis angle, not rounded, from length zero."""
        return self.counts_per_length * self.length(angle_deg)

    def angle_deg(self, counts: Angles) -> Angles:
        """Axis angle at so many counts from length zero."""
        return self.angle_from_length_deg(counts / self.counts_per_length)

    def with_beta_from(self, angle_deg: float, length: float) -> "ScrewjackDrive":
        """The same screwjack with beta such that it has ``length`` L at this axis angle.

        Repeat at a second angle: a beta that differs there means that R1, R2, R3 or the sign are
        wrong.
        """
        return msgspec.structs.replace(self, beta_deg=_corner_deg(self, length) - angle_deg)


Drive: TypeAlias = RotaryDrive | ScrewjackDrive
"""How one axis is driven; msgspec tells them apart by ``type``: rotary or screwjack."""


def jack_length(pin_to_pin: float, tube_offset: float) -> float:
    """L along the tube's centreline from the length L1 between the pins: L^2 = L1^2 - R3^2."""
    if not abs(tube_offset) < pin_to_pin < math.inf:
        raise ConfigurationError(
            f"a pin-to-pin length L1 = {pin_to_pin:g} cannot be: it must be longer than the tube "
            f"offset R3 = {tube_offset:g}"
        )
    return math.sqrt(pin_to_pin * pin_to_pin - tube_offset * tube_offset)


def reading_deg(drive: Drive, reference_deg: float, register: Angles) -> Angles:
    """Absolute read-out when the count register, zero at the reference, shows ``register``."""
    return drive.angle_deg(drive.counts(reference_deg) + register)


def register(drive: Drive, reference_deg: float, reading_deg: float) -> int:
    """Whole counts on the register at a read-out: the nearest to it."""
    return round(drive.counts(reading_deg) - drive.counts(reference_deg))


def format_drive(drive: Drive) -> str:
    """A drive as the wire protocol writes it; numbers come back to the last bit."""
    if isinstance(drive, RotaryDrive):
        return f"rotary:{_number(drive.counts_per_deg)}"
    lengths = (drive.R1, drive.R2, drive.R3, drive.beta_deg, drive.counts_per_length)
    return ":".join(("screwjack", *map(_number, lengths), "-" if drive.sign < 0 else "+"))


def parse_drive(text: str) -> Drive:
    """A drive from ``rotary:counts_per_deg`` or ``screwjack:R1:R2:R3:beta:counts_per_length:sign``.

    Raises
    ------
    ConfigurationError
        Another notation, or numbers that no drive has.
    """
    kind, *fields = text.strip().split(":")
    try:
        if kind == "rotary" and len(fields) == 1:
            return RotaryDrive(float(fields[0]))
        if kind == "screwjack" and len(fields) == 6 and fields[5] in ("+", "-"):
            r1, r2, r3, beta_deg, counts_per_length = map(float, fields[:5])
            return ScrewjackDrive(
                r1, r2, r3, beta_deg, counts_per_length, -1 if fields[5] == "-" else 1
            )
    except ValueError:
        pass  # A field that is no number is answered like any other wrong notation.
    raise ConfigurationError(
        f"drive {text!r} is not rotary:COUNTS_PER_DEG or "
        "screwjack:R1:R2:R3:BETA:COUNTS_PER_LENGTH:SIGN with SIGN + or -"
    )


def _corner_deg(jack: ScrewjackDrive, length: Value) -> Value:
    """S + beta at a length L, in (0, 180) deg."""
    m = maths_for(length)
    cosine = (length * length - jack.SJP3) / jack.SJP2
    open_ = (length <= 0.0) | (abs(cosine) > 1.0)
    if m.any(open_):
        longest = math.sqrt(jack.SJP3 + abs(jack.SJP2))
        shortest = math.sqrt(max(jack.SJP3 - abs(jack.SJP2), 0.0))
        raise ConfigurationError(
            f"the screwjack triangle R1 = {jack.R1:g}, R2 = {jack.R2:g}, R3 = {jack.R3:g} cannot "
            f"close with a jack length of {_first(length, open_):g}: it must lie between "
            f"{shortest:g} and {longest:g}"
        )
    corner_deg = m.arccos(cosine) / RAD_PER_DEG
    dead = (corner_deg < DEAD_POINT_MARGIN_DEG) | (corner_deg > 180.0 - DEAD_POINT_MARGIN_DEG)
    if m.any(dead):
        raise ConfigurationError(
            f"a jack length of {_first(length, dead):g} is at a dead point of the screwjack "
            f"R1 = {jack.R1:g}, R2 = {jack.R2:g}, R3 = {jack.R3:g}: within "
            f"{DEAD_POINT_MARGIN_DEG:g} deg of a flat triangle it cannot turn the axis"
        )
    return corner_deg


def _first(value: Value, where: Value) -> float:
    """The first offending value, for a message."""
    return float(value) if isinstance(value, (float, int)) else float(value[where].flat[0])


def _number(value: float) -> str:
    return repr(float(value)).removesuffix(".0")


def _require_gear_ratio(value: float, what: str, unit: str) -> None:
    if not math.isfinite(value) or value == 0.0:
        raise ConfigurationError(f"a {what} needs a gear ratio in {unit}, not {value:g}")


@dataclass(frozen=True, slots=True)
class Jack:
    """One linear actuator.

    ``increment``: motor steps per metre. ``initial_stroke``: length at step 0, metres.
    ``offset``: from the axis to the jack's base pivot; ``pivot_radius``: from the axis to its other
    end, metres. ``initial_angle_deg``: the joint's angle at step 0. ``clockwise``: the joint's
    angle shrinks as the jack grows longer.
    """

    increment: float
    initial_stroke: float
    offset: float
    pivot_radius: float
    initial_angle_deg: float
    clockwise: bool

    def joint_deg(self, steps: FloatArray) -> FloatArray:
        """Joint angle at motor positions of any shape, degrees.

        Raises
        ------
        ConfigurationError
            Lengths that no triangle has, or a stroke at which it cannot close.
        """
        jack = ScrewjackDrive(self.offset, self.pivot_radius, 0.0, 0.0, self.increment)
        first = jack.angle_from_length_deg(self.initial_stroke)
        turned = first - jack.angle_from_length_deg(self.initial_stroke + steps / self.increment)
        return self.initial_angle_deg + (turned if self.clockwise else -turned)

    def steps_at(self, joint_deg: FloatArray) -> FloatArray:
        """Motor positions at joint angles: the inverse of ``joint_deg``, not rounded."""
        jack = ScrewjackDrive(self.offset, self.pivot_radius, 0.0, 0.0, self.increment)
        first = jack.angle_from_length_deg(self.initial_stroke)
        turned = joint_deg - self.initial_angle_deg
        corner = first - (turned if self.clockwise else -turned)
        return (jack.length(corner) - self.initial_stroke) * self.increment


@dataclass(frozen=True, slots=True)
class JackHeliostat:
    """Two jacks and where the mirror sits on them.

    ``position_enu``: of the first joint's origin, metres. ``first_joint``, ``second_joint``,
    ``concentrator``: translations (east, north, up) in front of each joint and behind the second,
    metres, in the frame that turns with the joints before.
    """

    jacks: tuple[Jack, Jack]
    position_enu: tuple[float, float, float]
    first_joint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    second_joint: tuple[float, float, float] = (0.0, 0.0, 0.0)
    concentrator: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def readings_deg(self, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(AX1, AX2) of the normal in the frame of a `tiltroll-ew` mount, steps (n, 2)."""
        joint1 = self.jacks[0].joint_deg(steps[:, 0])
        joint2 = self.jacks[1].joint_deg(steps[:, 1])
        return joint1 + 90.0, 90.0 - joint2

    def steps_at(self, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
        """Motor positions (n, 2) at these readings."""
        return np.stack(
            (self.jacks[0].steps_at(ax1_deg - 90.0), self.jacks[1].steps_at(90.0 - ax2_deg)),
            axis=-1,
        )

    def centre_enu(self, ax1_deg: FloatArray, ax2_deg: FloatArray) -> FloatArray:
        """Centre of the mirror (n, 3), metres, with the axes at these readings."""
        joint1, joint2 = (ax1_deg - 90.0) * RAD_PER_DEG, (90.0 - ax2_deg) * RAD_PER_DEG
        east, north, up = self.concentrator
        # Turned about up by joint 2, shifted, turned about East by joint 1.
        x = east * np.cos(joint2) - north * np.sin(joint2) + self.second_joint[0]
        y = east * np.sin(joint2) + north * np.cos(joint2) + self.second_joint[1]
        z = up + self.second_joint[2]
        turned = np.stack(
            (x, y * np.cos(joint1) - z * np.sin(joint1), y * np.sin(joint1) + z * np.cos(joint1)),
            axis=-1,
        )
        return np.asarray(turned + np.add(self.position_enu, self.first_joint))
