"""The points against the Sun's path: does it stand where they say?

A stamp and a pair of ideal angles say the same thing twice. Where they disagree, a time, a site, a
mount or the kind of the angles is not what the file says, and the fit is of another tracker. The
simplest single change that brings all points together is named with its size: first changes without
a number of their own (a whole hour, day and month exchanged, another hemisphere, a mirrored
longitude, another mount, angles counted otherwise, another kind of angles), then one number (a time
shift, a latitude, a longitude), then a place.
"""

import math
from typing import get_args

import msgspec
import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError
from solarcal.model.evidence.stamp_search import (
    KIND_FACTOR,
    KIND_WORDS,
    MARGIN_S,
    Explanation,
    StampSearch,
)
from solarcal.model.finding import Finding, Kind, points_named
from solarcal.model.sky_context import (
    LOWEST_ELEVATION_DEG,
    Ideal,
    SkyContext,
    SunDirections,
    sun_directions,
)
from solarcal.session.points import PointTable
from solarcal.sun.position import FIRST_UTC_S, LAST_UTC_S, SUN_YEARS
from solarcal.units import FloatArray, rms

AGREEMENT_SHARE = 0.5
"""Stamps and angles that differ by more than this part of the tolerance contradict each other."""
KIND_LIMIT_DEG = 0.01
"""Two kinds of ideal angles that differ by less are the same for a calibration."""

MOST_DECLINATION_DEG = 29.5
"""The Moon's 28.8 deg, and what refraction and a parallax may add."""

UNIT_CLOCK = "unit clock"
"""Whose time it is where a unit computed the ideal angles and the laptop stamped them."""

IDEAL_ANGLES = "ideal angles"
"""What is wrong where no angles of the Sun are in a file."""

_MOST_POINTS = 24
"""So many points, evenly chosen, are enough for a search."""


def stamp_evidence(
    table: PointTable, context: SkyContext, tolerance_deg: float, *, kind_claimed: bool = True
) -> tuple[Finding, ...]:
    """Findings on stamps, site, mount and kind of the ideal angles of the accepted points.

    Parameters
    ----------
    table : points of one unit; rows without an instant are not compared.
    context : their site, mount, air and kind of ideal angles.
    tolerance_deg : half of it is what stamps and angles may differ by, on sky.
    kind_claimed : whether the kind of the ideal angles is the file's word (a CSV, an import); where
        a unit computes them by the protocol it is known.

    Empty without a site or instants, or where they agree. Instants beyond the years of the Sun
    models are not compared, and a finding reports it.
    """
    used = table.accepted()
    if table.site is None:
        return ()
    if table.light == "sun" and not np.isfinite(used.utc_s).any():
        return _no_sun(used, context)
    known = _known_instants(used.utc_s)
    left_out = _not_compared(used.rows(np.flatnonzero(np.isfinite(used.utc_s) & ~known)), context)
    rows = used.rows(np.flatnonzero(known))
    return (*left_out, *_compared(rows, context, tolerance_deg, kind_claimed=kind_claimed))


def _no_sun(rows: PointTable, context: SkyContext) -> tuple[Finding, ...]:
    """Points without an instant, at declinations that the Sun never has."""
    if not len(rows):
        return ()
    azimuth, zenith = context.geometry.horizontal_from_axes(rows.ax1_deg, rows.ax2_deg)
    if context.heliostat is not None:
        azimuth, zenith = context.heliostat.sun_deg(azimuth, zenith)
    latitude = np.radians(context.site.latitude_deg)
    azimuth, zenith = np.radians(azimuth), np.radians(zenith)
    sine = np.cos(zenith) * np.sin(latitude) + np.sin(zenith) * np.cos(latitude) * np.cos(azimuth)
    declination = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
    beyond = np.flatnonzero(np.abs(declination) > MOST_DECLINATION_DEG)
    if not len(beyond):
        return ()
    worst = float(declination[beyond][np.argmax(np.abs(declination[beyond]))])
    labels = tuple(rows.labels[i] for i in beyond)
    return (
        Finding(
            kind="site",
            subject=IDEAL_ANGLES,
            sentence=f"the ideal angles of {points_named(labels)} are not the Sun's: at latitude "
            f"{context.site.latitude_deg:.2f} they reach a declination of {worst:.1f} deg, the Sun "
            "never leaves 23.5 nor the Moon 28.8; correct the site or the geometry, or give utc",
            number=worst,
            direct=True,
            labels=labels,
        ),
    )


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
        sun = sun_directions(context, rows.utc_s)
    except ConfigurationError:
        # Instants of a Sun that is not known cannot contradict anything.
        return ()
    apart = _apart_deg(rows, context, sun)
    limit = AGREEMENT_SHARE * tolerance_deg + _rounding_deg(rows)
    bad = np.flatnonzero((apart > limit) & ~_too_low(rows, context, sun))
    few = 2 * len(bad) < len(rows)
    other_kind = _kind_shown(rows, context, apart) if kind_claimed and few else ()
    if not len(bad) or other_kind:
        return other_kind
    # A few rows among many are slips of their own; else it is the file, or a part of it: a clock
    # that was set in between.
    everything = np.arange(len(rows))
    chosen, found = everything, None
    for tried in (bad,) if few else (everything, bad):
        search = StampSearch(rows.rows(_thinned(tried)), context)
        found = search.simplest(limit, whole_file=len(tried) == len(rows))
        if few or found is not None:
            chosen = tried
            break
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
                subject=IDEAL_ANGLES if len(chosen) == len(rows) else "time stamps",
                sentence=f"{start}: no single time shift, site, mount or kind of ideal angles "
                "explains it; check utc, site and geometry, or leave utc empty",
                number=worst,
                direct=True,
                labels=labels,
            ),
        )
    left = float(found.left_deg.max())
    said = f"{found.words}: {start}, and by up to {left:.3f} deg with that"
    if len(chosen) < len(rows):
        # What a few points are off may have many causes.
        said = f"{start}; one explanation: {found.words}, which leaves up to {left:.3f} deg"
    return (
        Finding(
            kind=found.kind,
            subject=_subject(found.kind, kind_claimed),
            sentence=f"{said}; {_cure(found, kind_claimed)}",
            number=found.number,
            unit=found.unit,
            direct=True,
            labels=labels,
        ),
    )


