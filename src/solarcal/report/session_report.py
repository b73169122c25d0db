"""What a headless command prints: a session, a fit, a calibration, put together from the tables."""

import shutil
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from solarcal.decimals import counted
from solarcal.errors import one_line
from solarcal.model.analysis import Analysis
from solarcal.model.evidence.direct import evidence_sentences
from solarcal.model.finding import Finding
from solarcal.mount.geometry import from_limit
from solarcal.report.blocks import Block, Prose, Sentences, section_text, text_of
from solarcal.report.judgement import (
    coefficients_table,
    fit_summary,
    forecast_facts,
    mechanism_facts,
    shims_blocks,
    verdict_blocks,
)
from solarcal.report.plots import error_plot
from solarcal.report.scales import Sheet
from solarcal.report.tables import (
    checks_table,
    clocks_table,
    date_and_time,
    file_points_table,
    key_in_table,
    listed_of_files,
    points_table,
    ref_checks_table,
    truth_table,
    upload_table,
)
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    FitRecord,
    InForce,
    Initialised,
    LinkLost,
    LinkRestored,
    Note,
    Override,
    PointRecord,
    Record,
    RefCheck,
    Restarted,
    SunOffset,
    Typed,
    UnknownRecord,
    UploadBegun,
    UploadRecord,
    Void,
)
from solarcal.session.view import SessionView
from solarcal.station.analysing import FileAnalysis, analyse_session
from solarcal.station.curves import session_plot_data, table_plot_data
from solarcal.station.question_evidence import found_words
from solarcal.station.sign_off import sign_off
from solarcal.station.state import uploads_as_replaced

if TYPE_CHECKING:
    from solarcal.station.headless import Calibration
    from solarcal.station.saved_sessions import Replay
    from solarcal.station.typed.field_book_calibration import HandCalibration

WIDEST_PLOT = 100

NOTHING_FOUND = "No problems found."
NOTHING_FOUND_OF_SIX = (
    "No problems found by a fit of P1..P6. The residuals of the terms above are not tested."
)


def _sheet() -> Sheet:
    """For a plot between the tables on this terminal."""
    columns, rows = shutil.get_terminal_size((80, 24))
    return Sheet(
        min(max(columns, 60), WIDEST_PLOT), min(max(rows - 2, 20), 30), sys.stdout.isatty()
    )


def diagnosis_section(findings: Sequence[Finding], nothing: str = NOTHING_FOUND) -> str:
    """What was seen, what the residuals ask for, and what these points cannot tell."""
    found = tuple(f.sentence for f in findings if f.certainty == "found")
    open_ = tuple(f.sentence for f in findings if f.certainty != "found")
    blocks: list[Block] = [Sentences(found) if found else Prose((nothing,))]
    if open_:
        blocks += [Prose(("Not determinable from these points:",)), Sentences(open_)]
    return section_text("Diagnosis", *blocks)


def heading(session: SessionView) -> str:
    """Who, where and what, in two lines."""
    header = session.header
    site = header.site
    return (
        f"Unit {header.unit.model} {header.unit.serial} ({header.geometry}), "
        f"{header.utc[:10]}, operator {header.operator or 'not named'}\n"
        f"Site {abs(site.latitude_deg):.4f} {'N' if site.latitude_deg >= 0 else 'S'} "
        f"{abs(site.longitude_deg):.4f} {'E' if site.longitude_deg >= 0 else 'W'} "
        f"{site.elevation_m:.0f} m, {header.weather.pressure_hpa:.0f} hPa "
        f"{header.weather.temperature_c:z.0f} C"
    )


def _judged(judgement: Analysis, tolerance_deg: float) -> list[str]:
    """Mechanism, forecast and verdict, each under its title."""
    mechanism = mechanism_facts(judgement.solution)
    shims = shims_blocks(judgement.verdict.base, judgement.verdict.shims)
    forecast = forecast_facts(judgement.forecast, tolerance_deg)
    return [
        *([section_text("Mechanism", mechanism)] if mechanism.rows else []),
        *([section_text("Shims", *shims)] if shims else []),
        section_text("Forecast, deg on the sky", forecast),
        section_text("Verdict", *verdict_blocks(judgement.verdict)),
    ]


