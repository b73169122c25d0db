"""The controller of a two-mirror tracker: calculated mode, search, steps, PID, near-zenith mode.

It knows its site, its clock, the diode's signals and its axis read-outs. The true base, the motors
and the sky belong to the world.
"""

import math
from collections.abc import Iterator
from enum import StrEnum

from solarcal.site import Site
from solarcal.two_mirror.base import BaseModel
from solarcal.two_mirror.control import (
    REVERSED,
    GrowthWatch,
    Pid,
    PidGains,
    ZenithPassage,
    beside,
    spiral_deg,
    step_rate_deg_s,
)
from solarcal.two_mirror.diode import QuadrantDiode, Signals, quadrant_errors
from solarcal.two_mirror.mirrors import axes_of
from solarcal.two_mirror.scenario import MirrorLoop, Sky

SEEN_LIGHT = 0.3
"""Less light than this part of the clear Sun's is no spot."""

LOCKED_MRAD = 1.0
"""The PID takes over from the steps, and points are logged, within this of the set point."""

LOST_AGAIN = 2
"""So often found and lost while it was being centred: not the clouds' doing."""

WAIT_S = 60.0
"""A spot that went is waited for at its calculated place before it is searched."""

KNOWN_SEARCH_DEG = 1.5
LEAD_DEG = 0.25
NEAR_LOOK_S = 5.0
"""The Sun moves 0.02 deg meanwhile."""

PATH_END = 2.0
SATURATED = 0.95


class LoopMode(StrEnum):
    """What the controller is doing."""

    SEARCH = "search"
    STEP = "step"
    PID = "pid"
    ZENITH = "near-zenith"
    CALCULATED = "calculated"
    WAIT = "wait"
    STOPPED = "stopped"


