"""The tables of a session: points, reference checks, clocks, uploads, check points, truth.

Plain text of at most 80 columns. Status is a word, never a colour.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.model.fit import Solution
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients
from solarcal.report.columns import BLANK, clock_text, columns, number, wrapped
from solarcal.session.points import PointTable
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    Header,
    PointRecord,
    RefCheck,
    UploadRecord,
)
from solarcal.station.solar_time import SunModel
from solarcal.timescale import format_utc, parse_utc
from solarcal.units import RAD_PER_DEG


@dataclass(frozen=True, slots=True)
class _PointRow:
    label: int
    solar_h: float | None
    utc: str | None
    ideal_deg: tuple[float, float] | None
    error_deg: tuple[float, float] | None
    status: str
    reason: str
    source: str = ""


def _time_of_day(utc: str) -> str:
    """HH:MM:SS, rounded, of an ISO instant."""
    return format_utc(parse_utc(utc), 0)[11:19]


def _date(utc: str) -> str:
    return format_utc(parse_utc(utc), 0)[:10]


def _sky_residual_deg(row: _PointRow, solution: Solution | None) -> float | None:
    if solution is None or row.ideal_deg is None or row.error_deg is None:
        return None
    e1, e2 = solution.predict_deg(*row.ideal_deg)
    cross = (row.error_deg[0] - float(e1)) * np.sin(row.ideal_deg[1] * RAD_PER_DEG)
    return float(np.hypot(cross, row.error_deg[1] - float(e2)))


def _points_lines(rows: Sequence[_PointRow], solution: Solution | None, key: str) -> list[str]:
    if not rows:
        return ["No points yet."]
    cells = []
    for row in rows:
        ideal, error = row.ideal_deg or (None, None), row.error_deg or (None, None)
        cells.append(
            [
                str(row.label),
                BLANK if row.solar_h is None else clock_text(row.solar_h),
                BLANK if row.utc is None else _time_of_day(row.utc),
                number(ideal[0], 3),
                number(ideal[1], 3),
                number(error[0], 3, signed=True),
                number(error[1], 3, signed=True),
                number(_sky_residual_deg(row, solution), 3),
                row.status,
            ]
        )
    head, rule, *body = columns(
        (key, "solar", "UTC", "AX1", "AX2", "error 1", "error 2", "residual", "status"),
        cells,
        ">>>>>>>><",
    )
    lines, date, source = [head, rule], "", ""
    for row, line in zip(rows, body, strict=True):
        if row.source != source:
            source, date = row.source, ""
            lines.append(source)
        if row.utc is not None and _date(row.utc) != date:
            date = _date(row.utc)
            lines.append(date)
        lines.append(line)
        if row.reason:
            lines += wrapped(row.reason, indent=6)
    return lines


def points_table(
    header: Header, points: Sequence[PointRecord], solution: Solution | None = None
) -> str:
    """All attempts of a session; residuals on sky where there is a solution. Angles in degrees."""
    sun = SunModel.of_session(header)
    rows = []
    for point in points:
        # An imported point may have no time of its own; that of its record is the import's.
        utc = point.read_utc or (point.utc if point.ideal_deg is None else None)
        solar_h = None
        if utc is not None:
            solar_h = float(sun.solar_time_h(np.array([parse_utc(utc)]), header.site)[0])
        rows.append(
            _PointRow(
                point.seq,
                solar_h,
                utc,
                point.ideal_deg,
                point.error_deg,
                point.status,
                point.reason,
            )
        )
    return "\n".join(_points_lines(rows, solution, "no."))


def file_points_table(
    table: PointTable, solution: Solution | None = None, most: int | None = 60
) -> str:
    """The rows of points files; of many the first ``most``, and how many more there are.

    Rows are called by line number, those of sessions by sequence number; merged files are named.
    """
    shown = table if most is None else table.rows(range(min(most, len(table))))
    site = table.site
    solar_h = np.full(len(shown), np.nan)
    timed = np.isfinite(shown.utc_s)
    if site is not None and timed.any():
        sun = SunModel("solartrak" if table.ideal == "solartrak" else "precise")
        solar_h[timed] = sun.solar_time_h(shown.utc_s[timed], site)

    def pairs(first: Sequence[float], second: Sequence[float]) -> Iterator[tuple[float, float]]:
        yield from zip(first, second, strict=True)

    merged = len(set(table.sources)) > 1
    rows = [
        _PointRow(
            label,
            hours if hours == hours else None,
            format_utc(utc_s) if utc_s == utc_s else None,
            ideal,
            error,
            status,
            note,
            source if merged else "",
        )
        for label, hours, utc_s, ideal, error, status, note, source in zip(
            shown.labels,
            solar_h.tolist(),
            shown.utc_s.tolist(),
            pairs(shown.ax1_deg.tolist(), shown.ax2_deg.tolist()),
            pairs(shown.err1_deg.tolist(), shown.err2_deg.tolist()),
            shown.status,
            shown.note,
            shown.sources,
            strict=True,
        )
    ]
    from_sessions = all(source.endswith(".jsonl") for source in table.sources)
    lines = _points_lines(rows, solution, "no." if from_sessions else "line")
    if len(shown) < len(table):
        lines.append(f"... and {len(table) - len(shown)} more")
    return "\n".join(lines)


def _ended(check: RefCheck) -> str:
    if not check.complete:
        return "NOT COMPLETE"
    return "complete" if check.at_switches else "no switches"


def ref_checks_table(checks: Sequence[RefCheck]) -> str:
    """Counts found at the reference switches, and how far they moved since the check before."""
    if not checks:
        return "No reference check yet."
    rows, previous = [], None
    for check in checks:
        found = check.difference_counts
        shown, moved = (BLANK, BLANK), (BLANK, BLANK)
        if found is not None:
            shown = (f"{found[0]:+d}", f"{found[1]:+d}")
            if check.complete:
                if previous is not None:
                    moved = (f"{found[0] - previous[0]:+d}", f"{found[1] - previous[1]:+d}")
                previous = found
        rows.append(
            [
                str(check.seq),
                _time_of_day(check.utc),
                str(check.number),
                _ended(check),
                *shown,
                *moved,
            ]
        )
    headings = ("no.", "UTC", "check", "result", "counts 1", "counts 2", "change 1", "change 2")
    return "\n".join(columns(headings, rows, ">>><>>>>"))


def clocks_table(sets: Sequence[ClockSet]) -> str:
    """Unit clock minus laptop clock before and after each setting, and any time tick."""
    if not sets:
        return "The unit's clock was not set."
    rows = [
        [
            str(record.seq),
            _time_of_day(record.utc),
            number(record.before_s, 2, signed=True),
            number(record.after_s, 2, signed=True),
            number(record.tick_minus_laptop_s, 2, signed=True),
            number(record.tick_sigma_s, 2),
        ]
        for record in sets
    ]
    headings = ("no.", "UTC", "before, s", "after, s", "tick - laptop, s", "sigma, s")
    return "\n".join(columns(headings, rows, ">>>>>>"))


def checks_table(checks: Sequence[CheckRecord], tolerance_deg: float = 0.1) -> str:
    """Check points after an upload: what is left of the error, compared with the tolerance."""
    if not checks:
        return "No check points."
    rows, reasons = [], []
    for check in checks:
        ideal, error = check.ideal_deg or (None, None), check.error_deg or (None, None)
        sky = check.sky_error_deg
        judged = BLANK
        if sky is not None:
            judged = "within" if sky <= tolerance_deg else "BEYOND"
        rows.append(
            [
                str(check.seq),
                _time_of_day(check.read_utc or check.utc),
                number(ideal[0], 3),
                number(ideal[1], 3),
                number(error[0], 3, signed=True),
                number(error[1], 3, signed=True),
                number(sky, 3),
                judged,
                check.status,
            ]
        )
        if check.reason:
            reasons += wrapped(f"{check.seq}: {check.reason}", indent=2, hang=6)
    headings = (
        "no.", "UTC", "AX1", "AX2", "left 1", "left 2", "on sky", f"of {tolerance_deg:g}", "status",
    )  # fmt: skip
    return "\n".join(columns(headings, rows, ">>>>>>><<") + reasons)


def upload_table(record: UploadRecord) -> str:
    """Old and new coefficients and offsets, their difference, and what the unit read back."""
    old = (*record.old_coefficients.as_tuple(), record.old_offsets.O1, record.old_offsets.O2)
    new = (*record.new_coefficients.as_tuple(), record.new_offsets.O1, record.new_offsets.O2)
    units = (*COEFFICIENT_UNITS, "deg", "deg")
    rows = [
        [name, *(number(v, 6 if unit == "deg/deg" else 4, True) for v in (a, b, b - a)), unit]
        for name, unit, a, b in zip((*COEFFICIENT_NAMES, "O1", "O2"), units, old, new, strict=True)
    ]
    lines = columns(("", "old", "new", "difference", "unit"), rows, "<>>><")
    what = "Rolled back" if record.rollback else f"Uploaded ({record.method})"
    if record.verified:
        lines.append(f"{what}; the unit read back exactly these numbers.")
    else:
        lines.append(f"{what}; READ BACK DIFFERS: the unit does not hold these numbers. Roll back.")
    if record.forced:
        lines += wrapped(f"Forced: {record.forced}")
    return "\n".join(lines)


def truth_table(truth: Mapping[str, float | None], found: Coefficients | None = None) -> str:
    """An emulator's hidden truth beside what was found, and the true error before and after.

    ``truth`` has the keys of ``solarcal calibrate --json``; what is missing or null is left blank.
    """
    values: tuple[float | None, ...] = (None,) * 6 if found is None else found.as_tuple()
    rows = []
    for name, unit, value in zip(COEFFICIENT_NAMES, COEFFICIENT_UNITS, values, strict=True):
        decimals, true = (6 if unit == "deg/deg" else 4), truth.get(name)
        off = None if value is None or true is None else value - true
        rows.append([name, *(number(v, decimals, True) for v in (true, value, off)), unit])
    lines = columns(("", "truth", "found", "difference", "unit"), rows, "<>>><")
    errors = [
        [what, *(number(truth.get(f"{key}_{when}_deg"), 4) for when in ("before", "after"))]
        for what, key in (
            ("day, rms", "day_rms"),
            ("day, largest", "day_max"),
            ("year, rms", "year_rms"),
        )
    ]
    lines += ["", *columns(("true error on the sky, deg", "before", "after"), errors, "<>>")]
    return "\n".join(lines)
