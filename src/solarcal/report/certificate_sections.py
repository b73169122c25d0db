"""What most sections of a certificate say."""

import numpy as np

from solarcal.model.analysis import Analysis
from solarcal.model.solution import Solution
from solarcal.report.columns import BLANK, number
from solarcal.report.fit_tables import meaning
from solarcal.report.forecast_map import forecast_map
from solarcal.report.judgement_text import STATE_WORDS, forecast_rows, mechanism_rows
from solarcal.report.plots import error_plot, residual_plot
from solarcal.report.renderables import Block, Facts, Figure, Section, Sentences, Table
from solarcal.report.svg_figures import (
    HEIGHT,
    WIDTH,
    error_figure,
    forecast_figure,
    residual_figure,
)
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.analysing import FileAnalysis
from solarcal.station.curves import table_plot_data
from solarcal.timescale import format_utc

TEXT_WIDTH, TEXT_HEIGHT = 78, 22


def subject_section(judged: FileAnalysis, header: Header | None) -> Section:
    """Site, unit, operator, instruments."""
    table = judged.table
    place = [("mount", table.geometry), ("site", _site(table, header))]
    rows = [("unit", table.unit or "not named"), *place]
    if header is not None:
        if not header.unit.imported:
            rows.append(("firmware", header.unit.firmware))
            rows.append(("update range", f"{header.unit.update_range_deg:g} deg"))
        operators = dict.fromkeys(s.header.operator for s in judged.sessions if s.header.operator)
        devices = dict.fromkeys(
            s.header.pointing_device for s in judged.sessions if s.header.pointing_device
        )
        rows += [
            ("operator", ", ".join(operators) or "not named"),
            ("pointing device", ", ".join(devices) or "not named"),
            (
                "air",
                f"{header.weather.pressure_hpa:.0f} hPa, {header.weather.temperature_c:.0f} C",
            ),
        ]
    rows.append(("laptop clock", _clock(judged)))
    rows.append(("tolerance", f"{judged.tolerance_deg:g} deg on the sky, 95 % of the year"))
    return Section("What was calibrated", (Facts(tuple(rows)),))


def _site(table: PointTable, header: Header | None) -> str:
    if table.latitude_deg is None:
        return "not known"
    north = "N" if table.latitude_deg >= 0.0 else "S"
    words = f"{abs(table.latitude_deg):.4f} {north}"
    if table.longitude_deg is not None:
        east = "E" if table.longitude_deg >= 0.0 else "W"
        words += f" {abs(table.longitude_deg):.4f} {east}"
    name = header.site.name if header is not None else ""
    return f"{f'{name}, ' if name else ''}{words}, {table.elevation_m:.0f} m"


def _clock(judged: FileAnalysis) -> str:
    ticks = [
        (record.tick_minus_laptop_s, record.tick_sigma_s)
        for session in judged.sessions
        for record in session.clock_sets
        if record.tick_minus_laptop_s is not None
    ]
    if not ticks:
        return "not compared with a time signal"
    offset_s, sigma_s = ticks[-1]
    return (
        f"time signal minus laptop {offset_s:+.2f} s"
        f"{'' if sigma_s is None else f' +- {sigma_s:.2f} s'}"
    )


def verdict_section(judgement: Analysis) -> Section:
    verdict = judgement.verdict
    return Section(
        "Verdict", (Facts((("state", STATE_WORDS[verdict.state]),)), Sentences(verdict.reasons))
    )


