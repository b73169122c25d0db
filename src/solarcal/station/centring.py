"""What a technician does with hand and eye: wait for the Sun, bring the collector onto it by what
the sunspot device shows, watch it track.
"""

from collections.abc import Callable

import numpy as np

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused
from solarcal.mount.controller import ideal_axes_deg
from solarcal.station.guards import AxisStands, standing_axis
from solarcal.station.jogging import BEHIND_DEG
from solarcal.station.procedure import Station
from solarcal.station.sun_path import forward_sense, sun_moves_deg, sun_rates_deg_per_s
from solarcal.sun.day import daylight
from solarcal.timescale import format_utc
from solarcal.unit.tracker import Mode, Spot, Status

MIN_POINT_ELEVATION_DEG = 10.0
TRACKED_ELEVATION_DEG = 0.5

FINE_MOVE_S = 2.0
"""Every jog aims at where the Sun will be this much later, and is renewed at this interval."""

CATCH_UP_S = 60.0
"""An axis past the Sun by less than this waits for it; by more, it goes behind."""

MOST_MOVES = 12
MOST_RENEWALS = 600
WATCH_S = 60.0
WATCH_STEP_S = 5.0
LONGEST_WATCH_S = 420.0
STANDS_S = 60.0
"""An axis that is driven and has not moved for so long does not move."""

CLOUD_WAIT_S = 300.0
CLOUD_WAITS = 6
MOST_UNSEEN = 8
"""Slots in a row without a spot: half a day of clouds, or the Sun is not where it is looked for."""

NO_SPOT = (
    "no spot was found or centred: clouds; or the hour or date of the clock, or the site "
    "(latitude, sign of the longitude, zone) is wrong: compare them; or the tower leans so far "
    "that the Sun falls off the sunspot device; then shim first, or load rough coefficients"
)


def wait_until(station: Station, utc_s: float) -> None:
    station.clock.wait(max(0.0, round(utc_s - station.clock.utc_s(), 3)))


def sun_up(station: Station) -> bool:
    """High enough that the unit, with its own Sun, does not refuse to track it."""
    return station.sun_elevation_deg() >= TRACKED_ELEVATION_DEG


def sun_usable(station: Station) -> bool:
    """High enough, and the place it would send the axes to is within the limits."""
    if station.sun_elevation_deg() < MIN_POINT_ELEVATION_DEG:
        return False
    header = station.session.header
    ax1, ax2 = ideal_axes_deg(
        station.geometry, header.site, station.clock.utc_s(), header.unit.heliostat
    )
    return float(header.unit.limits.distance_deg(ax1, ax2)) > 1.0


def wait_for_sun(station: Station) -> None:
    """Wait, in quarter hours, until the Sun is usable; polar nights have an end too."""
    for _ in range(4 * 24 * 2):
        if sun_usable(station):
            return
        station.clock.wait(900.0)
    raise ProcedureRefused(
        "the Sun did not come within reach for two days; check site, date and limits "
        f"({format_utc(station.clock.utc_s(), 0)})"
    )


def spread_min(station: Station, points: int) -> float:
    """Minutes between so many points from now to the evening."""
    now = station.clock.utc_s()
    interval = daylight(station.session.header.site, now, MIN_POINT_ELEVATION_DEG)
    left_min = (interval[1] - now) / 60.0 if interval is not None else 0.0
    return spread_every_min(points, left_min - 10.0)


def spread_every_min(points: int, daylight_left_min: float) -> float:
    """Minutes between points that use the daylight left: 20 at least, 60 at most."""
    return float(np.clip(daylight_left_min / max(points - 1, 1), 20.0, 60.0))


