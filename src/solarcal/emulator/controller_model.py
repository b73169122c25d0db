"""What the controller knows: its time, place and Sun, with P and O applied; of each axis registers,
reference and nominal drive. No truth in here.

The reference check is as the controller runs it: to the switch, behind it, slowly onto it again.
"""

from collections.abc import Sequence
from enum import Enum, auto
from typing import Protocol

import msgspec
import numpy as np

from solarcal.emulator.settings import UnitSettings
from solarcal.errors import ConfigurationError
from solarcal.mount.controller import ControllerModel, ideal_and_elevation_deg
from solarcal.mount.drive import Drive, reading_deg, register
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import Limits
from solarcal.site import Site
from solarcal.unit.tracker import RefCheckResult
from solarcal.units import Angles, FloatArray


class Quartz(Protocol):
    """Seconds the unit's quartz has counted at so many true seconds since the start."""

    def __call__(self, now_s: Angles) -> Angles: ...


class EmulatedControllerModel:
    """Clock, site, Sun, coefficients and limits of one controller.

    Its Sun is Appendix A's, airless, for its configured site and the time its own clock shows.
    A heliostat's ideal angles are those of the normal, from that Sun and its configured target.
    """

    def __init__(
        self, settings: UnitSettings, site: Site, zone_west_h: float, quartz: Quartz, utc_s: float
    ) -> None:
        self._settings = settings
        self._quartz = quartz
        self.site = site
        self.zone_west_h = zone_west_h
        self.geometry = settings.mount(site)
        self.heliostat = settings.heliostat()
        coefficients, offsets = settings.memory()
        self.formula = ControllerModel(
            settings.limits(),
            settings.tilt_decimals,
            settings.scale_decimals,
            coefficients,
            offsets,
        )
        self._clock_set_to_s = utc_s
        self._clock_set_at_s = 0.0

    @property
    def limits(self) -> Limits:
        return self.formula.limits

    @property
    def coefficients(self) -> Coefficients:
        return self.formula.coefficients

    @property
    def offsets(self) -> Offsets:
        return self.formula.offsets

    def remember(self, coefficients: Coefficients, offsets: Offsets) -> None:
        """P and O from a memory, as they stand there."""
        self.formula = msgspec.structs.replace(
            self.formula, coefficients=coefficients, offsets=offsets
        )

    def utc_s(self, now_s: Angles) -> Angles:
        """The unit's clock plus its zone."""
        counted = self._quartz(now_s) - self._quartz(self._clock_set_at_s)
        return self._clock_set_to_s + counted

    def set_clock(self, utc_s: float, now_s: float) -> None:
        self._clock_set_to_s = utc_s
        self._clock_set_at_s = now_s

    def set_site(self, site: Site, zone_west_h: float) -> None:
        """The clock shows local time and runs on: in another zone it means another UTC."""
        self._clock_set_to_s += (zone_west_h - self.zone_west_h) * 3600.0
        self.site, self.zone_west_h = site, zone_west_h
        self.geometry = self._settings.mount(site)

    def clock_error_s(self, now_s: FloatArray, true_start_utc_s: float) -> FloatArray:
        """Unit clock minus true time as the present setting runs on; before it, as just set."""
        since = np.maximum(now_s, self._clock_set_at_s)
        return self.utc_s(since) - (true_start_utc_s + since)

    def sun(self, now_s: float) -> tuple[float, float, float]:
        """Ideal axis angles and the Sun's elevation at one instant."""
        return self._ideal_deg(self.utc_s(now_s))

    def readings_deg(self, utc_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Readings (2, n) to drive to when the clock says ``utc_s`` (n,), and the room left (n,).

        The room is the distance to the nearest limit or of the Sun to the horizon, negative beyond.
        """
        ideal1, ideal2, elevation = self._ideal_deg(utc_s)
        readings = np.stack(self.formula.target_deg(ideal1, ideal2))
        room = np.minimum(self.limits.distance_deg(readings[0], readings[1]), elevation)
        return readings, room

    def _ideal_deg(self, utc_s: Angles) -> tuple[Angles, Angles, Angles]:
        """Angles of the Sun, or of the normal that reflects it to the target; Sun's elevation."""
        return ideal_and_elevation_deg(self.geometry, self.site, utc_s, self.heliostat)

    def targets_deg(self, now_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """``readings_deg`` at so many seconds since the start."""
        return self.readings_deg(self.utc_s(now_s))


class MotorPort(Protocol):
    """The wires of one axis: motor commands one way, encoder and switch the other.

    All times are seconds since the start; senses are of counts, +1 or -1, 0 at rest.
    """

    @property
    def sense(self) -> int: ...

    @property
    def switch_sense(self) -> int: ...

    def encoder(self, now_s: float) -> int: ...

    def run_to(self, encoder: int, now_s: float) -> None: ...

    def run_to_switch(self, sense: int, now_s: float, *, slow: bool) -> None: ...

    def stop(self, now_s: float) -> None: ...


class AxisControl:
    """Count register and drive of one axis."""

    OVERTRAVEL_DEG = 0.5
    """How far behind the switch a reference check goes before it approaches it slowly."""

    def __init__(self, motor: MotorPort, drive: Drive, reference_deg: float) -> None:
        self.motor = motor
        self.drive = drive
        self.reference_deg = reference_deg
        self.approach = 0
        self.moving = 0
        self._under_way = False
        self._goal: int | None = None
        self._zero = 0
        self._frozen_at: int | None = None
        self._count_sense()

    @property
    def at_rest(self) -> bool:
        return not self._under_way

    def configure(self, drive: Drive, reference_deg: float) -> None:
        self.drive = drive
        self.reference_deg = reference_deg
        self._count_sense()

    def counts(self, now_s: float) -> int:
        """The register as shown: whole counts since the last reference check."""
        if self._frozen_at is not None:
            return self._frozen_at
        return self.motor.encoder(now_s) - self._zero

    def reading_deg(self, now_s: float) -> float:
        """The absolute read-out as shown."""
        return self._reading_deg(self.counts(now_s))

    def encoder_reading_deg(self, now_s: float) -> float:
        """The absolute read-out of the encoder itself, shown or not."""
        return self._reading_deg(self.motor.encoder(now_s) - self._zero)

    def _reading_deg(self, counts: int) -> float:
        try:
            return float(reading_deg(self.drive, self.reference_deg, counts))
        except ConfigurationError:
            # Registers that were never referenced may lie beyond what a linear drive can reach.
            return self.reference_deg

    def count_deg(self) -> float:
        """Size of one count near the reference, degrees."""
        return 1.0 / abs(self._counts_per_deg)

    def drive_to(self, target_deg: float, now_s: float) -> bool:
        """Start for a reading; False when the register stands there already."""
        goal = int(register(self.drive, self.reference_deg, target_deg)) + self._zero
        if goal == self.motor.encoder(now_s):
            if not self.at_rest:
                self.stop(now_s)
            return False
        self.motor.run_to(goal, now_s)
        self._set_out()
        self._goal = goal
        return True

    def fell_short(self, now_s: float) -> bool:
        """The motor came to rest without reaching what it was sent for: something jams."""
        return self._goal is not None and self._goal != self.motor.encoder(now_s)

    def seek_switch(self, now_s: float) -> None:
        """At full speed to the reference switch, from whichever side."""
        self.motor.run_to_switch(self.motor.switch_sense, now_s, slow=False)
        self._set_out()

    def back_off(self, now_s: float) -> None:
        """Behind the switch, on the side of lower counts."""
        overtravel = round(self.OVERTRAVEL_DEG * abs(self._counts_per_deg))
        self.motor.run_to(self.motor.encoder(now_s) - overtravel, now_s)
        self._set_out()

    def approach_switch(self, now_s: float) -> None:
        """Slowly onto the switch, always in the sense of growing counts."""
        self.motor.run_to_switch(1, now_s, slow=True)
        self._set_out()

    def zero_register(self, now_s: float) -> int:
        """Counts found on the register; from now on it reads zero here."""
        found = self.motor.encoder(now_s) - self._zero
        self._zero += found
        return found

    def stop(self, now_s: float) -> None:
        self.motor.stop(now_s)
        self.arrived()
        self._goal = None

    def arrived(self) -> None:
        """The motor has come to rest."""
        if self.moving:
            self.approach = self.moving
        self.moving = 0
        self._under_way = False

    def freeze(self, now_s: float) -> None:
        """A fault: the read-out stands still from now on."""
        self._frozen_at = self.counts(now_s)

    def thaw(self) -> None:
        self._frozen_at = None

    def _set_out(self) -> None:
        self.moving = self.motor.sense * (1 if self._counts_per_deg > 0.0 else -1)
        self._under_way = True
        self._goal = None

    def _count_sense(self) -> None:
        low, high = self.reference_deg - 0.1, self.reference_deg + 0.1
        self._counts_per_deg = float(self.drive.counts(high) - self.drive.counts(low)) / 0.2


class _Stage(Enum):
    IDLE = auto()
    SEEK = auto()
    BACK_OFF = auto()
    APPROACH = auto()
    DONE = auto()


class ReferenceCheck:
    """Progress and result of the checks since power-up. O and P are none of its business."""

    def __init__(self) -> None:
        self.referenced = False
        self._number = 0
        self._stages = [_Stage.IDLE, _Stage.IDLE]
        self._differences = [0, 0]
        self._complete = False
        self._running = False

    def start(self, axes: Sequence[AxisControl], now_s: float) -> int:
        self._number += 1
        self._complete = False
        self._running = True
        self._differences = [0, 0]
        self._stages = [_Stage.SEEK, _Stage.SEEK]
        for axis in axes:
            axis.seek_switch(now_s)
        return self._number

    def motor_stopped(self, index: int, axis: AxisControl, now_s: float) -> bool:
        """The next leg of an axis. True when both have arrived and the check is complete."""
        stage = self._stages[index]
        if stage is _Stage.SEEK:
            self._stages[index] = _Stage.BACK_OFF
            axis.back_off(now_s)
        elif stage is _Stage.BACK_OFF:
            self._stages[index] = _Stage.APPROACH
            axis.approach_switch(now_s)
        elif stage is _Stage.APPROACH:
            self._stages[index] = _Stage.DONE
            self._differences[index] = axis.zero_register(now_s)
        if all(stage is _Stage.DONE for stage in self._stages):
            self._running = False
            self._complete = self.referenced = True
        return self._complete

    def interrupt(self) -> None:
        """Stopped before the end: the check is broken; a former one still counts."""
        self._running = False
        self._stages = [_Stage.IDLE, _Stage.IDLE]

    def result(self) -> RefCheckResult:
        return RefCheckResult(
            number=self._number,
            complete=self._complete,
            difference1=self._differences[0],
            difference2=self._differences[1],
            running=self._running,
        )
