"""Set Sun Offset by hand: where the technician wants the axes, and from which side they came.

The unit takes absolute targets that expire. While jogging follows the Sun, the target is the
unit's ideal angle plus what the technician added, sent anew before it expires: the spot stands
still on the plate but for what the technician does to it, and every renewal comes forward.
"""

import math
from dataclasses import dataclass, replace

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused, SolarcalError
from solarcal.session.records import SunOffset, Void
from solarcal.station.procedure import Station
from solarcal.station.sun_path import forward_sense, sun_rates_deg_per_s
from solarcal.unit.tracker import Mode, Spot, Status

STEPS_DEG = (0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1.0)
"""The steps to choose from."""

BEHIND_DEG = 0.4
"""How far to go behind the Sun before coming forward: more than any backlash worth the name."""

TAKEN_UP_DEG = 0.3
"""An axis that has come forward by this much since it last went backward has no slack left."""

RENEWAL_LEAD_S = (0.5, 4.0)
"""A renewed target aims at where the Sun will be when the next one comes, as long from now as the
last was ago, but within these; the unit forgets a target after five seconds."""

SETTING_LEAD_S = 2.0
"""Before the offset is set the axes are put where the Sun will be then, and wait for it."""

SETTLE_TRIES = 30
STILL_DEG = 1e-6

STOPPED = (Mode.STOP, Mode.STOW, Mode.FAULT, Mode.REF)


@dataclass(frozen=True, slots=True)
class ApproachWatch:
    """How far each axis has come forward since it last went backward, degrees.

    ``reading_deg`` is where they were last seen. An axis whose last finished motion was forward
    when the watch began is trusted: tracking brought it there. So is one in which the Sun stands,
    when the end of a motion turns the sense that is forward.
    """

    reading_deg: Pair
    forward_deg: Pair
    senses: tuple[int, int]

    @classmethod
    def begin(cls, status: Status, senses: tuple[int, int]) -> "ApproachWatch":
        trusted = [
            math.inf if approach == sense else 0.0
            for approach, sense in zip(status.approach, senses, strict=True)
        ]
        return cls(status.reading_deg, (trusted[0], trusted[1]), senses)

    def seen(self, status: Status, senses: tuple[int, int]) -> "ApproachWatch":
        """The watch after one more look at the axes."""
        reading = status.reading_deg
        forward = list(ApproachWatch.begin(status, senses).forward_deg)
        for axis in (0, 1):
            if senses[axis] != self.senses[axis]:
                continue
            along = (reading[axis] - self.reading_deg[axis]) * senses[axis]
            forward[axis] = 0.0 if along < -STILL_DEG else self.forward_deg[axis] + max(along, 0.0)
        return ApproachWatch(reading, (forward[0], forward[1]), senses)

    @property
    def from_behind(self) -> tuple[bool, bool]:
        """Whether each axis stands where it does with its slack taken up."""
        return self.forward_deg[0] >= TAKEN_UP_DEG, self.forward_deg[1] >= TAKEN_UP_DEG


@dataclass(frozen=True, slots=True)
class Aim:
    """What the technician wants. ``wanted_deg``: reading - ideal while it follows the Sun, the
    reading itself while it does not. ``behind``: axes that first go behind."""

    wanted_deg: Pair
    follows: bool
    behind: tuple[bool, bool] = (False, False)

    def target_deg(
        self, status: Status, rates: Pair, senses: tuple[int, int], lead_s: float
    ) -> Pair:
        """The absolute read-outs to send."""
        ideal = status.ideal_deg
        targets = [
            self.wanted_deg[axis]
            + (ideal[axis] + rates[axis] * lead_s if self.follows else 0.0)
            - (senses[axis] * BEHIND_DEG if self.behind[axis] else 0.0)
            for axis in (0, 1)
        ]
        return targets[0], targets[1]


@dataclass(frozen=True, slots=True)
class JogView:
    """What a screen shows of it. ``spot`` is ``None`` on a real unit."""

    status: Status
    rates_deg_per_s: Pair
    senses: tuple[int, int]
    watch: ApproachWatch
    aim: Aim | None
    target_deg: Pair | None
    spot: Spot | None


