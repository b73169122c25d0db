"""What the residuals, the branch and the coefficients in force say reaches the verdict."""

import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_up_trackers import JUNE, day_of
from test_time_stamps import day

from solarcal.errors import ProcedureRefused
from solarcal.model.analysis import analyse
from solarcal.model.evidence.branch import side_evidence
from solarcal.model.evidence.direct import Evidence, direct_findings, weigh
from solarcal.model.finding import listed, points_named
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.mount.controller import ideal_and_elevation_deg
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.session.interchange import imported_header
from solarcal.session.view import read_session, view_session
from solarcal.site import Site
from solarcal.station.fitting import point_set, sky_context
from solarcal.station.uploading import offer_upload, refuse_doubtful
from solarcal.timescale import parse_utc

SAVED = Path(__file__).parents[2] / "sessions"


@pytest.fixture(scope="module")
def good_day():
    return read_session(SAVED / "azel-good-day.jsonl")


def found(analysis, kind):
    return [f for f in analysis.findings if f.kind == kind and f.certainty == "found"]


# -- a step ----------------------------------------------------------------------------------------


# An azimuth that jumps at noon looks like a scale: there axis 1 is not determinable.
@pytest.mark.parametrize(
    ("axis", "first"),
    [("err1_deg", 4), ("err1_deg", 8), ("err2_deg", 4), ("err2_deg", 6), ("err2_deg", 8)],
)
def test_a_step_between_two_runs_is_named_where_it_is(axis, first):
    context, points = day_of("azel", 12, noise_deg=0.02)
    moved = getattr(points, axis).copy()
    moved[first:] += 1.0
    analysis = analyse(points.replace(**{axis: moved}), context)
    (step,) = found(analysis, "step")
    before, after = points.labels[first - 1], points.labels[first]
    assert f"between points {before} and {after}" in step.sentence
    said = re.search(r"axis 1 reads (\S+) deg and axis 2 (\S+) deg otherwise", step.sentence)
    assert said is not None
    truth = (1.0, 0.0) if axis == "err1_deg" else (0.0, 1.0)
    assert tuple(map(float, said.groups())) == pytest.approx(truth, abs=0.3)
    assert analysis.verdict.state == "does_not_fit"
    assert step.sentence in analysis.verdict.reasons


def test_clean_days_and_smooth_causes_have_no_step():
    for seed in range(6):
        context, points = day_of("azel", 12, noise_deg=0.02, seed=seed)
        assert found(analyse(points, context), "step") == []
        bent = points.replace(err1_deg=points.err1_deg + 0.2 / np.sin(np.radians(points.ax2_deg)))
        assert found(analyse(bent, context), "step") == []


@pytest.mark.parametrize("moved", [slice(0, 2), slice(10, 12)])
@pytest.mark.parametrize("axis", ["err1_deg", "err2_deg"])
def test_two_points_at_an_end_are_no_run(axis, moved):
    """They contradict the others, but do not show on which side of a step the truth is."""
    context, points = day_of("azel", 12, noise_deg=0.02)
    errors = getattr(points, axis).copy()
    errors[moved] += 1.0
    for step in found(analyse(points.replace(**{axis: errors}), context), "step"):
        assert f"between points {points.labels[1]} and " not in step.sentence
        assert f"and {points.labels[10]}: " not in step.sentence


def test_one_bad_point_is_no_step():
    context, points = day_of("azel", 12, noise_deg=0.02)
    bad = points.err2_deg.copy()
    bad[5] += 1.0
    assert found(analyse(points.replace(err2_deg=bad), context), "step") == []


# -- named causes ----------------------------------------------------------------------------------


def test_a_named_cross_axis_term_keeps_the_verdict_from_done():
    context, points = day_of("azel", 16, noise_deg=0.01)
    assert analyse(points, context).verdict.state == "done"
    bent = points.replace(err1_deg=points.err1_deg + 0.3 / np.sin(np.radians(points.ax2_deg)))
    analysis = analyse(bent, context)
    named = found(analysis, "collimation") + found(analysis, "cross_axis")
    assert named
    assert analysis.verdict.state != "done"
    assert named[0].sentence in analysis.verdict.reasons


# -- the linear fit --------------------------------------------------------------------------------


