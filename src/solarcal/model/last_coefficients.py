"""The unit's last coefficients as prior, as long as the points do not contradict them."""

from collections.abc import Callable

import msgspec
import numpy as np
from scipy.special import chdtrc

from solarcal.model.finding import Finding
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.prior import Prior
from solarcal.model.sky_context import SkyContext
from solarcal.model.year_grid import mechanism_of
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients

CHANCE_LIMIT = 0.01
"""Coefficients as far from the points as these would be by chance less often are another tracker's,
or of another time: no prior."""


def last_prior(last: Coefficients, context: SkyContext, usual: Prior) -> Prior:
    """About the mechanism for which the controller's best coefficients are the last ones.

    A lean read from an inclinometer, which ``usual`` then knows, counts beside it by its sigma.
    """
    about = Prior.of_last_coefficients(Coefficients(*mechanism_of(last, context).tolist()))
    means, sigmas = about.mean_array(), about.sigma_array()
    read = np.array(usual.sigmas) != np.array(Prior().sigmas)
    if read.any():
        weight, other = 1.0 / sigmas[read] ** 2, 1.0 / usual.sigma_array()[read] ** 2
        both = weight * means[read] + other * usual.mean_array()[read]
        means[read] = both / (weight + other)
        sigmas[read] = 1.0 / np.sqrt(weight + other)
    return msgspec.structs.replace(
        about, means=tuple(means.tolist()), sigmas=tuple(sigmas.tolist()), last=last
    )


def weigh_last(
    last: Coefficients,
    context: SkyContext,
    usual: Prior,
    solve: Callable[[Prior], MechanismSolution],
) -> tuple[Prior, tuple[Finding, ...]]:
    """The prior to use, and a finding where the points contradict the last coefficients.

    Parameters
    ----------
    last
        What the unit held.
    usual
        The prior without them: it takes their place where they are contradicted.
    solve
        The fit by a prior.

    Raises
    ------
    FitError
        Points that allow no fit.
    """
    prior = last_prior(last, context, usual)
    solution = solve(usual)
    posterior = solution.posterior
    away = posterior.mean - prior.mean_array()
    spread = posterior.covariance + np.diag(prior.sigma_array() ** 2)
    # What the points leave open agrees with anything.
    chance = float(chdtrc(max(solution.rank, 1), away @ np.linalg.solve(spread, away)))
    if chance >= CHANCE_LIMIT:
        return prior, ()
    sigmas = np.sqrt(np.diag(spread))
    worst = int(np.argmax(np.abs(away) / sigmas))
    name, unit = COEFFICIENT_NAMES[worst], COEFFICIENT_UNITS[worst]
    decimals = 2 if unit == "deg" else 5
    held, found = last.as_tuple()[worst], float(solution.values[worst])
    odds = f"{chance:.1g}" if chance > 1e-9 else "below 1e-9"
    return usual, (
        Finding(
            kind="last_coefficients",
            subject="last coefficients",
            sentence=f"the last coefficients do not fit these points (p = {odds}): {name} is "
            f"{held:+.{decimals}f} by them and {found:+.{decimals}f} {unit} by the "
            "points; they were not used. Check that they are of this unit; if so, tower, "
            "references or gears have changed",
            number=found - held,
            sigma=float(sigmas[worst]),
            unit=unit,
            direct=True,
        ),
    )