def session_text(session: SessionView, judgement: Analysis | None) -> str:
    """A session so far: checks, points, fit, verdict, plot, upload, check points, evidence."""
    solution = None if judgement is None else judgement.solution
    parts = [
        heading(session),
        section_text("Clock", *clocks_table(session.clock_sets)),
        section_text("Reference checks", *ref_checks_table(session.ref_checks)),
        section_text("Points", *points_table(session, solution)),
    ]
    if judgement is not None and solution is not None:
        parts.append(section_text("Coefficients", coefficients_table(solution)))
        parts.append(section_text("Fit", *fit_summary(solution)))
        parts += _judged(judgement, session.header.tolerance_deg)
    data = session_plot_data(session.header, session.points, solution)
    parts.append(error_plot(data, _sheet()))
    uploads = uploads_as_replaced(session.uploads)
    parts += [section_text("Upload", *upload_table(upload)) for upload in uploads]
    if session.checks:
        parts.append(
            section_text(
                "Check points",
                *checks_table(session.checks, session.header.tolerance_deg),
                Sentences((sign_off([session], judgement).sentence,)),
            )
        )
    if judgement is not None:
        parts.append(diagnosis_section(judgement.findings))
    elif said := evidence_sentences(session):
        parts.append(section_text("Evidence", Sentences(tuple(said))))
    return "\n\n".join(parts)


def calibration_text(calibration: "Calibration") -> str:
    """A finished headless calibration, with the emulator's truth."""
    ending = (
        "Calibration completed, read back equal."
        if calibration.completed
        else f"NOT completed: {calibration.failure}"
    )
    truth = truth_table(
        calibration.truth_document(),
        calibration.solution.coefficients(),
        uploaded=calibration.upload is not None,
    )
    return "\n\n".join(
        [
            session_text(
                calibration.session,
                analyse_session(calibration.session, calibration.solution.method),
            ),
            section_text("Truth (the emulator's)", *truth),
            f"Session file: {one_line(str(calibration.path))}\n{ending}",
        ]
    )


def fit_text(judged: FileAnalysis, *, plot: bool) -> str:
    """A fit of files: points, coefficients, what the fit says of itself, forecast, verdict."""
    parts = [text_of(Sentences(judged.warnings))] if judged.warnings else []
    parts += [
        section_text("Points", *file_points_table(listed_of_files(judged.files), judged.solution)),
        section_text("Coefficients", coefficients_table(judged.solution)),
        section_text("Fit", *fit_summary(judged.solution)),
    ]
    if judged.analysis is not None:
        parts += _judged(judged.analysis, judged.tolerance_deg)
    if plot:
        data = table_plot_data(judged.table, judged.solution)
        parts.append(error_plot(data, _sheet()))
    if judged.findings:
        nothing = NOTHING_FOUND if judged.analysis is not None else NOTHING_FOUND_OF_SIX
        parts.append(diagnosis_section(judged.findings, nothing))
    return "\n\n".join(parts)


def record_line(record: Record, *, dated: bool = False) -> str:
    """One record in one line, as the log and a replay tell it."""
    day, time = date_and_time(record.utc)
    when = f"{day} {time}" if dated else time
    return f"{when}  {record.seq:>4}  {one_line(record_words(record))}"


def record_lines(records: Sequence[Record]) -> list[str]:
    """One line a record, with its date where they are of more than one day."""
    dated = len({date_and_time(record.utc)[0] for record in records}) > 1
    return [record_line(record, dated=dated) for record in records]


