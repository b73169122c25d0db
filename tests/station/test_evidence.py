"""Records brought to the tests: direct evidence of a session, and its diagnosis."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from emulated_station import emulated_station

from solarcal.model.analysis import findings_of
from solarcal.model.evidence.direct import Evidence, direct_findings, evidence_sentences
from solarcal.model.evidence.sun_path import UNIT_CLOCK
from solarcal.mount.formula import Offsets
from solarcal.session.records import RefCheck, Void
from solarcal.session.view import SessionView, view_session
from solarcal.station.analysing import analyse_session, solve_merged
from solarcal.station.fitting import sky_context, solve
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.timescale import format_utc, parse_utc


@pytest.fixture(scope="module")
def day() -> SessionView:
    """Eight points of an emulated tracker whose unit knows the true Sun but for the air."""
    station, _ = emulated_station("tijeras-azel", start="2026-06-03T13:30:00Z")
    emulation = station.tracker.emulation
    assert emulation is not None
    technician = AutomaticTechnician(
        station, emulation.spot, Schedule(points=8), eye_sigma_deg=0.02
    )
    technician.prepare()
    for _ in range(8):
        assert technician.take_point() is not None
        station.clock.wait(4200.0)
    return station.session


def with_points(session: SessionView, change) -> SessionView:
    """The session with every point put through ``change(index, point)``."""
    index = iter(range(1000))
    records = tuple(change(next(index), r) if r in session.points else r for r in session.records)
    return view_session(session.header, records)


def kinds(session: SessionView, certainty: str = "found") -> set[str]:
    findings = direct_findings(session)
    assert all(finding.direct for finding in findings)
    return {f.kind for f in findings if f.certainty == certainty}


def test_a_good_day_has_nothing_but_the_laptop_clock_to_say(day):
    assert kinds(day) == set()
    assert kinds(day, "not_determinable") == {"laptop_clock", "missed_counts"}
    assert any(
        "laptop's own clock cannot be found" in sentence for sentence in evidence_sentences(day)
    )


def test_a_diagnosis_of_a_good_day_finds_nothing_and_says_what_it_cannot_tell(day):
    findings = analyse_session(day).findings
    assert not [f.sentence for f in findings if f.certainty == "found"]
    assert "laptop_clock" in {f.kind for f in findings}
    # Whatever the method of the fit on the screen.
    linear = analyse_session(day, "linear").findings
    assert [f.subject for f in linear] == [f.subject for f in findings]


def test_a_clock_that_drifts_is_found(day):
    late = with_points(
        day, lambda i, p: msgspec.structs.replace(p, unit_minus_laptop_s=0.05 * i + 0.01)
    )
    assert "clock_step" not in kinds(late)
    fast = with_points(day, lambda i, p: msgspec.structs.replace(p, unit_minus_laptop_s=2.0 * i))
    assert "clock_drift" in kinds(fast)


def test_angles_of_a_units_clock_that_is_ahead_are_explained_by_it(day):
    """100 s are 0.417 deg of Sun; the unit's clock says so, and the site is not doubted."""

    def ahead(index, point):
        laptop_utc = format_utc(parse_utc(point.read_utc) - 100.0)
        return msgspec.structs.replace(point, read_utc=laptop_utc, unit_minus_laptop_s=100.0)

    found = analyse_session(with_points(day, ahead)).findings
    (finding,) = [f for f in found if f.subject == UNIT_CLOCK and "ideal angles" in f.sentence]
    assert finding.number == pytest.approx(100.0)
    assert "up to +100.0 s from the laptop's at the points, 0.417 deg of Sun" in finding.sentence
    assert not [f for f in found if f.kind in ("site", "geometry")]


def test_a_unit_an_hour_wrong_in_its_own_sums_is_explained(day):
    wrong = with_points(
        day,
        lambda i, p: msgspec.structs.replace(p, unit_minus_laptop_s=p.unit_minus_laptop_s - 3600.0),
    )
    (sun,) = [f for f in direct_findings(wrong) if f.kind == "unit_sun"]
    assert sun.direct
    assert "+1 h" in sun.sentence
    assert len(sun.labels) == len(day.accepted)


def test_the_other_hemisphere_is_named(day):
    unit = day.header.unit
    south = msgspec.structs.replace(unit.site, latitude_deg=-unit.site.latitude_deg)
    header = msgspec.structs.replace(day.header, unit=msgspec.structs.replace(unit, site=south))
    said = [f.sentence for f in direct_findings(view_session(header, day.records))]
    assert any("the other hemisphere" in sentence for sentence in said)


def test_a_frozen_axis_is_found(day):
    still = day.accepted[0].reading_deg[0]
    frozen = with_points(
        day, lambda i, p: msgspec.structs.replace(p, reading_deg=(still, p.reading_deg[1]))
    )
    (finding,) = [f for f in direct_findings(frozen) if f.kind == "frozen"]
    assert finding.subject == "axis 1"


