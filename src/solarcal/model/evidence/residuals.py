"""What is wrong when the points do not fit: the sentences behind the residual tests.

Only what direct evidence (clocks, counts, approach sides, read-outs) has not explained reaches
these tests. What the points cannot decide is reported as such, never found and never excluded.
"""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import NDArray

from solarcal.decimals import counted
from solarcal.model.degeneracy import degeneracies
from solarcal.model.evidence.read_outs import Loss, undo_losses
from solarcal.model.evidence.steps import steps
from solarcal.model.f_tests import PointsTested
from solarcal.model.finding import Finding, Kind, listed
from solarcal.model.fit import FEWEST_POINTS as LINEAR_FEWEST
from solarcal.model.fit import fit_linear
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit_exact
from solarcal.model.parameter_checks import correlation_text
from solarcal.model.prior import Prior
from solarcal.model.residual_tests import BadPoint, Cause, ResidualTests, run_residual_tests
from solarcal.model.sky_context import SkyContext, true_points
from solarcal.model.solution import Solution
from solarcal.model.terms import CONTROLLER_TERMS, TERMS, LookedFor
from solarcal.mount.mechanism import Mechanism
from solarcal.stopping_rule import TOLERANCE_DEG
from solarcal.units import wrap_deg

CROSS_AXIS: set[Kind] = {"collimation", "nonperpendicularity"}
"""Hardly any day separates them."""
NEGLIGIBLE_SHARE = 0.1
"""An effect below this part of the tolerance, added to it in squares, is half a percent of it."""
FEWEST_POINTS = 5


def diagnose(
    solution: MechanismSolution,
    approach: NDArray[np.int_] | None = None,
    *,
    losses: Sequence[Loss] = (),
    tolerance_deg: float = TOLERANCE_DEG,
) -> tuple[Finding, ...]:
    """Findings from the residuals, the certain ones first.

    Parameters
    ----------
    solution : a ``robust`` or ``exact`` fit.
    approach : (n, 2), sense of the last motion of each axis at the fitted points, +1, -1, 0
        unknown.
    losses : counts known to have been missed: undone before anything is tested.
    tolerance_deg : against which an effect matters or does not.
    """
    if losses:
        points, _ = undo_losses(solution.points, solution.context, solution.posterior.mean, losses)
        solution = fit_exact(
            points, solution.context, prior=solution.prior, use_prior=solution.method == "robust"
        )
    points = solution.points
    doubtful = degeneracies(solution)
    if len(points) < FEWEST_POINTS:
        return (_too_few(len(points)), *doubtful)
    outliers = set(solution.outliers)
    tested = PointsTested.of(points, solution.context, approach, solution.seen)
    rows = tested.rows(solution.posterior.mean, {})
    tests = run_residual_tests(
        tested,
        rows,
        solution.posterior.mean,
        solution.prior,
        suspects=[i for i, label in enumerate(points.labels) if label in outliers],
        noise_deg=solution.noise_deg,
    )
    stepped = steps(solution, rows, tolerance_deg)
    return (
        *stepped,
        *(() if stepped else _unknown(tests.unnatural, tolerance_deg)),
        *(_cause(cause, tolerance_deg) for cause in tests.causes),
        *(_bad_point(bad, solution) for bad in tests.bad),
        *_undecided(tests),
        *doubtful,
    )


MOST_TESTED = 500
"""Points the residual tests look at: a division of a night into two is a fit of its own."""


def thinned(solution: Solution, context: SkyContext, prior: Prior) -> MechanismSolution:
    """A robust fit of evenly spread points of a large file, for the tests."""
    n = len(solution.points)
    chosen = np.linspace(0, n - 1, MOST_TESTED).astype(np.intp)
    return fit_exact(solution.points.subset(chosen.tolist()), context, prior=prior)


def thinning(points: int) -> Finding:
    """Says that not all points were tested."""
    return Finding(
        kind="unmodelled",
        subject="residuals",
        sentence=f"the residual tests looked at {MOST_TESTED} of {points} points, evenly spread; "
        "single bad points among the others are not determinable",
        certainty="not_determinable",
    )


