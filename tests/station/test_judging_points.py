"""A new point against the fit without it, and what an upload would change."""

import math
import re
from dataclasses import replace

import msgspec
import pytest
from emulated_station import emulated_station

from solarcal.errors import ProcedureRefused
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits
from solarcal.session.records import CheckRecord, PointRecord, Void
from solarcal.session.view import SessionView, view_session
from solarcal.station.analysing import analyse_session
from solarcal.station.curves import session_plot_data
from solarcal.station.fitting import solve
from solarcal.station.guards import GuardRefused
from solarcal.station.point_judgement import (
    counts_doubt,
    judge_check,
    judge_point,
    point_evidence,
    point_influence,
)
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.station.uploading import propose_upload, too_few_points


@pytest.fixture(scope="module")
def taken() -> SessionView:
    """Six points of one day, half an hour apart."""
    station, _ = emulated_station()
    emulation = station.tracker.emulation
    assert emulation is not None
    technician = AutomaticTechnician(station, emulation.spot, Schedule(points=6, every_min=45.0))
    station.initialise(confirmed=True)
    technician.take_points()
    return station.session


def without_last(session: SessionView) -> tuple[SessionView, PointRecord]:
    last = session.accepted[-1]
    kept = tuple(p for p in session.points if p.seq != last.seq)
    records = tuple(r for r in session.records if r.seq != last.seq)
    return replace(session, points=kept, records=records), last


def test_a_good_point_matches_the_prediction(taken: SessionView) -> None:
    session, last = without_last(taken)
    judged = judge_point(session, last)
    assert not judged.suspicious
    assert all(axis.sigmas is not None and abs(axis.sigmas) < 3.0 for axis in judged.axes)
    assert "Matches" in judged.sentence
    assert judged.axes[0].found_counts == pytest.approx(judged.axes[0].expected_counts, rel=0.02)


def test_missed_counts_do_not_match_and_the_axis_is_named(taken: SessionView) -> None:
    session, last = without_last(taken)
    assert last.error_deg is not None
    off = msgspec.structs.replace(last, error_deg=(last.error_deg[0], last.error_deg[1] + 1.0))
    judged = judge_point(session, off)
    assert judged.suspicious
    assert judged.sentence.startswith("Axis 2 does NOT match")


@pytest.mark.parametrize("axis", [0, 1])
def test_more_than_three_sigmas_from_the_prediction_is_doubted(
    taken: SessionView, axis: int
) -> None:
    session, last = without_last(taken)
    judged = judge_point(session, last).axes[axis]
    assert judged.sigmas is not None
    sigma_deg = judged.off_deg / judged.sigmas
    for sigmas, doubted in ((-3.2, True), (-2.8, False), (2.8, False), (3.2, True)):
        error = list(last.error_deg)
        error[axis] += (sigmas - judged.sigmas) * sigma_deg
        moved = judge_point(session, msgspec.structs.replace(last, error_deg=tuple(error)))
        assert moved.axes[axis].sigmas == pytest.approx(sigmas)
        assert moved.axes[axis].suspicious == moved.suspicious == doubted


@pytest.mark.parametrize("axis", [1, 2])
@pytest.mark.parametrize("sign", [1, -1])
def test_counts_that_make_no_sense_are_named_with_their_axis_and_degrees(
    taken: SessionView, axis: int, sign: int
) -> None:
    """A quarter of a degree on the sky is the least; the fit of five points knows it better."""
    session, last = without_last(taken)
    assert last.found_counts is not None
    assert last.ideal_deg is not None
    assert counts_doubt(session, last, "robust") == ""
    drive = (session.header.unit.drive1, session.header.unit.drive2)[axis - 1]
    assert isinstance(drive, RotaryDrive)
    on_sky = math.sin(math.radians(last.ideal_deg[1])) if axis == 1 else 1.0
    for sky_deg, doubted in ((0.15, False), (0.6, True)):
        lost = round(sign * sky_deg / on_sky * drive.counts_per_deg)
        found = list(last.found_counts)
        found[axis - 1] += lost
        doubt = counts_doubt(
            session, msgspec.structs.replace(last, found_counts=tuple(found)), "robust"
        )
        assert bool(doubt) == doubted, (sky_deg, doubt)
    assert doubt.startswith(f"axis {axis} moved {found[axis - 1]} counts since the last point")
    degrees = re.search(r"\(([+-][0-9.]+) deg\)", doubt)
    assert degrees is not None
    assert float(degrees[1]) == pytest.approx(sign * 0.6 / on_sky, abs=0.2)


