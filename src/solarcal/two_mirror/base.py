"""The Euler angles of a two-mirror tracker's base, from where its axes stood on the Sun.

``fit_base`` finds them; ``BaseModel`` is what the tracker's controller works with: its own target's
place and the base as it learns it from its log.
"""

import math
from dataclasses import dataclass

import numpy as np

from solarcal.errors import FitError
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import apparent_zenith_deg
from solarcal.sun.appendix_a import horizontal_deg
from solarcal.two_mirror.mirrors import EulerBase, direction, rotation_x, rotation_y, rotation_z
from solarcal.two_mirror.scenario import Sky
from solarcal.units import RAD_PER_DEG, FloatArray, rms, wrap_deg

FEWEST_POSITIONS = 3
LEAST_SPREAD_DEG = 2.0
"""Positions nearer to one another than this do not determine the rotation about them."""

MOST_LEFT_DEG = 2.0
"""Where more than this is left, rms on the sky, no base turns the Suns into the read-outs."""


@dataclass(frozen=True, slots=True, eq=False)
class MirrorPoints:
    """Where the Sun was and where the axes stood with the spot centred.

    All (n,) arrays in degrees, `azel` native: ``sun1_deg, sun2_deg`` the Sun's AX1, AX2;
    ``axis1_deg, axis2_deg`` the read-outs. AX1 on any branch. ``labels`` name the rows.
    """

    sun1_deg: FloatArray
    sun2_deg: FloatArray
    axis1_deg: FloatArray
    axis2_deg: FloatArray
    labels: tuple[int, ...] = ()

    def __len__(self) -> int:
        return len(self.sun1_deg)

    def rows(self, chosen: list[int]) -> "MirrorPoints":
        """The points of these rows only."""
        return MirrorPoints(
            self.sun1_deg[chosen],
            self.sun2_deg[chosen],
            self.axis1_deg[chosen],
            self.axis2_deg[chosen],
            tuple(self.labels[row] for row in chosen) if self.labels else (),
        )

    def suns(self) -> FloatArray:
        """Unit vectors of the Sun in the Earth's frame, (n, 3)."""
        return direction(self.sun1_deg, self.sun2_deg)

    def calculated_deg(self, base: EulerBase) -> tuple[FloatArray, FloatArray]:
        """Where a base puts the axes, on the branch of the read-outs, (n,) each."""
        suns = zip(self.sun1_deg.tolist(), self.sun2_deg.tolist(), strict=True)
        axes = np.array([base.axes_deg(one, two) for one, two in suns]).reshape(-1, 2)
        return self.axis1_deg + wrap_deg(axes[:, 0] - self.axis1_deg), axes[:, 1]

    def sky_deg(self, base: EulerBase) -> FloatArray:
        """How far on the sky a base's axes are from the read-outs, (n,)."""
        apart = direction(*self.calculated_deg(base)) - self.seen()
        return np.asarray(2.0 * np.arcsin(0.5 * np.linalg.norm(apart, axis=1)) / RAD_PER_DEG)

    def seen(self) -> FloatArray:
        """Unit vectors of the Sun in the tracker's frame, (n, 3)."""
        return direction(self.axis1_deg, self.axis2_deg)


@dataclass(frozen=True, slots=True, eq=False)
class BaseSolution:
    """A fitted base. ``sigma_deg``: of alpha, beta, gamma, from the residuals; ``None`` at n = 3.

    ``sky_deg`` (n,): what is left at each point, an angle on the sky.
    """

    base: EulerBase
    start: EulerBase
    sigma_deg: tuple[float, float, float] | None
    sky_deg: FloatArray
    n_points: int
    labels: tuple[int, ...]

    @property
    def sky_rms_deg(self) -> float:
        return rms(self.sky_deg)

    @property
    def sky_max_deg(self) -> float:
        return float(self.sky_deg.max())

    @property
    def worst_label(self) -> int:
        """Which point is left with ``sky_max_deg``."""
        worst = int(np.argmax(self.sky_deg))
        return self.labels[worst] if self.labels else worst + 1


