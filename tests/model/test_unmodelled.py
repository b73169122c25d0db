"""What a day cannot exclude widens the posterior; the coefficients stay those of the fit."""

from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_up_trackers import JUNE, TRACKER, context_of, day_of, measured

from benchmarks.judgement_world import MOUNTS, Place, Tracker, exact_errors, sun_enu
from solarcal.errors import ConfigurationError
from solarcal.model.analysis import analyse
from solarcal.model.earlier_sessions import merge_sessions
from solarcal.model.forecast import forecast
from solarcal.model.methods import fit, fit_exact
from solarcal.model.sky_context import SkyContext
from solarcal.model.unmodelled import CROSS_AXIS, NAMES, components, sky_columns, widened
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.session.records import ClockSet
from solarcal.session.view import read_session, view_session
from solarcal.site import Site
from solarcal.station.analysing import analyse_session
from solarcal.station.uploading import offer_upload
from solarcal.stopping_rule import DEFAULT_UNMODELLED, UNSYNCHRONISED_S, StoppingRule, Unmodelled

SESSION = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"

NOTHING = Unmodelled(
    cross_axis_deg=1e-6, large_cross_axis_deg=1e-6, large_chance=0.0, sag_deg=1e-6, air=1e-6,
    clock_s=1e-6,
)  # fmt: skip


@pytest.mark.parametrize("mount", MOUNTS)
def test_what_each_amount_does_is_what_exact_rotations_say(mount):
    place = Place(mount, 45.0)
    context = SkyContext(Site(45.0, 0.0), MountGeometry(mount, 45.0))
    times = 1.782e9 + 3000.0 * np.arange(-4.0, 5.0)
    native, later = (place.native(sun_enu(45.0, times + wait)) for wait in (0.0, 1.0))
    ax1, ax2 = place.angles(native)
    values = np.array([0.3, 0.1, -0.2, 0.3, 0.001, -0.001])
    columns = sky_columns(values, context, ax1, ax2)
    plain = np.array(exact_errors(place, Tracker(values), native))
    weight = np.stack((np.sin(np.radians(ax2)), np.ones_like(ax2)))
    for name, amounts in (
        ("collimation", {"collimation_deg": 0.01}),
        ("squareness", {"squareness_deg": 0.01}),
    ):
        changed = np.array(exact_errors(place, Tracker(values, **amounts), native))
        effect = (changed - plain) / 0.01 * weight
        assert columns[NAMES.index(name)] == pytest.approx(effect, abs=0.02)
    moved = np.array(place.angles(later)) - np.stack((ax1, ax2))
    assert columns[NAMES.index("clock")] == pytest.approx(-moved * weight, abs=1e-4)


def test_with_nothing_beside_the_six_numbers_the_posterior_is_the_fit_s():
    context, points = day_of("azel", 9, JUNE)
    solution = fit_exact(points, context)
    wide = widened(solution, NOTHING)
    assert wide.mean[:6] == pytest.approx(solution.posterior.mean, abs=1e-6)
    assert wide.covariance[:6, :6] == pytest.approx(solution.posterior.covariance, rel=1e-3)


def test_amounts_and_numbers_are_those_of_one_least_squares_problem():
    """One noise scale and one width: the joint normal is that of eleven unknowns at once."""
    context, points = day_of("tiltroll-ns", 10, JUNE)
    solution = fit_exact(points, context)
    spread = Unmodelled(cross_axis_deg=0.05, large_chance=0.0, sag_deg=0.03, air=0.1, clock_s=3.0)
    wide = widened(solution, spread)
    posterior = solution.posterior
    columns = sky_columns(posterior.mean, context, points.ax1_deg, points.ax2_deg)
    rows = np.concatenate(
        (
            solution.slopes.reshape(-1, 6),
            np.transpose(columns, (2, 1, 0)).reshape(-1, len(NAMES)),
        ),
        axis=1,
    )
    q = int(np.argmax(posterior.weights))
    weights = np.repeat(posterior.point_weights[q], 2)
    information = rows.T @ (weights[:, np.newaxis] * rows)
    prior = np.linalg.inv(posterior.covariances[q]) - information[:6, :6]
    information[:6, :6] += prior
    information[6:, 6:] += np.diag(components(spread)[0][1] ** -2.0)
    same = np.argmin(np.abs(wide.noise_deg - posterior.noise_deg[q]))
    candidates = [
        wide.covariances[i]
        for i in np.flatnonzero(np.isclose(wide.noise_deg, wide.noise_deg[same]))
    ]
    expected = np.linalg.inv(information)
    assert any(np.allclose(found, expected, rtol=1e-4, atol=1e-10) for found in candidates)


def test_more_that_cannot_be_excluded_makes_less_sure_and_changes_no_coefficient():
    context, points = day_of("azel", 9, JUNE)
    solution = fit(points, context)
    sure = [
        forecast(solution, rule=StoppingRule(unmodelled=beside)).probability_within_tolerance
        for beside in (NOTHING, Unmodelled(), Unmodelled(clock_s=20.0))
    ]
    assert sure[0] >= sure[1] > sure[2]
    assert sure[2] < 0.95


