"""Setting up a screwjack: SJP#1-3 from what can be measured with tape and inclinometer.

R1, R2 and R3 are measured; beta (SJP#1) follows from the jack's length at one axis angle. At two or
more angles it is a least-squares fit, and how well the lengths then agree says whether R1, R2, R3
and the sense are right: every observation has a beta of its own, and they must be one.

    SJP1 = beta    SJP2 = -+2 R1 R2    SJP3 = R1^2 + R2^2 - R3^2        (10-physics, section 5)
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import DEAD_POINT_MARGIN_DEG, ScrewjackDrive, jack_length, reading_deg
from solarcal.units import RAD_PER_DEG, FloatArray, rms

CONSISTENT_DEG = 0.5
"""Betas of one screwjack that lie further apart are not of these lengths, whatever the tape."""

_STEP_DEG = 1e-10
_INSIDE_DEG = 1e-6


class Measured(NamedTuple):
    """Axis angle, and the length L of the jack there along the tube's centreline."""

    angle_deg: float
    length: float


@dataclass(frozen=True, slots=True)
class Explanation:
    """A change of one length alone that brings the observations together."""

    name: str
    change: float
    rms: float


@dataclass(frozen=True, slots=True)
class ScrewjackSetup:
    """A screwjack with beta fitted, and how the observations agree.

    ``betas_deg`` (n,): from each observation alone. ``length_residuals`` (n,): measured minus
    fitted length; ``angle_residuals_deg`` (n,): what that is in axis angle. ``beta_sigma_deg``:
    one sigma, ``None`` from one observation. ``explanations``: best first; from three observations
    on, and only where beta alone is not consistent.
    """

    drive: ScrewjackDrive
    betas_deg: tuple[float, ...]
    length_residuals: tuple[float, ...]
    angle_residuals_deg: tuple[float, ...]
    beta_sigma_deg: float | None
    explanations: tuple[Explanation, ...]

    @property
    def spread_deg(self) -> float:
        """Largest minus smallest beta."""
        return max(self.betas_deg) - min(self.betas_deg)

    @property
    def consistent(self) -> bool | None:
        """``None`` from one observation, which agrees with itself."""
        return None if len(self.betas_deg) < 2 else self.spread_deg <= CONSISTENT_DEG


def measured(angle_deg: float, length: float, R3: float, *, pin_to_pin: bool) -> Measured:
    """An observation; a length between the pins is brought onto the tube's centreline.

    Raises
    ------
    ConfigurationError
        A length no jack has.
    """
    if not 0.0 < length < math.inf:
        raise ConfigurationError(f"a jack length must be greater than zero, not {length:g}")
    return Measured(angle_deg, jack_length(length, R3) if pin_to_pin else length)


def fit_beta(jack: ScrewjackDrive, observations: Sequence[Measured]) -> ScrewjackSetup:
    """beta of a screwjack by least squares of the lengths; the ``beta_deg`` it comes with is lost.

    Lengths, not angles: near a dead point an angle from a length says next to nothing.

    Raises
    ------
    ConfigurationError
        No observation, or several at one angle only; lengths with which the triangle cannot close;
        a dead point.
    """
    if not observations:
        raise ConfigurationError(
            "beta needs the jack's length at one axis angle at least; measure it at two"
        )
    if len(observations) > 1 and len({one.angle_deg for one in observations}) == 1:
        raise ConfigurationError(
            f"all lengths were measured at {observations[0].angle_deg:g} deg, where they cannot "
            "contradict each other; measure one at another angle"
        )
    betas = tuple(jack.with_beta_from(*one).beta_deg for one in observations)
    try:
        fitted, residuals = _fitted(jack, observations, float(np.mean(betas)))
    except ConfigurationError:
        raise ConfigurationError(_contradiction(jack, observations, betas)) from None
    slopes = np.array([_slope(fitted, one.angle_deg) for one in observations])
    n = len(observations)
    sigma = None
    if n > 1:
        scatter = math.sqrt(float(residuals @ residuals) / (n - 1))
        sigma = scatter / math.sqrt(float(slopes @ slopes))
    setup = ScrewjackSetup(
        fitted, betas, tuple(residuals.tolist()), tuple((residuals / slopes).tolist()), sigma, ()
    )
    if n < 3 or setup.consistent:
        return setup
    return replace(setup, explanations=_explanations(fitted, observations))


def dead_points_deg(jack: ScrewjackDrive) -> tuple[float, float]:
    """Axis angles at which the triangle lies flat: the jack works between them."""
    return -jack.beta_deg, 180.0 - jack.beta_deg


def reach_deg(jack: ScrewjackDrive) -> tuple[float, float]:
    """Lowest and highest axis angle at which the jack can turn the axis."""
    low, high = dead_points_deg(jack)
    margin = DEAD_POINT_MARGIN_DEG + _INSIDE_DEG
    low, high = low + margin, high - margin
    # Where the pivots come closer than the tube offset there is no length.
    cosine = -jack.SJP3 / jack.SJP2
    if abs(cosine) < 1.0:
        closes_deg = math.acos(cosine) / RAD_PER_DEG - jack.beta_deg
        if jack.sign < 0:
            low = max(low, closes_deg + _INSIDE_DEG)
        else:
            high = min(high, closes_deg - _INSIDE_DEG)
    return low, high