def base_from_three(points: MirrorPoints) -> EulerBase:
    """Start value: the rotation that best turns three positions of the Sun into those seen.

    A rotation needs only two directions; the third makes the answer steady. Computed by singular
    values (Kabsch), which holds where the three lie in one plane too, as they do at the equinox.
    Of more than three points the first, the last and the one that is farthest from both are taken.

    Raises
    ------
    FitError
        Fewer than three positions, or all near one another.
    """
    _require_usable(points)
    return _rotation_between(points.rows(_three_apart(points.suns())))


def fit_base(points: MirrorPoints) -> BaseSolution:
    """Euler angles by least squares on the sky over all points.

    A chord between unit vectors is the angle on the sky to third order.

    Raises
    ------
    FitError
        Fewer than three positions, all near one another, a Sun below the horizon, not finite, or
        read-outs of another tracker.
    """
    start = base_from_three(points)
    base = _rotation_between(points)
    predicted, slopes = _predicted(base, points.suns())
    apart = np.linalg.norm(points.seen() - predicted, axis=1)
    left_deg = 2.0 * np.arcsin(0.5 * apart) / RAD_PER_DEG
    solution = BaseSolution(
        base=base,
        start=start,
        sigma_deg=_sigma_deg(slopes.reshape(-1, 3), left_deg),
        sky_deg=left_deg,
        n_points=len(points),
        labels=points.labels,
    )
    if solution.sky_rms_deg > MOST_LEFT_DEG:
        raise FitError(
            f"the axis read-outs do not belong to these positions of the Sun (left on the sky: rms "
            f"{solution.sky_rms_deg:.1f} deg); check site, clock and the sense of both axes"
        )
    return solution


def _require_usable(points: MirrorPoints) -> None:
    if len(points) < FEWEST_POSITIONS:
        raise FitError(
            f"too few positions ({len(points)}): the Euler angles of the base need at least "
            f"{FEWEST_POSITIONS}"
        )
    columns = (points.sun1_deg, points.sun2_deg, points.axis1_deg, points.axis2_deg)
    for row in range(len(points)):
        label = points.labels[row] if points.labels else row + 1
        if not all(np.isfinite(column[row]) for column in columns):
            raise FitError(f"position {label}: all four angles must be numbers")
        if not 0.0 <= points.sun2_deg[row] <= 90.0:
            raise FitError(
                f"position {label}: the Sun's zenith angle {points.sun2_deg[row]:.2f} deg is not "
                "between 0 and 90 (below the horizon?); leave it out"
            )
    suns = points.suns()
    apart_deg = np.degrees(np.arccos(np.clip((suns @ suns.T).min(), -1.0, 1.0)))
    if apart_deg < LEAST_SPREAD_DEG:
        raise FitError(
            f"the positions are within {apart_deg:.2f} deg of one another; take them at least "
            f"{LEAST_SPREAD_DEG:g} deg apart (some ten minutes), better over hours"
        )


def _three_apart(suns: FloatArray) -> list[int]:
    """First, last, and the one whose nearer of the two is farthest; in order."""
    first, last = 0, len(suns) - 1
    nearer = np.maximum(suns @ suns[first], suns @ suns[last])
    nearer[[first, last]] = np.inf
    return [first, int(np.argmin(nearer)), last]


def _rotation_between(points: MirrorPoints) -> EulerBase:
    """Kabsch: the proper rotation M with the least sum of |seen - M sun|^2."""
    left, _, right = np.linalg.svd(points.seen().T @ points.suns())
    proper = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(left @ right)))])
    return EulerBase.of_matrix(left @ proper @ right)


