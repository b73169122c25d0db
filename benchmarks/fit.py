"""The 12-point fit with covariance against katpoint's, and how the fit grows with the points.

Both solve the same problem: six parameters of an alt-azimuth mount, sky-weighted least squares by
singular value decomposition, with the standard errors of the parameters.
"""

import warnings
from collections.abc import Callable

import numpy as np

from benchmarks.timing import table, timed
from solarcal.model.fit import fit_linear
from solarcal.model.points import Points
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import MountGeometry

COUNTS = (12, 120, 1200, 12000)
KATPOINT_PARAMETERS = [1, 5, 6, 7, 9, 12]
"""Its names for what P1..P6 are: both leans, both zeros, both scales."""


def day_of_points(n: int) -> Points:
    """n points of a day's arc with 0.03 deg of noise on sky."""
    geometry = MountGeometry("azel", 35.0)
    ax1 = np.linspace(-110.0, 110.0, n)
    ax2 = 75.0 - 60.0 * np.cos(np.radians(ax1 * 0.75))
    truth = Coefficients(P1=0.3, P2=0.2, P3=-0.4, P4=0.1, P5=0.001, P6=-0.002)
    e1, e2 = correction_deg(truth, ax1, ax2)
    noise1, noise2 = 0.03 * np.random.default_rng(1).standard_normal((2, n))
    return Points(
        geometry=geometry,
        ax1_deg=ax1,
        ax2_deg=ax2,
        err1_deg=e1 + noise1 / np.sin(np.radians(ax2)),
        err2_deg=e2 + noise2,
    )


def katpoint_fit(points: Points) -> Callable[[], object]:
    """katpoint's fit of the same points, its angles converted beforehand."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import katpoint

    az, el = np.radians(180.0 - points.ax1_deg), np.radians(90.0 - points.ax2_deg)
    delta_az, delta_el = np.radians(-points.err1_deg), np.radians(-points.err2_deg)

    def fit() -> object:
        return katpoint.PointingModel().fit(
            az,
            el,
            delta_az,
            delta_el,
            enabled_params=KATPOINT_PARAMETERS,
            keep_disabled_params=True,
        )

    return fit


def run() -> list[str]:
    rows = []
    for n in COUNTS:
        points = day_of_points(n)
        ours, theirs = timed(
            lambda points=points: fit_linear(points).sigmas,  # type: ignore[misc]
            katpoint_fit(points),
        )
        rows.append(
            (f"{n}", ours.per(1, 1e-6), theirs.per(1, 1e-6), f"{theirs.least_s / ours.least_s:.1f}")
        )
    points = day_of_points(12)
    checked, told = timed(
        lambda: fit_linear(_checked_again(points)).sigmas, lambda: fit_linear(points).as_json()
    )
    return [
        "P1..P6 with sigmas, microseconds: least (median)",
        *table(("points", "solarcal", "katpoint", "ratio"), rows),
        f"12 points with checking them: {checked.per(1, 1e-6)}; with everything a screen shows: "
        f"{told.per(1, 1e-6)} (asked: 3 times as fast as katpoint)",
    ]


def _checked_again(points: Points) -> Points:
    return Points(
        geometry=points.geometry,
        ax1_deg=points.ax1_deg,
        ax2_deg=points.ax2_deg,
        err1_deg=points.err1_deg,
        err2_deg=points.err2_deg,
    )


if __name__ == "__main__":
    print("\n".join(run()))
