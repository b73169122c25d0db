"""Sun positions at one site over one year: solarcal's precise and fast paths against pvlib's SPA.

The peer is pvlib's numpy implementation of NREL's SPA, through its public function. The fast
path's time includes preparing it for the year.
"""

import time
from collections.abc import Callable

import numpy as np
import pandas as pd
from pvlib.solarposition import spa_python

from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.units import FloatArray, wrap_deg

SITE = Site(35.05, -106.48, 1830.0, "Tijeras")
START_UTC_S = 1767225600.0  # 2026-01-01
YEAR_S = 365.0 * 86400.0
SIZES = (1_000, 10_000, 100_000, 1_000_000)
SLOW_LIMIT = 100_000
"""Beyond this the slow paths would take minutes and only repeat their time per position."""


def run() -> list[str]:
    """The table as lines of text."""
    lines = [
        "Sun positions at one site over one year, microseconds each (best of 3; 1e5 and up: of 1)",
        f"{'positions':>10}{'SPA':>10}{'precise':>10}{'fast':>10}"
        f"{'SPA/precise':>13}{'SPA/fast':>10}",
    ]
    # Imports and first calls are nobody's time per position.
    warm = _times(10)
    for path in (_spa, _precise, _fast):
        path(warm)
    spa_us = precise_us = 0.0
    for size in SIZES:
        times = _times(size)
        note = ""
        if size <= SLOW_LIMIT:
            spa_us = _microseconds_each(_spa, times)
            precise_us = _microseconds_each(_precise, times)
        else:
            note = f"  (SPA, precise: as measured at {SLOW_LIMIT})"
        fast_us = _microseconds_each(_fast, times)
        lines.append(
            f"{size:>10}{spa_us:>10.3f}{precise_us:>10.3f}{fast_us:>10.3f}"
            f"{spa_us / precise_us:>13.2f}{spa_us / fast_us:>10.1f}{note}"
        )
    lines.append(f"fast path's worst deviation from precise: {_deviation_arcsec():.4f} arcsec")
    return lines


def _times(size: int) -> FloatArray:
    return START_UTC_S + np.linspace(0.0, YEAR_S, size)


def _spa(utc_s: FloatArray) -> None:
    instants = pd.DatetimeIndex((utc_s * 1e9).astype("datetime64[ns]"), tz="UTC")
    spa_python(instants, SITE.latitude_deg, SITE.longitude_deg, SITE.elevation_m, how="numpy")


def _precise(utc_s: FloatArray) -> None:
    sun_position("precise", utc_s, SITE)


def _fast(utc_s: FloatArray) -> None:
    SiteEphemeris(SITE, float(utc_s[0]), float(utc_s[-1])).horizontal_deg(utc_s)


def _microseconds_each(path: Callable[[FloatArray], None], utc_s: FloatArray) -> float:
    best = np.inf
    for _ in range(3 if utc_s.size < 100_000 else 1):
        started = time.perf_counter()
        path(utc_s)
        best = min(best, time.perf_counter() - started)
    return float(best / utc_s.size * 1e6)


def _deviation_arcsec() -> float:
    utc_s = _times(20_011)
    exact = sun_position("precise", utc_s, SITE)
    azimuth, zenith = SiteEphemeris(SITE, START_UTC_S, START_UTC_S + YEAR_S).horizontal_deg(utc_s)
    across = wrap_deg(azimuth - exact.azimuth_deg) * np.sin(np.radians(exact.zenith_deg))
    return float(3600.0 * np.hypot(across, zenith - exact.zenith_deg).max())


if __name__ == "__main__":
    print("\n".join(run()))
