"""The calibration procedure as a state machine: commands in, immutable ``StationState`` out.

Every command either does the whole step and records it, or raises and leaves the session as it was,
apart from what the raising itself records (an aborted attempt, a lost link). Nothing moves or is
written unless its command was called.
"""

from functools import partial

import msgspec

from solarcal.errors import ProcedureRefused, SessionFileError, SolarcalError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.journal import Journal
from solarcal.session.records import (
    ClockSet,
    Closed,
    Initialised,
    Note,
    RefCheck,
    SunOffset,
    UploadBegun,
    UploadRecord,
    Void,
)
from solarcal.session.voids import TAKEN_BACK, refuse_void
from solarcal.station import guards
from solarcal.station.attempts import PointSteps, Progress
from solarcal.station.recording import CreateJournal
from solarcal.station.state import Activity, held_before_upload, newest_upload
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Mode, Stored

REF_CHECK_LIMIT_S = 3600.0
"""No reference check takes an hour; a unit that says it is still at it is stuck."""

REF_CHECK_POLL_S = 2.0


class Station(PointSteps):
    """The steps of the manual, each a command."""

    # -- motion ------------------------------------------------------------------------------

    def stop(self) -> None:
        """Stop every motion. Never waits for anything else."""
        self._stops += 1
        self.tracker.stop()

    def track(self) -> None:
        self.tracker.set_mode(Mode.TRACK)

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        """Send one jog target (absolute read-outs). It expires unless sent again.

        The limits are checked here too: a unit with wrong limits must not be driven into them.
        """
        limits = self.session.header.unit.limits
        distance = float(limits.distance_deg(target1_deg, target2_deg))
        if distance < 0.0:
            raise ProcedureRefused(
                f"jog refused: the target ({target1_deg:z.3f}, {target2_deg:z.3f}) deg lies "
                f"{-distance:.3f} deg beyond a limit"
            )
        self.tracker.jog(target1_deg, target2_deg)

    # -- the steps of the manual -------------------------------------------------------------

    def set_unit_clock(
        self, tick_minus_laptop_s: float | None = None, tick_sigma_s: float | None = None
    ) -> ClockSet:
        """Set the unit's clock to the laptop's UTC (corrected by a time tick, if one was given)."""
        before = self.poll()
        before_s = before.unit_utc_s - self.clock.utc_s()
        self.tracker.set_clock(self.clock.utc_s() + (tick_minus_laptop_s or 0.0))
        after = self.poll()
        after_s = after.unit_utc_s - self.clock.utc_s()
        return self._record(
            partial(
                ClockSet,
                before_s=round(before_s, 3),
                after_s=round(after_s, 3),
                tick_minus_laptop_s=tick_minus_laptop_s,
                tick_sigma_s=tick_sigma_s,
            )
        )

    def ref_check(self, progress: Progress | None = None) -> RefCheck:
        """Run a reference check to its end and record the counts found at the switches.

        It is a command to move: a unit that was stopped is let go for it. Without a reference
        there is no other way out of a STOP, for such a unit does not track. A check that the unit
        is in already is waited for instead: a second one would find none of its counts.
        """
        self._demand_idle("a reference check")
        self._become(activity=Activity.REF_CHECK)
        try:
            if self._let_go() is not Mode.REF:
                self.tracker.start_ref_check()
            waited = 0.0
            while self.poll().mode is Mode.REF:
                if waited >= REF_CHECK_LIMIT_S:
                    self.tracker.stop()
                    raise ProcedureRefused(
                        "the reference check did not end within an hour and was stopped; "
                        "look at the reference switches"
                    )
                if progress is not None:
                    progress(waited)
                self.clock.wait(REF_CHECK_POLL_S)
                waited += REF_CHECK_POLL_S
            result = self.tracker.ref_check_result()
        finally:
            self._become(activity=Activity.IDLE)
        number = self._check_number(result.number)
        return self._record(
            partial(
                RefCheck,
                number=number,
                complete=result.complete,
                difference_counts=None
                if result.difference1 is None or result.difference2 is None
                else (result.difference1, result.difference2),
                at_switches=self.session.header.unit.has_switches,
            )
        )

    def _check_number(self, of_unit: int) -> int:
        """The unit's own; one that begins anew (a restart) goes on from the session's last."""
        checks = self.session.ref_checks
        return of_unit if not checks else max(of_unit, checks[-1].number + 1)

    def _let_go(self) -> Mode:
        """End the STOP of a moment ago; one that comes meanwhile stands. The mode found."""
        stops = self._stops
        if (found := self.poll().mode) is not Mode.STOP:
            return found
        self.tracker.set_mode(Mode.MANUAL)
        if self._stops != stops:
            self.tracker.stop()
            raise ProcedureRefused("not begun: STOP was pressed")
        return found

    def set_sun_offset(self, slack_axes: tuple[int, ...] = ()) -> SunOffset:
        """Take the axes' present stand as on the Sun: the unit sets O accordingly.

        ``slack_axes``: those that were seen to come forward by too little.
        """
        before = self.state.live.status
        if before is not None:
            guards.demand_free_of_limits(before)
        status = self.tracker.set_sun_offset()
        in_force = self._in_force
        typed_utc_s = status.typed_utc_s
        record = self._record(
            partial(
                SunOffset,
                ideal_deg=status.ideal_deg,
                reading_deg=status.reading_deg,
                counts=status.counts,
                offsets=status.offsets,
                coefficients=in_force,
                approach=status.approach,
                read_utc=None if typed_utc_s is None else format_utc(typed_utc_s),
                slack_axes=slack_axes,
            )
        )
        if before is not None:
            self._replaced[record] = before.offsets
        return record

    @property
    def replaced_offsets(self) -> Offsets | None:
        """The O before a Set Sun Offset that no point was stored on; None where there is none."""
        newest = self.session.unused_sun_offset
        linked = self.tracker.capabilities.has_link
        return self._replaced.get(newest) if newest is not None and linked else None

    def take_back_sun_offset(self) -> Void:
        """Put back the O that the newest Set Sun Offset replaced, and strike its record.

        Of one set while this program runs. The unit's permanent memory stays as it is. A unit that
        tracks drives to where these O lead.

        Raises
        ------
        ProcedureRefused
            There is none, or the unit no longer holds what was set.
        """
        self._demand_idle("taking back an offset")
        newest, before = self.session.unused_sun_offset, self.replaced_offsets
        if newest is None or before is None:
            raise ProcedureRefused("there is no Set Sun Offset to take back")
        held = self.tracker.stored()
        if held.offsets != newest.offsets:
            raise ProcedureRefused("the unit holds other offsets than were set; set them anew")
        back = self.tracker.write_coefficients(held.coefficients, before, store=False)
        if back.offsets != before:
            raise ProcedureRefused("the unit reads back other offsets than were written")
        words = f"O1 {before.O1:+z.4f}, O2 {before.O2:+z.4f} deg"
        return self.void(newest.seq, f"{TAKEN_BACK}: {words} again")

    def initialise(
        self,
        *,
        confirmed: bool,
        override_reason: str | None = None,
        start_next: CreateJournal | None = None,
    ) -> Initialised:
        """Begin the calibration in this file (Alt-F3); once per file.

        A second time needs ``start_next``: the present file is closed and kept, and the next one
        begins with the site, the unit and the last clock, check and offset of this one.
        """
        if not confirmed:
            raise ProcedureRefused("initialise needs the technician's confirmation")
        self._demand_idle("initialise")
        status = self.poll()
        distance = guards.distance_to_limits_deg(self.session.header.unit, status)
        with self._overruled(override_reason):
            guards.demand_clear_of_limits(self.session.header, status, "initialise")
        if self.session.initialised is not None:
            if start_next is None:
                raise ProcedureRefused(
                    f"this session was initialised at {self.session.initialised.utc}; "
                    "initialising again closes this file and starts another"
                )
            self._continue_in(start_next)
        return self._record(partial(Initialised, distance_to_limits_deg=round(distance, 5)))

    def _continue_in(self, start_next: CreateJournal) -> None:
        old = self.session
        old_journal = self._open_journal()
        journal = start_next(self._header(continues=_name(old_journal)))
        carried = (old.clock_sets[-1:], old.ref_checks[-1:], old.sun_offsets[-1:])
        try:
            # The evidence keeps the time it was made at; only its place in the file is new.
            journal.append_all(
                [
                    msgspec.structs.replace(record, seq=journal.next_seq + place)
                    for place, record in enumerate(record for kind in carried for record in kind)
                ]
            )
            # Last: as long as this file is not closed in so many words, it is the one in force.
            self._record(partial(Closed, reason="initialised again", next=_name(journal)))
        except SessionFileError:
            journal.close()
            raise
        old_journal.close()
        self._use(journal)

    # -- upload ------------------------------------------------------------------------------

    def upload(
        self, coefficients: Coefficients, *, method: str, forced: str = "", rollback: bool = False,
        offsets: Offsets | None = None, replaced: tuple[Coefficients, Offsets] | None = None,
    ) -> UploadRecord:  # fmt: skip
        """Write P1..P6 and both O in one transaction, store, read back, compare exactly."""
        self._demand_idle("an upload")
        unit = self.session.header.unit
        new = coefficients.rounded(unit.tilt_decimals, unit.scale_decimals)
        offsets = offsets or Offsets()
        self._become(activity=Activity.UPLOADING)
        begun: UploadBegun | None = None
        try:
            held, held_offsets = replaced or held_before_upload(
                self.session, self.tracker.stored(), new, offsets
            )
            # On the disk before the first write: whatever happens then, a rollback knows.
            begun = self._record(
                partial(
                    UploadBegun,
                    old_coefficients=held,
                    old_offsets=held_offsets,
                    new_coefficients=new,
                    new_offsets=offsets,
                    method=method,
                    forced=forced,
                    rollback=rollback,
                )
            )
            back = self.tracker.write_coefficients(new, offsets)
            self._in_force = back.coefficients
        except SolarcalError as error:
            if begun is not None:
                self._record(partial(begun.outcome, verified=False, failure=str(error)))
            raise
        finally:
            self._become(activity=Activity.IDLE)
        return self._record(partial(begun.outcome, verified=_holds(back, new, offsets)))

    def upload_again(self) -> UploadRecord:
        """Write the newest upload once more: the unit no longer holds it.

        What a rollback restores stays what that upload had replaced.
        """
        if not self.session.uploads:
            raise ProcedureRefused(
                "nothing was uploaded in this session; there is nothing to repeat"
            )
        newest = self.session.uploads[-1]
        return self.upload(
            newest.new_coefficients,
            method=newest.method,
            forced=newest.forced,
            rollback=newest.rollback,
            offsets=newest.new_offsets,
            replaced=(newest.old_coefficients, newest.old_offsets),
        )

    def rollback(self) -> UploadRecord:
        """Restore the P and O that the newest upload of this session replaced.

        ProcedureRefused where there is none, or the unit holds already what a rollback restored.
        """
        newest = newest_upload(self.session.uploads)
        if newest is None:
            raise ProcedureRefused("there is no upload in this session to roll back")
        last = self.session.uploads[-1]
        restored = last.new_coefficients, last.new_offsets
        if last.rollback and last.verified and _holds(self.tracker.stored(), *restored):
            raise ProcedureRefused(
                f"upload {newest.seq} is rolled back already, by record {last.seq}, and the unit "
                "holds what that restored: nothing was written"
            )
        return self.upload(
            newest.old_coefficients, method=newest.method, rollback=True, offsets=newest.old_offsets
        )

    # -- remarks -----------------------------------------------------------------------------

    def note(self, text: str) -> Note:
        return self._record(partial(Note, text=text))

    def void(self, seq_to_void: int, reason: str) -> Void:
        """Strike a record; voiding the void restores it."""
        refuse_void(self.session.header, self.session.records, seq_to_void)
        return self._record(partial(Void, voids=seq_to_void, reason=reason))


def _holds(stored: Stored, coefficients: Coefficients, offsets: Offsets) -> bool:
    """In force and permanently."""
    return (
        stored.coefficients == stored.permanent_coefficients == coefficients
        and stored.offsets == stored.permanent_offsets == offsets
    )


def _name(journal: Journal) -> str:
    return journal.path.name if journal.path is not None else ""
