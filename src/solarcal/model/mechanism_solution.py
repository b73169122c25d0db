"""The answer of an exact fit: what to upload, and what is wrong with the mount."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from scipy import linalg

from solarcal.model.prior import MechanismPosterior, Prior
from solarcal.model.sky_context import SkyContext, TruePoints
from solarcal.model.solution import Solution
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Linearised, Mechanism
from solarcal.site import BoltCircle
from solarcal.units import FloatArray, wrap_deg

OUTLIER_PROBABILITY = 0.5


@dataclass(frozen=True, slots=True)
class MechanismSummary:
    """Lean, zeros and scales of the mechanism, one sigma each. Degrees; scales in deg/deg.

    ``lean_bearing_deg``: where the primary axis has gone. On ``azel`` the compass bearing of the
    tower's top; on the others counted from Up (``polar``: from the equator's meridian point)
    through South (``tiltroll-ew``) or East. None of it without a lean.
    """

    lean_deg: float
    lean_sigma_deg: float
    lean_bearing_deg: float
    lean_bearing_sigma_deg: float
    offsets_deg: tuple[float, float]
    offset_sigmas_deg: tuple[float, float]
    scales: tuple[float, float]
    scale_sigmas: tuple[float, float]
    noise_deg: float


def summarise(posterior: MechanismPosterior) -> MechanismSummary:
    P1, P2, P3, P4, P5, P6 = posterior.mean.tolist()
    sigma = np.sqrt(np.diag(posterior.covariance)).tolist()
    lean = math.hypot(P1, P3)
    # The primary axis moves by (-P1, +P3, 0) in the native frame.
    bearing = math.degrees(math.atan2(P3, P1)) % 360.0
    block = posterior.covariance[np.ix_([0, 2], [0, 2])]
    along = np.array([P1, P3]) / lean if lean > 0.0 else np.array([1.0, 0.0])
    across = np.array([-along[1], along[0]])
    lean_sigma = math.sqrt(float(along @ block @ along))
    across_sigma = math.sqrt(float(across @ block @ across))
    return MechanismSummary(
        lean_deg=lean,
        lean_sigma_deg=lean_sigma,
        lean_bearing_deg=bearing,
        lean_bearing_sigma_deg=min(180.0, math.degrees(math.atan2(across_sigma, max(lean, 1e-9)))),
        offsets_deg=(P2, P4),
        offset_sigmas_deg=(sigma[1], sigma[3]),
        scales=(P5, P6),
        scale_sigmas=(sigma[4], sigma[5]),
        noise_deg=posterior.noise_median_deg,
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class MechanismSolution(Solution):
    """A ``robust`` or ``exact`` fit.

    ``values``, ``covariance`` and ``coefficients()`` are the six numbers to UPLOAD, chosen to make
    the controller's formula best over the year; ``predict_deg`` is that formula. The residuals are
    those of the exact mechanism. ``rank`` and ``condition_number`` tell what the points alone say.

    Attributes
    ----------
    posterior : what is known of the mechanism.
    context, prior : what was known beforehand.
    seen : the points from where the Sun really stood.
    year : the mechanism over the year's grid.
    blunder_probability : (n,)
    slopes : (n, 2, 6), of the points' sky errors with respect to the mechanism.
    shift_slopes : (2 n, k), with respect to what moved between sessions, in units of its prior.
    session_shifts : (4,) by the earlier session's name, P1..P4 less those of the last, degrees.
    """

    posterior: MechanismPosterior
    context: SkyContext
    prior: Prior
    seen: TruePoints
    year: Linearised
    blunder_probability: FloatArray
    slopes: FloatArray
    point_weights: FloatArray
    left_out: tuple[str, ...] = ()
    """Sentences about points that were not used."""
    shift_slopes: FloatArray | None = None
    session_shifts: Mapping[str, FloatArray] = field(default_factory=dict)

    def predict_of_deg(
        self, sources: Sequence[str], ax1_deg: FloatArray, ax2_deg: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        e = np.stack(self.predict_deg(ax1_deg, ax2_deg))
        if self.session_shifts:
            now, of = self.posterior.mean, np.array(sources)
            for source, shift in self.session_shifts.items():
                at = (of == source) & np.isfinite(ax1_deg) & np.isfinite(ax2_deg)
                here = self.geometry, ax1_deg[at], ax2_deg[at]
                then = Mechanism.of(now + np.pad(shift, (0, 2))).errors_deg(*here)
                e[:, at] += wrap_deg(np.stack(then) - np.stack(Mechanism.of(now).errors_deg(*here)))
        return e[0], e[1]

    @cached_property
    def mechanism(self) -> MechanismSummary:
        return summarise(self.posterior)

    @cached_property
    def outliers(self) -> tuple[int, ...]:
        """Labels of the points that are more likely blunders than not."""
        bad = np.flatnonzero(self.blunder_probability > OUTLIER_PROBABILITY)
        return tuple(self.labels[i] for i in bad)

    @property
    def noise_deg(self) -> float:
        """Noise of one point on sky, per axis, as far as the points and the prior tell."""
        return self.posterior.noise_median_deg

    def beside_shifts(self, columns: FloatArray, point_weights: FloatArray) -> FloatArray:
        """Columns (2 n, q) less what shifts between sessions explain of them, weights (n,)."""
        assert self.shift_slopes is not None
        weighted = self.shift_slopes.T * np.repeat(point_weights, 2)
        normal = weighted @ self.shift_slopes + np.eye(len(weighted))
        explained = linalg.solve(normal, weighted @ columns, assume_a="pos")
        less: FloatArray = columns - self.shift_slopes @ explained
        return less

    def _sigma_notes(self) -> list[str]:
        notes = [*self.left_out]
        if self.prior.last is not None and self.method == "robust":
            notes.append(f"prior: {self.prior.words()}")
        for i in np.flatnonzero(self.blunder_probability > OUTLIER_PROBABILITY):
            notes.append(
                f"point {self.labels[i]} has a residual of {self.sky_deg[i]:.2f} deg and has "
                "almost no weight; check what happened there"
            )
        if self.rank < len(self.model_terms) and self.method == "robust":
            notes.append(
                f"the points alone fix {self.rank} of the 6 numbers; the rest comes from the "
                "usual errors of towers, zeros and gears"
                if self.prior.last is None
                else f"the points alone fix {self.rank} of the 6 numbers; the rest comes from "
                "the prior"
            )
        elif self.rank < len(self.model_terms):
            notes.append(
                f"the points fix {self.rank} of the 6 numbers; for the rest the smallest values "
                "were taken, in units of their usual size"
            )
        return notes

    def as_json(self) -> dict[str, Any]:
        document = super().as_json()
        m = self.mechanism
        document["outliers"] = list(self.outliers)
        document["noise_deg"] = self.noise_deg
        document["prior"] = self.prior.as_json() if self.method == "robust" else None
        document["mechanism"] = {
            "lean_deg": m.lean_deg,
            "lean_bearing_deg": m.lean_bearing_deg,
            "offsets_deg": list(m.offsets_deg),
            "scales": list(m.scales),
            "lean_sigma_deg": m.lean_sigma_deg,
            "lean_bearing_sigma_deg": m.lean_bearing_sigma_deg,
            "offset_sigmas_deg": list(m.offset_sigmas_deg),
            "scale_sigmas": list(m.scale_sigmas),
        }
        return document


SHIM_FIRST_DEG = 3.5
"""With more lean the controller's first-order formula leaves more than 0.1 deg somewhere."""


