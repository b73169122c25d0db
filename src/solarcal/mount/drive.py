"""Counts to axis angle and back: gears, and linear actuators (screwjacks).

A screwjack stands between two pivots, R1 and R2 from the axis, and turns the axis by its length.
The axis is the third corner of the triangle; its corner there is S + beta when the jack's length L
grows with the axis angle S (sign -), and 180 - (S + beta) when it shrinks (sign +). R3 is the
offset of the jack tube's centreline from the base pivot:

    SJP1 = beta    SJP2 = sign 2 R1 R2    SJP3 = R1^2 + R2^2 - R3^2
    L = sqrt(SJP3 + SJP2 cos(S + beta))          (10-physics, section 5)

Lengths are in any one unit, inches in the field.
"""

import math
from typing import Literal, TypeAlias

import msgspec

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import Value, maths_for
from solarcal.units import RAD_PER_DEG, Angles

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
