"""Time stamps against ideal angles: does the Sun stand where the points say, when they say?

A stamp and a pair of ideal angles say the same thing twice. Where they disagree, a time, a site, a
mount or the kind of the angles is not what the file says, and the fit is of another tracker. The
simplest single change that brings all points together is named with its size: first changes
without a number of their own (a whole hour, another hemisphere, a mirrored longitude, another
mount, another kind of angles), then one number (a time shift, a latitude, a longitude), then a
place.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from scipy.optimize import minimize, minimize_scalar

from solarcal.errors import ConfigurationError
from solarcal.model.finding import Finding, Kind, points_named
from solarcal.model.sky_context import Ideal, SkyContext, sun_directions
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.session.points import PointTable
from solarcal.site import Site
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S, SUN_YEARS
from solarcal.sun.refraction import apparent_zenith_deg
from solarcal.timescale import SECONDS_PER_DAY
from solarcal.units import FloatArray

AGREEMENT_SHARE = 0.5
"""Stamps and angles that differ by more than this part of the tolerance contradict each other."""
KIND_LIMIT_DEG = 0.01
"""Two kinds of ideal angles that differ by less are the same for a calibration."""
AS_GOOD_DEG = 0.003
"""Two explanations that leave less than this are equally good."""
KIND_FACTOR = 3.0
"""Another kind has to meet the stamps so many times as well before the data show it."""

UNIT_CLOCK = "unit clock"
"""Whose time it is where a unit computed the ideal angles and the laptop stamped them."""

_MOST_POINTS = 24
"""So many points, evenly chosen, are enough for a search."""
_MARGIN_S = 2.0 * SECONDS_PER_DAY
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


@dataclass(frozen=True, slots=True)
class _Explanation:
    """A change, the separation (m,) it leaves, and how it is reported."""

    change: _Change
    left_deg: FloatArray
    kind: Kind
    words: str
    number: float
    unit: str

    @property
    def rms_deg(self) -> float:
        return float(np.sqrt(np.mean(self.left_deg**2)))


def stamp_evidence(
    table: PointTable, context: SkyContext, tolerance_deg: float, *, kind_claimed: bool = True
) -> tuple[Finding, ...]:
    """Findings on stamps, site, mount and kind of the ideal angles of the accepted points.

    Parameters
    ----------
    table
        Points of one unit; rows without an instant are not compared.
    context
        Their site, mount, air and kind of ideal angles.
    tolerance_deg
        Half of it is what stamps and angles may differ by, on sky.
    kind_claimed
        Whether the kind of the ideal angles is the file's word (a CSV, an import); where a unit
        computes them by the protocol it is known.

    Returns
    -------
    tuple of Finding
        Empty without a site or instants, or where they agree. Instants beyond the years of the
        Sun models are not compared, and a finding reports it.
    """
    used = table.accepted()
    if table.site is None or not len(used):
        return ()
    known = _known_instants(used.utc_s)
    left_out = _not_compared(used.rows(np.flatnonzero(np.isfinite(used.utc_s) & ~known)), context)
    rows = used.rows(np.flatnonzero(known))
    return (*left_out, *_compared(rows, context, tolerance_deg, kind_claimed=kind_claimed))


def _not_compared(rows: PointTable, context: SkyContext) -> tuple[Finding, ...]:
    """What is left out of points whose instants the Sun models do not cover."""
    if not len(rows):
        return ()
    return (
        Finding(
            kind="time_stamps",
            subject="time stamps",
            sentence=f"the Sun models hold for {SUN_YEARS}: the time stamps of "
            f"{points_named(rows.labels)} cannot be compared with their ideal angles, and the "
            f"forecast is for {context.year[:4]}",
            certainty="not_determinable",
            labels=rows.labels,
        ),
    )


def _compared(
    rows: PointTable, context: SkyContext, tolerance_deg: float, *, kind_claimed: bool
) -> tuple[Finding, ...]:
    """The same of rows whose instants have a Sun."""
    if not len(rows):
        return ()
    try:
        apart = _apart_now(rows, context)
    except ConfigurationError:
        # Instants of a Sun that is not known cannot contradict anything.
        return ()
    limit = AGREEMENT_SHARE * tolerance_deg
    bad = np.flatnonzero(apart > limit)
    if not len(bad):
        return _kind_shown(rows, context, apart) if kind_claimed else ()
    # A few rows among many are slips of their own; else it is the file.
    chosen = bad if 2 * len(bad) < len(rows) else np.arange(len(rows))
    search = _Search(rows.rows(_thinned(chosen)), context)
    found = search.simplest(limit, whole_file=len(chosen) == len(rows))
    labels = tuple(rows.labels[i] for i in chosen)
    worst = float(apart[bad].max())
    where = f"at {len(bad)} of {len(rows)} points"
    start = f"time stamps and ideal angles disagree by up to {worst:.3g} deg {where}"
    if len(chosen) < len(rows):
        start += f" ({points_named(labels)})"
    if found is None:
        return (
            Finding(
                kind="time_stamps",
                subject="time stamps",
                sentence=f"{start}: no single time shift, site, mount or kind of ideal angles "
                "explains it; check utc, site and geometry, or leave utc empty",
                number=worst,
                direct=True,
                labels=labels,
            ),
        )
    left = float(found.left_deg.max())
    return (
        Finding(
            kind=found.kind,
            subject=_subject(found.kind, kind_claimed),
            sentence=f"{found.words}: {start}, and by up to {left:.3f} deg with that; "
            f"{_cure(found, kind_claimed)}",
            number=found.number,
            unit=found.unit,
            direct=True,
            labels=labels,
        ),
    )


def _as_good(one: _Explanation, best: _Explanation) -> bool:
    return one.rms_deg <= KIND_FACTOR * max(best.rms_deg, AS_GOOD_DEG)


def _all_as_good(good: list[_Explanation]) -> _Explanation:
    """The first, and the others beside it: a time shift is nearly a longitude."""
    return replace(good[0], words=", or ".join(e.words for e in good))


def _subject(kind: Kind, from_a_file: bool) -> str:
    if kind == "time_stamps":
        return "time stamps" if from_a_file else UNIT_CLOCK
    return {"ideal_kind": "ideal angles", "site": "site"}.get(kind, "mount")


def _cure(found: _Explanation, from_a_file: bool) -> str:
    if found.kind == "time_stamps" and not from_a_file:
        return "compare the clocks of unit and laptop, and set the wrong one right"
    if found.kind == "ideal_kind":
        return f"give ideal={found.change.ideal} (or --ideal {found.change.ideal})"
    if found.kind == "time_stamps":
        return "correct utc, or leave it empty"
    return f"correct the {'site' if found.kind == 'site' else 'geometry'}"


def _known_instants(utc_s: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    # The Sun's models end somewhere; a shift must not lead beyond them.
    with np.errstate(invalid="ignore"):
        return (utc_s > FIRST_UTC_S + 2.0 * _MARGIN_S) & (utc_s < LAST_UTC_S - 2.0 * _MARGIN_S)


def _thinned(chosen: "np.ndarray[tuple[int, ...], np.dtype[np.intp]]") -> list[int]:
    places = np.linspace(0, len(chosen) - 1, min(len(chosen), _MOST_POINTS)).round().astype(int)
    return [int(chosen[place]) for place in places]


def _apart_now(rows: PointTable, context: SkyContext) -> FloatArray:
    """Separation (n,) on sky of ideal angles and Sun as the file has them."""
    sun = sun_directions(context, rows.utc_s)
    return np.asarray(
        context.geometry.sky_separation_deg(
            context.geometry.branch(rows.ax1_deg), rows.ax2_deg, sun.ideal1_deg, sun.ideal2_deg
        ),
        dtype=np.float64,
    )


def _kind_shown(
    rows: PointTable, context: SkyContext, apart_deg: FloatArray
) -> tuple[Finding, ...]:
    """Stamps and angles agree; but do they agree much better as another kind of angles?"""
    worst = float(apart_deg.max())
    if worst <= KIND_LIMIT_DEG:
        return ()
    rms = {
        kind: float(np.sqrt(np.mean(_apart_now(rows, _with_kind(context, kind)) ** 2)))
        for kind in get_args(Ideal)
    }
    best = min(rms, key=lambda kind: rms[kind])
    if rms[best] * KIND_FACTOR > rms[context.ideal]:
        return ()
    return (
        Finding(
            kind="ideal_kind",
            subject="ideal angles",
            sentence=f"the ideal angles are {_KIND_WORDS[best]}, not {context.ideal}: taken as "
            f"{context.ideal} they are up to {worst:.3f} deg from the Sun at their time stamps, "
            f"taken as {best} {rms[best]:.4f} deg rms; give ideal={best} (or --ideal {best})",
            number=worst,
            direct=True,
            labels=rows.labels,
        ),
    )


_KIND_WORDS = {
    "apparent": "apparent (with refraction)",
    "airless": "airless (without refraction)",
    "solartrak": "the controller's own (solartrak, without refraction)",
}


def _with_kind(context: SkyContext, kind: str) -> SkyContext:
    return SkyContext(
        context.site, context.geometry, context.limits, kind,  # type: ignore[arg-type]
        context.weather, context.refraction, context.year, context.heliostat,
    )  # fmt: skip


class _Search:
    """Changes tried on some rows (m,); times, places and angles of all of them at once."""

    def __init__(self, rows: PointTable, context: SkyContext) -> None:
        self.rows = rows
        self.context = context
        self.site = context.site
        self.sun = SiteEphemeris(
            Site(0.0, 0.0),
            float(rows.utc_s.min()) - _MARGIN_S,
            float(rows.utc_s.max()) + _MARGIN_S,
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
        aim = (azimuth, zenith)
        if self.context.heliostat is not None:
            aim = self.context.heliostat.controller_normal_deg(*aim)
        ax1, ax2 = (axis.reshape(utc_s.shape) for axis in geometry.axes_from_horizontal(*aim))
        return np.asarray(
            geometry.sky_separation_deg(self.rows.ax1_deg, self.rows.ax2_deg, ax1, ax2),
            dtype=np.float64,
        )

    def simplest(self, limit_deg: float, *, whole_file: bool) -> _Explanation | None:
        """The best of the simplest family that brings every row within ``limit_deg``."""
        families: tuple[Callable[[bool], Iterator[_Explanation]], ...] = (
            self._whole,
            self._one_number,
            self._place,
        )
        for family in families:
            good = [e for e in family(whole_file) if float(e.left_deg.max()) <= limit_deg]
            if good:
                best = min(good, key=lambda e: e.rms_deg)
                if family == self._one_number:
                    return _all_as_good([e for e in good if _as_good(e, best)])
                return best
        return None

    def _explained(
        self, change: _Change, kind: Kind, words: str, number: float, unit: str
    ) -> _Explanation:
        return _Explanation(change, self.left(change), kind, words, number, unit)

    def _whole(self, whole_file: bool) -> Iterator[_Explanation]:
        """Changes without a number of their own."""
        shifts = (*(1800.0 * k for k in _HALF_HOURS), SECONDS_PER_DAY, -SECONDS_PER_DAY)
        for shift_s in shifts:
            yield self._shifted(shift_s)
        if not whole_file:
            return
        latitude, longitude = self.site.latitude_deg, self.site.longitude_deg
        for kind in get_args(Ideal):
            # The Sun of solartrak and the airless one are too near each other for this search.
            if kind not in (self.context.ideal, "solartrak"):
                yield self._explained(
                    _Change(ideal=kind), "ideal_kind",
                    f"the ideal angles are {_KIND_WORDS[kind]}, not {self.context.ideal}",
                    float(self.left(_Change()).max()), "deg",
                )  # fmt: skip
        yield self._explained(
            _Change(latitude_deg=-latitude), "site",
            f"the latitude has the wrong sign ({latitude:+.4f} for {-latitude:+.4f} deg)",
            2.0 * latitude, "deg",
        )  # fmt: skip
        yield self._explained(
            _Change(longitude_deg=-longitude), "site",
            f"the longitude has the wrong sign ({longitude:+.4f} for {-longitude:+.4f} deg, east "
            "positive)", 2.0 * longitude, "deg",
        )  # fmt: skip
        if abs(longitude) <= 90.0:
            yield self._explained(
                _Change(latitude_deg=longitude, longitude_deg=latitude), "site",
                "latitude and longitude are exchanged", latitude - longitude, "deg",
            )  # fmt: skip
        if self.context.heliostat is None:
            for name in GEOMETRIES:
                if name != self.context.geometry.name:
                    yield self._explained(
                        _Change(geometry=name), "geometry",
                        f"the angles are those of a {name} mount, not "
                        f"{self.context.geometry.name}",
                        float(self.left(_Change()).max()), "deg",
                    )  # fmt: skip

    def _one_number(self, whole_file: bool) -> Iterator[_Explanation]:
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
            f"the latitude is {off:+.3f} deg off ({self.site.latitude_deg:.4f}, the angles are of "
            f"{latitude:.3f})", off, "deg",
        )  # fmt: skip
        longitudes = np.arange(-180.0, 181.0)
        squares = self._squares(_Change(longitude_deg=longitudes[:, np.newaxis]))
        longitude = self._best(lambda x: _Change(longitude_deg=x), longitudes, squares)
        off = self.site.longitude_deg - longitude
        yield self._explained(
            _Change(longitude_deg=longitude), "site",
            f"the longitude is {off:+.3f} deg off ({self.site.longitude_deg:.4f}, the angles are "
            f"of {longitude:.3f}, east positive)", off, "deg",
        )  # fmt: skip

    def _place(self, whole_file: bool) -> Iterator[_Explanation]:
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
            f"the angles are of another site: {at[0]:.3f}, {at[1]:.3f} deg, not "
            f"{self.site.latitude_deg:.3f}, {self.site.longitude_deg:.3f}",
            float(np.hypot(at[0] - self.site.latitude_deg, at[1] - self.site.longitude_deg)), "deg",
        )  # fmt: skip

    def _shifted(self, shift_s: float) -> _Explanation:
        late_s = -shift_s
        sense = "late" if late_s > 0.0 else "early"
        hours = round(late_s / 1800.0) / 2.0
        words = f"the time stamps are {abs(late_s):.0f} s {sense}"
        if abs(abs(late_s) - SECONDS_PER_DAY) < _WHOLE_HOUR_S:
            words += " (a day: the date)"
        elif hours and abs(late_s - 3600.0 * hours) < _WHOLE_HOUR_S:
            words += f" ({abs(hours):g} h: daylight-saving time or the time zone)"
        return self._explained(
            _Change(shift_s=shift_s), "time_stamps", words, round(late_s, 1), "s"
        )

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