@dataclass(frozen=True, slots=True)
class BaseTilt:
    """How the base of a mount stands. ``tilt_deg`` from level, the top gone towards
    ``bearing_deg`` (North through East); ``turn_deg`` about the vertical, positive from North
    towards West (counterclockwise from above)."""

    tilt_deg: float
    bearing_deg: float
    turn_deg: float


def base_tilt(values: FloatArray, geometry: MountGeometry) -> BaseTilt:
    """From the mechanism's P1 and P3: the rotation (-P3, -P1, 0) about native x, y, seen in ENU.

    For ``azel`` this is the lean itself; on the other mounts part of it is a turned base.
    """
    native = np.array([-values[2], -values[0], 0.0])
    east, north, up = (geometry.basis().T @ native).tolist()
    # A rotation w moves the tower's top by w x up = (w_n, -w_e, 0).
    top_east, top_north = north, -east
    return BaseTilt(
        tilt_deg=math.hypot(top_east, top_north),
        bearing_deg=math.degrees(math.atan2(top_east, top_north)) % 360.0,
        turn_deg=up,
    )


@dataclass(frozen=True, slots=True)
class Shim:
    """What to put under the base at one bolt."""

    bolt_bearing_deg: float
    height_mm: float


def shim_heights(lean_deg: float, bearing_deg: float, plate: BoltCircle) -> tuple[Shim, ...]:
    """Heights that bring a leaning tower upright; the highest corner gets nothing.

    ``bearing_deg``: towards which compass bearing the top leans.
    """
    radius, first_deg = plate.diameter_mm / 2.0, plate.first_bolt_bearing_deg
    bearings = [(first_deg + 360.0 * i / plate.bolts) % 360.0 for i in range(plate.bolts)]
    # The plate is low on the side the top leans to: that side is lifted.
    rises = [
        radius * math.sin(math.radians(lean_deg)) * math.cos(math.radians(b - bearing_deg))
        for b in bearings
    ]
    lowest = min(rises)
    return tuple(Shim(b, r - lowest) for b, r in zip(bearings, rises, strict=True))


_WINDS = ("N", "NNE", "NE", "ENE", "E", "ESE", "SE", "SSE")
_ALL_WINDS = (*_WINDS, "S", "SSW", "SW", "WSW", "W", "WNW", "NW", "NNW")


def wind(bearing_deg: float) -> str:
    """Compass point of a bearing: 'NNE'."""
    return _ALL_WINDS[round(bearing_deg / 22.5) % 16]
