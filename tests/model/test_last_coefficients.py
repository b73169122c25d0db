"""The unit's last coefficients as prior: they save points, and give way where they are wrong."""

import numpy as np
import pytest
from made_up_trackers import day_of

from solarcal.model.earlier_sessions import last_prior, weigh_last
from solarcal.model.finding import Finding
from solarcal.model.forecast import forecast
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_PRIOR, fit_exact
from solarcal.model.points import Points
from solarcal.model.prior import PLAIN, SINCE_LAST, Prior
from solarcal.model.sky_context import SkyContext
from solarcal.model.year_grid import controller_coefficients, mechanism_of
from solarcal.mount.formula import Coefficients

TRUTH = np.array([0.7, -0.5, 0.3, 1.2, 0.001, -0.0005])
A_YEAR = np.array([-0.1, 0.3, 0.08, -0.2, 0.0002, -0.0003])
"""How far the mechanism of the calibration before was from today's."""


def held(context: SkyContext, mechanism: np.ndarray) -> Coefficients:
    """What a calibration of that mechanism would have loaded."""
    return Coefficients(*controller_coefficients(mechanism, context, Prior()).tolist())


def fitted(
    points: Points, context: SkyContext, last: Coefficients
) -> tuple[MechanismSolution, tuple[Finding, ...]]:
    prior, findings = weigh_last(
        last, context, DEFAULT_PRIOR, lambda one: fit_exact(points, context, prior=one)
    )
    return fit_exact(points, context, prior=prior), findings


@pytest.mark.parametrize("ideal", ["apparent", "airless", "solartrak"])
@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
def test_the_mechanism_is_the_one_whose_coefficients_they_are(geometry, ideal):
    context, _ = day_of(geometry, 1, ideal=ideal)
    assert mechanism_of(held(context, TRUTH), context) == pytest.approx(TRUTH, abs=1e-9)


def test_without_them_and_with_impossible_ones_the_numbers_are_finite():
    context, _ = day_of("azel", 1)
    for values in ((0.0,) * 6, (10.0, 30.0, -10.0, 30.0, 0.05, -0.05)):
        assert np.isfinite(mechanism_of(Coefficients(*values), context)).all()


@pytest.mark.parametrize("geometry", ["azel", "tiltroll-ew", "tiltroll-ns", "polar"])
def test_near_the_truth_fewer_points_reach_the_same_sigma(geometry):
    context, points = day_of(geometry, 12, ideal="solartrak")
    last = held(context, TRUTH + A_YEAR)
    blank_deg, informed_deg = [], []
    for k in (1, 2, 3, 4, 6, 9):
        part = points.subset(range(k))
        informed, findings = fitted(part, context, last)
        assert findings == ()
        assert informed.prior.last == last
        blank_deg.append(forecast(fit_exact(part, context), context).year_rms_deg)
        informed_deg.append(forecast(informed, context).year_rms_deg)
    assert (np.array(informed_deg) <= blank_deg).all()
    assert np.argmax(np.array(informed_deg) < 0.7) < np.argmax(np.array(blank_deg) < 0.7)


@pytest.mark.parametrize("n", [1, 2, 5, 12])
@pytest.mark.parametrize("away", [(4, 0, 0, 0, 0, 0), (0, 0, -4, 0, 0, 0), (3, -8, -3, 8, 0, 0)])
def test_far_from_the_truth_the_points_win_and_a_finding_reports_it(n, away):
    context, points = day_of("azel", n)
    solution, findings = fitted(points, context, held(context, TRUTH + np.array(away)))
    alone = fit_exact(points, context)
    assert solution.values.tolist() == alone.values.tolist()
    sigmas = np.sqrt(np.diag(solution.posterior.covariance))
    assert (np.abs(solution.posterior.mean - TRUTH) < 3.0 * sigmas).all()
    (finding,) = findings
    assert finding.kind == "last_coefficients"
    assert finding.sentence.startswith("the last coefficients do not fit these points (p = ")


def test_a_little_off_they_stay_and_the_truth_is_within_the_band():
    context, points = day_of("azel", 5)
    moved = np.array([0.5, -0.8, -0.4, 1.0, 0.0004, -0.0004])
    solution, findings = fitted(points, context, held(context, TRUTH + moved))
    assert findings == ()
    sigmas = np.sqrt(np.diag(solution.posterior.covariance))
    assert (np.abs(solution.posterior.mean - TRUTH) < 3.0 * sigmas).all()


def test_a_lean_read_today_counts_beside_them_by_its_sigma():
    context, _ = day_of("azel", 1)
    last = held(context, TRUTH)
    plain = last_prior(last, context, DEFAULT_PRIOR)
    assert (plain.sigmas, plain.widths) == (SINCE_LAST, PLAIN)
    read = last_prior(last, context, DEFAULT_PRIOR.with_inclinometer(0.0, 0.0, 0.3))
    assert read.means[0] == pytest.approx(0.35, abs=1e-6)
    assert read.sigmas[0] == pytest.approx(0.3 / np.sqrt(2.0))
    assert read.means[1] == plain.means[1]


def test_the_fit_reports_what_its_prior_was():
    context, points = day_of("azel", 5)
    last = held(context, TRUTH)
    solution, _ = fitted(points, context, last)
    (note,) = [note for note in solution.notes if note.startswith("prior: ")]
    assert note.startswith(f"prior: the unit's last coefficients {last.P1:+.4f} {last.P2:+.4f} ")
    assert solution.as_json()["prior"]["last"]["P1"] == last.P1
    blank = fit_exact(points, context)
    assert not any("prior:" in note for note in blank.notes)
    assert blank.as_json()["prior"]["last"] is None
    assert fit_exact(points, context, use_prior=False).as_json()["prior"] is None