def test_a_plan_promises_no_more_than_what_is_beside_the_six_numbers_leaves():
    """More points of the day remove none of a sag of two tenths that P1..P6 cannot hold."""
    context, points = day_of("azel", 20, JUNE)
    ends = []
    for beside in (NOTHING, Unmodelled(sag_deg=0.2, cross_axis_deg=0.2)):
        planned = analyse(
            points.subset(range(6)),
            context,
            at_utc_s=float(points.utc_s[6]),
            rule=StoppingRule(unmodelled=beside),
        ).plan
        ends.append(planned.stops[-1])
    assert ends[0].year_p95_deg < 0.1 < ends[1].year_p95_deg
    assert ends[1].probability < 0.5 < ends[0].probability


def test_a_day_that_shows_collimation_moves_the_posterior_there():
    context = context_of("azel")
    _, points = day_of("azel", 20, JUNE)
    askew = Mechanism(
        TRACKER.P1, TRACKER.P2, TRACKER.P3, TRACKER.P4, TRACKER.P5, TRACKER.P6,
        collimation_deg=0.3,
    )  # fmt: skip
    seen = measured(context, askew, points.utc_s, np.random.default_rng(5), 0.01)
    wide = widened(fit_exact(seen, context), Unmodelled())
    sigma = np.sqrt(wide.covariance[6, 6])
    # The rest goes to axes not square: one day hardly tells them apart.
    assert wide.mean[6] > 0.03
    assert abs(wide.mean[6] - 0.3) < 4.0 * sigma


SAID = "not excluded: collimation above 0.1 deg ("


def test_what_a_large_collimation_would_make_of_done_is_said_where_it_cannot_be_excluded():
    """Counted among other draws, at every moment of the year's grid."""
    session = read_session(SESSION.with_name("ns-tiltroll-two-days.jsonl"))
    analysis = analyse_session(session)
    assert analysis.verdict.state == "done"
    expected = analysis.forecast
    other = expected.posterior.samples(4096, seed=99)
    away = replace(expected.errors, away=other - expected.posterior.mean)
    within = np.concatenate(
        [
            np.mean(np.hypot(*np.swapaxes(away.of(slice(k, k + 64)), 0, 1)) <= 0.1, axis=1) >= 0.95
            for k in range(0, len(other), 64)
        ]
    )
    large = np.abs(other[:, 6]) > 0.1
    found = expected.large_cross_axis[0]
    assert found.what == "collimation"
    assert found.share == pytest.approx(np.mean(large), abs=0.01)
    assert found.within == pytest.approx(np.mean(within[large]), abs=0.2)
    assert found.within < expected.probability_within_tolerance - 0.2
    (sentence,) = (reason for reason in analysis.verdict.reasons if reason.startswith(SAID))
    assert f"({100 * found.share:.0f} %)" in sentence
    assert sentence.endswith(f"about {round(10 * found.within)}0 % sure")


def test_axes_that_are_not_square_are_named_for_themselves_on_a_polar_mount():
    """A large collimation, which is likelier there and does no harm, does not hide them."""
    context, points = day_of("polar", 20, JUNE, noise_deg=0.01)
    analysis = analyse(points, context)
    (square,) = [one for one in analysis.forecast.large_cross_axis if one.what != "collimation"]
    assert square.share >= 0.01
    assert square.within < 0.5
    said = [reason for reason in analysis.verdict.reasons if reason.startswith("not excluded: ")]
    assert analysis.verdict.state == "done"
    assert said == [
        f"not excluded: axes not square above 0.1 deg ({100 * square.share:.0f} %); with it only "
        f"about {round(10 * square.within)}0 % sure"
    ]


def test_nothing_is_said_of_a_large_collimation_that_the_points_exclude_or_nobody_expects():
    clear = analyse_session(read_session(SESSION))
    context, points = day_of("tiltroll-ns", 14, JUNE)
    rule = StoppingRule(unmodelled=Unmodelled(large_chance=0.0))
    nobody = analyse(points, context, rule=rule)
    for analysis in (clear, nobody):
        assert analysis.verdict.state == "done"
        assert not any("not excluded" in reason for reason in analysis.verdict.reasons)


def test_sessions_between_which_something_moved_are_widened_too():
    context, first = day_of("azel", 8, JUNE)
    moved = Mechanism(TRACKER.P1, 0.6, TRACKER.P3, TRACKER.P4, TRACKER.P5, TRACKER.P6)
    _, second = day_of("azel", 9, JUNE + 20, mechanism=moved, seed=2)
    merged = merge_sessions([first, second], context)
    assert merged.findings
    whole = analyse(
        merged.solution.points,
        context,
        at_utc_s=float(second.utc_s[-1]) - 9000.0,
        solution=merged.solution,
    )
    wide = widened(merged.solution, Unmodelled())
    assert 0.0 <= whole.forecast.probability_within_tolerance <= 1.0
    assert (np.linalg.eigvalsh(wide.covariance[:6, :6]) > 0.0).all()
    assert (np.diag(wide.covariance)[:6] >= 0.999 * np.diag(merged.solution.posterior.covariance)
            ).sum() >= 4  # fmt: skip


