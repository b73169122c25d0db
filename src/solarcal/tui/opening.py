"""From a choice of the start screen to a unit on a line with its session open.

Everything here may take seconds: it is called on a thread.
"""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from solarcal.config import Choice, file_stem, new_session_path
from solarcal.errors import ProcedureRefused, SolarcalError
from solarcal.profiles import Profile
from solarcal.station.saved_sessions import finished, unfinished_sessions
from solarcal.stopping_rule import SYNCHRONISED_S
from solarcal.timescale import Clock, SystemClock, parse_utc
from solarcal.unit.drivers import demand_driver

if TYPE_CHECKING:
    from solarcal.session.journal import Journal
    from solarcal.session.records import Header
    from solarcal.station.procedure import Station
    from solarcal.station.typed.forms import Display
    from solarcal.unit.tracker import Tracker, UnitIdentity

CreateJournal = Callable[["Header"], "Journal"]


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

    station: "Station"
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
    choice: Choice,
    profile: Profile,
    *,
    output: Path | None = None,
    trace: str | None = None,
    display: "Display | None" = None,
) -> OpenLine:
    """Open the line, learn who is there, and open or continue the session file.

    Parameters
    ----------
    display : who reads the display of a unit without a line.

    Raises
    ------
    SolarcalError
        Nothing stays open then.
    """
    from solarcal.station.clocks import EmulatedClock, clock_sigma_s
    from solarcal.station.connect import disagreements, open_tracker
    from solarcal.station.procedure import Station

    with contextlib.ExitStack() as resources:
        tracker: Tracker
        if choice.scenario and demand_driver(choice.driver).rotator is not None:
            tracker = _emulated_unit(choice)
        else:
            url = choice.port
            if choice.scenario:
                url = resources.enter_context(_emulated_line(choice))
            tracker = open_tracker(
                url,
                choice.driver,
                trace=trace,
                baudrate=choice.baudrate,
                profile=profile,
                display=display,
            )
        resources.callback(tracker.close)
        emulated = tracker.emulation is not None
        clock: Clock = SystemClock()
        if tracker.emulation is not None:
            clock = EmulatedClock(tracker.emulation)
        # An emulated tracker stands at its own place, whatever site the profile is for.
        station = Station(
            tracker,
            clock,
            site=None if emulated else profile.site,
            weather=None if emulated else profile.weather,
            operator=profile.operator,
            pointing_device=profile.pointing_device,
            rule=profile.rule(SYNCHRONISED_S if emulated else clock_sigma_s()),
            inclinometer=None if emulated else profile.inclinometer,
        )
        identity = station.connect()
        if choice.offers_unfinished and not choice.session and output is None:
            _offer_unfinished(choice, identity)
        create = _journal_creator(choice, station, output)
        if choice.session:
            journal = _continue(station, Path(choice.session))
        else:
            journal = station.open_session(create)
            if profile.inclinometer is not None and not emulated:
                station.note(profile.inclinometer.words())
        noticed = (*journal.warnings, *disagreements(station))
        path = journal.path or Path()
        return OpenLine(station, choice, path, resources.pop_all(), create, clock, noticed)


def _offer_unfinished(choice: Choice, identity: "UnitIdentity") -> None:
    """Leave it to the technician where this unit has sessions to go on with."""
    anew = msgspec.structs.replace(choice, offers_unfinished=False)
    entries = [
        (saved.words(), msgspec.structs.replace(anew, session=str(saved.path)))
        for saved in unfinished_sessions(identity.model, identity.serial)
    ]
    if entries:
        raise UnfinishedSessions(f"{identity.model} {identity.serial}", entries, anew)


def _continue(station: "Station", path: Path) -> "Journal":
    from solarcal.session.journal import Journal

    journal = Journal.resume(path)
    try:
        station.resume_session(journal)
    except SolarcalError:
        journal.close()
        raise
    return journal


def _journal_creator(choice: Choice, station: "Station", output: Path | None) -> CreateJournal:
    """Where session files go; only the first one may take the name asked for."""
    waiting = [output] if output is not None else []

    def create(header: "Header") -> "Journal":
        from solarcal.session.journal import Journal

        name = file_stem(choice.scenario or header.unit.serial or "unit")
        path = waiting.pop() if waiting else new_session_path(name, header.utc)
        return Journal.create(path, header)

    return create


def _emulated_unit(choice: Choice) -> "Tracker":
    """An emulated unit that no line is emulated for: it is spoken to within this process."""
    from solarcal.emulated_units import emulated_unit

    return emulated_unit(
        choice.scenario,
        choice.driver,
        settings=choice.settings,
        start_utc_s=parse_utc(choice.start_utc) if choice.start_utc else None,
        seed=choice.seed,
        noise_deg=choice.noise_deg,
        speed=1.0,
    ).tracker


@contextlib.contextmanager
def _emulated_line(choice: Choice) -> Iterator[str]:
    """An emulator in a thread of this process, on a line like any other."""
    from solarcal.emulator.emulation import Emulator
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import serve_here

    emulator = Emulator(
        load_scenario(choice.scenario, list(choice.settings)),
        start_utc_s=parse_utc(choice.start_utc) if choice.start_utc else None,
        seed=choice.seed,
        noise_deg=choice.noise_deg,
        speed=1.0 if choice.speed is None else choice.speed,
    )
    with serve_here(emulator) as url:
        yield url
