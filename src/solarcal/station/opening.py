"""From a tracker on its line to a station with its session open, new or gone on with; and the end.

Everything here may take seconds: it is called on a thread.
"""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec

from solarcal.config import Choice, file_stem, new_session_path
from solarcal.errors import ProcedureRefused
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import Header
from solarcal.station.clocks import clock_beside, clock_sigma_s
from solarcal.station.connect import disagreements, other_site
from solarcal.station.procedure import Station
from solarcal.station.recording import profile_settings
from solarcal.station.saved_sessions import finished, unfinished_sessions
from solarcal.stopping_rule import SYNCHRONISED_S
from solarcal.timescale import Clock
from solarcal.unit.tracker import Tracker, UnitIdentity

CreateJournal = Callable[[Header], Journal]


class UnfinishedSessions(ProcedureRefused):
    """The unit that answers has sessions to go on with: the technician chooses.

    Attributes
    ----------
    entries : words and the choice that goes on with each, the newest first.
    anew : the choice that begins a new one all the same.
    """

    def __init__(self, unit: str, entries: list[tuple[str, Choice]], anew: Choice) -> None:
        super().__init__(
            f"{unit} has unfinished sessions: choose one to go on with, or begin a new one"
        )
        self.entries = entries
        self.anew = anew


@dataclass(slots=True)
class OpenLine:
    """A station on its line, and what has to be given up again when it is left."""

    station: Station
    choice: Choice
    path: Path
    resources: contextlib.ExitStack
    create_journal: CreateJournal
    clock: Clock
    noticed: tuple[str, ...] = ()
    """What was noticed on the way: a torn file, a unit with another site or Sun."""

    def close(self) -> None:
        """Leave the session complete, and the line free."""
        station = self.station
        try:
            session = station.state.session
            if station.state.attempt is not None:
                station.abort_attempt("left the program")
            reason = finished(session) if session is not None else "nothing was recorded"
            if reason:
                station.close(reason)
            else:
                station.leave()
        finally:
            self.resources.close()


def open_line(
    tracker: Tracker, choice: Choice, profile: Profile, *, output: Path | None = None
) -> OpenLine:
    """Learn who is on the line, and open or continue the session file.

    ``tracker``: not opened yet; it is closed with the line. Nothing stays open after an error.
    """
    with contextlib.ExitStack() as resources:
        resources.callback(tracker.close)
        emulated = tracker.emulation is not None
        clock = clock_beside(tracker.emulation)
        settings = profile_settings(profile, SYNCHRONISED_S if emulated else clock_sigma_s())
        if emulated:
            # It stands at its own place, whatever site the profile is for.
            settings |= {"site": None, "weather": None}
        if choice.scenario:
            # The profile is that of another tower.
            settings |= {"inclinometer": None, "last_coefficients": choice.last_coefficients}
        station = Station(tracker, clock, **settings)
        offers = choice.offers_unfinished and not choice.session and output is None
        if offers and tracker.display is not None:
            # Before the technician types what the unit holds.
            _offer_unfinished(choice, tracker, tracker.display.identity)
        identity = station.connect()
        if offers:
            _offer_unfinished(choice, tracker, identity)
        create = _journal_creator(choice, output)
        if choice.session:
            journal = Journal.resume(choice.session)
            station.resume_session(journal)
        else:
            journal = station.open_session(create)
            if profile.inclinometer is not None and not choice.scenario:
                station.note(profile.inclinometer.words())
        site = profile.site if emulated and not choice.scenario else None
        noticed = (*journal.warnings, *other_site(station, site), *disagreements(station))
        path = journal.path or Path()
        return OpenLine(station, choice, path, resources.pop_all(), create, clock, noticed)


def _offer_unfinished(choice: Choice, tracker: Tracker, identity: UnitIdentity) -> None:
    """Leave it to the technician where this unit has sessions to go on with."""
    here, target = tracker.site(), tracker.parameters().target
    anew = msgspec.structs.replace(choice, offers_unfinished=False)
    entries = [
        (saved.words(), msgspec.structs.replace(anew, session=str(saved.path)))
        for saved in unfinished_sessions(
            identity.model, identity.serial, here.geometry, here.site, target
        )
    ]
    if entries:
        raise UnfinishedSessions(f"{identity.model} {identity.serial}", entries, anew)


def _journal_creator(choice: Choice, output: Path | None) -> CreateJournal:
    """Where session files go; only the first one may take the name asked for."""
    waiting = [output] if output is not None else []

    def create(header: Header) -> Journal:
        name = file_stem(choice.scenario or header.unit.serial or "unit")
        path = waiting.pop() if waiting else new_session_path(name, header.utc)
        return Journal.create(path, header)

    return create