def _subject(kind: Kind, from_a_file: bool) -> str:
    if kind == "time_stamps":
        return "time stamps" if from_a_file else UNIT_CLOCK
    return {"ideal_kind": IDEAL_ANGLES, "site": "site"}.get(kind, "mount")


def _cure(found: Explanation, from_a_file: bool) -> str:
    if found.kind == "time_stamps" and not from_a_file:
        return "compare the clocks of unit and laptop, and set the wrong one right"
    if found.change.read_outs:
        return "give what the controller computed for the Sun: read-out less error"
    if found.kind == "ideal_kind":
        return f"give ideal={found.change.ideal} (or --ideal {found.change.ideal})"
    if found.kind == "time_stamps":
        return "correct utc, or leave it empty"
    if found.change.convention is not None:
        return (
            "give AX1 and AX2 as docs/physics.md has them, and reading - ideal of these as the "
            "errors: where an axis is counted the other way their sign changes"
        )
    return f"correct the {'site' if found.kind == 'site' else 'geometry'}"


def _known_instants(utc_s: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    # The Sun's models end somewhere; a shift must not lead beyond them.
    with np.errstate(invalid="ignore"):
        return (utc_s > FIRST_UTC_S + MARGIN_S) & (utc_s < LAST_UTC_S - MARGIN_S)


def _thinned(chosen: "np.ndarray[tuple[int, ...], np.dtype[np.intp]]") -> list[int]:
    places = np.linspace(0, len(chosen) - 1, min(len(chosen), _MOST_POINTS)).round().astype(int)
    return [int(chosen[place]) for place in places]


def _apart_deg(rows: PointTable, context: SkyContext, sun: SunDirections) -> FloatArray:
    """Separation (n,) on sky of ideal angles and Sun as the file has them."""
    return np.asarray(
        context.geometry.sky_separation_deg(
            context.geometry.branch(rows.ax1_deg), rows.ax2_deg, sun.ideal1_deg, sun.ideal2_deg
        ),
        dtype=np.float64,
    )


def _rounding_deg(rows: PointTable) -> float:
    """How far, on the diagonal, the noted angles may be from what they were rounded from."""
    angles = np.concatenate((rows.ax1_deg, rows.ax2_deg))
    for step_deg in (1.0, 0.1):
        if np.abs(angles / step_deg - np.round(angles / step_deg)).max() < 1e-6:
            return step_deg / math.sqrt(2.0)
    return 0.0


def _too_low(rows: PointTable, context: SkyContext, sun: SunDirections) -> NDArray[np.bool_]:
    """Which (n,) no fit uses, whether stamp or angles are right: there refraction dominates.

    Of a heliostat's normal the angles do not tell how high the Sun is.
    """
    low = sun.elevation_deg < LOWEST_ELEVATION_DEG
    if context.heliostat is None:
        _, zenith_deg = context.geometry.horizontal_from_axes(rows.ax1_deg, rows.ax2_deg)
        low &= 90.0 - zenith_deg < LOWEST_ELEVATION_DEG
    return low


def _kind_shown(
    rows: PointTable, context: SkyContext, apart_deg: FloatArray
) -> tuple[Finding, ...]:
    """Stamps and angles agree; but do they agree much better as another kind of angles?"""
    worst = float(apart_deg.max())
    if worst <= KIND_LIMIT_DEG:
        return ()
    left_deg = {}
    for kind in get_args(Ideal):
        other = msgspec.structs.replace(context, ideal=kind)
        left_deg[kind] = rms(_apart_deg(rows, other, sun_directions(other, rows.utc_s)))
    best = min(left_deg, key=lambda kind: left_deg[kind])
    if left_deg[best] * KIND_FACTOR > left_deg[context.ideal]:
        return ()
    return (
        Finding(
            kind="ideal_kind",
            subject=IDEAL_ANGLES,
            sentence=f"the ideal angles are {KIND_WORDS[best]}, not {context.ideal}: taken as "
            f"{context.ideal} they are up to {worst:.3f} deg from the Sun at their time stamps, "
            f"taken as {best} {left_deg[best]:.4f} deg rms; give ideal={best} (or --ideal {best})",
            number=worst,
            direct=True,
            labels=rows.labels,
        ),
    )
