"""The text tables: everything needed to judge a session, in 80 columns, in words."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from made_up_session import TRUTH, hourly

from solarcal.model.fit import fit_linear
from solarcal.model.points import Points
from solarcal.model.terms import TERMS
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import MountGeometry
from solarcal.report import judgement, tables
from solarcal.report.blocks import clock_text, columns, number, text_of
from solarcal.report.session_report import record_line, record_lines, session_text
from solarcal.session.points import labelled_by_file, merge_tables
from solarcal.session.records import (
    Answers,
    CheckRecord,
    ClockSet,
    LinkRestored,
    RefCheck,
    UploadRecord,
    Void,
)
from solarcal.session.view import read_session, view_session
from solarcal.station.analysing import UnitFiles
from solarcal.station.fitting import solve
from solarcal.station.state import uploads_as_replaced
from solarcal.tui.workstation.lines import check_lines, coefficient_lines
from solarcal.units import rms

SESSIONS = Path(__file__).parents[2] / "sessions"
AT = "2026-06-21T15:00:00.000Z"


def told(table, *args, **kwargs):
    """A table as the terminal shows it."""
    made = table(*args, **kwargs)
    return text_of(*made) if isinstance(made, tuple) else text_of(made)


def of_points(header, points, solution=None):
    return tables.points_table(view_session(header, tuple(points)), solution)


def narrow(text):
    assert max(map(len, text.split("\n"))) <= 80, text
    return text


def test_points_with_time_angles_errors_residual_and_status(june_day, fit_points):
    header, points = june_day
    text = narrow(told(of_points, header, points, fit_points(header, points)))
    lines = text.split("\n")
    assert lines[0].split() == [
        "no.", "solar", "UTC", "AX1", "AX2", "error", "1", "error", "2", "residual", "status",
    ]  # fmt: skip
    assert lines[2] == "2026-06-21"
    first = lines[3].split()
    assert first[:3] == ["10", "06:52", "14:00:00"]
    assert float(first[3]) == pytest.approx(points[0].ideal_deg[0], abs=0.001)
    assert float(first[5]) == pytest.approx(points[0].error_deg[0], abs=0.001)
    residual = fit_points(header, points).sky_deg[0]
    assert float(first[7]) == pytest.approx(residual, abs=0.001)
    assert first[8] == "accepted"
    # 18:00 local is past midnight UTC.
    assert "2026-06-22" in lines


def test_an_aborted_attempt_stays_in_the_table_with_its_reason(june_day):
    header, points = june_day
    aborted = msgspec.structs.replace(
        points[0],
        status="aborted",
        answers=Answers(ref_check=True, sun_offset=False),
        reason="Did you do a 'Set Sun Offset'? No, and this reason is long enough to need a line "
        "of its own and more",
        ideal_deg=None,
        error_deg=None,
    )
    text = narrow(told(of_points, header, [aborted, *points[1:]]))
    row = text.split("\n")[3].split()
    assert row[3:] == ["-", "-", "-", "-", "-", "aborted"]
    assert "Did you do a 'Set Sun Offset'? No" in text


@pytest.mark.parametrize("files", [1, 2])
def test_a_struck_point_stays_in_the_table_with_its_reason(june_day, fit_points, tmp_path, files):
    header, points = june_day
    last, struck = points[-1], points[4]
    void = Void(seq=last.seq + 1, utc=last.utc, voids=struck.seq, reason="a bird on the plate")
    session = view_session(header, (*points, void), "monday.jsonl")
    solution = fit_points(header, session.accepted)
    text = narrow(told(tables.points_table, session, solution))
    later = [msgspec.structs.replace(p, utc=p.utc.replace("2026", "2027")) for p in points]
    others = [view_session(header, tuple(later), "tuesday.jsonl")] * (files - 1)
    sessions = (*others, session)
    parts = labelled_by_file([one.table for one in sessions])
    of_files = UnitFiles((), parts, merge_tables(parts), sessions)
    listed = tables.listed_of_files(of_files)
    assert text_of(*tables.file_points_table(listed)).count("accepted") == 12 * files - 1
    for lines in (text.split("\n"), told(tables.file_points_table, listed).split("\n")[-15:]):
        at = next(at for at, line in enumerate(lines) if line.endswith("struck"))
        numbers = [line.split()[0] for line in (lines[at - 1], lines[at], lines[at + 2])]
        assert numbers == [str(point.seq) for point in points[3:6]]
        assert lines[at + 1].strip() == "a bird on the plate"
        assert float(lines[at].split()[3]) == pytest.approx(struck.ideal_deg[0], abs=0.001)
    assert struck.seq not in session.table.labels, "what is fitted and exported has it not"


def test_no_points_is_a_sentence(june_day):
    assert told(of_points, june_day[0], []) == "No points yet."
    assert told(tables.ref_checks_table, []) == "No reference check yet."
    assert told(tables.checks_table, []) == "No check points."
    assert told(tables.clocks_table, []) == "The unit's clock was not set."


def test_a_points_file_gives_the_same_numbers_as_its_session(june_day, fit_points):
    header, points = june_day
    solution = fit_points(header, points)
    from_file = told(
        tables.file_points_table,
        view_session(header, tuple(points), "made-up.jsonl").table,
        solution,
    )
    from_session = told(of_points, header, points, solution)
    assert [line.split() for line in narrow(from_file).split("\n")[2:]] == [
        line.split() for line in from_session.split("\n")[2:]
    ]


def test_a_long_points_file_says_how_much_it_leaves_out(june_day):
    header, points = june_day
    table = view_session(header, tuple(points), "made-up.jsonl").table
    text = told(tables.file_points_table, table, most=5)
    assert text.endswith("... and 7 more")
    assert text.count("accepted") == 5


def test_rows_of_merged_files_are_told_apart(june_day):
    header, points = june_day
    first = view_session(header, tuple(points[:6]), "monday.jsonl").table
    second = view_session(header, tuple(points[6:]), "tuesday.jsonl").table
    lines = told(tables.file_points_table, merge_tables([first, second])).split("\n")
    assert lines[0].startswith("no.")
    assert lines[2:4] == ["monday.jsonl", "2026-06-21"]
    assert lines[10:12] == ["tuesday.jsonl", "2026-06-21"]


@pytest.mark.parametrize(
    ("geometry", "words"),
    [
        ("azel", ("lean of tower top to the north", "lean of tower top to the east")),
        ("tiltroll-ew", ("east end of the axis down", "east end of the axis to the south")),
        ("tiltroll-ns", ("north end of the axis down", "north end of the axis to the east")),
        ("polar", ("pole end of the axis down", "pole end of the axis to the east")),
    ],
)
def test_coefficients_say_what_they_mean_on_this_mount(
    make_header, make_points, fit_points, geometry, words
):
    header = make_header(geometry=geometry)
    points = make_points(header, hourly("2026-05-10", 15, 23))
    points += make_points(header, hourly("2026-08-10", 15, 23), first_seq=100)
    text = narrow(told(judgement.coefficients_table, fit_points(header, points)))
    rows = {line[:2]: line for line in text.split("\n")[2:]}
    assert words[0] in rows["P1"]
    assert words[1] in rows["P3"]
    assert "gear-ratio" in rows["P5"]
    assert "deg/deg" in rows["P6"]
    # By the same names as in the sentences about them.
    for name in ("P2", "P4", "P5", "P6"):
        assert TERMS[name].called[geometry] in rows[name]


def test_coefficients_and_sigmas_are_those_of_the_solution(june_day, fit_points):
    header, points = june_day
    solution = fit_points(header, points)
    for line, value, sigma in zip(
        told(judgement.coefficients_table, solution).split("\n")[2:],
        solution.values,
        solution.sigmas,
        strict=True,
    ):
        _, shown, shown_sigma, *_ = line.split()
        assert float(shown) == pytest.approx(value, abs=6e-5)
        assert float(shown_sigma) == pytest.approx(sigma, abs=6e-5)


def test_tpoint_terms_are_shown_in_arcseconds(june_day):
    header, points = june_day
    ideal = np.array([p.ideal_deg for p in points])
    error = np.array([p.error_deg for p in points])
    solution = fit_linear(
        Points(
            geometry=MountGeometry("azel", header.site.latitude_deg),
            ax1_deg=ideal[:, 0],
            ax2_deg=ideal[:, 1],
            err1_deg=error[:, 0],
            err2_deg=error[:, 1],
        ),
        ("IA", "IE", "AN", "AW", "CA"),
    )
    text = narrow(told(judgement.coefficients_table, solution))
    assert text.count("arcsec") == 5
    assert "north-south lean" in text


def test_the_summary_names_rank_residuals_and_what_cannot_be_told_apart(
    june_day, make_header, make_points, fit_points
):
    header, points = june_day
    text = narrow(told(judgement.fit_summary, fit_points(header, points)))
    assert text.startswith("12 points, method linear, rank 6 of 6, condition number 6.")
    assert "population SD 0.0" in text
    assert "scaled by the residuals" in text
    polar = make_header(geometry="polar")
    day = make_points(polar, hourly("2026-06-21", 14, 24))
    solution = fit_points(polar, day)
    said = " ".join(narrow(told(judgement.fit_summary, solution)).split())
    assert solution.inseparable
    assert all(sentence in said for sentence in solution.inseparable)
    assert f"rank {solution.rank} of 6" in said


def test_the_residual_beside_the_points_is_named_where_the_mechanism_leaves_another():
    session = read_session(SESSIONS / "azel-good-day.jsonl")
    solution = solve(session, "robust")
    left = judgement.formula_residuals_deg(solution, solution.points)
    assert abs(left.max() - solution.sky_max_deg) > 0.001
    text = narrow(told(judgement.fit_summary, solution))
    assert f"residual of the formula, as beside each point: rms {rms(left):.4f} deg" in text
    rows = told(of_points, session.header, session.accepted, solution).split("\n")
    beside = [line.split()[-2] for line in rows if line.endswith("accepted")]
    assert max(beside) == f"{left.max():.3f}"
    # The pane of the coefficients stands beside that of the points.
    pane = "".join(str(part) for line in coefficient_lines(session, solution) for part in line)
    assert f"max {left.max():.4f} deg" in pane


def test_unrealistic_parameters_are_said_last(june_day, fit_points):
    header, points = june_day
    solution = fit_points(header, points[:3])
    text = narrow(told(judgement.fit_summary, solution))
    assert solution.message == "Parameters still unrealistic"
    assert text.split("\n")[-1] == "*** Parameters still unrealistic ***"
    assert "population SD not known yet" in text


def test_reference_checks_show_the_counts_missed_since_the_one_before():
    """The register is zeroed at the switch: the next check finds what was missed since."""
    checks = [
        RefCheck(seq=2, utc=AT, number=1, complete=True, difference_counts=(3, -2)),
        RefCheck(seq=5, utc=AT, number=2, complete=False, difference_counts=(0, 0)),
        RefCheck(seq=9, utc=AT, number=3, complete=True, difference_counts=(4, 40)),
    ]
    rows = [line.split() for line in narrow(told(tables.ref_checks_table, checks)).split("\n")[2:]]
    assert rows[0] == ["2", "15:00:00", "1", "complete", "+3", "-2"]
    assert rows[1][3:5] == ["NOT", "COMPLETE"]
    assert rows[2][-2:] == ["+4", "+40"]


def test_checks_and_clocks_of_two_days_stand_below_their_dates():
    later = AT.replace("21T", "22T")
    checks = [
        RefCheck(seq=seq, utc=utc, number=seq, complete=True, difference_counts=(0, 0))
        for seq, utc in enumerate((AT, AT, later), start=1)
    ]
    sets = [
        ClockSet(seq=seq, utc=utc, before_s=0.5, after_s=0.0) for seq, utc in ((1, AT), (4, later))
    ]
    for table, records in ((tables.ref_checks_table, checks), (tables.clocks_table, sets)):
        lines = narrow(told(table, records)).split("\n")
        dates = [AT[:10], later[:10]]
        assert [line.strip() for line in lines if line.strip() in dates] == dates
        assert AT[:10] not in told(table, records[:1])


def test_clock_settings_before_and_after():
    text = narrow(
        told(
            tables.clocks_table,
            [
                ClockSet(seq=1, utc=AT, before_s=41.237, after_s=-0.004),
                ClockSet(
                    seq=4,
                    utc=AT,
                    before_s=0.5,
                    after_s=0.0,
                    tick_minus_laptop_s=-24.0,
                    tick_sigma_s=0.3,
                ),
            ],
        )
    )
    rows = [line.split() for line in text.split("\n")[2:]]
    assert rows[0] == ["1", "15:00:00", "+41.24", "+0.00", "-", "-"]
    assert rows[1][-2:] == ["-24.00", "0.30"]


def upload(**changes):
    record = UploadRecord(
        seq=50,
        utc=AT,
        old_coefficients=Coefficients(P1=0.1, P5=0.0002),
        old_offsets=Offsets(0.3, -0.2),
        new_coefficients=TRUTH,
        new_offsets=Offsets(),
        verified=True,
    )
    return msgspec.structs.replace(record, **changes)


def test_an_upload_shows_old_new_difference_and_the_read_back():
    text = narrow(told(tables.upload_table, upload()))
    rows = {line[:2]: line.split() for line in text.split("\n")[2:-1]}
    assert rows["P1"] == ["P1", "+0.1000", "+0.4000", "+0.3000", "deg"]
    assert rows["P5"] == ["P5", "+0.000200", "+0.001000", "+0.000800", "deg/deg"]
    assert rows["O1"] == ["O1", "+0.3000", "+0.0000", "-0.3000", "deg"]
    assert "read back exactly these numbers" in text
    assert "READ BACK DIFFERS" in told(tables.upload_table, upload(verified=False))
    cut_off = upload(verified=False, failure="no answer for 3 s")
    lost = " ".join(told(tables.upload_table, cut_off).split())
    assert "NOT finished (no answer for 3 s): the unit may hold either set" in lost
    assert "READ BACK DIFFERS" not in lost
    assert "Rolled back" in told(tables.upload_table, upload(rollback=True))
    assert "Forced: the tower moves" in told(tables.upload_table, upload(forced="the tower moves"))


def test_an_upload_repeated_after_a_lost_line_is_shown_with_what_a_rollback_restores(june_day):
    """Files of before have the numbers that the unit held already in the second record."""
    lost = upload(verified=False, failure="the line was lost")
    again = upload(seq=52, old_coefficients=TRUTH, old_offsets=Offsets())
    header, points = june_day
    session = view_session(header, (*points, lost, again))
    for text in (session_text(session, None), "\n".join(check_lines(session))):
        assert text.count(told(tables.old_and_new_table, upload())) == 2
    back = upload(seq=53, old_coefficients=TRUTH, new_coefficients=Coefficients(), rollback=True)
    assert uploads_as_replaced([lost, again, back])[-1] == back


def test_check_points_are_compared_with_the_tolerance():
    yes = Answers(ref_check=True, sun_offset=True, tracking=True)
    checks = [
        CheckRecord(
            seq=60 + i,
            utc=AT,
            status="accepted",
            answers=yes,
            ideal_deg=(10.0, 40.0),
            error_deg=(0.02, sky),
            sky_error_deg=sky,
        )
        for i, sky in enumerate((0.012, 0.2))
    ]
    checks.append(
        CheckRecord(seq=70, utc=AT, status="aborted", answers=Answers(), reason="the Sun went in")
    )
    rows = narrow(told(tables.checks_table, checks)).split("\n")[2:]
    assert "within" in rows[0]
    assert "BEYOND" in rows[1]
    assert rows[2].split()[-2:] == ["-", "aborted"]
    assert rows[3] == "      the Sun went in"


def test_truth_beside_what_was_found():
    truth = {
        **dict(zip(("P1", "P2", "P3", "P4", "P5", "P6"), TRUTH.as_tuple(), strict=True)),
        "day_rms_before_deg": 0.71,
        "day_rms_after_deg": 0.0123,
        "day_max_after_deg": 0.0301,
        "year_rms_before_deg": 0.69,
        "year_rms_after_deg": None,
    }
    text = narrow(told(tables.truth_table, truth, Coefficients(P1=0.41)))
    assert "P1  +0.400000"[:4] in text
    rows = [line.split() for line in text.split("\n")]
    assert ["P1", "+0.4000", "+0.4100", "+0.0100", "deg"] in rows
    assert ["day,", "rms", "0.7100", "0.0123"] in rows
    assert ["day,", "largest", "-", "0.0301"] in rows
    assert ["year,", "rms", "0.6900", "-"] in rows
    assert "+0.4000" in told(tables.truth_table, truth)
    assert "before   after" in text
    # Nothing was written: there is no after.
    refused = told(tables.truth_table, truth, Coefficients(P1=0.41), uploaded=False)
    assert "before" in refused
    assert "after" not in refused
    assert "0.0123" not in refused


def test_numbers_and_columns():
    assert number(-0.0001, 3, signed=True) == "+0.000"
    assert number(-0.0001, 3) == "0.000"
    assert number(float("nan"), 3) == "-"
    assert number(None, 1) == "-"
    assert clock_text(23.9999) == "00:00"
    assert columns(("a", "bb"), [("1", "2")], "<>") == ["a  bb", "-  --", "1   2"]


def test_a_time_of_day_is_the_same_in_a_table_and_in_a_line():
    """Rounded to the second: the dialog said 13:01:38 and the pane 13:01:37."""
    clock = ClockSet(seq=3, utc="2026-06-03T13:01:37.600Z", before_s=-0.004, after_s=0.0)
    assert record_line(clock) == "13:01:38     3  unit clock set: -0.004 s before, +0.000 s after"
    slow = msgspec.structs.replace(clock, before_s=-0.043, after_s=-0.032)
    assert record_line(slow).endswith("-0.043 s before, -0.032 s after")
    for losses, words in ((0, ""), (1, ", lost 1 more time before"), (2, ", lost 2 more times")):
        restored = LinkRestored(seq=4, utc=AT, serial="0001", losses=losses)
        assert words in record_line(restored)
    assert "13:01:38" in text_of(*tables.clocks_table([clock]))


def test_records_of_several_days_are_listed_with_their_dates():
    first = ClockSet(seq=3, utc="2026-06-03T13:40:00.000Z", before_s=0.1, after_s=0.0)
    second = ClockSet(seq=4, utc="2026-06-04T12:59:59.600Z", before_s=0.1, after_s=0.0)
    assert record_lines([first, first]) == [record_line(first)] * 2
    assert [line[:20] for line in record_lines([first, second])] == [
        "2026-06-03 13:40:00 ", "2026-06-04 13:00:00 ",
    ]  # fmt: skip
