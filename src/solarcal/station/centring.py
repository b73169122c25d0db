"""Bringing the collector onto the Sun by what the sunspot device shows, and watching it track."""

from collections.abc import Callable

import numpy as np

from solarcal.station.procedure import Station
from solarcal.station.sun_path import forward_sense, sun_moves_deg, sun_rates_deg_per_s
from solarcal.unit.tracker import Spot, Status

FINE_MOVE_S = 2.0
"""Every jog aims at where the Sun will be this much later, and is renewed at this interval."""

BEHIND_DEG = 0.4
"""How far to go behind the Sun before coming forward: more than any backlash worth the name."""

CATCH_UP_S = 60.0
"""An axis past the Sun by less than this waits for it; by more, it goes behind."""

MOST_MOVES = 12
MOST_RENEWALS = 600
WATCH_S = 60.0
WATCH_STEP_S = 5.0
LONGEST_WATCH_S = 420.0
CLOUD_WAIT_S = 300.0
CLOUD_WAITS = 6


class SunCentring:
    """The technician's eye on the spot and hand on the jog keys.

    Parameters
    ----------
    station : connected, its session open.
    look : what the sunspot device shows now.
    eye_sigma_deg : how well the spot can be read, one sigma per axis on sky.
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

    def centre(self) -> bool:
        """Jog until the spot is centred, each axis coming from behind the Sun.

        An axis that is past the Sun by less than the Sun makes up in a minute is left to be
        caught up with: the jog aims at where the Sun will be then. One that is further past
        goes behind first.
        """
        station = self._station
        tolerance_deg = 3.0 * self._eye_sigma_deg + 0.003
        status = station.poll()
        # Decided once: going behind the Sun must not turn the sense it is then approached in.
        senses = [
            forward_sense(rate, approach)
            for rate, approach in zip(
                self._rates(status),
                status.approach,
                strict=True,
            )
        ]
        adjusted = False
        for _ in range(MOST_MOVES):
            spot = self._look_through_clouds()
            if spot is None:
                self._say("no spot to be seen")
                return False
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
                    status.reading_deg,
                    errors,
                    moves,
                    past_s,
                    senses,
                    strict=True,
                )
            )
            self._move(target1, target2, aim_s)
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

    def _move(self, target1_deg: float, target2_deg: float, aim_s: float) -> None:
        """Jog there and stay until ``aim_s`` has passed, renewing the target until at rest."""
        passed_s = 0.0
        for _ in range(MOST_RENEWALS):
            self._station.jog(target1_deg, target2_deg)
            self._station.clock.wait(FINE_MOVE_S)
            passed_s += FINE_MOVE_S
            if passed_s >= aim_s and self._station.poll().moving == (0, 0):
                return