class SunOffsetJog:
    """Jogging onto the Sun through a ``Station``; called from the thread that talks to it.

    Nothing moves before the first ``nudge`` or ``go_behind``; nothing is written but by
    ``set_here`` and ``take_back``.
    """

    def __init__(self, station: Station, *, follows: bool = True) -> None:
        self.station = station
        self.follows = follows
        self._aim: Aim | None = None
        self._watch: ApproachWatch | None = None
        self._found_tracking: bool | None = None
        self._looked_utc_s: float | None = None
        self._sun_of_utc_s = -math.inf
        self._standing: tuple[int, int] | None = None

    @property
    def jogging(self) -> bool:
        """A target is being renewed."""
        return self._aim is not None

    def look(self) -> JogView:
        """Read the unit; renew the jog target, if there is one."""
        status = self._poll()
        if self._found_tracking is None:
            self._found_tracking = status.mode is Mode.TRACK
        rates = self._rates(status)
        senses = self._senses(status, rates)
        watch = self._watch
        self._watch = watch.seen(status, senses) if watch else ApproachWatch.begin(status, senses)
        target = None
        if self._aim is not None and status.mode in STOPPED:
            # Somebody stopped it, here or at the unit: a stop is never jogged away from.
            self.release()
        if self._aim is not None:
            self._aim = self._came_behind(self._aim, status, rates, senses)
            target = self._aim.target_deg(status, rates, senses, self._lead_s(status))
            self.station.jog(*target)
        self._looked_utc_s = status.unit_utc_s
        emulation = self.station.tracker.emulation
        spot = emulation.spot() if emulation is not None else None
        return JogView(status, rates, senses, self._watch, self._aim, target, spot)

    def nudge(self, axis1_deg: float, axis2_deg: float) -> JogView:
        """Move the aim by that many axis degrees; the unit follows at once.

        Raises
        ------
        ProcedureRefused
            The unit was stopped and has not been set to track since, or the aim lies beyond a
            limit; the aim is then what it was.
        """
        aim = self._aim or self._aim_here()
        wanted = (aim.wanted_deg[0] + axis1_deg, aim.wanted_deg[1] + axis2_deg)
        return self._look_with(replace(aim, wanted_deg=wanted))

    def go_behind(self) -> JogView:
        """Axes that did not come from behind go behind the Sun, then forward to the aim."""
        aim = self._aim or self._aim_here()
        # The sense first: where the Sun stands in an axis it may be another than that it came in.
        self._hold_senses()
        from_behind = self.look().watch.from_behind
        behind = (not from_behind[0], not from_behind[1])
        if not any(behind):
            raise ProcedureRefused("both axes already came from behind; nothing to take up")
        return self._look_with(replace(aim, behind=behind))

    def go_to(self, error_deg: Pair) -> JogView:
        """Go to where reading - ideal is this: behind it first, then forward onto it."""
        self._aim_here()  # refuses where the unit was stopped
        self.follows = True
        self._hold_senses()
        return self._look_with(Aim(error_deg, True, (True, True)))

    def _look_with(self, aim: Aim) -> JogView:
        """Look with a new aim; it is taken back where it cannot be followed."""
        before, self._aim = self._aim, aim
        try:
            return self.look()
        except SolarcalError:
            self._aim = before
            raise

    def follow(self, follows: bool) -> JogView:
        """Follow the Sun with the aim, or stand still and let it come."""
        self.follows = follows
        if self._aim is not None:
            self._aim = replace(self._aim_here(), behind=self._aim.behind)
        return self.look()

    def release(self) -> None:
        """Renew no more: the target expires and the axes stand."""
        self._aim = None

    def track(self) -> JogView:
        """Give the axes back to the unit."""
        self.release()
        self.station.track()
        return self.look()

    def set_here(self) -> SunOffset:
        """Wait until the axes rest on the aim, set the offset, and let the unit track.

        Raises
        ------
        ProcedureRefused
            The axes do not come to rest, or are on their way behind the Sun.
        """
        self.rest_on_aim()
        came = self._watch.from_behind if self._watch else (True, True)
        record = self.station.set_sun_offset(tuple(i for i, ok in enumerate(came, 1) if not ok))
        self.release()
        self._standing = None
        self.station.track()
        return record

    def take_back(self) -> Void:
        """Give the aim up, and put back the offsets before the newest Set Sun Offset."""
        self.release()
        return self.station.take_back_sun_offset()

    def rest_on_aim(self) -> None:
        """Let the axes come to rest where the aim is then; raises as ``set_here``."""
        aim = self._aim
        if aim is not None and any(aim.behind):
            raise ProcedureRefused("the axes are still going behind the Sun; wait, then centre")
        status = self._poll()
        if status.mode in STOPPED:
            raise ProcedureRefused(
                f"the unit is in mode {status.mode}; track or jog onto the Sun first"
            )
        if aim is not None and aim.follows:
            # Where the Sun will be: the axes rest there and it comes to them.
            rates = self._rates(status)
            target = aim.target_deg(status, rates, self._senses(status, rates), SETTING_LEAD_S)
            self.station.jog(*target)
            self.station.clock.wait(SETTING_LEAD_S)
        self._settle()

    def leave(self) -> bool:
        """Leave without writing. A unit found tracking that was only jogged tracks again."""
        jogged = self._aim is not None
        self.release()
        mode = self.station.poll().mode
        if self._found_tracking and mode in (Mode.JOG, Mode.MANUAL):
            self.station.track()
            return True
        return jogged

    # -- inside ------------------------------------------------------------------------------

    def _poll(self) -> Status:
        return self.station.poll()

    def _lead_s(self, status: Status) -> float:
        least, most = RENEWAL_LEAD_S
        now_s = status.unit_utc_s
        lead_s = min(max(now_s - (self._looked_utc_s or now_s), least), most)
        # Never an earlier Sun than the last renewal's, which would drive the axes backward.
        self._sun_of_utc_s = max(now_s + lead_s, min(self._sun_of_utc_s, now_s + most))
        return self._sun_of_utc_s - now_s

    def _rates(self, status: Status) -> Pair:
        header, unit_site = self.station.session.header, self.station.unit_site
        site, heliostat = (unit_site or header).site, header.unit.heliostat
        return sun_rates_deg_per_s(self.station.geometry, site, status.unit_utc_s, heliostat)

    def _senses(self, status: Status, rates: Pair) -> tuple[int, int]:
        first, second = self._standing or status.approach
        return forward_sense(rates[0], first), forward_sense(rates[1], second)

    def _hold_senses(self) -> None:
        """Where the Sun stands in an axis, going behind must not turn the sense to come forward in:
        that of what little the Sun moves."""
        rates = self._rates(self._poll())
        self._standing = -1 if rates[0] < 0.0 else 1, -1 if rates[1] < 0.0 else 1

    def _aim_here(self) -> Aim:
        """The aim that keeps the axes as they stand towards the Sun (or the ground)."""
        status = self._poll()
        if status.mode in STOPPED:
            raise ProcedureRefused(
                f"the unit is in mode {status.mode} and is not jogged out of it; "
                "set it to track first"
            )
        return Aim(status.off_ideal_deg if self.follows else status.reading_deg, self.follows)

    def _came_behind(self, aim: Aim, status: Status, rates: Pair, senses: tuple[int, int]) -> Aim:
        """Once all that had to are behind and at rest, come forward."""
        if not any(aim.behind) or status.moving != (0, 0):
            return aim
        target = aim.target_deg(status, rates, senses, 0.0)
        reading = status.reading_deg
        there = all(
            (target[axis] - reading[axis]) * senses[axis] > -0.25 * BEHIND_DEG
            for axis in (0, 1)
            if aim.behind[axis]
        )
        return replace(aim, behind=(False, False)) if there else aim

    def _settle(self) -> None:
        for _ in range(SETTLE_TRIES):
            if self.station.poll().moving == (0, 0):
                return
            self.station.clock.wait(0.5)
        raise ProcedureRefused("the axes do not come to rest; STOP, and find the cause")
