"""The section an owner looks for: as found, as fitted, as uploaded, as measured."""

from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS
from solarcal.report.columns import number
from solarcal.report.renderables import Block, Facts, Section, Sentences, Table
from solarcal.session.records import UploadRecord
from solarcal.station.analysing import FileAnalysis
from solarcal.station.sign_off import SignOff, forecast_with
from solarcal.timescale import format_utc, parse_utc


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
        rows.append((f"with what was {_done(newest)} {newest.utc[:16].replace('T', ' ')}", left))
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
        blocks += [_upload_table(newest), Sentences(_upload_sentences(judged, after, newest))]
    if after.checks:
        blocks.append(_check_table(after, judged.tolerance_deg))
    blocks.append(Facts((("measured after the upload", after.reason), *_measured(after))))
    return Section("Before and after", tuple(blocks))


def _done(upload: UploadRecord) -> str:
    return "restored" if upload.rollback else "uploaded"


def _measured(after: SignOff) -> tuple[tuple[str, str], ...]:
    if after.sky_rms_deg is None:
        return ()
    return (("left on the sky, rms", f"{after.sky_rms_deg:.3f} deg"),)


def _upload_table(upload: UploadRecord) -> Table:
    old = (*upload.old_coefficients.as_tuple(), upload.old_offsets.O1, upload.old_offsets.O2)
    new = (*upload.new_coefficients.as_tuple(), upload.new_offsets.O1, upload.new_offsets.O2)
    rows = tuple(
        (name, *(number(v, 6 if unit == "deg/deg" else 4, True) for v in (a, b, b - a)), unit)
        for name, unit, a, b in zip(
            (*COEFFICIENT_NAMES, "O1", "O2"), (*COEFFICIENT_UNITS, "deg", "deg"), old, new,
            strict=True,
        )
    )  # fmt: skip
    return Table(("", "before", "after", "difference", "unit"), rows, "<>>><")


def _upload_sentences(
    judged: FileAnalysis, after: SignOff, newest: UploadRecord
) -> tuple[str, ...]:
    said = [
        "the unit read back exactly these numbers"
        if newest.verified
        else "the unit did NOT read back these numbers"
    ]
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
                f"({judged.solution.method}, {judged.solution.n_points} points)"
            )
    return tuple(said)


def _check_table(after: SignOff, tolerance_deg: float) -> Table:
    rows = []
    for check in after.checks:
        ideal, error = check.ideal_deg or (None, None), check.error_deg or (None, None)
        sky = check.sky_error_deg
        rows.append(
            (
                str(check.seq),
                format_utc(parse_utc(check.read_utc or check.utc), 0)[:19].replace("T", " "),
                *(number(value, 3) for value in ideal),
                *(number(value, 3, True) for value in error),
                number(sky, 3),
                "within" if sky is not None and sky <= tolerance_deg else "BEYOND",
            )
        )
    headings = (
        "check", "UTC", "AX1", "AX2", "left 1", "left 2", "on sky", f"of {tolerance_deg:g}",
    )  # fmt: skip
    return Table(headings, tuple(rows), "><>>>>><")