@dataclass(frozen=True, slots=True)
class WrongLength:
    """Axis angles a controller with wrong lengths produces; columns (n,), degrees.

    ``error_deg``: read-out minus where the axis stands, zero at the reference. ``left_deg``: what
    an offset and a scale (P2 with P5, P4 with P6) cannot take out of it. ``offset_deg``,
    ``scale``: that best straight line.
    """

    angle_deg: FloatArray
    error_deg: FloatArray
    left_deg: FloatArray
    offset_deg: float
    scale: float


def wrong_length(
    true: ScrewjackDrive, told: ScrewjackDrive, reference_deg: float, angle_deg: FloatArray
) -> WrongLength:
    """Read-outs with the lengths ``told`` while ``true`` ones move it, counting from the reference.

    Raises
    ------
    ConfigurationError
        An angle that one of the two cannot reach.
    """
    counts = true.counts(angle_deg) - true.counts(reference_deg)
    error = reading_deg(told, reference_deg, counts) - angle_deg
    line = np.stack((np.ones(len(angle_deg)), angle_deg), axis=1)
    (offset, scale), *_ = np.linalg.lstsq(line, error, rcond=None)
    left = error - line @ np.array([offset, scale])
    return WrongLength(angle_deg, error, left, float(offset), float(scale))


def _fitted(
    jack: ScrewjackDrive, observations: Sequence[Measured], start_deg: float
) -> tuple[ScrewjackDrive, FloatArray]:
    """beta by Gauss and Newton, and the lengths' residuals (n,)."""
    angles = np.array([one.angle_deg for one in observations])
    lengths = np.array([one.length for one in observations])
    beta = start_deg
    for _ in range(50):
        fitted = msgspec.structs.replace(jack, beta_deg=beta)
        residuals = lengths - fitted.length(angles)
        slopes = np.array([_slope(fitted, angle) for angle in angles.tolist()])
        step = float(slopes @ residuals) / float(slopes @ slopes)
        beta += step
        if abs(step) < _STEP_DEG:
            break
    fitted = msgspec.structs.replace(jack, beta_deg=beta)
    return fitted, np.asarray(lengths - fitted.length(angles))


def _slope(jack: ScrewjackDrive, angle_deg: float) -> float:
    """dL/dS, length per degree; the same by beta."""
    corner = (angle_deg + jack.beta_deg) * RAD_PER_DEG
    return -0.5 * jack.SJP2 * math.sin(corner) / jack.length(angle_deg) * RAD_PER_DEG


def _explanations(
    jack: ScrewjackDrive, observations: Sequence[Measured]
) -> tuple[Explanation, ...]:
    """R1, R2 or the sense changed alone, beta fitted anew each time."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415

    found = []
    for name in ("R1", "R2"):
        measured_length = getattr(jack, name)

        def left(change: float, name: str = name, base: float = measured_length) -> float:
            try:
                changed = msgspec.structs.replace(jack, **{name: base + change})
                own = [changed.with_beta_from(*one).beta_deg for one in observations]
                _, residuals = _fitted(changed, observations, float(np.mean(own)))
            except ConfigurationError:
                return 1e3 * base
            return rms(residuals)

        best = minimize_scalar(
            left, bounds=(-0.2 * measured_length, 0.2 * measured_length), method="bounded",
            options={"xatol": 1e-7 * measured_length},
        )  # fmt: skip
        found.append(Explanation(name, float(best.x), float(best.fun)))
    turned = _turned_betas_deg(jack, observations)
    if turned is not None:
        other = msgspec.structs.replace(jack, sign=-jack.sign)
        try:
            _, residuals = _fitted(other, observations, float(np.mean(turned)))
        except ConfigurationError:
            pass  # No beta serves all of them in the other sense either: it explains nothing.
        else:
            found.append(Explanation("sense", 0.0, rms(residuals)))
    return tuple(sorted(found, key=lambda one: one.rms))


def _turned_betas_deg(
    jack: ScrewjackDrive, observations: Sequence[Measured]
) -> tuple[float, ...] | None:
    """The betas were the sense the other one; ``None`` where a triangle does not close."""
    turned = msgspec.structs.replace(jack, sign=-jack.sign)
    try:
        return tuple(turned.with_beta_from(*one).beta_deg for one in observations)
    except ConfigurationError:
        return None


def _contradiction(
    jack: ScrewjackDrive, observations: Sequence[Measured], betas_deg: tuple[float, ...]
) -> str:
    """What to say of observations that no single beta serves."""
    alone = ", ".join(f"{beta:z.1f}" for beta in betas_deg)
    said = (
        f"no single beta serves all observations (each alone gives {alone} deg): R1, R2, R3 or the "
        "sense is wrong"
    )
    turned = _turned_betas_deg(jack, observations)
    if turned is not None and max(turned) - min(turned) <= CONSISTENT_DEG:
        said += "; with the other sense they agree"
    return said