def record_words(record: Record) -> str:
    """What a record says, without its time and number."""
    match record:
        case Initialised():
            return f"data file initialised, {from_limit(record.distance_to_limits_deg, 1)}"
        case ClockSet():
            return (
                f"unit clock set: {record.before_s:+z.3f} s before, {record.after_s:+z.3f} s after"
            )
        case RefCheck():
            done = "" if record.complete else " (broken off)"
            return f"reference check {record.number}{done}: {found_words(record)}"
        case SunOffset():
            return f"Set Sun Offset: O = {record.offsets.O1:+z.4f}, {record.offsets.O2:+z.4f} deg"
        case PointRecord():
            told = f"point {record.status}"
            if record.error_deg is not None:
                told += f": error {record.error_deg[0]:+z.4f}, {record.error_deg[1]:+z.4f} deg"
            return told + (f" ({record.reason})" if record.reason else "")
        case CheckRecord():
            left = record.sky_error_deg
            told = f"check point {record.status}"
            return told + (f": {left:.4f} deg left on the sky" if left is not None else "")
        case FitRecord():
            # As much as a row of 80 columns holds behind time and number.
            values = " ".join(f"{p:+z.3f}" for p in record.coefficients.as_tuple()[:4])
            those = counted(record.points, "point")
            return f"fit, {those}, rms {record.sky_rms_deg:.3f}: P1..4 {values}"
        case UploadRecord():
            kind = "rollback" if record.rollback else "upload"
            if record.failure:
                return f"{kind} FAILED: {record.failure}"
            return f"{kind}, read back {'equal' if record.verified else 'DIFFERENT'}"
        case UploadBegun():
            return f"{'rollback' if record.rollback else 'upload'} begun"
        case InForce():
            return (
                "the unit holds what was uploaded"
                if record.as_uploaded
                else "the unit does NOT hold what was uploaded"
            )
        case Restarted():
            return "the unit has restarted and lost its reference"
        case Typed():
            values = " ".join(f"{name} {text}" for name, text in record.values.items())
            doubted = f" (kept: {'; '.join(record.kept)})" if record.kept else ""
            if record.corrected:
                doubted += " (corrected)"
            return f"typed for {record.form}: {values}{doubted}"
        case Note():
            return f"note: {record.text}"
        case Void():
            return f"record {record.voids} voided: {record.reason}"
        case Override():
            return f"guard overruled ({record.guard}): {record.reason}"
        case LinkLost():
            return f"link lost: {record.reason}"
        case LinkRestored():
            again = f", lost {counted(record.losses, 'more time')} before" if record.losses else ""
            return f"link restored to unit {record.serial}{again}"
        case UnknownRecord():
            return f"{record.type} (not known to this version)"
        case _:
            return type(record).__name__.lower()


def replay_text(replay: "Replay") -> str:
    """A session record by record, then its end."""
    session = replay.view
    log = "\n".join(record_lines(session.records))
    parts = [text_of(Sentences(replay.warnings))] if replay.warnings else []
    parts += [
        f"What happened\n-------------\n{log}",
        session_text(session, analyse_session(session)),
    ]
    return "\n\n".join(parts)


def hand_calibration_text(calibration: "HandCalibration") -> str:
    """A field book's whole calibration; last what to key in, and whether that was done."""
    session = calibration.session
    parts = [session_text(session, analyse_session(session, calibration.method))]
    if calibration.key_in:
        table = key_in_table(calibration.key_in, session.header.geometry)
        parts.append(section_text("Coefficients to key in", table))
    parts.append(f"Session file: {one_line(str(calibration.path))}\n{_hand_ending(calibration)}")
    return "\n\n".join(parts)


def _hand_ending(calibration: "HandCalibration") -> str:
    """Where the calibration stands, in a sentence."""
    upload = calibration.upload
    if not calibration.key_in:
        return "Too few points: coefficients need at least three."
    if upload is None:
        return (
            "NOT keyed in yet: key these in, set both offsets to 0, store; then add a line "
            "`upload` with the displayed values."
        )
    if upload.rollback:
        return "Rolled back: the unit holds its previous values."
    if not upload.verified:
        return "NOT completed: the display does not show the values to key in."
    if calibration.session.offset_left is not None:
        return (
            "NOT completed: the newest Set Sun Offset is still in the unit: take a check point "
            "with a new one (lines `offset`, `check` and `zero`), or key the coefficients in again "
            "(`upload`)."
        )
    return "Calibration completed, keyed in and typed back equal."