def coefficients_section(solution: Solution) -> Section:
    """P1..P6 with their sigmas, the mechanism, and what the fit says of itself."""
    sigmas = [None] * 6 if solution.sigmas is None else solution.sigmas.tolist()
    rows = tuple(
        (
            term.name,
            number(value, 6 if term.unit == "deg/deg" else 4, True),
            number(sigma, 6 if term.unit == "deg/deg" else 4),
            term.unit,
            meaning(term, solution.geometry.name),
        )
        for term, value, sigma in zip(
            solution.model_terms, solution.values.tolist(), sigmas, strict=True
        )
    )
    blocks: list[Block] = [Table(("", "value", "sigma", "unit", "meaning"), rows, "<>><<")]
    if mechanism := mechanism_rows(solution):
        blocks.append(Facts(tuple(mechanism)))
    blocks.append(
        Facts(
            (
                ("method", f"{solution.method}, {solution.n_points} points"),
                (
                    "residual on the sky",
                    f"rms {solution.sky_rms_deg:.4f} deg, largest {solution.sky_max_deg:.4f}",
                ),
            )
        )
    )
    said = (*solution.inseparable, *solution.notes)
    if solution.message is not None:
        said = (solution.message, *said)
    if said:
        blocks.append(Sentences(said))
    return Section("Coefficients", tuple(blocks))


def points_section(judged: FileAnalysis) -> Section:
    """Every attempt with its residual, and the two plots."""
    header = judged.header
    limits = None
    if header is not None and not header.unit.imported:
        limits = header.unit.limits
    data = table_plot_data(judged.table, judged.solution, limits)
    return Section(
        "Points",
        (
            _points_table(judged),
            Figure(
                "Error of the axes at every point, and the model",
                error_plot(data, TEXT_WIDTH, TEXT_HEIGHT, colour=False),
                error_figure(data),
                WIDTH,
                HEIGHT,
            ),
            Figure(
                "What the model leaves of every point on the sky",
                residual_plot(data, TEXT_WIDTH, TEXT_HEIGHT, colour=False),
                residual_figure(data),
                WIDTH,
                HEIGHT,
            ),
        ),
    )


def _points_table(judged: FileAnalysis) -> Table:
    table, solution = judged.table, judged.solution
    e1, e2 = solution.predict_deg(
        np.nan_to_num(table.ax1_deg), np.nan_to_num(table.ax2_deg, nan=45.0)
    )
    cross = (table.err1_deg - e1) * np.sin(np.radians(table.ax2_deg))
    residual = np.hypot(cross, table.err2_deg - e2)
    merged = len(set(table.sources)) > 1
    rows = []
    for i, label in enumerate(table.labels):
        time = float(table.utc_s[i])
        rows.append(
            (
                *((table.sources[i].rpartition("/")[2],) if merged else ()),
                str(label),
                BLANK if np.isnan(time) else format_utc(time, 0)[:19].replace("T", " "),
                number(float(table.ax1_deg[i]), 3),
                number(float(table.ax2_deg[i]), 3),
                number(float(table.err1_deg[i]), 3, True),
                number(float(table.err2_deg[i]), 3, True),
                number(float(residual[i]), 3),
                table.status[i],
                table.note[i],
            )
        )
    headings = ("no.", "UTC", "AX1", "AX2", "error 1", "error 2", "residual", "status", "remark")
    align = "><>>>>><<"
    if merged:
        return Table(("file", *headings), tuple(rows), "<" + align)
    return Table(headings, tuple(rows), align)


def forecast_section(judgement: Analysis, tolerance_deg: float) -> Section:
    """The year in figures and as a map."""
    expected = judgement.forecast
    return Section(
        "Forecast for the year, deg on the sky",
        (
            Facts(tuple(forecast_rows(expected, tolerance_deg))),
            Figure(
                "Expected error by day of the year and solar hour",
                forecast_map(expected, TEXT_WIDTH, 36, colour=False, tolerance_deg=tolerance_deg),
                forecast_figure(expected, tolerance_deg),
                WIDTH,
                HEIGHT,
            ),
        ),
    )


def evidence_section(judged: FileAnalysis) -> tuple[Section, ...]:
    """What clocks, reference checks and the readers of the files say; empty without any."""
    said = (
        *(finding.sentence for finding in judged.findings),
        *judged.warnings,
    )
    return (Section("Evidence", (Sentences(said),)),) if said else ()