def test_a_linear_fit_of_the_formulas_own_data_has_nothing_to_explain():
    context, points = day_of("azel", 14, noise_deg=0.02)
    e1, e2 = correction_deg(
        Coefficients(2.5, -0.4, 1.5, 0.3, 0.001, -0.0005), points.ax1_deg, points.ax2_deg
    )
    noise = np.random.default_rng(4).normal(0.0, 0.01, (2, len(points)))
    formula = points.replace(err1_deg=e1 + noise[0], err2_deg=e2 + noise[1])
    plain = replace_kind(context)
    linear = analyse(formula, plain, method="linear")
    assert [f.sentence for f in linear.findings if f.certainty == "found"] == []
    # The exact mechanism is another one: there the same data do not fit.
    assert [f for f in analyse(formula, plain).findings if f.certainty == "found"]


def replace_kind(context):
    from msgspec.structs import replace as changed

    return changed(context, ideal="apparent")


# -- two branches ----------------------------------------------------------------------------------


def test_points_on_both_sides_of_the_branch_are_two_calibrations():
    table = day(n=10)
    ax1 = np.where(np.arange(10) < 6, 150.0 + 5.0 * np.arange(10), -175.0 + 5.0 * np.arange(10))
    crossing = replace(table, ax1_deg=ax1, utc_s=table.utc_s)
    (finding,) = side_evidence(crossing, sky_context(crossing))
    assert finding.labels == (7, 8, 9, 10)
    assert "two calibrations" in finding.sentence
    assert weigh([finding], set(table.labels), 0.1).waiting == (finding.sentence,)
    one_side = replace(crossing, status=("accepted",) * 6 + ("rejected",) * 4)
    assert side_evidence(one_side, sky_context(one_side)) == ()


def side_of_the_few(ax1_deg: np.ndarray) -> tuple[int, ...]:
    """Labels of the points that are beyond the end of the branch, of a day begun at midnight."""
    times = np.arange(len(ax1_deg)) * 5760.0
    table = replace(day(n=len(ax1_deg)), utc_s=times, ax1_deg=ax1_deg)
    return tuple(
        label for finding in side_evidence(table, sky_context(table)) for label in finding.labels
    )


def test_on_a_polar_day_the_points_before_the_jump_are_the_odd_ones():
    round_the_clock = np.array([-179.4, *np.linspace(158.1, -179.1, 15)])
    assert side_of_the_few(round_the_clock) == (1,)
    again = np.array([*round_the_clock, *np.linspace(157.9, -178.8, 15)])
    assert side_of_the_few(again) == (1,)


def test_days_that_cross_the_end_at_noon_have_the_same_two_sides():
    noon_in_the_north = np.array([100.0, 130.0, 170.0, -170.0, -120.0])
    assert side_of_the_few(np.tile(noon_in_the_north, 2)) == (4, 5, 9, 10)


@pytest.mark.parametrize("latitude_deg", [5.0, 45.0])
def test_a_morning_and_the_afternoon_of_another_day_are_on_both_sides(latitude_deg: float):
    """June: the Sun passes north of the zenith at 5 N, and at 45 N to the south of it."""
    one = day(n=6)
    context = SkyContext(Site(latitude_deg, 0.0), MountGeometry("azel", latitude_deg))
    noon_s = parse_utc("2026-06-10T12:00:00Z")
    hours = np.array([2.5, 3.0, 3.5, 19.0, 19.5, 20.0])
    ax1, _, _ = ideal_and_elevation_deg(context.geometry, context.site, noon_s + 3600.0 * hours)
    table = replace(one, utc_s=noon_s + 3600.0 * hours, ax1_deg=np.asarray(ax1))
    sides = [finding.labels for finding in side_evidence(table, context)]
    assert sides == ([(4, 5, 6)] if latitude_deg == 5.0 else [])


def test_points_that_are_too_low_to_be_fitted_are_on_no_side():
    table = day(n=10)
    # Hours later, below the horizon and across the end of the branch.
    nights = replace(
        table,
        utc_s=np.append(table.utc_s[:8], table.utc_s[7] + 3600.0 * np.array([8.0, 9.0])),
        ax1_deg=np.append(table.ax1_deg[:8], [-170.0, 170.0]),
        ax2_deg=np.append(table.ax2_deg[:8], [105.0, 105.0]),
    )
    context = sky_context(nights)
    findings = analyse(point_set(nights), context, Evidence(nights)).findings
    assert [f for f in findings if f.kind == "branch"] == []
    (one_beyond,) = side_evidence(nights, sky_context(nights))
    assert one_beyond.labels
    assert re.match(r"point \d+ lies beyond", one_beyond.sentence)


