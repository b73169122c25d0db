"""A calibration done by hand, from its field book: the same steps, the same session every time."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from solarcal.errors import ProcedureRefused
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import Offsets
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import Header, Record, Typed, UploadRecord
from solarcal.session.view import SessionView
from solarcal.station.connect import open_tracker
from solarcal.station.procedure import Station
from solarcal.station.recording import profile_settings
from solarcal.station.typed.entry_forms import key_in_texts
from solarcal.station.typed.field_book import BookClock, Entry, FieldBook
from solarcal.station.uploading import UploadOffer, propose_upload, refuse_doubtful
from solarcal.stopping_rule import UNSYNCHRONISED_S

Tell = Callable[[Record], None]


@dataclass(frozen=True, slots=True)
class HandCalibration:
    """What a field book came to.

    Attributes
    ----------
    proposal : what the points say is to be keyed in; ``None`` with too few.
    upload : the newest upload or rollback; ``None`` where none was keyed in.
    """

    session: SessionView
    path: Path
    proposal: UploadOffer | None
    upload: UploadRecord | None
    method: str = DEFAULT_METHOD

    @property
    def completed(self) -> bool:
        """The coefficients were keyed in, typed back equal, and no Set Sun Offset was left in."""
        keyed_in = self.upload is not None and self.upload.verified and not self.upload.rollback
        return keyed_in and self.session.offset_left is None

    @property
    def key_in(self) -> tuple[tuple[str, str], ...]:
        """Names and values to key in, with both offsets zero; empty with too few points."""
        if self.proposal is None:
            return ()
        unit = self.session.header.unit
        return key_in_texts(
            self.proposal.rounded, Offsets(), (unit.tilt_decimals, unit.scale_decimals)
        )


def calibrate_by_book(
    lines: Iterable[str],
    name: str,
    profile: Profile,
    create_journal: Callable[[Header], Journal],
    *,
    method: str = DEFAULT_METHOD,
    tell: Tell = lambda record: None,
) -> HandCalibration:
    """Do what a field book says, line by line.

    Raises
    ------
    InputFileError
        A line that cannot be; the session file keeps everything above it.
    ConfigurationError
        The profile lacks the site.
    ProcedureRefused
        A step the procedure does not allow there; names the line.
    """
    clock = BookClock()
    book = FieldBook(lines, name, clock)
    tracker = open_tracker("", "typed", profile=profile, display=book, clock=clock)
    station = Station(tracker, clock, **profile_settings(profile, UNSYNCHRONISED_S))
    station.connect()
    journal = station.open_session(create_journal)
    try:
        _perform(station, book, method, tell)
        proposal = propose_upload(station.session, station.coefficients_in_force, method)
        uploads = station.session.uploads
        calibration = HandCalibration(
            station.session,
            journal.path or Path(),
            proposal,
            uploads[-1] if uploads else None,
            method,
        )
        if calibration.completed:
            station.close("calibration finished")
        else:
            # To go on with at the unit, or with a longer book.
            station.leave()
    finally:
        journal.close()
    return replace(calibration, session=station.session)


def _perform(station: Station, book: FieldBook, method: str, tell: Tell) -> None:
    told = 0
    while (entry := book.next_entry()) is not None:
        try:
            _STEPS[entry.step](station, entry, method)
        except ProcedureRefused as refusal:
            raise ProcedureRefused(f"{entry.where}: {refusal}") from None
        finally:
            records = station.session.records
            for record in records[told:]:
                if not isinstance(record, Typed) or record.kept or record.corrected:
                    tell(record)
            told = len(records)


def _point(station: Station, entry: Entry, method: str, *, check: bool = False) -> None:
    station.begin_point(check=check, override_reason=entry.reason or None)
    asked = 3
    if not entry.answers or (all(entry.answers) and len(entry.answers) < asked):
        station.abort_attempt("not answered in the field book")
        raise entry.error("answer the three questions: yes yes yes, or up to the first no")
    for yes in entry.answers:
        if station.answer(yes).question is None or not yes:
            break
    if station.state.attempt is None:
        return
    if entry.stores is None:
        station.abort_attempt("not decided in the field book")
        raise entry.error("store it or not? End the line with `store`, or `reject` and why")
    station.gather_point()
    station.store(entry.stores, "" if entry.stores else entry.reason)
    if entry.stores and not check:
        station.record_newest_fit(method)


def _upload(station: Station, entry: Entry, method: str) -> None:
    proposal = propose_upload(station.session, station.coefficients_in_force, method)
    if proposal is None:
        raise ProcedureRefused("too few points to compute coefficients worth keying in")
    forced = refuse_doubtful(proposal, entry.reason or None)
    station.upload(proposal.rounded, method=method, forced=forced)


def _void(station: Station, entry: Entry, method: str) -> None:
    del method
    number, _, reason = entry.reason.partition(" ")
    if not number.isdigit() or not reason:
        raise entry.error("void which record, and why? `void 12 the spot had moved`")
    station.void(int(number), reason)


def _initialise(station: Station, entry: Entry, method: str) -> None:
    del method
    station.initialise(confirmed=True, override_reason=entry.reason or None)


def _belongs_elsewhere(station: Station, entry: Entry, method: str) -> None:
    del station, method
    raise entry.error(f"nothing above needs a line `{entry.step}`")


_STEPS: dict[str, Callable[[Station, Entry, str], object]] = {
    "clock": lambda station, entry, method: station.set_unit_clock(),
    "reference": lambda station, entry, method: station.ref_check(),
    "offset": lambda station, entry, method: station.set_sun_offset(),
    "initialise": _initialise,
    "point": _point,
    "check": partial(_point, check=True),
    "upload": _upload,
    "rollback": lambda station, entry, method: station.rollback(),
    "note": lambda station, entry, method: station.note(entry.reason),
    "void": _void,
    **dict.fromkeys(("open", "zero", "held", "again", "keep"), _belongs_elsewhere),
}
