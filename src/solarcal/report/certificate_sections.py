"""What the sections of a certificate say, in the order they stand."""

from solarcal.decimals import counted
from solarcal.errors import one_line
from solarcal.model.analysis import Analysis
from solarcal.report.blocks import Block, Facts, Figure, Section, Sentences, Table, number
from solarcal.report.forecast_map import forecast_map
from solarcal.report.judgement import (
    coefficients_table,
    fit_summary,
    forecast_facts,
    mechanism_facts,
    shims_blocks,
    verdict_blocks,
)
from solarcal.report.plots import error_plot, residual_plot
from solarcal.report.scales import Sheet
from solarcal.report.session_report import record_words
from solarcal.report.svg_figures import error_figure, forecast_figure, residual_figure
from solarcal.report.tables import (
    checks_table,
    file_points_table,
    listed_of_files,
    old_and_new_table,
    read_back_words,
)
from solarcal.session.points import PointTable
from solarcal.session.records import Header, UploadRecord
from solarcal.station.analysing import FileAnalysis
from solarcal.station.curves import table_plot_data
from solarcal.station.sign_off import SignOff
from solarcal.station.state import uploads_as_replaced
from solarcal.station.uploading import forecast_with

TEXT_SHEET = Sheet(78, 22, colour=False)
MAP_SHEET = Sheet(78, 36, colour=False)


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
                f"{header.weather.pressure_hpa:.0f} hPa, {header.weather.temperature_c:z.0f} C",
            ),
        ]
    rows.append(("laptop clock", _clock(judged)))
    rows.append(("tolerance", f"{judged.tolerance_deg:g} deg on the sky, 95 % of the year"))
    rows += [("asked for", text) for text in judged.asked_for]
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
        f"time signal minus laptop {offset_s:+z.2f} s"
        f"{'' if sigma_s is None else f' +- {sigma_s:.2f} s'}"
    )


def verdict_section(judgement: Analysis) -> Section:
    return Section("Verdict", verdict_blocks(judgement.verdict))


def coefficients_section(judgement: Analysis) -> Section:
    """P1..P6 with their sigmas, the mechanism, what the fit says of itself, and shims."""
    solution, verdict = judgement.solution, judgement.verdict
    mechanism = mechanism_facts(solution)
    return Section(
        "Coefficients",
        (
            coefficients_table(solution),
            *((mechanism,) if mechanism.rows else ()),
            *fit_summary(solution),
            *shims_blocks(verdict.base, verdict.shims),
        ),
    )


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
            *file_points_table(listed_of_files(judged.files), judged.solution, most=None),
            Figure(
                "Error of the axes at every point, and the model",
                error_plot(data, TEXT_SHEET),
                error_figure(data),
            ),
            Figure(
                "What the model leaves of every point on the sky",
                residual_plot(data, TEXT_SHEET),
                residual_figure(data),
            ),
        ),
    )


def forecast_section(judgement: Analysis, tolerance_deg: float) -> Section:
    """The year in figures and as a map."""
    expected = judgement.forecast
    return Section(
        "Forecast for the year, deg on the sky",
        (
            forecast_facts(expected, tolerance_deg),
            Figure(
                "Expected error by day of the year and solar hour",
                forecast_map(expected, MAP_SHEET, tolerance_deg),
                forecast_figure(expected, tolerance_deg),
            ),
        ),
    )


def evidence_section(judged: FileAnalysis) -> tuple[Section, ...]:
    """What clocks, reference checks and the readers of the files say, and which records were struck
    out; empty without any."""
    said = (*(finding.sentence for finding in judged.findings), *judged.warnings)
    struck = tuple(
        (str(record.seq), one_line(record_words(record)), void.reason)
        for session in judged.sessions
        for record, void in session.struck_out
    )
    blocks: list[Block] = [Sentences(said)] if said else []
    if struck:
        blocks.append(Table(("struck out", "record", "reason"), struck, "><<"))
    return (Section("Evidence", tuple(blocks)),) if blocks else ()


def after_section(judged: FileAnalysis, after: SignOff) -> Section:
    """As found, as fitted, as uploaded; what the check points measured."""
    judgement, header = judged.of_the_controller(), judged.header
    rows = []
    if header is not None and not header.unit.imported:
        found = forecast_with(judgement, header.coefficients, header.offsets)
        rows.append(("as found when the session began", found))
    rows.append(("with the coefficients of this certificate", judgement.forecast))
    newest = after.newest
    if newest is not None:
        left = forecast_with(judgement, newest.new_coefficients, newest.new_offsets)
        done = "restored" if newest.rollback else "uploaded"
        rows.append((f"with what was {done} {newest.utc[:16].replace('T', ' ')}", left))
    blocks: list[Block] = [
        Table(
            ("expected error over the year, deg", "rms", "95 %", "largest", "P"),
            tuple(
                (
                    what,
                    number(year.year_rms_deg, 3),
                    number(year.year_p95_deg, 3),
                    number(year.year_max_deg, 3),
                    number(year.probability_within_tolerance, 2),
                )
                for what, year in rows
            ),
            "<>>>>",
        )
    ]
    if newest is not None:
        replaced = old_and_new_table(uploads_as_replaced(after.uploads)[-1])
        blocks += [replaced, Sentences(_upload_sentences(judged, after, newest))]
    if after.checks:
        blocks += checks_table(after.checks, judged.tolerance_deg, dated=True)
    measured = [("measured after the upload", after.reason)]
    if after.sky_rms_deg is not None:
        measured.append(("left on the sky, rms", f"{after.sky_rms_deg:.3f} deg"))
    blocks.append(Facts(tuple(measured)))
    return Section("Before and after", tuple(blocks))


def _upload_sentences(
    judged: FileAnalysis, after: SignOff, newest: UploadRecord
) -> tuple[str, ...]:
    said = [read_back_words(newest)]
    if newest.forced:
        said.append(f"uploaded against advice: {newest.forced}")
    if len(after.uploads) > 1:
        said.append(f"the newest of {len(after.uploads)} uploads and rollbacks in these files")
    header = judged.header
    if header is not None and not newest.rollback:
        here = judged.solution.coefficients().rounded(
            header.unit.tilt_decimals, header.unit.scale_decimals
        )
        if here != newest.new_coefficients:
            said.append(
                f"the unit was given other numbers ({newest.method}) than this certificate's fit "
                f"({judged.solution.method}, {counted(judged.solution.n_points, 'point')})"
            )
    return tuple(said)