@pytest.fixture
def lost_counts(day) -> SessionView:
    """The day with 0.3 deg of counts missed on axis 2 from its sixth point on, and a check."""
    drive, reference = day.header.unit.drive2, day.header.unit.reference2_deg
    counts = round(drive.counts(reference + 0.3) - drive.counts(reference))
    lost = with_points(
        day,
        lambda i, p: (
            msgspec.structs.replace(
                p,
                basis="gathering",
                error_deg=(p.error_deg[0], p.error_deg[1] + 0.3),
                reading_deg=(p.reading_deg[0], p.reading_deg[1] + 0.3),
                counts=(p.counts[0], p.counts[1] + counts),
                offsets=Offsets(p.offsets.O1, p.offsets.O2 + 0.3),
            )
            if i >= 5
            else p
        ),
    )
    last = lost.records[-1]
    check = RefCheck(
        seq=last.seq + 1,
        utc=last.utc,
        number=lost.ref_checks[-1].number + 1,
        complete=True,
        difference_counts=(1, counts),
    )
    return view_session(lost.header, (*lost.records, check))


def test_what_no_later_check_proves_is_said(day):
    """Counts missed after the last check show in nothing but the next one."""
    (said,) = (f for f in analyse_session(day).findings if f.kind == "missed_counts")
    assert said.sentence.startswith(f"no reference check since point {day.accepted[-1].seq}")
    last = day.records[-1]
    for change, proven in (
        ({}, True),
        ({"complete": False}, False),
        ({"difference_counts": None}, False),
    ):
        check = RefCheck(
            seq=last.seq + 1, utc=last.utc, number=2, complete=True, difference_counts=(0, 1)
        )
        later = msgspec.structs.replace(check, **change)
        view = view_session(day.header, (*day.records, later))
        assert (kinds(view, "not_determinable") == {"laptop_clock"}) == proven


def test_missed_counts_are_dated_by_the_points_and_then_nothing_else_fires(day, lost_counts):
    session = lost_counts
    found = [f for f in analyse_session(session).findings if f.certainty == "found"]
    (missed,) = found
    assert missed.kind == "missed_counts"
    assert missed.number == pytest.approx(0.3, abs=0.01)
    assert missed.labels == tuple(p.seq for p in day.accepted[5:])


def test_points_read_with_missed_counts_keep_the_verdict_from_stop(lost_counts):
    verdict = analyse_session(lost_counts).verdict
    assert verdict.state != "done"
    bad = [str(point.seq) for point in lost_counts.accepted[5:]]
    (reason,) = [reason for reason in verdict.reasons if "strike these out" in reason]
    assert all(label in reason for label in bad)
    last = lost_counts.records[-1]
    voids = tuple(
        Void(seq=last.seq + 1 + i, utc=last.utc, voids=int(label), reason="missed counts")
        for i, label in enumerate(bad)
    )
    struck = view_session(lost_counts.header, (*lost_counts.records, *voids))
    # Whether the five that are left were all read before the loss, they alone may not tell; whoever
    # struck the ones after it has said so.
    analysis = analyse_session(struck)
    (missed,) = [f for f in analysis.findings if f.kind == "missed_counts"]
    assert missed.labels == ()
    assert "most likely after point" in missed.sentence
    assert not any("strike these out" in reason for reason in analysis.verdict.reasons)


def test_a_table_brings_its_sides_and_sessions_merge(day):
    table = day.table
    findings = findings_of(solve(day), sky_context(table, day.header), Evidence(table))
    assert not [f for f in findings if f.certainty == "found"]
    half = len(table) // 2
    first, second = table.rows(range(half)), table.rows(range(half, len(table)))
    assert np.nanmin(first.utc_s) < np.nanmin(second.utc_s)
    merged = solve_merged([second, first], day.header)
    assert merged.solution.n_points == len(day.accepted)
    assert merged.change == "same"


def test_without_times_the_session_taken_as_the_last_is_named(day):
    table = replace(day.table, utc_s=np.full(len(day.table), np.nan), ideal="apparent")
    half = len(table) // 2
    later = replace(table, err2_deg=table.err2_deg + 0.5, sources=("later",) * len(table))
    parts = [table.rows(range(half)), later.rows(range(half, len(table)))]
    (moved,) = [f for f in solve_merged(parts).findings if f.kind == "moved"]
    assert moved.sentence.endswith("later, given last, is taken as the last")


@pytest.mark.parametrize("known_of", ["both", "one", "none"])
def test_sigmas_of_merged_sessions_count_only_where_every_one_gives_them(day, known_of):
    half = len(day.table) // 2
    first, second = day.table.rows(range(half)), day.table.rows(range(half, len(day.table)))
    if known_of != "none":
        first = replace(first, sigma_deg=np.full(len(first), 0.02))
    if known_of == "both":
        second = replace(second, sigma_deg=np.full(len(second), 0.04))
    sigma_deg = solve_merged([first, second], day.header).solution.points.sigma_deg
    if known_of == "both":
        assert sorted(set(sigma_deg)) == [0.02, 0.04]
    else:
        assert sigma_deg is None
