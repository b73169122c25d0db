"""The session file of a station: its header, its records, and the state that everyone sees.

The header is the unit as it answers, and what the technician says beside it. A record is written
and synced BEFORE the state shows it. Time comes from an injected clock.
"""

import threading
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TypedDict, TypeVar, Unpack

import msgspec

from solarcal import __version__
from solarcal.decimals import Six
from solarcal.errors import ProcedureRefused
from solarcal.mount.drive import Drive
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import MountGeometry
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.points import SITE_TOLERANCE_DEG
from solarcal.session.records import (
    Answers,
    CheckRecord,
    Header,
    KnownRecord,
    PointRecord,
    Typed,
    UnitRecord,
)
from solarcal.session.view import SessionView, view_session
from solarcal.site import (
    BoltCircle,
    Inclinometer,
    Site,
    Weather,
    longitude_apart_deg,
    standard_pressure_hpa,
)
from solarcal.station.state import Activity, Attempt, StationState
from solarcal.station.typed.forms import TypedAnswer
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule
from solarcal.sun import sun_position
from solarcal.timescale import Clock, format_utc
from solarcal.unit.tracker import Tracker, UnitIdentity, UnitParameters, UnitSite


class SessionSettings(TypedDict, total=False):
    """What a header says beside the unit.

    ``site``: the technician's; the unit's own when None. ``weather``: station pressure and
    temperature; the standard atmosphere's when None. ``rule``: when the calibration is done.
    ``true_sun``: the Sun the points are taken on; another than ``precise`` only in an emulated
    world. ``target``: what the points are taken on, ``sun`` or ``moon``.
    """

    site: Site | None
    weather: Weather | None
    true_sun: str
    target: str
    operator: str
    pointing_device: str
    rule: StoppingRule
    inclinometer: Inclinometer | None
    last_coefficients: Six | None
    bolt_circle: BoltCircle | None


def profile_settings(profile: Profile, clock_s: float) -> SessionSettings:
    """What a profile says of a session; ``clock_s``: how well the laptop's clock is known."""
    return {
        "site": profile.site,
        "weather": profile.weather,
        "operator": profile.operator,
        "pointing_device": profile.pointing_device,
        "rule": profile.rule(clock_s),
        "inclinometer": profile.inclinometer,
        "last_coefficients": profile.last_coefficients,
        "bolt_circle": profile.bolt_circle,
    }


def refuse_another_unit(
    header: Header, identity: UnitIdentity, site: UnitSite, parameters: UnitParameters
) -> None:
    """A session goes on with its own unit, set up as it was; limits and decimals may differ.

    Refused (ProcedureRefused) is another unit, or one whose read-outs have another meaning.
    """
    ours = header.unit
    name = f"unit {ours.model} {ours.serial}"
    if (identity.model, identity.serial) != (ours.model, ours.serial):
        raise ProcedureRefused(
            f"the session belongs to {name}, but {identity.model} {identity.serial} is connected; "
            "start a new session"
        )
    for what, now, then in (
        ("geometry", site.geometry, header.geometry),
        ("centre of the branch of axis 1", site.ax1_centre_deg, header.ax1_centre_deg),
        ("reference position of axis 1", parameters.reference1_deg, ours.reference1_deg),
        ("reference position of axis 2", parameters.reference2_deg, ours.reference2_deg),
        ("drive of axis 1", _drive_words(parameters.drive1), _drive_words(ours.drive1)),
        ("drive of axis 2", _drive_words(parameters.drive2), _drive_words(ours.drive2)),
    ):
        if now != then:
            raise ProcedureRefused(
                f"{name} has another {what} now ({now}) than in this session ({then}): the "
                "session's points and coefficients do not apply; calibrate again"
            )
    for what, here, there in (
        ("latitude", site.site.latitude_deg, ours.site.latitude_deg),
        ("longitude", site.site.longitude_deg, ours.site.longitude_deg),
    ):
        # Latitudes are never so far apart that it matters.
        if abs(longitude_apart_deg(here, there)) > SITE_TOLERANCE_DEG:
            raise ProcedureRefused(
                f"{name} has been given another {what} ({here:g} deg) than it had in this "
                f"session ({there:g} deg); set it back, or calibrate again"
            )


def _drive_words(drive: Drive) -> str:
    return ", ".join(f"{name} {value}" for name, value in msgspec.structs.asdict(drive).items())


def session_header(
    tracker: Tracker,
    identity: UnitIdentity,
    unit_site: UnitSite,
    utc_s: float,
    settings: SessionSettings,
    continues: str = "",
) -> Header:
    """The header of a session that begins now.

    Asks the unit for its parameters and coefficients, and raises as it answers.
    """
    parameters, stored = tracker.parameters(), tracker.stored()
    site = settings.get("site") or unit_site.site
    rule = settings.get("rule", DEFAULT_RULE)
    last = settings.get("last_coefficients")
    return Header(
        utc=format_utc(utc_s),
        software=f"solarcal {__version__}",
        unit=UnitRecord(
            model=identity.model,
            serial=identity.serial,
            firmware=identity.firmware,
            zone_west_h=unit_site.zone_west_h,
            drive1=parameters.drive1,
            drive2=parameters.drive2,
            limits=parameters.limits,
            update_range_deg=parameters.update_range_deg,
            reference1_deg=parameters.reference1_deg,
            reference2_deg=parameters.reference2_deg,
            tilt_decimals=parameters.tilt_decimals,
            scale_decimals=parameters.scale_decimals,
            site=unit_site.site,
            heliostat=parameters.heliostat,
            has_switches=tracker.capabilities.has_switches,
        ),
        site=site,
        geometry=unit_site.geometry,
        ax1_centre_deg=unit_site.ax1_centre_deg,
        true_sun=settings.get("true_sun", "precise"),
        target=settings.get("target", "sun"),
        tolerance_deg=rule.tolerance_deg,
        done_probability=rule.probability,
        unmodelled=rule.unmodelled,
        coefficients=stored.coefficients,
        offsets=stored.offsets,
        operator=settings.get("operator", ""),
        weather=settings.get("weather")
        or Weather(pressure_hpa=round(standard_pressure_hpa(site.elevation_m), 1)),
        pointing_device=settings.get("pointing_device", ""),
        continues=continues,
        inclinometer=settings.get("inclinometer"),
        last_coefficients=None if last is None else Coefficients(*last),
        bolt_circle=settings.get("bolt_circle"),
    )


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
