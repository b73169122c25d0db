"""What a calibration by hand ends in: the session, and the coefficients to key in."""

from typing import TYPE_CHECKING

from solarcal.model.terms import TERMS
from solarcal.report.columns import columns
from solarcal.report.fit_tables import meaning
from solarcal.report.session_report import section, session_text
from solarcal.station.analysing import analyse_session

if TYPE_CHECKING:
    from solarcal.station.typed.field_book_calibration import HandCalibration


def key_in_table(key_in: tuple[tuple[str, str], ...], geometry: str) -> str:
    """Values as the unit keeps them, in the order of its keys."""

    rows = []
    for name, value in key_in:
        term = TERMS.get(name)
        words = meaning(term, geometry) if term is not None else f"reference offset, axis {name[1]}"
        rows.append([name, value, term.unit if term is not None else "deg", words])
    return "\n".join(columns(("", "key in", "unit", "meaning"), rows, "<><<"))


def hand_calibration_text(calibration: "HandCalibration") -> str:
    """A field book's calibration, told whole; last what to key in, and whether that was done."""
    session = calibration.session
    parts = [session_text(session, analyse_session(session, calibration.method))]
    if calibration.key_in:
        table = key_in_table(calibration.key_in, session.header.geometry)
        parts.append(section("Coefficients to key in", table))
    parts.append(f"Session file: {calibration.path}\n{ending(calibration)}")
    return "\n\n".join(parts)


def ending(calibration: "HandCalibration") -> str:
    """Where the calibration stands, in a sentence."""
    upload = calibration.upload
    if not calibration.key_in:
        return "Too few points: three are the least from which coefficients are computed."
    if upload is None:
        return (
            "NOT keyed in yet: key these in, set both offsets to 0, store; then add a line "
            "`upload` with what the display shows."
        )
    if upload.rollback:
        return "Rolled back: the unit holds what it held before."
    if not upload.verified:
        return "NOT completed: the display shows something else than was to be keyed in."
    return "Calibration completed, keyed in and typed back equal."