class SunCentring:
    """The technician's eye on the spot and hand on the jog keys.

    Parameters
    ----------
    station : connected, its session open.
    look : what the sunspot device shows now.
    eye_sigma_deg : how well the spot can be read, one sigma per axis on sky.

    Attributes
    ----------
    unseen : so many times in a row there was no spot.
    """

    def __init__(
        self,
        station: Station,
        look: Callable[[], Spot],
        *,
        eye_sigma_deg: float,
        say: Callable[[str], None] = lambda sentence: None,
    ) -> None:
        self._station = station
        self._look = look
        self._eye_sigma_deg = eye_sigma_deg
        self._say = say
        self.unseen = 0

    def centre(self) -> bool:
        """Jog until the spot is centred, each axis coming from behind the Sun.

        An axis that is past the Sun by less than the Sun makes up in a minute is left to be
        caught up with: the jog aims at where the Sun will be then. One that is further past
        goes behind first.

        Raises
        ------
        AxisStands
            An axis does not move, tracked or jogged.
        """
        station = self._station
        tolerance_deg = 3.0 * self._eye_sigma_deg + 0.003
        status = self._following()
        # Decided once: going behind the Sun must not turn the sense it is then approached in.
        senses = [
            forward_sense(rate, approach)
            for rate, approach in zip(self._rates(status), status.approach, strict=True)
        ]
        adjusted = False
        for _ in range(MOST_MOVES):
            spot = self._look_through_clouds()
            if spot is None:
                self._tracked_since(status)
                self._say("no spot to be seen")
                self.unseen += 1
                return False
            self.unseen = 0
            status = station.poll()
            if adjusted and status.on_sky_deg(spot.error1_deg, spot.error2_deg) <= tolerance_deg:
                return True
            rates = self._rates(status)
            errors = (spot.error1_deg, spot.error2_deg)
            past_s = [
                -error * sense / max(abs(rate), 1e-9) if error * sense < 0.0 else 0.0
                for error, sense, rate in zip(errors, senses, rates, strict=True)
            ]
            catching_up = [late_s for late_s in past_s if late_s <= CATCH_UP_S]
            aim_s = FINE_MOVE_S * (1.0 + np.ceil(max(catching_up, default=0.0) / FINE_MOVE_S))
            adjusted = len(catching_up) == 2
            moves = self._moves(status, aim_s)
            target1, target2 = (
                reading + error + move - (0.0 if late_s <= CATCH_UP_S else sense * BEHIND_DEG)
                for reading, error, move, late_s, sense in zip(
                    status.reading_deg, errors, moves, past_s, senses, strict=True
                )
            )
            try:
                self._move(status, (target1, target2), aim_s)
            except AxisStands:
                raise
            except ProcedureRefused as refusal:
                # The Sun stands beyond a limit by now, for this slot as good as a cloud.
                self._say(str(refusal))
                return False
        self._say("the spot could not be centred")
        return False

    def watch(self) -> bool:
        """Let it track for a minute and through one update; is the spot centred then?"""
        station = self._station
        station.track()
        station.clock.wait(WATCH_S)
        before = station.poll().update_phase
        for _ in range(int(LONGEST_WATCH_S / WATCH_STEP_S)):
            station.clock.wait(WATCH_STEP_S)
            phase = station.poll().update_phase
            if phase < before:
                break
            before = phase
        spot = self._look()
        status = station.poll()
        # After an update the axes stand up to half a range ahead, on each axis.
        allowed_deg = (
            0.75 * station.session.header.unit.update_range_deg + 4.0 * self._eye_sigma_deg + 0.02
        )
        return spot.visible and status.on_sky_deg(spot.error1_deg, spot.error2_deg) <= allowed_deg

    def _rates(self, status: Status) -> tuple[float, float]:
        unit = self._station.session.header.unit
        return sun_rates_deg_per_s(
            self._station.geometry, unit.site, status.unit_utc_s, unit.heliostat
        )

    def _moves(self, status: Status, seconds: float) -> tuple[float, float]:
        unit, now_s = self._station.session.header.unit, status.unit_utc_s
        return sun_moves_deg(
            self._station.geometry, unit.site, now_s, now_s + seconds, unit.heliostat
        )

    def _look_through_clouds(self) -> Spot | None:
        for _ in range(CLOUD_WAITS):
            spot = self._look()
            if spot.visible:
                return spot
            self._station.clock.wait(CLOUD_WAIT_S)
        return None

    def _following(self) -> Status:
        """The status; of axes that rest far from where the unit tracks, after a while."""
        status, unit = self._station.poll(), self._station.session.header.unit
        at_rest = status.mode is Mode.TRACK and status.moving == (0, 0)
        if at_rest and standing_axis(unit, status, status):
            self._station.clock.wait(STANDS_S)
            status = self._tracked_since(status)
        return status

    def _tracked_since(self, before: Status) -> Status:
        """The status; AxisStands where the unit has tracked and an axis has not followed."""
        status, unit = self._station.poll(), self._station.session.header.unit
        if before.mode is status.mode is Mode.TRACK and (
            stands := standing_axis(unit, before, status)
        ):
            raise AxisStands(stands)
        return status

    def _move(self, before: Status, targets_deg: Pair, aim_s: float) -> None:
        """Jog there and stay until ``aim_s`` has passed, renewing the targets until at rest."""
        passed_s, unit = 0.0, self._station.session.header.unit
        for _ in range(MOST_RENEWALS):
            self._station.jog(*targets_deg)
            self._station.clock.wait(FINE_MOVE_S)
            passed_s += FINE_MOVE_S
            if passed_s < aim_s:
                continue
            status = self._station.poll()
            stands = standing_axis(unit, before, status, targets_deg)
            if stands and passed_s >= STANDS_S:
                raise AxisStands(stands)
            if not stands and status.moving == (0, 0):
                return
