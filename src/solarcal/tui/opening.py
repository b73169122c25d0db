"""From a choice of the start screen to a unit on a line with its session open.

Everything here may take seconds: it is called on a thread.
"""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from solarcal.clock import Clock, SystemClock
from solarcal.config import Choice, file_stem, new_session_path, sessions_dir
from solarcal.errors import SolarcalError
from solarcal.plain_text import harmless
from solarcal.profiles import Profile
from solarcal.unit.drivers import demand_driver

if TYPE_CHECKING:
    from solarcal.session.journal import Journal
    from solarcal.session.records import Header
    from solarcal.station.procedure import Station
    from solarcal.station.state import SessionView
    from solarcal.station.typed.forms import Display
    from solarcal.unit.tracker import Tracker

NEWEST_SESSIONS = 40
"""How many saved sessions the start screen looks into."""

CreateJournal = Callable[["Header"], "Journal"]


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
    """What was noticed on the way: a torn file, a unit that believes in another site or Sun."""

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


def finished(session: "SessionView") -> str:
    """Why a session needs no going on with, or nothing: then the start screen offers it first."""
    if any(upload.verified and not upload.rollback for upload in session.uploads):
        return "calibration finished"
    if session.initialised is None and not session.accepted:
        return "left before the calibration was begun"
    return ""


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
    from solarcal.station.connect import open_tracker
    from solarcal.station.connecting import disagreements
    from solarcal.station.emulated_clock import EmulatedClock
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
            tolerance_deg=profile.tolerance_deg,
            done_probability=profile.done_probability,
            inclinometer=None if emulated else profile.inclinometer,
        )
        station.connect()
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
    from solarcal.timescale import parse_utc

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
    from solarcal.timescale import parse_utc

    emulator = Emulator(
        load_scenario(choice.scenario, list(choice.settings)),
        start_utc_s=parse_utc(choice.start_utc) if choice.start_utc else None,
        seed=choice.seed,
        noise_deg=choice.noise_deg,
        speed=1.0 if choice.speed is None else choice.speed,
    )
    with serve_here(emulator) as url:
        yield url


# -- saved sessions --------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class SavedSession:
    """A session file as the start screen offers it; ``damage`` says why it cannot be read."""

    path: Path
    last_utc: str = ""
    points: int = 0
    finished: bool = True
    damage: str = ""
    by_hand: bool = False

    def words(self) -> str:
        name = harmless(self.path.name)
        if self.damage:
            return f"{name}  cannot be read"
        plural = "" if self.points == 1 else "s"
        return f"{name}  {self.points} point{plural}, last {self.last_utc[:16]}Z"


def saved_sessions(folder: Path | None = None) -> list[SavedSession]:
    """The newest session files, newest first."""
    folder = folder or sessions_dir()
    if not folder.is_dir():
        return []
    files = [(path.stat().st_mtime, path) for path in folder.glob("*.jsonl")]
    files.sort(key=lambda entry: (-entry[0], entry[1].name))
    return [look_into(path) for _, path in files[:NEWEST_SESSIONS]]


def look_into(path: Path) -> SavedSession:
    """A session file in one line, or why it cannot be read."""
    from solarcal.session.reader import read_session
    from solarcal.session.records import Closed, PointRecord

    try:
        session = read_session(path)
    except SolarcalError as error:
        return SavedSession(path, damage=str(error))
    last = session.records[-1] if session.records else session.header
    accepted = sum(
        isinstance(record, PointRecord) and record.status == "accepted"
        for record in session.records
    )
    imported = session.header.sun_model != "solartrak"
    return SavedSession(
        path,
        last.utc,
        accepted,
        isinstance(last, Closed) or imported,
        by_hand=session.header.unit.typed,
    )


def continuing(saved: SavedSession, remembered: Choice | None) -> Choice | None:
    """How to go on with a session: the line it was taken on, if that is known.

    An emulator of this process died with it: another one of the same truth takes over at the time
    the session broke off.
    """
    if remembered is None:
        return Choice(driver="typed", session=str(saved.path)) if saved.by_hand else None
    start = saved.last_utc if remembered.scenario else ""
    return msgspec.structs.replace(remembered, session=str(saved.path), start_utc=start)