def test_counts_are_doubted_from_the_fifth_point_on(taken: SessionView) -> None:
    session, last = without_last(taken)
    assert last.found_counts is not None
    wild = msgspec.structs.replace(last, found_counts=(last.found_counts[0] + 90_000, 0))
    assert counts_doubt(session, wild, "robust")
    four = replace(session, points=session.points[:-1])
    assert counts_doubt(four, wild, "robust") == ""
    for name in ("ideal_deg", "reading_deg", "expected_counts", "found_counts"):
        unread = msgspec.structs.replace(wild, **{name: None})
        assert counts_doubt(session, unread, "robust") == ""


def test_the_first_point_has_nothing_to_be_compared_with(taken: SessionView) -> None:
    empty = replace(taken, points=(), records=())
    judged = judge_point(empty, taken.accepted[0])
    assert not judged.suspicious
    assert "first point" in judged.sentence


def test_the_second_point_is_compared_with_the_first(taken: SessionView) -> None:
    first = taken.accepted[0]
    one = replace(
        taken, points=(first,), records=tuple(r for r in taken.records if r.seq <= first.seq)
    )
    judged = judge_point(one, taken.accepted[1])
    assert "last point only" in judged.sentence
    assert judged.axes[0].off_deg is not None


@pytest.mark.parametrize(("left_deg", "word"), [(0.04, "within"), (0.2, "BEYOND")])
def test_a_check_point_is_measured_against_the_tolerance(
    taken: SessionView, left_deg: float, word: str
) -> None:
    check = CheckRecord(
        seq=1,
        utc="2026-06-03T20:00:00.000Z",
        status="accepted",
        answers=taken.accepted[0].answers,
        sky_error_deg=left_deg,
    )
    assert word in judge_check(check, 0.1)


def test_an_upload_is_proposed_rounded_with_its_change_in_sigmas(taken: SessionView) -> None:
    proposal = propose_upload(taken, Coefficients(P2=0.1))
    assert proposal is not None
    assert proposal.rounded == proposal.judgement.solution.coefficients().rounded(4, 6)
    change = proposal.changes[1]
    assert (change.name, change.old) == ("P2", 0.1)
    assert change.sigma is not None
    assert change.sigmas == pytest.approx((change.new - 0.1) / change.sigma)


def test_too_few_points_propose_nothing_and_say_so(taken: SessionView) -> None:
    first = taken.accepted[0]
    one = replace(
        taken, points=(first,), records=tuple(r for r in taken.records if r.seq <= first.seq)
    )
    assert propose_upload(one, Coefficients()) is None
    assert too_few_points(one).startswith("1 accepted point:")


def test_absurd_coefficients_are_doubted(taken: SessionView) -> None:
    wide = Limits(AxisLimits(-180.0, 180.0), AxisLimits(0.0, 180.0))
    unit = msgspec.structs.replace(taken.header.unit, limits=wide)
    header = msgspec.structs.replace(taken.header, unit=unit)
    absurd = tuple(
        msgspec.structs.replace(
            r,
            basis="gathering",
            error_deg=(40.0, 20.0),
            reading_deg=(r.ideal_deg[0] + 40.0, r.ideal_deg[1] + 20.0),
            counts=None,
            offsets=Offsets(40.0, 20.0),
        )
        if isinstance(r, PointRecord) and r.ideal_deg is not None
        else r
        for r in taken.records
    )
    points = tuple(r for r in absurd if isinstance(r, PointRecord))
    session = replace(taken, header=header, records=absurd, points=points)
    proposal = propose_upload(session, Coefficients())
    assert proposal is not None
    assert any("unrealistic" in doubt for doubt in proposal.against)


