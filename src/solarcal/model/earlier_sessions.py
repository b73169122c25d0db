"""What earlier sessions of a unit still say of it: their points, or their last coefficients.

Two things change between sessions: zeros (a reference switch, a new encoder: P2, P4) and the lean
of the tower (P1, P3). Gears stay. Each is tested against the residuals, Holm-corrected, beside
single bad points. Where something changed, the earlier sessions keep what still holds of them:
their own shifts of P1..P4 are fitted along, counted from the last session, whose numbers are
uploaded.

Where only the last coefficients are known, they are the prior as long as the points do not
contradict them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import msgspec
import numpy as np
from scipy.special import chdtrc

from solarcal.errors import FitError
from solarcal.model.f_tests import (
    LEAN,
    ZEROS,
    PointsTested,
    SessionIndex,
    shift_columns,
    weakest_change_deg,
    what_changed,
)
from solarcal.model.finding import Finding, listed
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit_exact
from solarcal.model.points import Points
from solarcal.model.prior import Prior
from solarcal.model.sky_context import LOWEST_ELEVATION_DEG, SkyContext, true_points
from solarcal.model.year_grid import coefficients_jacobian, mechanism_of
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients
from solarcal.mount.mechanism import Mechanism
from solarcal.units import FloatArray, wrap_deg

Change = Literal["same", "zeros", "tower"]

MATTERS_DEG = 0.1

_TURNS = 4


@dataclass(frozen=True, eq=False, slots=True)
class Merged:
    """One solution from all sessions, valid for the last of them.

    Attributes
    ----------
    solution : its residuals are counted after each session's own shift.
    change : ``same``; ``zeros`` changed; ``tower``: the lean changed, and zeros may have, too.
    shifts, shift_sigmas : (s - 1, 4), P1..P4 of each earlier session less those of the last,
        degrees; zero where not allowed.
    findings : on what changed, or what could have without showing.
    sentence : the outcome of the test.
    """

    solution: MechanismSolution
    change: Change
    shifts: FloatArray
    shift_sigmas: FloatArray
    findings: tuple[Finding, ...]
    sentence: str


def merge_sessions(
    parts: Sequence[Points],
    context: SkyContext,
    *,
    prior: Prior = DEFAULT_PRIOR,
    names: Sequence[str] = (),
) -> Merged:
    """Fit sessions of one unit together, testing for changes between them.

    Parameters
    ----------
    parts : the sessions in order of time. The tower may have moved between any two.
    context : common to all.
    names : what the sessions are called; default ``session 1``...

    Raises
    ------
    FitError
        No session, or one without a point high enough.
    """
    if not parts:
        raise FitError("no session to merge; give at least one file")
    called = list(names) or [f"session {k + 1}" for k in range(len(parts))]
    parts = [_high_enough(p, context, name) for p, name in zip(parts, called, strict=True)]
    joint = Points.joined(parts)
    session = np.repeat(np.arange(len(parts)), [len(part) for part in parts])
    solution = fit_exact(joint, context, prior=prior)
    nothing = np.zeros((len(parts) - 1, 4))
    if len(parts) == 1:
        return Merged(solution, "same", nothing, nothing, (), "one session: nothing to compare")
    taken = what_changed(joint, session, context, solution.posterior.mean)
    if not taken:
        weakest = weakest_change_deg(joint, session, solution)
        finding, sentence = _no_change(called, weakest)
        return Merged(solution, "same", nothing, nothing, finding, sentence)
    change: Change = "tower" if LEAN in taken else "zeros"
    allowed = (*LEAN, *ZEROS) if change == "tower" else ZEROS
    solution, shifts, sigmas = _fit_shifted(joint, session, context, prior, sorted(allowed))
    findings = tuple(
        _moved(change, called[k], called[-1], shifts[k], sigmas[k]) for k in range(len(parts) - 1)
    )
    sentence = "; ".join(finding.sentence for finding in findings)
    solution = replace(solution, session_shifts=dict(zip(called, shifts, strict=False)))
    return Merged(solution, change, shifts, sigmas, findings, sentence)


def _high_enough(points: Points, context: SkyContext, name: str) -> Points:
    high = true_points(points, context).elevation_deg >= LOWEST_ELEVATION_DEG
    if not high.any():
        raise FitError(
            f"{name} has no point above {LOWEST_ELEVATION_DEG:g} deg of elevation; leave it out"
        )
    return points if high.all() else points.subset(high)


def _no_change(called: Sequence[str], weakest_deg: float) -> tuple[tuple[Finding, ...], str]:
    between = listed(list(called))
    if weakest_deg <= MATTERS_DEG:
        return (), (
            f"{between} agree: nothing moved between them that exceeds {weakest_deg:.2f} deg"
        )
    less = f"less than {weakest_deg:.2g} deg" if np.isfinite(weakest_deg) else "any move at all"
    sentence = (
        f"no sign that the tower moved between {between}, but that is not determinable from these "
        f"points: {less} might not show"
    )
    finding = Finding(
        kind="moved",
        subject="tower",
        sentence=sentence,
        certainty="not_determinable",
        number=weakest_deg if np.isfinite(weakest_deg) else None,
    )
    return (finding,), sentence


def _moved(
    change: Change, earlier: str, last: str, shift: FloatArray, sigma: FloatArray
) -> Finding:
    by = f"by {-shift[1]:+z.3f} +- {sigma[1]:.3f} and {-shift[3]:+z.3f} +- {sigma[3]:.3f} deg"
    if change == "zeros":
        worst = 1 if abs(shift[1]) * sigma[3] >= abs(shift[3]) * sigma[1] else 3
        number, spread = float(-shift[worst]), float(sigma[worst])
        sentence = (
            f"between {earlier} and {last} the zeros of axis 1 and 2 changed {by}; the tower's "
            "lean did not: each session has its own zeros now, the last one's are given"
        )
    else:
        number = float(np.hypot(shift[0], shift[2]))
        along = np.array([shift[0], shift[2]]) / max(number, 1e-12)
        spread = float(np.hypot(along[0] * sigma[0], along[1] * sigma[2]))
        sentence = (
            f"between {earlier} and {last} the tower moved: its lean changed by {number:.3f} +- "
            f"{spread:.3f} deg (P1 {-shift[0]:+z.3f}, P3 {-shift[2]:+z.3f}), the zeros of "
            f"axis 1 and 2 {by}; the last session's numbers are given; check the foundation"
        )
    return Finding(
        kind="moved",
        subject="tower" if change == "tower" else "zeros",
        sentence=sentence,
        number=number,
        sigma=spread,
    )


def _fit_shifted(
    points: Points, session: SessionIndex, context: SkyContext, prior: Prior, allowed: Sequence[int]
) -> tuple[MechanismSolution, FloatArray, FloatArray]:
    """With shifts of these numbers for every session but the last; solution, shifts, sigmas.

    ``prior`` is of the last session: only what was found without it is held against it, and what
    moved is as wide as usual.
    """
    s = int(session.max())
    shifts, sigmas = np.zeros((s, 4)), np.zeros((s, 4))
    wide = DEFAULT_PRIOR.sigma_array()
    solution = fit_exact(points, context, prior=DEFAULT_PRIOR)
    priors = [DEFAULT_PRIOR] * _TURNS + ([] if prior == DEFAULT_PRIOR else [prior] * _TURNS)
    for turn, here in enumerate(priors):
        unit = here.sigma_array()
        if turn:
            shifted = _as_the_last(points, session, context, solution.posterior.mean, shifts)
            solution = fit_exact(shifted, context, prior=here)
        # In units of the prior, weighted by what the robust fit thinks of each point.
        root = np.sqrt(solution.point_weights)[:, np.newaxis]
        six = (solution.slopes * unit * root[..., np.newaxis]).reshape(-1, 6)
        more = shift_columns(six * (wide / unit), session, allowed)
        tested = PointsTested.of(solution.points, context, seen=solution.seen)
        at, weights = tested.rows(solution.posterior.mean, {}), tested.weights[:, np.newaxis]
        left = (at.residuals.reshape(-1, 2) / weights * root).reshape(-1)
        both = np.hstack((six, more))
        held = shifts[:, list(allowed)].reshape(-1) / np.tile(wide[list(allowed)], s)
        away = (here.mean_array() - solution.posterior.mean) / unit
        normal = both.T @ both + np.eye(both.shape[1])
        step = np.linalg.solve(normal, both.T @ left + np.concatenate((away, -held)))
        shifts[:, list(allowed)] += (step[6:] * np.tile(wide[list(allowed)], s)).reshape(s, -1)
        covariance = np.linalg.inv(normal)
        spread = np.sqrt(np.diag(covariance))[6:] * np.tile(wide[list(allowed)], s)
        sigmas[:, list(allowed)] = spread.reshape(s, -1)
    slopes = shift_columns((solution.slopes * wide).reshape(-1, 6), session, allowed)
    return _with_shifts_free(replace(solution, shift_slopes=slopes)), shifts, sigmas


def _as_the_last(
    points: Points,
    session: SessionIndex,
    context: SkyContext,
    values: FloatArray,
    shifts: FloatArray,
) -> Points:
    """The points as they would have been in the last session's state."""
    seen = true_points(points, context)
    geometry = points.geometry
    now = np.stack(Mechanism.of(values).errors_deg(geometry, seen.ax1_deg, seen.ax2_deg))
    err = np.stack((points.err1_deg, points.err2_deg))
    for k, shift in enumerate(shifts):
        then = Mechanism.of(values + np.array([*shift, 0.0, 0.0]))
        change = now - np.stack(then.errors_deg(geometry, seen.ax1_deg, seen.ax2_deg))
        change[0] = wrap_deg(change[0])
        err += change * (session == k)
    return points.replace(err1_deg=err[0], err2_deg=err[1])