def test_a_read_out_frozen_at_points_too_low_to_be_fitted_is_no_reason(good_day):
    first, *others = good_day.accepted
    still = [
        msgspec.structs.replace(first, reading_deg=(1.0, 1.0), ideal_deg=(ax1, 100.0))
        for ax1 in (-150.0, -140.0)
    ]
    records = tuple(r for r in good_day.records if r.seq < first.seq)
    low = view_session(good_day.header, (*records, *still, *others))
    assert [f.kind for f in direct_findings(low) if f.kind == "frozen"] == ["frozen"]
    used = {(p.seq, p.ideal_deg[1]) for p in others}
    assert [f for f in direct_findings(low, used=used) if f.kind in ("frozen", "offsets")] == []


# -- in force and proposed -------------------------------------------------------------------------


def test_an_upload_must_be_better_than_what_is_in_force():
    table = day(n=10)
    analysis = analyse(point_set(table), sky_context(table))
    unit = imported_header(table, 0.0).unit
    from_zero = offer_upload(analysis, unit, (Coefficients(), Offsets()))
    assert from_zero.better > 0.95
    assert refuse_doubtful(from_zero, None) == ""
    # The very numbers the unit holds change nothing: no reason is asked for.
    held = from_zero.rounded
    assert offer_upload(analysis, unit, (held, Offsets())).against == ()
    nearly = msgspec.structs.replace(held, P1=held.P1 + 1e-4)
    again = offer_upload(analysis, unit, (nearly, Offsets()))
    assert again.better < 0.95
    with pytest.raises(ProcedureRefused, match="no improvement beyond its uncertainty"):
        refuse_doubtful(again, None)
    assert f"better with a probability of {100.0 * again.better:.0f} %" in again.against[0]
    assert f"{again.held.year_p95_deg:.3f} deg with the P and O it holds now" in again.against[0]
    assert refuse_doubtful(again, "the owner asked for it") == "the owner asked for it"


def test_names_are_listed_as_one_says_them():
    assert listed(("a",)) == "a"
    assert listed(("a", "b")) == "a and b"
    assert listed(("a", "b", "c"), "or") == "a, b or c"
    assert points_named((3,)) == "point 3"
    assert points_named((3, 4)) == "points 3 and 4"
    assert points_named((1, 2, 3, 4, 5, 6)) == "points 1, 2, 3, 4, 5 and 6"
    assert points_named(tuple(range(1, 12))) == "points 1, 2, 3, 4, 5, 6 and 5 more"


@pytest.mark.parametrize("seed", range(1, 7))
def test_what_moved_between_two_visits_is_said_to_have_moved_there(seed: int) -> None:
    """A zero that is a tenth of a degree elsewhere on the second day: divisions of the first day
    explain nearly as much, and are named beside it."""
    context, first = day_of("azel", 12, JUNE, noise_deg=0.02, seed=seed)
    _, second = day_of("azel", 6, JUNE + 20, noise_deg=0.02, seed=seed + 50)
    moved = second.replace(err1_deg=second.err1_deg + 0.15)
    both = Points.joined([first, moved])
    points = replace(both, labels=tuple(range(1, 19)))
    (step,) = found(analyse(points, context), "step")
    assert step.subject == "points 12 and 13"
    assert "moved between the visits: keep the later run" in step.sentence
    assert step.labels == tuple(range(13, 19))


@pytest.mark.parametrize("scale", [1.5, 2.0])
def test_backlash_where_the_side_changes_is_no_step(scale: float) -> None:
    """In the afternoon axis 2 comes from the other side, and reads otherwise from there on."""
    context, points = day_of("azel", 13, JUNE, noise_deg=0.02, seed=3)
    rising = np.gradient(points.ax2_deg) < 0
    bent = points.replace(err2_deg=points.err2_deg + np.where(rising, -0.08, 0.08) * scale)
    sides = np.stack((np.ones(13, dtype=int), np.where(rising, -1, 1)), axis=-1)

    class Sides(Evidence):
        def approach(self, labels):
            return sides

    analysis = analyse(bent, context, Sides())
    assert found(analysis, "step") == []
    assert [f.subject for f in found(analysis, "backlash")] == ["axis 2"]
    assert found(analyse(bent, context), "step") != []
