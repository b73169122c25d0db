"""The session file of a station and the state that everyone sees.

A record is written and synced BEFORE the state shows it. Time comes from an injected clock.
"""

import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypeVar, Unpack

import msgspec

from solarcal.errors import ProcedureRefused
from solarcal.mount.geometry import MountGeometry
from solarcal.session.journal import Journal
from solarcal.session.records import Answers, CheckRecord, Header, KnownRecord, PointRecord, Typed
from solarcal.session.view import SessionView, view_session
from solarcal.station.session_header import SessionSettings, session_header
from solarcal.station.state import Activity, Attempt, StationState
from solarcal.station.typed.forms import TypedAnswer
from solarcal.sun import sun_position
from solarcal.timescale import Clock, format_utc
from solarcal.unit.tracker import Tracker, UnitSite

Recorded = TypeVar("Recorded", bound=KnownRecord)
Listener = Callable[[StationState], object]
CreateJournal = Callable[[Header], Journal]


class StationFile:
    """One session, its file and the state: what every step is recorded by.

    Parameters
    ----------
    tracker : the unit.
    clock : the laptop's clock (the emulator's when the unit is one).
    settings : what the header of its sessions says beside the unit.
    """

    def __init__(self, tracker: Tracker, clock: Clock, **settings: Unpack[SessionSettings]) -> None:
        self.tracker = tracker
        self.clock = clock
        self.unit_site: UnitSite | None = None
        self._settings = settings
        self._journal: Journal | None = None
        self._change = threading.RLock()
        self._listeners: list[Listener] = []
        self._state = StationState()
        self._typed_before: list[TypedAnswer] = []
        if tracker.display is not None:
            tracker.display.listen(self._take_down)

    @property
    def state(self) -> StationState:
        return self._state

    @property
    def session(self) -> SessionView:
        if self._state.session is None:
            raise ProcedureRefused("no session is open; connect to a unit first")
        return self._state.session

    @property
    def session_path(self) -> Path | None:
        """The session's file; ``None`` without one, or while it is kept in memory."""
        return self._journal.path if self._journal is not None else None

    @property
    def geometry(self) -> MountGeometry:
        return self.session.geometry

    def sun_elevation_deg(self) -> float:
        """Airless elevation of the Sun for the laptop's clock at our site."""
        sun = sun_position("precise", self.clock.utc_s(), self.session.header.site)
        return float(sun.elevation_deg)

    def subscribe(self, listener: Listener) -> None:
        """Call ``listener`` with every new state, from whichever thread made it."""
        self._listeners.append(listener)

    def _become(self, **changes: object) -> None:
        with self._change:
            self._state = replace(
                self._state,
                generation=self._state.generation + 1,
                **changes,  # type: ignore[arg-type]
            )
            state = self._state
        for listener in self._listeners:
            listener(state)

    def _live(self, **changes: object) -> None:
        with self._change:
            self._become(live=replace(self._state.live, **changes))  # type: ignore[arg-type]

    def _record(self, make: Callable[..., Recorded]) -> Recorded:
        """Append to the journal, and only then show it. ``make`` is given ``seq`` and ``utc``."""
        utc = format_utc(self.clock.utc_s())
        with self._change:
            journal = self._open_journal()
            record = make(seq=journal.next_seq, utc=utc)
            journal.append(record)
            self._become(session=view_session(journal.header, tuple(journal.records)))
        return record

    def _take_down(self, answer: TypedAnswer) -> None:
        """Keep what was typed, before anything is made of it."""
        if self._journal is None:
            self._typed_before.append(answer)
            return
        self._record(
            partial(
                Typed,
                form=answer.form.word,
                read_utc=format_utc(answer.read_utc_s),
                values={name: text for name, text in answer.texts.items() if text},
                kept=answer.kept,
                corrected=tuple(dict(texts) for texts in answer.corrected),
            )
        )

    def _use(self, journal: Journal) -> None:
        """Record into this file from now on: what was typed before it was there first."""
        self._journal = journal
        self._become(session=view_session(journal.header, tuple(journal.records)))
        self._recall_heliostat()
        waiting, self._typed_before = self._typed_before, []
        for answer in waiting:
            self._take_down(answer)

    def _open_journal(self) -> Journal:
        if self._journal is None:
            raise ProcedureRefused("no session file is open; connect to a unit first")
        return self._journal

    def _recall_heliostat(self) -> None:
        """What the session's header says of target and mirror belongs to the unit's place."""
        session = self._state.session
        if session is not None and self.unit_site is not None:
            self.unit_site = msgspec.structs.replace(
                self.unit_site, heliostat=session.header.unit.heliostat
            )

    def open_session(self, create: CreateJournal) -> Journal:
        """Open a session file at once: ``create`` gets the header and returns its journal."""
        journal = create(self._header())
        self._use(journal)
        return journal

    def _header(self, continues: str = "") -> Header:
        identity, unit_site = self._state.live.identity, self.unit_site
        if identity is None or unit_site is None:
            raise ProcedureRefused("no unit is connected; connect first")
        return session_header(
            self.tracker, identity, unit_site, self.clock.utc_s(), self._settings, continues
        )

    def abort_attempt(
        self, reason: str, answers: Answers | None = None
    ) -> PointRecord | CheckRecord:
        """Give the attempt up; it stays in the file as aborted and is never fitted.

        ``answers``: those given, where the last of them ends the attempt. No state is announced in
        which a fourth question would be open.
        """
        attempt: Attempt | None = self._state.attempt
        if attempt is None:
            raise ProcedureRefused("no point is being taken")
        given: Answers = answers or attempt.answers
        kind = CheckRecord if attempt.check else PointRecord
        record: PointRecord | CheckRecord = self._record(
            lambda seq, utc: kind(seq=seq, utc=utc, status="aborted", answers=given, reason=reason)
        )
        self._become(activity=Activity.IDLE, attempt=None)
        return record
