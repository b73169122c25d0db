"""The simplest change that brings time stamps and ideal angles together, searched for.

First changes without a number of their own, then one number, then a place.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import get_args

import msgspec
import numpy as np
from scipy.optimize import minimize, minimize_scalar

from solarcal.model.evidence.angle_conventions import AngleConvention, other_conventions
from solarcal.model.finding import Kind
from solarcal.model.sky_context import Ideal, SkyContext
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.session.points import PointTable
from solarcal.site import Site, longitude_apart_deg
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray, rms

AS_GOOD_DEG = 0.003
"""Two explanations that leave less than this are equally good."""
KIND_FACTOR = 3.0
"""Another kind has to meet the stamps so many times as well before the data show it."""
MARGIN_S = 2.0 * SECONDS_PER_DAY
_WHOLE_HOUR_S = 120.0
_HALF_HOURS = tuple(k for k in range(-28, 29) if k)


@dataclass(frozen=True, slots=True)
class _Change:
    """What is taken to be otherwise than the file says."""

    shift_s: float | FloatArray = 0.0
    latitude_deg: float | None = None
    longitude_deg: float | FloatArray | None = None
    geometry: str | None = None
    ideal: Ideal | None = None
    convention: AngleConvention | None = None
    read_outs: bool = False
    """The angles are those that the axes showed."""


@dataclass(frozen=True, slots=True)
class Explanation:
    """A change, the separation (m,) it leaves, and how it is reported."""

    change: _Change
    left_deg: FloatArray
    kind: Kind
    words: str
    number: float

    @property
    def unit(self) -> str:
        """Of the number."""
        return "s" if self.kind == "time_stamps" else "deg"

    @property
    def rms_deg(self) -> float:
        return rms(self.left_deg)


KIND_WORDS = {
    "apparent": "apparent (with refraction)",
    "airless": "airless (without refraction)",
    "solartrak": "the controller's own (solartrak, without refraction)",
}


class StampSearch:
    """Changes tried on some rows (m,); times, places and angles of all of them at once."""

    def __init__(self, rows: PointTable, context: SkyContext) -> None:
        self.rows = rows
        self.context = context
        self.site = context.site
        self.exchanged_s = day_and_month_exchanged_s(rows.utc_s)
        known = np.concatenate((rows.utc_s, self.exchanged_s))
        self.sun = SiteEphemeris(
            Site(0.0, 0.0),
            max(float(known.min()) - MARGIN_S, FIRST_UTC_S),
            min(float(known.max()) + MARGIN_S, LAST_UTC_S - 1.0),
        )

    def left(self, change: _Change) -> FloatArray:
        """Separation (m,) on sky with this change; (k, m) of k shifts or longitudes (k, 1)."""
        latitude = self.site.latitude_deg if change.latitude_deg is None else change.latitude_deg
        longitude = (
            self.site.longitude_deg if change.longitude_deg is None else change.longitude_deg
        )
        geometry = MountGeometry(
            change.geometry or self.context.geometry.name,
            latitude,
            self.context.geometry.ax1_centre_deg,
        )
        utc_s, east_deg = np.broadcast_arrays(self.rows.utc_s + change.shift_s, longitude)
        azimuth, zenith = self.sun.horizontal_elsewhere_deg(
            utc_s.reshape(-1),
            np.full(utc_s.size, latitude),
            east_deg.reshape(-1),
            np.full(utc_s.size, self.site.elevation_m),
        )
        if (change.ideal or self.context.ideal) == "apparent":
            zenith = apparent_zenith_deg(zenith, self.context.refraction, self.context.air)
        given1, given2 = self.rows.ax1_deg, self.rows.ax2_deg
        if change.read_outs:
            given1, given2 = given1 - self.rows.err1_deg, given2 - self.rows.err2_deg
        if change.convention is not None:
            given1, given2 = change.convention.native_deg(given1, given2)
            if given2.min() < 0.0 or given2.max() > 180.0:
                return np.full(utc_s.shape, np.inf)
        there = msgspec.structs.replace(self.context, geometry=geometry)
        ax1, ax2 = (a.reshape(utc_s.shape) for a in there.believed_axes_deg(azimuth, zenith))
        return np.asarray(
            geometry.sky_separation_deg(given1, given2, ax1, ax2),
            dtype=np.float64,
        )

    def simplest(self, limit_deg: float, *, whole_file: bool) -> Explanation | None:
        """The best of the simplest family that brings every row within ``limit_deg``."""
        families: tuple[Callable[[bool], Iterator[Explanation]], ...] = (
            self._whole,
            self._one_number,
            self._place,
        )
        for family in families:
            good = [e for e in family(whole_file) if float(e.left_deg.max()) <= limit_deg]
            if good:
                best = min(good, key=lambda e: e.rms_deg)
                # The others beside the first: a time shift is nearly a longitude, at an equinox
                # the other hemisphere an azimuth from North.
                enough_deg = KIND_FACTOR * max(best.rms_deg, AS_GOOD_DEG)
                as_good = [e for e in good if e.rms_deg <= enough_deg]
                return replace(as_good[0], words=", or ".join(e.words for e in as_good))
        return None

    def _explained(self, change: _Change, kind: Kind, words: str, number: float) -> Explanation:
        return Explanation(change, self.left(change), kind, words, number)

    def _whole(self, whole_file: bool) -> Iterator[Explanation]:
        """Changes without a number of their own."""
        shifts = (*(1800.0 * k for k in _HALF_HOURS), SECONDS_PER_DAY, -SECONDS_PER_DAY)
        for shift_s in shifts:
            yield self._shifted(shift_s)
        exchanged_s = self.exchanged_s - self.rows.utc_s
        if exchanged_s.any():
            yield self._explained(
                _Change(shift_s=exchanged_s), "time_stamps",
                "day and month of the time stamps are exchanged",
                -float(exchanged_s[np.argmax(np.abs(exchanged_s))]),
            )  # fmt: skip
        if not whole_file:
            return
        latitude, longitude = self.site.latitude_deg, self.site.longitude_deg
        worst_deg = float(self.left(_Change()).max())
        for kind in get_args(Ideal):
            # The Sun of solartrak and the airless one are too near each other for this search.
            if kind not in (self.context.ideal, "solartrak"):
                yield self._explained(
                    _Change(ideal=kind), "ideal_kind",
                    f"the ideal angles are {KIND_WORDS[kind]}, not {self.context.ideal}",
                    worst_deg,
                )  # fmt: skip
        yield self._explained(
            _Change(latitude_deg=-latitude), "site",
            f"the latitude has the wrong sign ({latitude:+z.4f} for {-latitude:+z.4f} deg)",
            2.0 * latitude,
        )  # fmt: skip
        yield self._explained(
            _Change(longitude_deg=-longitude), "site",
            f"the longitude has the wrong sign ({longitude:+z.4f} for {-longitude:+z.4f} deg, east "
            "positive)", 2.0 * longitude,
        )  # fmt: skip
        if abs(longitude) <= 90.0:
            yield self._explained(
                _Change(latitude_deg=longitude, longitude_deg=latitude), "site",
                "latitude and longitude are exchanged", latitude - longitude,
            )  # fmt: skip
        if self.context.heliostat is None:
            for name in GEOMETRIES:
                if name != self.context.geometry.name:
                    yield self._explained(
                        _Change(geometry=name), "geometry",
                        f"the angles are those of a {name} mount, not {self.context.geometry.name}",
                        worst_deg,
                    )  # fmt: skip

        yield self._explained(
            _Change(read_outs=True), "ideal_kind",
            "the angles are the axes' read-outs, not ideal angles", worst_deg,
        )  # fmt: skip
        for convention in other_conventions():
            yield self._explained(
                _Change(convention=convention), "geometry",
                f"the ideal angles {convention.words(self.context.geometry.name)}", worst_deg,
            )  # fmt: skip

    def _one_number(self, whole_file: bool) -> Iterator[Explanation]:
        shifts = np.arange(-50400.0, 50401.0, 120.0)
        squares = self._squares(_Change(shift_s=shifts[:, np.newaxis]))
        shift_s = self._best(lambda x: _Change(shift_s=x), shifts, squares)
        yield self._shifted(shift_s)
        if not whole_file:
            return
        latitudes = np.arange(-89.5, 90.0)
        squares = np.array([self._squares(_Change(latitude_deg=x)) for x in latitudes])
        latitude = self._best(lambda x: _Change(latitude_deg=x), latitudes, squares)
        off = self.site.latitude_deg - latitude
        yield self._explained(
            _Change(latitude_deg=latitude), "site",
            f"the latitude is {off:+z.3f} deg off ({self.site.latitude_deg:.4f}, the angles are of "
            f"{latitude:z.3f})", off,
        )  # fmt: skip
        longitudes = np.arange(-180.0, 181.0)
        squares = self._squares(_Change(longitude_deg=longitudes[:, np.newaxis]))
        longitude = self._best(lambda x: _Change(longitude_deg=x), longitudes, squares)
        off = longitude_apart_deg(self.site.longitude_deg, longitude)
        yield self._explained(
            _Change(longitude_deg=longitude), "site",
            f"the longitude is {off:+z.3f} deg off ({self.site.longitude_deg:z.4f}, the angles are "
            f"of {longitude:z.3f}, east positive)", off,
        )  # fmt: skip

    def _place(self, whole_file: bool) -> Iterator[Explanation]:
        if not whole_file or len(self.rows) < 2:
            return
        latitudes, longitudes = np.arange(-87.0, 88.0, 3.0), np.arange(-177.0, 181.0, 3.0)
        squares = np.array(
            [self._squares(_Change(0.0, one, longitudes[:, np.newaxis])) for one in latitudes]
        )
        row, column = np.unravel_index(np.argmin(squares), squares.shape)
        found = minimize(
            lambda place: float(self._squares(_Change(0.0, *place))),
            (latitudes[row], longitudes[column]),
            method="Nelder-Mead",
            bounds=((-89.0, 89.0), (None, None)),
            options={"xatol": 1e-4, "fatol": 1e-12},
        )
        at = (float(found.x[0]), float(found.x[1]))
        yield self._explained(
            _Change(0.0, *at), "site",
            f"the angles are of another site: {at[0]:z.3f}, {at[1]:z.3f} deg, not "
            f"{self.site.latitude_deg:z.3f}, {self.site.longitude_deg:z.3f}",
            float(np.hypot(at[0] - self.site.latitude_deg, at[1] - self.site.longitude_deg)),
        )  # fmt: skip

    def _shifted(self, shift_s: float) -> Explanation:
        late_s = -shift_s
        sense = "late" if late_s > 0.0 else "early"
        hours = round(late_s / 1800.0) / 2.0
        words = f"the time stamps are {abs(late_s):.0f} s {sense}"
        if abs(abs(late_s) - SECONDS_PER_DAY) < _WHOLE_HOUR_S:
            words += " (a day: the date)"
        elif hours and abs(late_s - 3600.0 * hours) < _WHOLE_HOUR_S:
            words += f" ({abs(hours):g} h: daylight-saving time or the time zone)"
        return self._explained(_Change(shift_s=shift_s), "time_stamps", words, round(late_s, 1))

    def _squares(self, change: _Change) -> FloatArray:
        """Sum of squared separations, of each change tried."""
        squares: FloatArray = np.sum(self.left(change) ** 2, axis=-1)
        return squares

    def _best(
        self, change: Callable[[float], _Change], tried: FloatArray, squares: FloatArray
    ) -> float:
        """The number that brings the rows together best, beside the best of those tried (k,)."""
        at = int(np.argmin(squares))
        low, high = tried[max(at - 1, 0)], tried[min(at + 1, len(tried) - 1)]
        found = minimize_scalar(
            lambda value: float(self._squares(change(value))),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-6 * (high - low)},
        )
        return float(found.x)


def day_and_month_exchanged_s(utc_s: FloatArray) -> FloatArray:
    """The instants (n,) with day and month exchanged; as they are from the 13th of a month on."""
    date = np.floor(utc_s / SECONDS_PER_DAY).astype("datetime64[D]")
    month, year = date.astype("datetime64[M]"), date.astype("datetime64[Y]")
    day = (date - month.astype("datetime64[D]")).astype(int)
    other = (year.astype("datetime64[M]") + day).astype("datetime64[D]") + (
        month - year.astype("datetime64[M]")
    ).astype(int)
    shift_days = np.where(day < 12, (other - date).astype(int), 0)
    return np.asarray(utc_s + SECONDS_PER_DAY * shift_days, dtype=np.float64)
