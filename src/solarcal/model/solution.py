"""What a fit found, and everything a table or a forecast asks of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, Literal

import numpy as np

from solarcal.errors import FitError
from solarcal.model.least_squares import LeastSquares
from solarcal.model.parameter_checks import inseparable_sentences, unrealistic_message
from solarcal.model.points import Points
from solarcal.model.terms import (
    CONTROLLER_TERMS,
    LEAN_PRIOR_DEG,
    SCALE_PRIOR,
    ZERO_PRIOR_DEG,
    NativeAngles,
    Term,
    design_matrix,
    labels,
)
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import Limits, MountGeometry
from solarcal.units import RAD_PER_DEG, FloatArray, rms


# No slots: cached properties live in the instance's dictionary. What a fit is asked for every
# time (values, covariance, residuals) is computed at once, the rest when somebody looks.
@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """A fitted pointing model.

    Attributes
    ----------
    method : ``linear``: plain sky-weighted linear least squares.
    model_terms : the k fitted terms; ``terms`` are their names.
    values : (k,), fitted values, each in its term's unit.
    covariance : (k, k), None where nothing says how large the noise is.
    sigma_source : ``given``: from the points' own sigmas. ``residuals``: no sigmas were given, the
        covariance is scaled by the residuals. ``none``: no sigmas given and no residuals to judge
        by. ``posterior``: the unknown noise was weighed along with the parameters.
    rank : number of combinations of terms the points fix.
    condition_number : of the column-normalised design; infinite when rank-deficient.
    residual1_deg, residual2_deg : (n,), measured minus predicted, axis degrees.
    points : what was fitted.
    limits : within which the correction has to be realistic, or None.
    """

    method: str
    model_terms: tuple[Term, ...]
    values: FloatArray
    covariance: FloatArray | None
    sigma_source: Literal["given", "residuals", "none", "posterior"]
    residual1_deg: FloatArray
    residual2_deg: FloatArray
    points: Points
    limits: Limits | None
    least_squares: LeastSquares

    @property
    def terms(self) -> tuple[str, ...]:
        return tuple(term.name for term in self.model_terms)

    @property
    def units(self) -> tuple[str, ...]:
        return tuple(term.unit for term in self.model_terms)

    @property
    def geometry(self) -> MountGeometry:
        return self.points.geometry

    @property
    def labels(self) -> tuple[int, ...]:
        return self.points.labels

    @property
    def n_points(self) -> int:
        return len(self.points)

    @property
    def rank(self) -> int:
        return self.least_squares.rank

    @property
    def condition_number(self) -> float:
        return self.least_squares.condition_number

    @property
    def degrees_of_freedom(self) -> int:
        """Data (two a point) beyond the combinations fitted."""
        return 2 * self.n_points - self.rank

    @cached_property
    def sigmas(self) -> FloatArray | None:
        """One sigma of each value, (k,), in its unit; None where there is no covariance."""
        return None if self.covariance is None else np.sqrt(np.diag(self.covariance))

    @cached_property
    def correlation_matrix(self) -> FloatArray | None:
        """(k, k); None when rank-deficient without sigmas: data and prior share no unit then."""
        covariance = self.covariance
        # Residuals may be zero to the last digit; correlations do not depend on the noise then.
        if self.least_squares.prior_covariance is None:
            covariance = self.least_squares.data_covariance
        if covariance is None:
            return None
        sigma = np.sqrt(np.diag(covariance))
        scale = np.outer(sigma, sigma)
        # Points without any noise leave a sigma of exactly zero where the prior has no share.
        correlations = np.eye(len(sigma))
        np.divide(covariance, scale, out=correlations, where=scale > 0.0)
        return correlations

    @cached_property
    def correlations(self) -> dict[str, float]:
        """``{"P4,P6": r}`` for every pair, in the order of the terms."""
        matrix = self.correlation_matrix
        if matrix is None:
            return {}
        return {
            f"{self.terms[i]},{self.terms[j]}": float(matrix[i, j])
            for i, j in combinations(range(len(self.terms)), 2)
        }

    @cached_property
    def inseparable(self) -> tuple[str, ...]:
        """Sentences naming the terms these points cannot, or can hardly, tell apart."""
        return inseparable_sentences(
            labels(self.model_terms, self.geometry.name),
            self.least_squares.null_directions,
            self.correlation_matrix,
        )

    @cached_property
    def sky_deg(self) -> FloatArray:
        """Residual of each point on sky, (n,)."""
        cross = self.residual1_deg * np.sin(self.points.ax2_deg * RAD_PER_DEG)
        return np.hypot(cross, self.residual2_deg)

    @property
    def axis1_rms_deg(self) -> float:
        return rms(self.residual1_deg)

    @property
    def axis2_rms_deg(self) -> float:
        return rms(self.residual2_deg)

    @property
    def sky_rms_deg(self) -> float:
        return rms(self.sky_deg)

    @property
    def sky_max_deg(self) -> float:
        return float(self.sky_deg.max())

    @property
    def population_sd_deg(self) -> float | None:
        """sqrt(sum of sky^2 / (n - k)), None when there are no more points than terms."""
        spare = self.n_points - len(self.model_terms)
        return float(np.sqrt(np.sum(self.sky_deg**2) / spare)) if spare > 0 else None

    @property
    def noise_deg(self) -> float:
        """Noise of one point on sky, per axis, as far as the residuals tell."""
        return float((self.population_sd_deg or 0.0) / np.sqrt(2.0))

    @cached_property
    def message(self) -> str | None:
        """'Parameters still unrealistic', or None."""
        return unrealistic_message(self.model_terms, self.values, self.points, self.limits)

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Sentences that belong under the table: where the sigmas come from, odd points."""
        return (*self._sigma_notes(), *self.points.remarks())

    def _sigma_notes(self) -> list[str]:
        notes = []
        per_axis = self._sd_per_weight()
        if self.sigma_source == "residuals":
            notes.append(
                "no sigmas were given: those of the parameters are scaled by the residuals, "
                f"{per_axis:.4f} deg per axis on sky"
                + (" (points without noise: real ones have some)" if per_axis < 1e-9 else "")
            )
            if self.method == "iterated":
                notes.append(
                    f"the sigmas divide by n - k = {self.n_points - len(self.terms)}, as SPK's "
                    "PMFIT does, not by 2n - k"
                )
            elif self.model_terms[0].unit == "arcsec":
                notes.append(
                    f"the sigmas divide by 2n - k = {self.degrees_of_freedom}, two numbers a "
                    "point; SPK's PMFIT divides by n - k, which makes its sigmas larger"
                )
        elif self.sigma_source == "none":
            notes.append(
                f"{2 * self.n_points} numbers determine {self.rank} unknowns: no redundancy is "
                "left, so the residuals have no meaning and no sigma can be given"
            )
        elif per_axis > 1.0 + 3.0 / np.sqrt(2 * max(self.degrees_of_freedom, 1)):
            notes.append(
                f"the residuals are {per_axis:.1f} times the given sigmas; "
                "the sigmas of the parameters were not enlarged"
            )
        if self.rank < len(self.model_terms):
            notes.append(
                "what the points do not determine got the smallest values, in units of the usual "
                f"size (lean {LEAN_PRIOR_DEG:g} deg, zeros {ZERO_PRIOR_DEG:g} deg, "
                f"scales {SCALE_PRIOR:g})"
                + (", which is also their sigma there" if self.covariance is not None else "")
            )
        return notes

    def _sd_per_weight(self) -> float:
        """Standard deviation of one weighted datum, NaN where none is left over."""
        if self.degrees_of_freedom <= 0:
            return float("nan")
        squares = self.least_squares.weighted_residuals @ self.least_squares.weighted_residuals
        return float(np.sqrt(squares / self.degrees_of_freedom))

    def coefficients(self) -> Coefficients:
        """P1..P6 to load into a controller, zero where not fitted; FitError where none was."""
        return self._controller_values(self.values)

    def sigma_list(self) -> list[float | None]:
        """One sigma of each term, None where there is none."""
        return [None] * len(self.terms) if self.sigmas is None else list(self.sigmas.tolist())

    def sigma_coefficients(self) -> Coefficients | None:
        """One sigma of each of P1..P6, zero for one that was not fitted; None without sigmas."""
        return None if self.sigmas is None else self._controller_values(self.sigmas)

    def _controller_values(self, numbers: FloatArray) -> Coefficients:
        chosen = {
            name: float(number)
            for name, number in zip(self.terms, numbers, strict=True)
            if name in CONTROLLER_TERMS
        }
        if not chosen:
            raise FitError(
                "none of P1..P6 was fitted, so there are no coefficients for the controller; "
                "fit with the terms P1..P6"
            )
        return Coefficients(**chosen)

    def predict_deg(
        self, ax1_deg: FloatArray | float, ax2_deg: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """Fitted axis errors E1, E2 at ideal angles of any (broadcast) shape, axis degrees."""
        design, shape = self._design_at(ax1_deg, ax2_deg)
        e1, e2 = np.einsum("k,kan->an", self.values, design)
        return e1.reshape(shape), e2.reshape(shape)

    def predict_of_deg(
        self, sources: Sequence[str], ax1_deg: FloatArray, ax2_deg: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """``predict_deg`` at (n,) angles as the session was that each of them is from: where
        something moved after an earlier one, with what it had then."""
        del sources
        return self.predict_deg(ax1_deg, ax2_deg)

    def predict_sigma_deg(
        self, ax1_deg: FloatArray | float, ax2_deg: FloatArray | float
    ) -> tuple[FloatArray, FloatArray]:
        """One sigma of ``predict_deg``, axis degrees; infinite where there is no covariance."""
        design, shape = self._design_at(ax1_deg, ax2_deg)
        if self.covariance is None:
            return np.full(shape, np.inf), np.full(shape, np.inf)
        variance = np.einsum("kan,kl,lan->an", design, self.covariance, design, optimize=True)
        s1, s2 = np.sqrt(np.maximum(variance, 0.0))
        return s1.reshape(shape), s2.reshape(shape)

    def _design_at(
        self, ax1_deg: FloatArray | float, ax2_deg: FloatArray | float
    ) -> tuple[FloatArray, tuple[int, ...]]:
        ax1, ax2 = np.broadcast_arrays(
            np.asarray(ax1_deg, dtype=np.float64), np.asarray(ax2_deg, dtype=np.float64)
        )
        at = NativeAngles.at(self.geometry, ax1.ravel(), ax2.ravel())
        return design_matrix(self.model_terms, at), ax1.shape

    def as_json(self) -> dict[str, Any]:
        """The fit's part of ``solarcal fit --json``; an infinite condition number is null."""
        return {
            "geometry": self.geometry.name,
            "method": self.method,
            "coefficients": {
                term.name: {"value": value, "sigma": sigma, "unit": term.unit}
                for term, value, sigma in zip(
                    self.model_terms, self.values.tolist(), self.sigma_list(), strict=True
                )
            },
            "residuals": {
                "axis1_rms_deg": self.axis1_rms_deg,
                "axis2_rms_deg": self.axis2_rms_deg,
                "sky_rms_deg": self.sky_rms_deg,
                "sky_max_deg": self.sky_max_deg,
                "population_sd_deg": self.population_sd_deg,
            },
            "rank": self.rank,
            "condition_number": (
                self.condition_number if np.isfinite(self.condition_number) else None
            ),
            "correlations": self.correlations,
            "message": self.message,
            "notes": list(self.notes),
            "inseparable": list(self.inseparable),
            "sigma_source": self.sigma_source,
        }