NOT_TESTED = Finding(
    kind="unmodelled",
    subject="residuals",
    sentence="causes of the residuals are not determinable from these points: they are not of one "
    "tracker on the Sun",
    certainty="not_determinable",
)


def solution_to_test(
    solution: Solution, context: SkyContext, prior: Prior = DEFAULT_PRIOR
) -> MechanismSolution:
    """The solution the residual tests look at: the fit itself where it is of a mechanism.

    A ``linear`` fit is checked by the linear model: its own residuals are put on the mechanism of
    its six numbers, so that what the formula cannot follow is no misfit of points that follow it.
    """
    if isinstance(solution, MechanismSolution):
        return solution
    points = solution.points
    if solution.terms != CONTROLLER_TERMS or len(points) < LINEAR_FEWEST:
        return fit_exact(points, context, prior=prior)
    seen = true_points(points, context)
    there = points.replace(
        ax1_deg=seen.ax1_deg,
        ax2_deg=seen.ax2_deg,
        err1_deg=seen.err1_deg,
        err2_deg=seen.err2_deg,
    )
    # With the air and the better Sun taken out, as every fit of a mechanism has them.
    linear = fit_linear(there)
    exact1, exact2 = Mechanism.of(linear.values).errors_deg(
        points.geometry, there.ax1_deg, there.ax2_deg
    )
    return fit_exact(
        there.replace(
            err1_deg=wrap_deg(exact1 + linear.residual1_deg),
            err2_deg=np.clip(exact2 + linear.residual2_deg, -180.0, 180.0),
        ),
        msgspec.structs.replace(context, ideal="apparent"),
        prior=prior,
    )


def _too_few(n: int) -> Finding:
    return Finding(
        kind="unmodelled",
        subject="residuals",
        sentence="collimation, axes not square, gravity sag and bad points are not determinable "
        f"from these points: {counted(n, 'point')} beside six parameters, too little redundancy",
        certainty="not_determinable",
    )


def _looked_for(name: str) -> LookedFor:
    tested = TERMS[name].tested
    assert tested is not None
    return tested


def _times(name: str) -> str:
    """The unit of an amount, as a sentence has it."""
    unit = TERMS[name].unit
    return "times the standard air" if unit == "standard air" else unit


def _amount(name: str, value: float, sigma: float) -> str:
    decimals = 3 if TERMS[name].unit == "deg" else 2
    return f"{value:+z.{decimals}f} +- {sigma:.{decimals}f} {_times(name)}"


def _cause(cause: Cause, tolerance_deg: float) -> Finding:
    causes = (cause.name, *cause.rivals)
    effect = float(np.sqrt(max(cause.without_deg**2 - cause.leaves_deg[0] ** 2, 0.0)))
    kinds = tuple(_looked_for(c).finding for c in causes)
    cross = set(kinds) <= CROSS_AXIS
    kind: Kind = kinds[0]
    axis = _looked_for(cause.name).both_sides_of
    if cause.rivals:
        kind = "cross_axis" if cross else "unmodelled"
    amount = _amount(cause.name, cause.value, cause.sigma)
    sigmas = abs(cause.value) / cause.sigma
    names = [TERMS[c].meaning for c in causes]
    name = subject = names[0]
    largest = max(*cause.leaves_deg, cause.without_deg)
    leaves = [
        f"{called} would leave {_small(rms, largest)}"
        for called, rms in zip(names, cause.leaves_deg, strict=True)
    ]
    against = f"against {_small(cause.without_deg, largest)} with the six numbers"
    if cause.rivals:
        subject = "cross-axis term" if cross else listed(names, "or")
        r = cause.correlations[0]
        called = "a cross-axis term is missing" if cross else "something is missing in the model"
        sentence = (
            f"{called} ({sigmas:.1f} sigma): {listed(names)} cannot be separated with these "
            f"points (r = {correlation_text(r)}); {', '.join(leaves)} {against}"
        )
    elif axis is not None:
        subject = f"axis {axis}"
        sentence = (
            f"backlash: axis {axis} reads {amount} more after a motion in the positive sense than "
            f"after one in the negative ({sigmas:.1f} sigma); come from the same side every time"
        )
    else:
        what = f"a cross-axis term: {name}" if cross else name
        sentence = f"{what} of {amount} ({sigmas:.1f} sigma): {leaves[0]} {against}"
    if effect < NEGLIGIBLE_SHARE * tolerance_deg:
        sentence += (
            f"; it makes {_small(effect)} of pointing and does not matter against "
            f"{tolerance_deg:g} deg"
        )
    elif axis is None:
        sentence += "; P1..P6 cannot hold it"
    return Finding(
        kind=kind,
        subject=subject,
        sentence=sentence,
        number=cause.value,
        sigma=cause.sigma,
        unit=TERMS[cause.name].unit,
        causes=kinds,
        leaves_deg=cause.leaves_deg,
        effect_deg=effect,
    )