def test_the_cross_axis_columns_are_collimation_and_squareness():
    """Behind P1..P6: no sag is counted as a large collimation."""
    assert (*COEFFICIENT_NAMES, *NAMES)[CROSS_AXIS] == ("collimation", "squareness")


def test_collimation_may_be_likelier_than_axes_that_are_not_square():
    apart = components(Unmodelled(large_chance=0.1, large_collimation_chance=0.3))
    assert [(chance, *np.flatnonzero(sigmas == 0.2)) for chance, sigmas in apart] == [
        (pytest.approx(0.6),), (0.3, NAMES.index("collimation")), (0.1, NAMES.index("squareness")),
    ]  # fmt: skip
    one = components(Unmodelled(large_chance=0.1))
    assert [chance for chance, _ in one] == [pytest.approx(0.8), 0.1, 0.1]


def test_a_chance_that_is_named_alone_is_that_of_both():
    assert DEFAULT_UNMODELLED.large_chances == (0.48, 0.05)
    assert DEFAULT_UNMODELLED.changed({"large_chance": 0.0}).large_chances == (0.0, 0.0)
    both = {"large_chance": 0.1, "large_collimation_chance": 0.2}
    assert DEFAULT_UNMODELLED.changed(both).large_chances == (0.2, 0.1)
    assert DEFAULT_UNMODELLED.changed({"clock_s": 9.0}).large_chances == (0.48, 0.05)


def test_a_session_is_judged_by_the_chances_of_its_own_time():
    """Older versions recorded one chance, or none: 5 % of either."""
    header = read_session(SESSION).header
    recorded = msgspec.json.encode({"large_chance": 0.05, "cross_axis_deg": 0.02})
    for old in (None, msgspec.json.decode(recorded, type=Unmodelled)):
        rule = msgspec.structs.replace(header, unmodelled=old).rule
        assert rule.unmodelled.large_chances == (0.05, 0.05)


def test_sigmas_that_cannot_be_are_refused():
    with pytest.raises(ConfigurationError, match="above zero"):
        Unmodelled(sag_deg=0.0)
    with pytest.raises(ConfigurationError, match="chance"):
        Unmodelled(large_chance=0.7)
    with pytest.raises(ConfigurationError, match="large_collimation_chance"):
        Unmodelled(large_collimation_chance=0.5)
    with pytest.raises(ConfigurationError, match="bend is none of cross_axis_deg, "):
        Unmodelled().changed({"bend": 0.1})


def test_all_forecasts_of_an_analysis_hold_the_same_clock():
    """What the unit would hold after rounding, and what it holds now, are judged by one rule."""
    saved = read_session(SESSION)
    beside = Unmodelled(clock_s=20.0)
    header = msgspec.structs.replace(saved.header, unmodelled=beside)
    analysis = analyse_session(view_session(header, saved.records))
    assert analysis is not None
    offer = offer_upload(analysis, header.unit, (header.coefficients, header.offsets))
    year = analysis.forecast
    assert year.rule.unmodelled == beside
    assert offer.kept.year_p95_deg == pytest.approx(year.year_p95_deg, rel=1e-3)
    assert abs(offer.kept.probability_within_tolerance - year.probability_within_tolerance) < 0.01
    assert offer.held is not None
    assert offer.held.rule == year.rule


def test_a_laptop_that_nothing_synchronises_widens_the_bands_and_is_told_so():
    saved = read_session(SESSION)
    header = msgspec.structs.replace(saved.header, unmodelled=Unmodelled(clock_s=UNSYNCHRONISED_S))
    before, after = (
        analyse_session(view_session(one, saved.records)) for one in (saved.header, header)
    )
    assert before is not None
    assert after is not None
    assert after.forecast.year_p95_deg > 1.02 * before.forecast.year_p95_deg
    told = [f.sentence for f in after.findings if f.kind == "laptop_clock"]
    assert "uncertainty is 5 s" in told[0]


@pytest.mark.parametrize("sigma_s", [None, 20.0])
def test_the_clock_is_known_as_well_as_the_time_signal_it_was_compared_with(sigma_s):
    saved = read_session(SESSION)
    records = [
        msgspec.structs.replace(record, tick_minus_laptop_s=0.0, tick_sigma_s=sigma_s)
        if isinstance(record, ClockSet)
        else record
        for record in saved.records
    ]
    analysis = analyse_session(view_session(saved.header, records))
    assert analysis is not None
    probability = analysis.forecast.probability_within_tolerance
    if sigma_s is None:
        assert probability > 0.9
    else:
        # 24 s are the tolerance of 0.1 deg: beyond 1.2 sigma a clock this bad spoils the year.
        assert 0.6 < probability < 0.8
        assert analysis.verdict.state != "done"