def _with_shifts_free(solution: MechanismSolution) -> MechanismSolution:
    """The posterior with the shifts' uncertainty in it: points say less where they may shift."""
    posterior, A = solution.posterior, solution.slopes.reshape(-1, 6)
    assert posterior.point_weights is not None
    covariances = [
        np.linalg.inv(
            np.linalg.inv(covariance)
            - (A.T * np.repeat(weights, 2)) @ (A - solution.beside_shifts(A, weights))
        )
        for covariance, weights in zip(posterior.covariances, posterior.point_weights, strict=True)
    ]
    wider = replace(posterior, covariances=np.stack(covariances))
    carried = coefficients_jacobian(solution.year.slopes, solution.context, solution.prior)
    return replace(solution, posterior=wider, covariance=carried @ wider.covariance @ carried.T)


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


def weigh_inclinometer(
    read: Prior, solve: Callable[[Prior], MechanismSolution]
) -> tuple[Prior, tuple[Finding, ...]]:
    """``weigh_last`` of the lean of an inclinometer; ``read``: the prior with it."""
    posterior, lean = solve(DEFAULT_PRIOR).posterior, list(LEAN)
    away = (posterior.mean - read.mean_array())[lean]
    spread = posterior.covariance[np.ix_(lean, lean)] + np.diag(read.sigma_array()[lean] ** 2)
    chance = float(chdtrc(len(lean), away @ np.linalg.solve(spread, away)))
    if chance >= CHANCE_LIMIT:
        return read, ()
    P1, P3 = read.mean_array()[lean]
    by_points = posterior.mean[lean]
    return DEFAULT_PRIOR, (
        Finding(
            kind="inclinometer",
            subject="inclinometer",
            sentence=f"the inclinometer's reading does not fit these points (p = {_odds(chance)}): "
            f"P1 {P1:+z.3f} and P3 {P3:+z.3f} deg by it, {by_points[0]:+z.3f} and "
            f"{by_points[1]:+z.3f} deg by the points; it was not used. Check its signs, its axes "
            "and its sigma",
            number=float(np.hypot(*away)),
            sigma=float(np.sqrt(np.trace(spread) / 2.0)),
            direct=True,
        ),
    )


def _odds(chance: float) -> str:
    return f"{chance:.1g}" if chance > 1e-9 else "below 1e-9"


def weigh_last(
    last: Coefficients,
    context: SkyContext,
    usual: Prior,
    solve: Callable[[Prior], MechanismSolution],
) -> tuple[Prior, tuple[Finding, ...]]:
    """The prior to use, and a finding where the points contradict the last coefficients.

    Parameters
    ----------
    last : what the unit held.
    usual : the prior without them: it takes their place where they are contradicted.
    solve : the fit by a prior.

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
    return usual, (
        Finding(
            kind="last_coefficients",
            subject="last coefficients",
            sentence="the last coefficients do not fit these points "
            f"(p = {_odds(chance)}): {name} is {held:+z.{decimals}f} by them and "
            f"{found:+z.{decimals}f} {unit} by the points; they were not used. "
            "Check that they are of this unit; if so, tower, references or gears have changed",
            number=found - held,
            sigma=float(sigmas[worst]),
            unit=unit,
            direct=True,
        ),
    )