def _unknown(best: Cause | None, tolerance_deg: float) -> tuple[Finding, ...]:
    """What is left asks for a cause, and the best known one would be more of it than there is."""
    if best is None:
        return ()
    effect = float(np.sqrt(max(best.without_deg**2 - best.leaves_deg[0] ** 2, 0.0)))
    if effect < NEGLIGIBLE_SHARE * tolerance_deg:
        return ()
    amount = _amount(best.name, best.value, best.sigma)
    return (
        Finding(
            kind="unmodelled",
            subject="residuals",
            sentence="the residuals have a pattern of unknown cause (p = "
            f"{best.probability:.1g}): {TERMS[best.name].meaning} of {amount} would explain it "
            "best, and there is not so much of it; check what slips, bends or was moved during "
            "the day",
            effect_deg=effect,
        ),
    )


def _small(angle_deg: float, beside_deg: float = 0.0) -> str:
    """In arcseconds where it is small, and not said beside an angle in degrees."""
    if max(angle_deg, beside_deg) >= 0.02:
        return f"{angle_deg:.3f} deg"
    return f"{angle_deg * 3600.0:.1f} arcsec"


def _bad_point(bad: BadPoint, solution: MechanismSolution) -> Finding:
    label = solution.points.labels[bad.index]
    change = np.einsum("k,kag->ag", bad.step, solution.year.sky_slopes)
    moved = float(np.sqrt(np.mean(np.sum(change**2, axis=0))))
    without = _small(bad.rms_without_deg, bad.rms_with_deg)
    return Finding(
        kind="bad_point",
        subject=f"point {label}",
        sentence=(
            f"point {label} differs by {_small(bad.sky_deg)} from what the others predict "
            f"({bad.sky_deg / bad.sigma_deg:.1f} sigma, studentised): without it the scatter falls "
            f"from {_small(bad.rms_with_deg)} to {without} and an unweighted fit changes by "
            f"{moved:.3f} deg rms over the year; check what happened there"
        ),
        number=bad.sky_deg,
        sigma=bad.sigma_deg,
        labels=(label,),
        effect_deg=float(np.sqrt(max(bad.rms_with_deg**2 - bad.rms_without_deg**2, 0.0))),
    )


def _undecided(tests: ResidualTests) -> list[Finding]:
    said = []
    for name, weakest in tests.weakest.items():
        tested = _looked_for(name)
        if weakest <= tested.worth_knowing:
            continue
        unit = _times(name)
        less = (
            f"less than {weakest:.2g} {unit} would not show"
            if weakest < 20.0 * tested.worth_knowing
            else "no likely amount would show"
        )
        said.append(
            Finding(
                kind=tested.finding,
                subject=TERMS[name].meaning,
                sentence=f"{TERMS[name].meaning} is not determinable from these points: {less}",
                certainty="not_determinable",
                number=weakest if np.isfinite(weakest) else None,
                unit=unit,
            )
        )
    return said