def _predicted(base: EulerBase, suns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """M s, (n, 3), and its derivatives by alpha, beta, gamma, (n, 3, 3), per radian."""
    rx, ry, rz = rotation_x(base.gamma_deg), rotation_y(base.beta_deg), rotation_z(base.alpha_deg)
    # d Rz/d alpha = Rz Jz, where Jz v = z x v; its matrix has the rows e_i x z.
    jx, jy, jz = (np.cross(np.eye(3), axis) for axis in np.eye(3))
    slopes = (rx @ ry @ rz @ jz, rx @ ry @ jy @ rz, rx @ jx @ ry @ rz)
    return suns @ (rx @ ry @ rz).T, np.stack([suns @ slope.T for slope in slopes], axis=-1)


def _sigma_deg(slopes: FloatArray, left_deg: FloatArray) -> tuple[float, float, float] | None:
    # Two numbers a point, three angles.
    free = 2 * len(left_deg) - 3
    if len(left_deg) <= FEWEST_POSITIONS:
        return None
    variance = float(np.sum(left_deg**2)) / free
    sigmas = np.sqrt(variance * np.diag(np.linalg.inv(slopes.T @ slopes)))
    return float(sigmas[0]), float(sigmas[1]), float(sigmas[2])


RATE_SPAN_S = 20.0
LEAST_LOG_ELEVATION_DEG = 5.0
"""Lower the air bends the light by more than any formula knows."""


@dataclass(frozen=True, slots=True)
class LoggedPoint:
    """The Sun the controller computed and where its axes stood with the spot centred, degrees."""

    utc_s: float
    sun1_deg: float
    sun2_deg: float
    axis1_deg: float
    axis2_deg: float


class BaseModel:
    """The Sun by the controller's formula and air, and the Euler angles as known so far.

    Parameters
    ----------
    base : the Euler angles it begins with.
    log_every_s : how often a point is kept.
    sky : another target than the Sun, airless.

    Until three points tell the base, ``offset_deg`` is what to add to the calculated axis angles:
    how far off the spot was found.
    """

    def __init__(
        self, base: EulerBase, site: Site, log_every_s: float, sky: Sky | None = None
    ) -> None:
        self.base = base
        self.solution: BaseSolution | None = None
        self.log: list[LoggedPoint] = []
        self.offset_deg = (0.0, 0.0)
        self._site = site
        self._sky = sky
        self._weather = Weather(pressure_hpa=standard_pressure_hpa(site.elevation_m))
        self._log_every_s = log_every_s

    def sun_deg(self, utc_s: float) -> tuple[float, float]:
        """The controller's own apparent Sun, AX1 and AX2."""
        if self._sky is not None:
            azimuth, zenith = self._sky.horizontal_deg(utc_s)
        else:
            azimuth, zenith = horizontal_deg(
                utc_s, self._site.latitude_deg, self._site.longitude_deg, plus=True
            )
        return 180.0 - azimuth, apparent_zenith_deg(zenith, "saemundsson", self._weather)

    def calculated_deg(self, utc_s: float) -> tuple[float, float]:
        """Axis angles of the Sun by the base as known so far."""
        return self.base.axes_deg(*self.sun_deg(utc_s))

    def rates_deg_s(self, utc_s: float) -> tuple[float, float]:
        """How fast the Sun moves in both axes."""
        before = self.calculated_deg(utc_s - 0.5 * RATE_SPAN_S)
        after = self.calculated_deg(utc_s + 0.5 * RATE_SPAN_S)
        return (
            math.remainder(after[0] - before[0], 360.0) / RATE_SPAN_S,
            (after[1] - before[1]) / RATE_SPAN_S,
        )

    def keep_point(
        self, utc_s: float, to_go: tuple[float, float], axis1_deg: float, axis2_deg: float
    ) -> None:
        """Log a point when one is due, and learn the base from all of them."""
        if self.log and utc_s - self.log[-1].utc_s < self._log_every_s:
            return
        sun1, sun2 = self.sun_deg(utc_s)
        if sun2 > 90.0 - LEAST_LOG_ELEVATION_DEG and self.solution is not None:
            return
        # What the diode still shows is not lost: it is added by the same ray trace.
        centred = axis1_deg + to_go[0], axis2_deg + to_go[1]
        self.log.append(LoggedPoint(utc_s, sun1, sun2, *centred))
        try:
            self.solution = fit_base(self.points())
        except FitError:
            # Too few yet, or too near one another: what is known stands.
            calculated = self.base.axes_deg(sun1, sun2)
            if self.solution is None:
                self.offset_deg = (
                    math.remainder(centred[0] - calculated[0], 360.0),
                    centred[1] - calculated[1],
                )
            return
        self.base, self.offset_deg = self.solution.base, (0.0, 0.0)

    def points(self) -> MirrorPoints:
        """The log as points of a fit."""
        rows = np.array([[p.sun1_deg, p.sun2_deg, p.axis1_deg, p.axis2_deg] for p in self.log])
        sun1, sun2, axis1, axis2 = rows.reshape(-1, 4).T
        return MirrorPoints(sun1, sun2, axis1, axis2, tuple(range(1, len(self.log) + 1)))