def test_only_a_guard_may_be_overruled() -> None:
    """Near a limit or a low Sun: with a reason. A missing Initialise: by doing it."""
    station, _ = emulated_station("tijeras-azel", start="2026-06-04T01:48:00Z")
    with pytest.raises(ProcedureRefused) as refusal:
        station.begin_point()
    assert not isinstance(refusal.value, GuardRefused)
    station.initialise(confirmed=True, override_reason="a test")
    with pytest.raises(GuardRefused):
        station.begin_point()


def test_a_point_opened_shows_the_fit_with_and_without_it(taken: SessionView) -> None:
    last = taken.accepted[-1]
    influence = point_influence(taken, last)
    with_it, without = solve(taken), solve(without_last(taken)[0])
    assert with_it is not None
    assert without is not None
    assert influence.trouble == ""
    assert influence.with_it.solution.values == pytest.approx(with_it.values)
    assert influence.without.solution.values == pytest.approx(without.values)
    # One residual on all panes: the plot's, and the table's.
    data = session_plot_data(taken.header, taken.accepted, with_it)
    assert data.has_model
    assert not session_plot_data(taken.header, taken.accepted).has_model
    plotted = data.points
    assert influence.residual_deg == pytest.approx(
        (plotted.residual1_deg[-1], plotted.residual2_deg[-1]), abs=1e-12
    )
    off = [axis.off_deg for axis in influence.judged.axes]
    weight = math.sin(math.radians(last.ideal_deg[1]))
    left = math.hypot(weight * influence.residual_deg[0], influence.residual_deg[1])
    assert influence.leverage == pytest.approx(1.0 - left / math.hypot(weight * off[0], off[1]))
    assert influence.with_it.forecast.year_rms_deg == pytest.approx(
        analyse_session(taken).forecast.year_rms_deg
    )
    assert influence.without.forecast.year_rms_deg > influence.with_it.forecast.year_rms_deg


def test_a_point_that_is_not_fitted_has_no_residual(taken: SessionView) -> None:
    struck = taken.accepted[-1]
    void = Void(seq=taken.records[-1].seq + 1, utc=struck.utc, voids=struck.seq, reason="cloud")
    session = view_session(taken.header, (*taken.records, void))
    influence = point_influence(session, struck)
    assert influence.residual_deg is None
    assert influence.leverage is None
    # What it did to the fit stays what it was.
    before = point_influence(taken, struck)
    for now, then in ((influence.with_it, before.with_it), (influence.without, before.without)):
        assert now.solution.n_points == then.solution.n_points
        assert (now.solution.values == then.solution.values).all()
        assert now.forecast.year_p95_deg == then.forecast.year_p95_deg


def test_a_point_struck_out_with_its_offset_is_compared_as_well(taken: SessionView) -> None:
    last = taken.accepted[-1]
    offset = next(o for o in taken.sun_offsets if o.instant == last.read_utc)
    void = Void(seq=taken.records[-1].seq + 1, utc=last.utc, voids=offset.seq, reason="cloud")
    influence = point_influence(view_session(taken.header, (*taken.records, void)), last)
    assert influence.with_it.solution.n_points == len(taken.accepted)
    assert influence.without.solution.n_points == len(taken.accepted) - 1


def test_the_findings_of_one_point_speak_of_one(taken: SessionView) -> None:
    first = taken.accepted[0].seq
    one = view_session(taken.header, tuple(r for r in taken.records if r.seq <= first))
    said = [finding.sentence for finding in analyse_session(one).findings]
    assert any("1 point beside six parameters" in sentence for sentence in said)


def test_the_evidence_of_a_point_is_what_came_last_before_it(taken: SessionView) -> None:
    first, last = taken.accepted[0], taken.accepted[-1]
    for point in (first, last):
        evidence = point_evidence(taken, point)
        offsets = [offset for offset in taken.sun_offsets if offset.seq < point.seq]
        checks = [check for check in taken.ref_checks if check.seq < point.seq]
        assert evidence.sun_offset == offsets[-1]
        assert evidence.ref_check == checks[-1]
        assert evidence.void is None
        assert [r.seq for r in evidence.records] == sorted(r.seq for r in evidence.records)
        assert evidence.records[-1] == point
