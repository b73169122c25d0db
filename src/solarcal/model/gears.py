"""What the points say of the gears, P5 and P6, beyond what gears are like."""

import numpy as np

from solarcal.model.forecast import Forecast
from solarcal.model.least_squares import inverse
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import fit_exact

AXES = (4, 5)
"""P5 and P6 among P1..P6, of axis 1 and axis 2."""
UNLIKE_GEARS = 4.0
"""So many prior sigmas make a ratio that was entered wrongly likelier than an odd gear."""


def unseen_gears(solution: MechanismSolution, expected: Forecast) -> list[str]:
    """A sentence for each scale that rests on the prior although the year would show it.

    Two prior sigmas otherwise: a gear in twenty is worse. The other five follow as the points ask.
    """
    if solution.method != "robust":
        return []
    sigmas = solution.prior.sigma_array()
    otherwise = 2.0 * sigmas
    rows = solution.slopes * sigmas
    seen = np.einsum("n,nai,naj->ij", solution.point_weights, rows, rows)
    said = []
    for axis, scale in enumerate(AXES, start=1):
        free = np.where(np.arange(6) == scale, 1e-6, 1.0)
        covariance = inverse(seen + np.diag(free))
        if covariance[scale, scale] < 1.0:
            continue
        away = otherwise * covariance[scale] / covariance[scale, scale]
        moved = (away @ expected.errors.slopes[:6]).reshape(2, -1)
        both = [np.hypot(*(expected.errors.known + turned)) for turned in (moved, -moved)]
        within_deg = max(float(np.quantile(errors, 0.95)) for errors in both)
        if within_deg > expected.rule.tolerance_deg:
            said.append(
                f"these points do not show P{scale + 1} (gears of axis {axis}): were it "
                f"{otherwise[scale]:g} otherwise, 95 % of the year would be within "
                f"{within_deg:.2f} deg; a point in another season shows it"
            )
    return said


def wrong_ratios(solution: MechanismSolution) -> list[str]:
    """A sentence for each gear ratio that explains points which nothing usual explains."""
    if solution.method != "robust":
        return []
    free = fit_exact(solution.points, solution.context, prior=solution.prior, use_prior=False)
    if free.message is not None or free.noise_deg > 0.5 * solution.noise_deg:
        return []
    limits = UNLIKE_GEARS * (
        solution.prior.sigma_array() + np.sqrt(np.diag(free.posterior.covariance))
    )
    return [
        f"P{scale + 1} = {value:+z.4f} alone leaves a scatter of {free.noise_deg:.3f} deg: axis "
        f"{axis} turns {100.0 * abs(value):.1f} % {'more' if value > 0.0 else 'less'} than it "
        "reads; correct its gear ratio (counts a degree) and take the points again, or fit with "
        "--method exact"
        for axis, scale in enumerate(AXES, start=1)
        if abs(value := float(free.posterior.mean[scale])) > limits[scale]
    ]
