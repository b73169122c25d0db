"""The tables of a session: points, reference checks, clocks, uploads, check points, truth.

At most 80 columns wide. Status is a word, never a colour.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import msgspec
import numpy as np

from solarcal.model.solution import Solution
from solarcal.model.terms import TERMS
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients
from solarcal.report.blocks import BLANK, Blocks, Prose, Table, clock_text, columns, number
from solarcal.report.judgement import formula_residuals_deg, meaning, values_table
from solarcal.session.points import PointTable, merge_tables, table_of_points
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    PointRecord,
    RefCheck,
    UploadRecord,
)
from solarcal.session.view import SessionView
from solarcal.station.analysing import UnitFiles
from solarcal.station.point_judgement import PointJudgement
from solarcal.station.sun_path import SunModel
from solarcal.sun.position import sun_known
from solarcal.timescale import format_utc, parse_utc, second_of_day
from solarcal.units import FloatArray


def date_and_time(utc: str) -> tuple[str, str]:
    """YYYY-MM-DD and HH:MM:SS, rounded."""
    told = format_utc(parse_utc(utc), 0)
    return told[:10], told[11:19]


def _days(records: Sequence[RefCheck] | Sequence[ClockSet]) -> tuple[tuple[str, ...], ...]:
    """The dates to stand above the rows, where the records are of more than one."""
    dates = [date_and_time(record.utc)[0] for record in records]
    return tuple((date if len(set(dates)) > 1 else "",) for date in dates)


STRUCK = "struck"
"""Status of a point that is struck out, in a table that is shown and nowhere else."""


def points_table(session: SessionView, solution: Solution | None = None) -> Blocks:
    """All attempts of a session; residuals on sky where there is a solution. Angles in degrees."""
    points = _listed(session)
    table = table_of_points(session.header, points)
    # An attempt without angles has the time of its record; that of an import is the import's.
    utc_s = [
        parse_utc(point.utc) if point.read_utc is None and point.ideal_deg is None else read_s
        for point, read_s in zip(points, table.utc_s.tolist(), strict=True)
    ]
    table = replace(table, utc_s=np.array(utc_s))
    return _points(table, solution, SunModel.of_session(session.header), "no.", None)


def _listed(session: SessionView) -> list[PointRecord]:
    """All attempts with those struck out, each in its place with its reason."""
    struck = [
        msgspec.structs.replace(record, status=STRUCK, reason=void.reason)
        for record, void in session.struck_out
        if isinstance(record, PointRecord)
    ]
    return sorted([*session.points, *struck], key=lambda point: point.seq)


def listed_of_files(files: UnitFiles) -> PointTable:
    """The table of files with the points struck out of their sessions, each in its place."""
    sessions = {session.path: session for session in files.sessions}
    return merge_tables(
        [_with_struck(t, sessions.get(t.sources[0]) if len(t) else None) for t in files.tables]
    )


def _with_struck(table: PointTable, session: SessionView | None) -> PointTable:
    if session is None:
        return table
    listed = table_of_points(session.header, _listed(session), session.path)
    # A row that another file has too is not in the table.
    own = set(table.labels)
    found = enumerate(zip(listed.labels, listed.status, strict=True))
    return listed.rows([row for row, (n, status) in found if n in own or status == STRUCK])


def file_points_table(
    table: PointTable, solution: Solution | None = None, most: int | None = 60
) -> Blocks:
    """The rows of points files; of many the first ``most``, and how many more there are.

    Rows are called by line number, those of sessions by sequence number; merged files are named.
    """
    sun = SunModel("solartrak" if table.ideal == "solartrak" else "precise")
    from_sessions = all(source.endswith(".jsonl") for source in table.sources)
    return _points(table, solution, sun, "no." if from_sessions else "line", most)


def _points(
    table: PointTable, solution: Solution | None, sun: SunModel, key: str, most: int | None
) -> Blocks:
    shown = table if most is None else table.rows(range(min(most, len(table))))
    if shown.stamp_utc_s is not None:
        shown = replace(shown, utc_s=shown.stamp_utc_s)
    if not len(shown):
        return (Prose(("No points yet.",)),)
    merged = len(set(table.sources)) > 1
    rows, groups, source, date = [], [], "", ""
    residuals_deg = np.full(len(shown), np.nan)
    if solution is not None:
        residuals_deg = formula_residuals_deg(solution, shown)
    times = [format_utc(at_s, 0) if at_s == at_s else "" for at_s in shown.utc_s.tolist()]
    for row, utc, solar_h, ax1, ax2, err1, err2, sky in zip(
        range(len(shown)), times,
        _solar_time_h(shown, sun).tolist(), shown.ax1_deg.tolist(), shown.ax2_deg.tolist(),
        shown.err1_deg.tolist(), shown.err2_deg.tolist(),
        residuals_deg.tolist(), strict=True,
    ):  # fmt: skip
        if shown.sources[row] != source:
            source, date = shown.sources[row], ""
        time = BLANK
        if utc:
            date, time = utc[:10], utc[11:19]
        groups.append((source if merged else "", date))
        rows.append(
            (
                f"{shown.labels[row]:d}",
                clock_text(solar_h) if solar_h == solar_h else BLANK,
                time,
                number(ax1, 3),
                number(ax2, 3),
                number(err1, 3, signed=True),
                number(err2, 3, signed=True),
                number(sky, 3),
                shown.status[row],
            )
        )
    headings = (key, "solar", "UTC", "AX1", "AX2", "error 1", "error 2", "residual", "status")
    block = Table(headings, tuple(rows), ">>>>>>>><", tuple(groups), shown.note)
    left_out = len(table) - len(shown)
    return (block, Prose((f"... and {left_out} more",))) if left_out else (block,)


def _solar_time_h(table: PointTable, sun: SunModel) -> FloatArray:
    solar_h = np.full(len(table), np.nan)
    timed = sun_known(table.utc_s)
    if table.site is not None and timed.any():
        solar_h[timed] = sun.solar_time_h(table.utc_s[timed], table.site)
    return solar_h


def _ended(check: RefCheck) -> str:
    if not check.complete:
        return "NOT COMPLETE"
    return "complete" if check.at_switches else "no switches"


def ref_checks_table(checks: Sequence[RefCheck]) -> Blocks:
    """Counts found at the reference switches: what was missed since the check before, or, at the
    first one and after a restart, what the register held."""
    if not checks:
        return (Prose(("No reference check yet.",)),)
    rows = []
    for check in checks:
        found = check.difference_counts
        shown = (BLANK, BLANK) if found is None else (f"{found[0]:+d}", f"{found[1]:+d}")
        rows.append(
            (str(check.seq), second_of_day(check.utc), str(check.number), _ended(check), *shown)
        )
    headings = ("no.", "UTC", "check", "result", "counts 1", "counts 2")
    return (Table(headings, tuple(rows), ">>><>>", _days(checks)),)


def clocks_table(sets: Sequence[ClockSet]) -> Blocks:
    """Unit clock minus laptop clock before and after each setting, and any time tick."""
    if not sets:
        return (Prose(("The unit's clock was not set.",)),)
    rows = tuple(
        (
            str(record.seq),
            second_of_day(record.utc),
            number(record.before_s, 2, signed=True),
            number(record.after_s, 2, signed=True),
            number(record.tick_minus_laptop_s, 2, signed=True),
            number(record.tick_sigma_s, 2),
        )
        for record in sets
    )
    headings = ("no.", "UTC", "before, s", "after, s", "tick - laptop, s", "sigma, s")
    return (Table(headings, rows, ">>>>>>", _days(sets)),)


def checks_table(
    checks: Sequence[CheckRecord], tolerance_deg: float = 0.1, *, dated: bool = False
) -> Blocks:
    """Check points after an upload: what is left of the error, compared with the tolerance."""
    if not checks:
        return (Prose(("No check points.",)),)
    rows, dates = [], []
    for check in checks:
        ideal, error = check.ideal_deg or (None, None), check.error_deg or (None, None)
        sky = check.sky_error_deg
        judged = BLANK
        if sky is not None:
            judged = "within" if sky <= tolerance_deg else "BEYOND"
        date, time = date_and_time(check.read_utc or check.utc)
        dates.append((date if dated else "",))
        rows.append(
            (
                str(check.seq),
                time,
                number(ideal[0], 3),
                number(ideal[1], 3),
                number(error[0], 3, signed=True),
                number(error[1], 3, signed=True),
                number(sky, 3),
                judged,
                check.status,
            )
        )
    headings = (
        "no.", "UTC", "AX1", "AX2", "left 1", "left 2", "on sky", f"of {tolerance_deg:g}", "status",
    )  # fmt: skip
    reasons = tuple(check.reason for check in checks)
    return (Table(headings, tuple(rows), ">>>>>>><<", tuple(dates), reasons),)


def old_and_new_table(record: UploadRecord) -> Table:
    """Old and new coefficients and offsets of an upload, and their difference."""
    old = (*record.old_coefficients.as_tuple(), record.old_offsets.O1, record.old_offsets.O2)
    new = (*record.new_coefficients.as_tuple(), record.new_offsets.O1, record.new_offsets.O2)
    names, units = (*COEFFICIENT_NAMES, "O1", "O2"), (*COEFFICIENT_UNITS, "deg", "deg")
    return values_table(
        ("", "old", "new", "difference", "unit"),
        ((*row, row[3] - row[2]) for row in zip(names, units, old, new, strict=True)),
    )


def upload_table(record: UploadRecord) -> Blocks:
    """What was in force and is now, and what the unit read back."""
    what = "Rolled back" if record.rollback else f"Uploaded ({record.method})"
    forced = (f"Forced: {record.forced}",) if record.forced else ()
    return old_and_new_table(record), Prose((f"{what}; {read_back_words(record)}.", *forced))


def read_back_words(record: UploadRecord) -> str:
    """What is known of the numbers in the unit after an upload, and what to do."""
    if record.verified:
        return "the unit read back exactly these numbers"
    again = "upload again, or roll back"
    if record.failure:
        return f"NOT finished ({record.failure}): the unit may hold either set; {again}"
    return f"READ BACK DIFFERS: the unit does not hold these numbers; {again}"


def key_in_table(key_in: tuple[tuple[str, str], ...], geometry: str) -> Table:
    """Values as the unit keeps them, in the order of its keys."""
    rows = []
    for name, value in key_in:
        term = TERMS.get(name)
        words = meaning(term, geometry) if term is not None else f"reference offset, axis {name[1]}"
        rows.append((name, value, term.unit if term is not None else "deg", words))
    return Table(("", "key in", "unit", "meaning"), tuple(rows), "<><<")


def truth_table(
    truth: Mapping[str, float | None],
    found: Coefficients | None = None,
    *,
    uploaded: bool = True,
) -> Blocks:
    """An emulator's hidden truth beside what was found, and the true error before and after.

    ``truth`` has the keys of ``solarcal calibrate --json``; what is missing or null is left blank.
    Where nothing was uploaded there is no after.
    """
    moments = ("before", "after") if uploaded else ("before",)
    values: tuple[float | None, ...] = (None,) * 6 if found is None else found.as_tuple()
    rows = []
    for name, unit, value in zip(COEFFICIENT_NAMES, COEFFICIENT_UNITS, values, strict=True):
        true = truth.get(name)
        rows.append(
            (name, unit, true, value, None if value is None or true is None else value - true)
        )
    errors = tuple(
        (what, *(number(truth.get(f"{key}_{when}_deg"), 4) for when in moments))
        for what, key in (
            ("day, rms", "day_rms"),
            ("day, largest", "day_max"),
            ("year, rms", "year_rms"),
        )
    )
    return (
        values_table(("", "truth", "found", "difference", "unit"), rows),
        Prose(("",)),
        Table(("true error on the sky, deg", *moments), errors, f"<{'>' * len(moments)}"),
    )


def point_result(candidate: PointRecord, judgement: PointJudgement) -> str:
    """Counts expected and found since the last point, and the error against the prediction."""
    rows = []
    for axis, judged in enumerate(judgement.axes, start=1):
        missing = None
        if judged.expected_counts is not None and judged.found_counts is not None:
            missing = judged.found_counts - judged.expected_counts
        rows.append(
            [
                str(axis),
                number(judged.expected_counts, 0, True),
                number(judged.found_counts, 0, True),
                number(missing, 0, True),
                number(judged.error_deg, 4, True),
                number(judged.off_deg, 4, True),
                number(judged.sigmas, 1, True),
                "LOOK" if judged.suspicious else "",
            ]
        )
    headings = (
        "axis", "expected", "found", "difference", "error, deg", "off fit", "in sigmas", "",
    )  # fmt: skip
    source = "Set Sun Offset" if candidate.basis == "sun_offset" else "the gathering"
    lines = ["Counts moved since the last point:", *columns(headings, rows, "<>>>>>><")]
    lines.append(f"Error taken from {source}" + (f": {candidate.reason}" * bool(candidate.reason)))
    return "\n".join(lines)


def check_result(candidate: CheckRecord) -> str:
    """What is left of the error after the upload."""
    e1, e2 = candidate.error_deg or (None, None)
    row = [number(e1, 4, True), number(e2, 4, True), number(candidate.sky_error_deg, 4)]
    headings = ("left, axis 1", "left, axis 2", "on the sky, deg")
    return "\n".join(["Check point, never fitted:", *columns(headings, [row], ">>>")])
