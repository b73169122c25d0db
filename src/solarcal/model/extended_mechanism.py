"""Points against a mechanism that may have more wrong with it than the six numbers.

Collimation, axes that are not square, gravity sag, air other than assumed and backlash, each with
its exact effect at the fitted lean: near the zenith a degree of lean changes what a collimation
error does by more than the noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError
from solarcal.model.exact_errors import LEAN_STEP_DEG, mechanism_of, own_sine
from solarcal.model.known_physics import SkyContext, TruePoints, true_points
from solarcal.model.points import PointSet
from solarcal.mount.mechanism import Mechanism
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.units import FloatArray, wrap_deg

COLLIMATION, SQUARENESS, SAG, AIR = "C", "N", "SAG", "REFRACTION"
BACKLASH = ("BACKLASH1", "BACKLASH2")
_STEP = {COLLIMATION: 1e-3, SQUARENESS: 1e-3, SAG: 1e-3, AIR: 1e-2}
_LARGEST = {COLLIMATION: 20.0, SQUARENESS: 20.0, SAG: 20.0, AIR: 50.0}
_SIDES_NEEDED = 2
"""Points that came from either side, before backlash is anything but a bad point."""


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """Linearisation on sky, in units of the points' relative noise; rows alternate between axes.

    ``residuals`` (2n,) measured minus computed; ``six`` (2n, 6); ``causes`` name -> (2n,).
    """

    residuals: FloatArray
    six: FloatArray
    causes: dict[str, FloatArray]


@dataclass(frozen=True, eq=False, slots=True)
class ExtendedMechanism:
    """Points of one mount, and what any mechanism would have made of them.

    ``approach`` (n, 2): sense of the last motion of each axis, +1, -1 or 0 (unknown).
    """

    points: PointSet
    context: SkyContext
    seen: TruePoints
    approach: NDArray[np.int_]
    weights: FloatArray

    @classmethod
    def of(
        cls, points: PointSet, context: SkyContext, approach: NDArray[np.int_] | None = None
    ) -> "ExtendedMechanism":
        n = len(points)
        weights = np.ones(n)
        if points.sigma_deg is not None:
            # Only their ratios count: the noise is judged by what is left over.
            weights = np.exp(np.mean(np.log(points.sigma_deg))) / points.sigma_deg
        return cls(
            points,
            context,
            true_points(points, context),
            np.zeros((n, 2), dtype=np.int_) if approach is None else np.asarray(approach),
            weights,
        )

    @property
    def causes(self) -> tuple[str, ...]:
        """What can be tested: backlash only where an axis came from both sides."""
        both = [
            name
            for axis, name in enumerate(BACKLASH)
            if min(np.count_nonzero(self.approach[:, axis] == way) for way in (1, -1))
            >= _SIDES_NEEDED
        ]
        return (COLLIMATION, SQUARENESS, SAG, AIR, *both)

    def rows(self, values: FloatArray, amounts: Mapping[str, float]) -> Rows:
        """Linearise about six numbers (6,) and amounts of other causes.

        Raises
        ------
        ConfigurationError
            Amounts that no mechanism has, or with which it does not reach every point.
        """
        errors = self._errors(mechanism_of(values), amounts)
        left = np.stack((self.seen.err1_deg, self.seen.err2_deg)) - errors
        left[0] = wrap_deg(left[0])
        sine = own_sine(values, self.seen.ax2_deg, errors[1])
        scale = np.stack((sine, np.ones_like(sine))) * self.weights

        def flat(axes: FloatArray) -> FloatArray:
            return (axes * scale).T.reshape(-1)

        def slope(changed: FloatArray, step: float) -> FloatArray:
            change = changed - errors
            change[0] = wrap_deg(change[0])
            return flat(change / step)

        one, zero = np.ones(len(sine)), np.zeros(len(sine))
        six = [
            flat(np.stack(pair))
            for pair in (
                (zero, zero),
                (one, zero),
                (zero, zero),
                (zero, one),
                (-self.seen.ax1_deg, zero),
                (zero, -self.seen.ax2_deg),
            )
        ]
        for index in (0, 2):
            nearby = values.copy()
            step = -LEAN_STEP_DEG if values[index] > 0.0 else LEAN_STEP_DEG
            nearby[index] += step
            six[index] = slope(self._errors(mechanism_of(nearby), amounts), step)
        mechanism = mechanism_of(values)
        causes: dict[str, FloatArray] = {}
        for name in self.causes:
            step = _STEP.get(name, 1.0)
            moved = {**amounts, name: amounts.get(name, 0.0) + step}
            causes[name] = slope(self._errors(mechanism, moved), step)
        return Rows(flat(left), np.column_stack(six), causes)

    def _errors(self, mechanism: Mechanism, amounts: Mapping[str, float]) -> FloatArray:
        """E1, E2 (2, n), axis degrees, counted from where the Sun is taken to be."""

        def held(name: str) -> float:
            amount = amounts.get(name, 0.0)
            if abs(amount) > _LARGEST[name]:
                raise ConfigurationError(f"no mechanism has {name} = {amount:g}")
            return amount

        geometry, ax1, ax2 = self.points.geometry, self.seen.ax1_deg, self.seen.ax2_deg
        built = Mechanism(
            mechanism.P1,
            mechanism.P2,
            mechanism.P3,
            mechanism.P4,
            mechanism.P5,
            mechanism.P6,
            collimation_deg=held(COLLIMATION),
            nonperpendicularity_deg=held(SQUARENESS),
            sag_deg=held(SAG),
        )
        lifted1, lifted2 = ax1, ax2
        if amounts.get(AIR):
            azimuth, zenith = self.context.sun_of_axes_deg(ax1, ax2)
            air = zenith - apparent_zenith_deg(zenith, self.context.refraction, self.context.air)
            lifted1, lifted2 = self.context.true_axes_deg(azimuth, zenith - held(AIR) * air)
        errors = np.stack(built.errors_deg(geometry, lifted1, lifted2))
        errors[0] += wrap_deg(lifted1 - ax1)
        errors[1] += lifted2 - ax2
        for axis, name in enumerate(BACKLASH):
            errors[axis] += 0.5 * amounts.get(name, 0.0) * self.approach[:, axis]
        return errors
