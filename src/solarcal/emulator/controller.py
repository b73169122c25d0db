"""The controller: what it is asked, what it is ordered, what it does of its own accord.

It never sees the world, only wires (``MotorPort``) and a quartz. Times ``now_s`` are seconds since
the start and never decrease; nothing here depends on how often it is asked.
"""

from typing import Final

import msgspec

from solarcal.emulator.controller_model import (
    AxisControl,
    EmulatedControllerModel,
    MotorPort,
    Quartz,
    ReferenceCheck,
)
from solarcal.emulator.following import NEVER_S, SunFollower
from solarcal.emulator.settings import UnitSettings
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.optics.offset_mirror import MirrorOffset
from solarcal.site import Site
from solarcal.unit.frames import Code, Refusal
from solarcal.unit.tracker import Mode, RefCheckResult, Status, Stored, UnitParameters, UnitSite

JOG_EXPIRES_S: Final = 5.0
UNLOCK_S: Final = 60.0
_TRACKING = (Mode.TRACK, Mode.LIMIT)


class Controller:
    """One controller, powered up at ``now_s`` = 0 in mode ``MANUAL``, not referenced.

    Methods that can be refused raise ``Refusal`` and then have changed nothing.
    """

    def __init__(
        self,
        settings: UnitSettings,
        site: Site,
        zone_west_h: float,
        motors: tuple[MotorPort, MotorPort],
        quartz: Quartz,
        utc_s: float,
    ) -> None:
        self._settings = settings
        self.model = EmulatedControllerModel(settings, site, zone_west_h, quartz, utc_s)
        references = (settings.reference1_deg, settings.reference2_deg)
        self.axes = tuple(
            AxisControl(motor, drive, reference)
            for motor, drive, reference in zip(motors, settings.drives(), references, strict=True)
        )
        self._follower = SunFollower(self.model, self.axes, settings.update_range_deg)
        self._reference = ReferenceCheck()
        self._permanent = settings.memory()
        self.mode = Mode.MANUAL
        self._goals_deg = references
        self._jog_expires_s = NEVER_S
        self._unlocked_until_s = -NEVER_S

    # --- what can be asked --------------------------------------------------------------------

    def status(self, now_s: float) -> Status:
        axis1, axis2 = self.axes
        model = self.model
        ideal1, ideal2, _ = model.sun(now_s)
        if self.mode in (Mode.JOG, Mode.STOW, Mode.REF):
            target1, target2 = self._goals_deg
        else:
            target1, target2 = model.formula.target_deg(ideal1, ideal2)
        return Status(
            mode=self.mode,
            unit_utc_s=model.utc_s(now_s),
            ideal1_deg=ideal1,
            ideal2_deg=ideal2,
            reading1_deg=axis1.reading_deg(now_s),
            reading2_deg=axis2.reading_deg(now_s),
            counts1=axis1.counts(now_s),
            counts2=axis2.counts(now_s),
            target1_deg=target1,
            target2_deg=target2,
            offsets=model.offsets,
            moving=(axis1.moving, axis2.moving),
            approach=(axis1.approach, axis2.approach),
            update_phase=self._follower.phase(now_s) if self.mode is Mode.TRACK else 0.0,
            referenced=self._reference.referenced,
            unlocked_s=max(0.0, self._unlocked_until_s - now_s),
            memories_differ=(model.coefficients, model.offsets) != self._permanent,
        )

    def unit_site(self) -> UnitSite:
        geometry = self.model.geometry
        return UnitSite(
            self.model.site, self.model.zone_west_h, geometry.name, geometry.ax1_centre_deg
        )

    def parameters(self) -> UnitParameters:
        axis1, axis2 = self.axes
        heliostat = self.model.heliostat
        return UnitParameters(
            drive1=axis1.drive,
            drive2=axis2.drive,
            limits=self.model.limits,
            update_range_deg=self._follower.update_range_deg,
            reference1_deg=axis1.reference_deg,
            reference2_deg=axis2.reference_deg,
            tilt_decimals=self._settings.tilt_decimals,
            scale_decimals=self._settings.scale_decimals,
            target=None if heliostat is None else heliostat.target,
            mirror=MirrorOffset() if heliostat is None else heliostat.reduced_offset,
        )

    def stored(self) -> Stored:
        return Stored(self.model.coefficients, self.model.offsets, *self._permanent)

    def ref_check_result(self) -> RefCheckResult:
        return self._reference.result()

    # --- the lock -----------------------------------------------------------------------------

    def unlock(self, now_s: float) -> float:
        self._unlocked_until_s = now_s + UNLOCK_S
        return UNLOCK_S

    def lock(self) -> None:
        self._unlocked_until_s = -NEVER_S

    def use_unlock(self, now_s: float) -> None:
        """Start the unlock's time anew; refused where it has run out."""
        if now_s >= self._unlocked_until_s:
            raise Refusal(Code.LOCKED, "locked")
        self.unlock(now_s)

    # --- motion -------------------------------------------------------------------------------

    def stop(self, now_s: float) -> None:
        self._rest(now_s)
        self.mode = Mode.STOP

    def stow(self, now_s: float) -> None:
        """To the stow position; to the switches where counts say nothing yet."""
        self._rest(now_s)
        self.mode = Mode.STOW
        if self._reference.referenced:
            self._goals_deg = (self._settings.stow1_deg, self._settings.stow2_deg)
            self._drive_to_goals(now_s)
        else:
            self._goals_deg = (self.axes[0].reference_deg, self.axes[1].reference_deg)
            for axis in self.axes:
                axis.seek_switch(now_s)

    def set_manual(self, now_s: float) -> None:
        self._refuse_while_checking()
        self._rest(now_s)
        self.mode = Mode.MANUAL

    def set_track(self, now_s: float) -> None:
        self._refuse_while_checking()
        self._require_reference()
        self._require_sun(now_s)
        if self.mode not in _TRACKING:
            self._rest(now_s)
            self._follower.begin(now_s)
            self._name_tracking()

    def jog(self, target1_deg: float, target2_deg: float, now_s: float) -> None:
        self._refuse_while_checking()
        self._refuse_while_stopped()
        self._require_reference()
        if beyond := self.model.limits.beyond(target1_deg, target2_deg):
            raise Refusal(Code.BEYOND_LIMIT, beyond)
        goals = (target1_deg, target2_deg)
        under_way = self.mode is Mode.JOG and goals == self._goals_deg
        self._jog_expires_s = now_s + JOG_EXPIRES_S
        if not under_way:
            self._goals_deg = goals
            self.mode = Mode.JOG
            self._drive_to_goals(now_s)

    def cancel_jog(self, now_s: float) -> None:
        if self.mode is Mode.JOG:
            self._rest(now_s)
            self.mode = Mode.MANUAL

    def start_ref_check(self, now_s: float) -> int:
        self._refuse_while_checking()
        self._refuse_while_stopped()
        self._rest(now_s)
        self.mode = Mode.REF
        self._goals_deg = (self.axes[0].reference_deg, self.axes[1].reference_deg)
        return self._reference.start(self.axes, now_s)

    # --- memory and settings ------------------------------------------------------------------

    def set_sun_offset(self, now_s: float) -> None:
        """O such that reading = ideal + E + O holds at this instant."""
        self._refuse_while_checking()
        self._require_reference()
        if not all(axis.at_rest for axis in self.axes):
            raise Refusal(Code.MOVING, "axis moving")
        self._require_sun(now_s)
        ideal1, ideal2, _ = self.model.sun(now_s)
        axis1, axis2 = self.axes
        formula = self.model.formula
        offsets = formula.offsets_at(
            ideal1, ideal2, axis1.reading_deg(now_s), axis2.reading_deg(now_s)
        )
        self.model.formula = formula.holding(offsets=offsets)
        self._reconsider(now_s)

    def set_coefficients(self, p: Coefficients, o: Offsets, now_s: float) -> None:
        self.model.formula = self.model.formula.holding(p, o)
        self._reconsider(now_s)

    def store(self) -> None:
        self._permanent = (self.model.coefficients, self.model.offsets)

    def set_clock(self, utc_s: float, now_s: float) -> None:
        self.model.set_clock(utc_s, now_s)
        self._reconsider(now_s)

    def set_site(self, site: Site, zone_west_h: float, now_s: float) -> None:
        self.model.set_site(site, zone_west_h)
        self._reconsider(now_s)

    def set_parameters(self, new: UnitParameters, now_s: float) -> None:
        """Raises ConfigurationError where a drive or the mirror is impossible as described."""
        self._refuse_while_checking()
        require_reach(new)
        heliostat = new.heliostat
        drives = ((new.drive1, new.reference1_deg), (new.drive2, new.reference2_deg))
        for axis, (drive, reference_deg) in zip(self.axes, drives, strict=True):
            axis.configure(drive, reference_deg)
        self.model.formula = msgspec.structs.replace(self.model.formula, limits=new.limits)
        self.model.heliostat = heliostat
        self._follower.update_range_deg = new.update_range_deg
        self._reconsider(now_s)

    def reboot(self, now_s: float) -> None:
        """Power lost and back: permanent memory and the clock survive, nothing else."""
        self._rest(now_s)
        self.mode = Mode.MANUAL
        self.model.remember(*self._permanent)
        self._reference = ReferenceCheck()
        for axis in self.axes:
            axis.zero_register(now_s)
            axis.approach = 0
        self.lock()

    # --- events -------------------------------------------------------------------------------

    def next_event_s(self) -> float:
        """When the controller does something of its own accord next."""
        if self.mode is Mode.JOG:
            return self._jog_expires_s
        return self._follower.next_event_s() if self.mode in _TRACKING else NEVER_S

    def act(self, now_s: float) -> None:
        """Do what is due at ``now_s`` (= ``next_event_s``)."""
        if self.mode is Mode.JOG:
            self.cancel_jog(now_s)
        elif self._follower.limit_due(now_s):
            self._reconsider(now_s)
        else:
            self._follower.update_due(now_s)

    def motor_stopped(self, index: int, now_s: float) -> None:
        """The motor of an axis (0 or 1) has come to rest of itself."""
        self.axes[index].arrived()
        if self.mode is Mode.REF:
            if self._reference.motor_stopped(index, self.axes[index], now_s):
                self.mode = Mode.MANUAL
        elif self.mode is Mode.TRACK:
            self._follower.updated(index, now_s)
        else:
            self._end_jog_on_arrival()

    def encoder_jumped(self, index: int, now_s: float) -> None:
        """A register changed without the motor having run."""
        if self.mode is Mode.TRACK:
            self._follower.keep_up(index, now_s)

    # --- inside -------------------------------------------------------------------------------

    def _rest(self, now_s: float) -> None:
        """Every motion ends now."""
        for axis in self.axes:
            axis.stop(now_s)
        self._reference.interrupt()

    def _drive_to_goals(self, now_s: float) -> None:
        for axis, goal_deg in zip(self.axes, self._goals_deg, strict=True):
            axis.drive_to(goal_deg, now_s)
        self._end_jog_on_arrival()

    def _end_jog_on_arrival(self) -> None:
        if self.mode is Mode.JOG and all(axis.at_rest for axis in self.axes):
            self.mode = Mode.MANUAL

    def _reconsider(self, now_s: float) -> None:
        """What the Sun's place or the way to it depends on has changed."""
        if self.mode in _TRACKING:
            self._follower.reconsider(now_s)
            self._name_tracking()

    def _name_tracking(self) -> None:
        self.mode = Mode.TRACK if self._follower.within else Mode.LIMIT

    def _refuse_while_checking(self) -> None:
        if self.mode is Mode.REF:
            raise Refusal(Code.BUSY, "busy (reference check)")

    def _refuse_while_stopped(self) -> None:
        # A jog renewed automatically must not undo a STOP pressed meanwhile.
        if self.mode is Mode.STOP:
            raise Refusal(Code.STOPPED, "stopped: MODE MANUAL or MODE TRACK first")

    def _require_reference(self) -> None:
        if not self._reference.referenced:
            raise Refusal(Code.NOT_REFERENCED, "not referenced")

    def _require_sun(self, now_s: float) -> None:
        if self.model.sun(now_s)[2] < 0.0:
            raise Refusal(Code.SUN_DOWN, "Sun below horizon")


def require_reach(parameters: UnitParameters) -> None:
    """Refuse drives that cannot reach their reference or limits, where a screwjack lies flat.

    ConfigurationError: it has a dead point or no triangle there.
    """
    limits = parameters.limits
    for drive, axis_limits, reference_deg in (
        (parameters.drive1, limits.axis1, parameters.reference1_deg),
        (parameters.drive2, limits.axis2, parameters.reference2_deg),
    ):
        for angle_deg in (axis_limits.low_deg, axis_limits.high_deg, reference_deg):
            drive.counts(angle_deg)
