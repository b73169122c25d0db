"""Follow the sensor on the Moon, with a unit that computes only the Sun.

There is no Set Sun Offset on the Moon: O counts from the unit's Sun. The axes are jogged to where
the Moon is, centred by the sensor and followed for a minute; a point is the read-outs at rest less
the Moon's own apparent place, computed here. Its errors are of the same mechanism, so P1..P6 of
such points serve for the Sun.
"""

from functools import cached_property

import msgspec

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused
from solarcal.mount.controller import commanded_error_deg
from solarcal.session.records import Answers, PointRecord
from solarcal.station import guards
from solarcal.station.jogging import SunOffsetJog
from solarcal.station.point_judgement import judge_point
from solarcal.station.procedure import Station
from solarcal.station.sensor_following import LONGEST_SLEW_S, SensorDoubt, SensorFollower
from solarcal.station.sun_path import RATE_OVER_S
from solarcal.sun.moon import MoonLight
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY, format_utc
from solarcal.unit.tracker import Status
from solarcal.units import wrap_deg

WATCH_S = 60.0


class MoonPlace:
    """Ideal axis angles of the middle of the Moon's light for one session: apparent."""

    def __init__(self, station: Station) -> None:
        self._session = station.session
        self._day = -1
        self._light: MoonLight | None = None

    def horizontal_deg(self, utc_s: float) -> Pair:
        """Azimuth and apparent zenith angle."""
        azimuth, zenith = self._light_at(utc_s).horizontal_deg(utc_s)
        return azimuth, float(apparent_zenith_deg(zenith, "hughes", self._session.header.weather))

    def bright_enough(self, utc_s: float) -> bool:
        """Whether enough of it is lit to be followed."""
        return self._light_at(utc_s).bright_enough

    def axes_deg(self, utc_s: float) -> Pair:
        """AX1 on the branch and AX2, of a heliostat those of the normal."""
        return self._session.true_axes_deg(*self.horizontal_deg(utc_s))

    def rates_deg_per_s(self, utc_s: float) -> Pair:
        """How fast the axes follow it, central difference."""
        one = self.axes_deg(utc_s - 0.5 * RATE_OVER_S)
        two = self.axes_deg(utc_s + 0.5 * RATE_OVER_S)
        return float(wrap_deg(two[0] - one[0])) / RATE_OVER_S, (two[1] - one[1]) / RATE_OVER_S

    def _light_at(self, utc_s: float) -> MoonLight:
        day = int(utc_s // SECONDS_PER_DAY)
        if self._light is None or day != self._day:
            begins_s = day * SECONDS_PER_DAY
            ends_s = begins_s + SECONDS_PER_DAY
            self._light = MoonLight(
                self._session.header.site, begins_s - RATE_OVER_S, ends_s + RATE_OVER_S
            )
            self._day = day
        return self._light


class MoonJog(SunOffsetJog):
    """Jogging onto the Moon: in every status its place stands where the unit's Sun stood."""

    def __init__(self, station: Station, place: MoonPlace) -> None:
        super().__init__(station)
        self._place = place

    def _poll(self) -> Status:
        status = super()._poll()
        ideal1, ideal2 = self._place.axes_deg(self.station.clock.utc_s())
        return msgspec.structs.replace(status, ideal1_deg=ideal1, ideal2_deg=ideal2)

    def _rates(self, status: Status) -> Pair:
        del status
        return self._place.rates_deg_per_s(self.station.clock.utc_s())

    def at_rest(self) -> tuple[Status, float]:
        """The unit's status with the axes at rest on the aim, and the laptop's UTC then."""
        self.rest_on_aim()
        return self._poll(), self.station.clock.utc_s()


class MoonFollower(SensorFollower):
    """The sensor's eye and the jogging hand, on the Moon; the unit need not track.

    The session is one of points on the Moon.
    """

    light = "Moon"

    @cached_property
    def _place(self) -> MoonPlace:
        return MoonPlace(self._station)

    def demand_ready(self) -> None:
        """The laptop's clock is the Moon's; and it must be lit enough to be followed."""
        if self._station.session.header.target != "moon":
            raise ProcedureRefused("this session holds points on the Sun; start one for the Moon")
        utc_s = self._station.clock.utc_s()
        if not self._place.bright_enough(utc_s):
            raise ProcedureRefused("the Moon is too thin to be followed; wait for a fuller one")

    def elevation_deg(self) -> float:
        return 90.0 - self._place.horizontal_deg(self._station.clock.utc_s())[1]

    def take_point(self) -> PointRecord:
        jog = MoonJog(self._station, self._place)
        try:
            self._go(jog)
            self._centre(jog)
            self._watch(jog)
            candidate = self._candidate(*jog.at_rest())
        finally:
            jog.release()
        judgement = judge_point(self._station.session, candidate)
        if judgement.suspicious:
            self._station.store_reading(
                msgspec.structs.replace(candidate, status="rejected", reason=judgement.sentence)
            )
            raise SensorDoubt(judgement.sentence)
        return self._stored(self._station.store_reading(candidate))

    def _go(self, jog: MoonJog) -> None:
        """To where the Moon should be, as the last point or P and O in force say."""
        station = self._station
        accepted = station.session.accepted
        error = accepted[-1].error_deg if accepted else None
        if error is None:
            status = jog.look().status
            error = commanded_error_deg(
                station.coefficients_in_force, status.offsets, status.ideal1_deg, status.ideal2_deg
            )
        jog.go_to(error)
        self._come_forward(jog, LONGEST_SLEW_S)

    def _watch(self, jog: MoonJog) -> None:
        """Followed for a minute it must still be centred."""
        view = self._renew(jog, WATCH_S)
        spot = self._mean_look(jog)
        off_deg = view.status.on_sky_deg(spot.error1_deg, spot.error2_deg)
        if off_deg > self._centred_deg + 4.0 * self._mean_sigma_deg:
            raise SensorDoubt("after a minute the sensor shows it off the Moon")

    def _candidate(self, status: Status, utc_s: float) -> PointRecord:
        """The point these read-outs at rest make."""
        session = self._station.session
        ideal, reading = status.ideal_deg, status.reading_deg
        return PointRecord(
            seq=-1,
            utc="",
            status="accepted",
            answers=Answers(ref_check=True, tracking=True),
            basis="moon",
            read_utc=format_utc(utc_s),
            unit_minus_laptop_s=round(status.unit_utc_s - utc_s, 3),
            ideal_deg=(round(ideal[0], 6), round(ideal[1], 6)),
            reading_deg=reading,
            counts=status.counts,
            approach=status.approach,
            distance_to_limits_deg=round(
                guards.distance_to_limits_deg(session.header.unit, status), 5
            ),
            error_deg=(
                round(float(wrap_deg(reading[0] - ideal[0])), 6),
                round(reading[1] - ideal[1], 6),
            ),
        )
