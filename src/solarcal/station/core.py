"""The line to the unit: what every step of the procedure is built on."""

import contextlib
import math
from collections.abc import Callable
from functools import partial
from typing import Unpack

from solarcal.errors import LinkError, ProcedureRefused, SessionFileError, SolarcalError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.journal import Journal
from solarcal.session.records import Closed, InForce, LinkLost, LinkRestored, Restarted, SunOffset
from solarcal.station import guards
from solarcal.station.recording import Recorded, SessionSettings, StationFile, refuse_another_unit
from solarcal.station.state import PENDING, Activity, LinkState
from solarcal.timescale import Clock
from solarcal.unit.tracker import Mode, Status, Tracker, UnitIdentity

HELD_S = 30.0
"""A line that is lost sooner than this after it came back is coming and going."""


class StationCore(StationFile):
    """One unit, one session, one technician: the line, the file and the state."""

    def __init__(self, tracker: Tracker, clock: Clock, **settings: Unpack[SessionSettings]) -> None:
        super().__init__(tracker, clock, **settings)
        self._in_force = Coefficients()
        self._stops = 0
        self._replaced: dict[SunOffset, Offsets] = {}
        self._referenced: bool | None = None
        # When the line came back last, and what of that is not in the file yet.
        self._restored_utc_s = -math.inf
        self._restored_serial = ""
        self._losses = 0
        self._flapping = False

    @property
    def coefficients_in_force(self) -> Coefficients:
        return self._in_force

    def connect(self) -> UnitIdentity:
        """Open the line and learn who is there. Records nothing yet."""
        identity = self.tracker.open()
        self._read_settings()
        self._connected(identity)
        return identity

    def _connected(self, identity: UnitIdentity) -> None:
        self._live(
            link=LinkState.CONNECTED,
            identity=identity,
            capabilities=self.tracker.capabilities,
            link_message="",
        )

    def _read_settings(self, again: UnitIdentity | None = None) -> None:
        """Of a unit that is there ``again`` they must be those of the session."""
        unit_site = self.tracker.site()
        if again is not None and self._journal is not None:
            parameters = self.tracker.parameters()
            refuse_another_unit(self._journal.header, again, unit_site, parameters)
        self.unit_site = unit_site
        self._recall_heliostat()
        self._in_force = self.tracker.stored().coefficients

    def link_lost(self, error: LinkError) -> None:
        """Say and record that the line is gone; an attempt in progress is kept as aborted.

        A line that is lost again within ``HELD_S`` is counted, not recorded once more: a loose
        plug must not fill the file.

        Raises
        ------
        SessionFileError
            It could not be recorded; the station knows of the lost line all the same.
        """
        if self._state.live.link is LinkState.LOST:
            return
        try:
            # On the disk first, as everything that is shown; a full disk must not hide the loss.
            if self._restored_serial:
                self._restored_serial = ""
                self._losses += 1
                self._live(losses_unrecorded=self._losses)
            elif self._journal is not None:
                self._record(partial(LinkLost, reason=str(error)))
            held_s = self.clock.utc_s() - self._restored_utc_s
            self._flapping = 0.0 <= held_s < HELD_S
        finally:
            self._live(link=LinkState.LOST, status=None, link_message=str(error), progress=None)
            try:
                if self._journal is not None and self._state.attempt is not None:
                    self.abort_attempt(f"link lost: {error}")
            finally:
                # Also where the file cannot be written now: an attempt cannot outlive its line.
                self._become(activity=Activity.IDLE, attempt=None)

    def reconnect(self) -> UnitIdentity:
        """Open the line again and re-read everything; refuse a unit that is not the same.

        Raises
        ------
        LinkError
            It does not answer.
        ProcedureRefused
            Another unit answers, or ours is not set up as it was. The line is closed then.
        """
        identity = self.tracker.open()
        try:
            self._refuse_another(identity)
            self._read_settings(identity)
        except ProcedureRefused as refused:
            self.tracker.close()
            self._live(link_message=str(refused))
            raise
        self._restored_utc_s = self.clock.utc_s()
        self._restored_serial = identity.serial
        if not self._flapping:
            self._record_restored()
        self._connected(identity)
        if self._journal is not None:
            try:
                self.compare_in_force()
            except LinkError as error:
                # Lost again at once: known before the next try restores it.
                self.link_lost(error)
                raise
        return identity

    def _refuse_another(self, identity: UnitIdentity) -> None:
        before = self._state.live.identity
        if before is not None and (before.model, before.serial) != (
            identity.model,
            identity.serial,
        ):
            raise ProcedureRefused(
                f"another unit answers: {identity.model} {identity.serial} instead of "
                f"{before.model} {before.serial}; connect the right one or start a new session"
            )

    def _record(self, make: Callable[..., Recorded]) -> Recorded:
        with self._change:
            self._record_restored()
            return super()._record(make)

    def _record_restored(self) -> None:
        """The line is back: recorded at once, or once a line that comes and goes has held."""
        serial, losses = self._restored_serial, self._losses
        if not serial:
            return
        self._restored_serial, self._losses = "", 0
        self._live(losses_unrecorded=0)
        if self._journal is not None:
            self._record(partial(LinkRestored, serial=serial, losses=losses))

    def poll(self) -> Status:
        """Read the unit's status once and show it."""
        if self._restored_serial and self.clock.utc_s() - self._restored_utc_s >= HELD_S:
            self._record_restored()
        before_utc_s = self.clock.utc_s()
        status = self.tracker.status()
        # The status belongs to the middle of its exchange, which takes a while on a slow line.
        laptop_utc_s = 0.5 * (before_utc_s + self.clock.utc_s())
        session = self._state.session
        self._live(
            status=status,
            laptop_utc_s=laptop_utc_s,
            unit_minus_laptop_s=round(status.unit_utc_s - laptop_utc_s, 3),
            distance_to_limits_deg=(
                guards.distance_to_limits_deg(session.header.unit, status) if session else None
            ),
        )
        self._notice_restart(status)
        return status

    def close(self, reason: str = "session finished") -> None:
        """Close the file and the line. The unit is left as it is.

        Raises
        ------
        SessionFileError
            The end could not be recorded; file and line are closed all the same, and the session
            can be gone on with.
        """
        try:
            if self._journal is not None:
                self._record(partial(Closed, reason=reason))
        finally:
            self.leave()

    def leave(self) -> None:
        """Close the line and let go of the file without ending the session: to go on later."""
        if self._journal is not None:
            # A disk that is full must not keep the line.
            with contextlib.suppress(SessionFileError):
                self._record_restored()
            self._journal.close()
            self._journal = None
        self.tracker.close()
        self._live(link=LinkState.CLOSED)

    def resume_session(self, journal: Journal) -> None:
        """Go on with a session that was interrupted; the unit must be the same one.

        The file is let go of where it is refused.
        """
        identity, unit_site = self._state.live.identity, self.unit_site
        try:
            if identity is not None and unit_site is not None:
                # First: a unit that is refused leaves nothing in the file.
                refuse_another_unit(journal.header, identity, unit_site, self.tracker.parameters())
            self._use(journal)
            self.compare_in_force()
        except SolarcalError:
            journal.close()
            raise

    def compare_in_force(self) -> bool:
        """Whether the unit holds what was uploaded last; a change of the answer is recorded.

        A unit without a line, or one that nothing was uploaded to, has nothing to compare. O is
        compared where no Set Sun Offset has changed it since.
        """
        session = self.session
        newest = session.uploads[-1] if session.uploads else None
        linked = self.tracker.capabilities.has_link
        if newest is None or not newest.verified or not linked:
            return True
        held = self.tracker.stored()
        self._in_force = held.coefficients
        same = held.coefficients == held.permanent_coefficients == newest.new_coefficients
        if not any(offset.seq > newest.seq for offset in session.sun_offsets):
            same = same and held.offsets == newest.new_offsets
        if same != session.holds_upload:
            self._record(
                partial(
                    InForce, coefficients=held.coefficients, offsets=held.offsets, as_uploaded=same
                )
            )
        return same

    def _notice_restart(self, status: Status) -> None:
        """Record that the unit lost its reference without a reference check of ours.

        A display does not report it: what was not typed since the program began is no restart.
        """
        if not self.tracker.capabilities.has_link:
            return
        if status.mode is Mode.REF:
            self._referenced = False
            return
        session = self._state.session
        was = self._referenced
        if was is None and session is not None:
            done = max((c.seq for c in session.ref_checks if c.complete), default=-1)
            was = done > max((r.seq for r in session.restarts), default=-1)
        self._referenced = status.referenced
        if was and not status.referenced and self._journal is not None:
            since = session.records[-1].utc if session is not None and session.records else ""
            self._record(partial(Restarted, since=since))

    def _demand_idle(self, step: str) -> None:
        if self._state.live.link is not LinkState.CONNECTED:
            raise ProcedureRefused(f"{step} needs a connected unit; the link is down")
        if self._state.activity is not Activity.IDLE:
            pending = PENDING[self._state.activity]
            raise ProcedureRefused(
                f"{step} has to wait: {pending.sentence}; {pending.first}", pending.action
            )