class MirrorController:
    """One day of one controller.

    Parameters
    ----------
    fastest_deg_s : the greatest rate of each axis.
    field_mrad : full field of view.
    log_every_s : how often a point is kept.
    sky : the target's place as the controller computes it; None: the Sun by its own formula.
    """

    def __init__(
        self,
        loop: MirrorLoop,
        site: Site,
        diode: QuadrantDiode,
        gains: PidGains,
        fastest_deg_s: tuple[float, float],
        field_mrad: float,
        log_every_s: float,
        sky: Sky | None = None,
    ) -> None:
        self.loop = loop
        self.base_model = BaseModel(loop.believed(), site, log_every_s, sky)
        self.mode = LoopMode.WAIT
        self.message = ""
        self._diode = diode
        self._fastest_deg_s = fastest_deg_s
        self._field_radius_deg = math.degrees(0.5e-3 * field_mrad)
        self._pids = tuple(Pid(gains, loop.period_s, fastest) for fastest in fastest_deg_s)
        self._watch = GrowthWatch()
        self._passage: ZenithPassage | None = None
        self._near = False
        self._look_again_utc_s = -math.inf
        self._spiral: Iterator[tuple[float, float]] | None = None
        self._beside_deg = (0.0, 0.0)
        self._waiting_s = WAIT_S
        self._last_off_mrad = 0.0
        self._lost_uncentred = 0

    # -- one update --------------------------------------------------------------------------

    def update(
        self, utc_s: float, signals: Signals, axis1_deg: float, axis2_deg: float
    ) -> tuple[float, float]:
        """Rates of both axes for the next period, degrees per second."""
        if self.mode is LoopMode.STOPPED:
            return 0.0, 0.0
        if self.loop.control == "calculated":
            self.mode = LoopMode.CALCULATED
            ahead = self.base_model.calculated_deg(utc_s + self.loop.period_s)
            return self._towards(ahead, axis1_deg, axis2_deg)
        seen = sum(signals) > SEEN_LIGHT
        errors = quadrant_errors(signals) if seen else (0.0, 0.0)
        if self._is_near_zenith(utc_s):
            return self._near_zenith(utc_s, errors if seen else None, axis1_deg, axis2_deg)
        if self._passage is not None:
            self._passage = None
            self.mode = LoopMode.WAIT
        if not seen:
            return self._without_spot(utc_s, axis1_deg, axis2_deg)
        return self._on_spot(utc_s, signals, errors, axis1_deg, axis2_deg)

    def _on_spot(
        self,
        utc_s: float,
        signals: Signals,
        errors: tuple[float, float],
        axis1_deg: float,
        axis2_deg: float,
    ) -> tuple[float, float]:
        off_mrad = self._off_mrad(signals, errors)
        if self.mode not in (LoopMode.STEP, LoopMode.PID):
            self.mode, self._spiral = LoopMode.STEP, None
            self._waiting_s = 0.0
            self._watch.forget()
        self._last_off_mrad = off_mrad
        if self._watch.growing(off_mrad):
            return self._stop(self._watch.sentence())
        to_go = self._diode.corrections_deg(*errors, axis1_deg, axis2_deg)
        if off_mrad < LOCKED_MRAD:
            self._lost_uncentred = 0
            if self.mode is LoopMode.STEP and self.loop.control == "pid":
                self._begin_pid(utc_s)
            self.base_model.keep_point(utc_s, to_go, axis1_deg, axis2_deg)
        if self.mode is LoopMode.STEP:
            return self._stepped(utc_s, to_go)
        return self._pids[0].rate_deg_s(to_go[0]), self._pids[1].rate_deg_s(to_go[1])

    def _off_mrad(self, signals: Signals, errors: tuple[float, float]) -> float:
        """How far off the spot seems; where the diode is saturated, the light that is left tells
        how near the edge of the field it is."""
        off_mrad = self._diode.off_centre_mrad(*errors)
        if max(abs(errors[0]), abs(errors[1])) > SATURATED:
            missing = 1.0 - min(1.0, sum(signals))
            off_mrad += missing * 1e3 * math.radians(self._field_radius_deg)
        return off_mrad

    def _begin_pid(self, utc_s: float) -> None:
        self.mode = LoopMode.PID
        for pid, rate in zip(self._pids, self.base_model.rates_deg_s(utc_s), strict=True):
            pid.begin(rate)

    def _stepped(self, utc_s: float, to_go: tuple[float, float]) -> tuple[float, float]:
        """Fixed steps of the size the Sun asks for, at least a tenth of its greatest rate."""
        period_s = self.loop.period_s
        rates = self.base_model.rates_deg_s(utc_s)
        least = 0.1 * 15.0 / 3600.0
        stepped = [
            step_rate_deg_s(
                error, self.loop.step_margin * max(abs(rate), least) * period_s, rate, period_s
            )
            for error, rate in zip(to_go, rates, strict=True)
        ]
        return stepped[0], stepped[1]

    # -- without a spot ----------------------------------------------------------------------

    def _without_spot(
        self, utc_s: float, axis1_deg: float, axis2_deg: float
    ) -> tuple[float, float]:
        """Go where it should be, wait a while, then search about that place."""
        if self.mode in (LoopMode.STEP, LoopMode.PID):
            if self._last_off_mrad > 2.0 * LOCKED_MRAD:
                self._lost_uncentred += 1
                if self._lost_uncentred >= LOST_AGAIN:
                    return self._stop(
                        f"the spot was found and lost again {self._lost_uncentred} times by the "
                        f"corrections meant to centre it: {REVERSED}"
                    )
            self.mode, self._waiting_s = LoopMode.WAIT, 0.0
        ahead = self.base_model.calculated_deg(utc_s + self.loop.period_s)
        place = ahead[0] + self.base_model.offset_deg[0], ahead[1] + self.base_model.offset_deg[1]
        if self.mode is LoopMode.WAIT:
            arrived = _apart_deg(place, axis1_deg, axis2_deg) < self._field_radius_deg
            self._waiting_s += self.loop.period_s if arrived else 0.0
            if self._waiting_s < WAIT_S and not (arrived and not self.base_model.log):
                return self._towards(place, axis1_deg, axis2_deg)
            self.mode = LoopMode.SEARCH
            self._next_arm()
        looked_at = axes_of(beside(*place, *self._beside_deg))
        if _apart_deg(looked_at, axis1_deg, axis2_deg) < 0.5 * self._field_radius_deg:
            self._next_arm()
            looked_at = axes_of(beside(*place, *self._beside_deg))
        return self._towards(looked_at, axis1_deg, axis2_deg)

    def _next_arm(self) -> None:
        """The next look of the spiral; after the last one the spiral begins anew."""
        following = next(self._spiral, None) if self._spiral is not None else None
        if following is None:
            limit_deg = self.loop.search_deg
            if self.base_model.log:
                # It has been found before: behind a cloud it is where it is calculated, and the
                # search must be back there soon.
                limit_deg = min(limit_deg, KNOWN_SEARCH_DEG)
            self._spiral = spiral_deg(self._field_radius_deg, limit_deg)
            following = next(self._spiral)
        self._beside_deg = following

    # -- near the zenith ---------------------------------------------------------------------

    def _is_near_zenith(self, utc_s: float) -> bool:
        """Near its own axis, where the azimuth is ill defined, or near the zenith of the site.

        A little earlier than asked for: axis 1 must have come to the calculated rate by then.
        """
        if utc_s >= self._look_again_utc_s:
            self._look_again_utc_s = utc_s + NEAR_LOOK_S
            sun = self.base_model.sun_deg(utc_s)
            nearest = min(sun[1], self.base_model.base.axes_deg(*sun)[1])
            self._near = nearest < self.loop.near_zenith_deg + LEAD_DEG
        return self._near

    def _near_zenith(
        self, utc_s: float, errors: tuple[float, float] | None, axis1_deg: float, axis2_deg: float
    ) -> tuple[float, float]:
        """Azimuth calculated, in one sense only; the zenith angle goes on by the diode."""
        if self._passage is None:
            self._passage = ZenithPassage(axis1_deg, self._path_deg(utc_s))
            self.mode = LoopMode.ZENITH
            self._pids[1].begin(self.base_model.rates_deg_s(utc_s)[1])
            self._watch.forget()
        ahead = self.base_model.calculated_deg(utc_s + self.loop.period_s)
        asked = self._passage.azimuth_deg(ahead[0] + self.base_model.offset_deg[0])
        rate1 = self._passage.rate_deg_s(axis1_deg, asked, self.loop.period_s)
        rate1 = math.copysign(min(abs(rate1), self._fastest_deg_s[0]), rate1)
        if errors is None:
            self._pids[1].begin(self.base_model.rates_deg_s(utc_s)[1])
            return rate1, self._limited(1, ahead[1] + self.base_model.offset_deg[1] - axis2_deg)
        _, to_go2 = self._diode.corrections_deg(*errors, axis1_deg, axis2_deg)
        return rate1, self._pids[1].rate_deg_s(to_go2)

    def _path_deg(self, utc_s: float) -> list[float]:
        """Calculated azimuths from now until the Sun has left the zone, every few seconds."""
        path = []
        for number in range(2000):
            azimuth, from_axis = self.base_model.calculated_deg(utc_s + 5.0 * number)
            path.append(azimuth)
            if number and from_axis > PATH_END * self.loop.near_zenith_deg:
                break
        return path

    # -- inside ------------------------------------------------------------------------------

    def _towards(
        self, place: tuple[float, float], axis1_deg: float, axis2_deg: float
    ) -> tuple[float, float]:
        """Rates that bring both axes there within a period, the short way."""
        return (
            self._limited(0, math.remainder(place[0] - axis1_deg, 360.0)),
            self._limited(1, place[1] - axis2_deg),
        )

    def _limited(self, axis: int, to_go_deg: float) -> float:
        fastest = self._fastest_deg_s[axis]
        return max(-fastest, min(fastest, to_go_deg / self.loop.period_s))

    def _stop(self, message: str) -> tuple[float, float]:
        self.mode, self.message = LoopMode.STOPPED, message
        return 0.0, 0.0


def _apart_deg(place: tuple[float, float], axis1_deg: float, axis2_deg: float) -> float:
    """From where the axes stand to a place, on the sky."""
    across = math.remainder(place[0] - axis1_deg, 360.0)
    return math.hypot(across * math.sin(math.radians(max(place[1], 0.1))), place[1] - axis2_deg)
