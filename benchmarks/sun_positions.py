"""Sun positions at one site over one year: solarcal's precise and fast paths against pvlib's SPA.

The peer is pvlib's numpy implementation of NREL's SPA, through its public function. The fast
path's time includes preparing it for the year.
"""

import numpy as np
import pandas as pd
from pvlib.solarposition import spa_python

from benchmarks.timing import table, timed
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.units import FloatArray, wrap_deg

SITE = Site(35.05, -106.48, 1830.0, "Tijeras")
START_UTC_S = 1767225600.0  # 2026-01-01
YEAR_S = 365.0 * 86400.0
RUNS = {1_000: 7, 10_000: 7, 100_000: 3, 1_000_000: 1}
"""Positions, and how often they are computed."""
LIMIT_US, LIMIT_ARCSEC = 0.5, 0.5


def run() -> list[str]:
    """The table as lines of text."""
    rows = []
    for size in RUNS:
        times = _times(size)
        spa, precise, fast = timed(
            lambda times=times: _spa(times),  # type: ignore[misc]
            lambda times=times: _precise(times),  # type: ignore[misc]
            lambda times=times: _fast(times),  # type: ignore[misc]
            runs=RUNS[size],
        )
        rows.append(
            (
                f"{size}",
                *(timing.per(size, 1e-6) for timing in (spa, precise, fast)),
                f"{spa.least_s / precise.least_s:.2f}",
                f"{spa.least_s / fast.least_s:.1f}",
            )
        )
    return [
        "one site, one year, microseconds for each position: least (median)",
        *table(("positions", "SPA", "precise", "fast", "SPA/precise", "SPA/fast"), rows),
        f"fast against precise, worst: {_deviation_arcsec():.3f} arcsec (asked: {LIMIT_ARCSEC}); "
        f"asked of it at 1e5 and more: {LIMIT_US} microseconds",
    ]


def _times(size: int) -> FloatArray:
    return START_UTC_S + np.linspace(0.0, YEAR_S, size)


def _spa(utc_s: FloatArray) -> None:
    instants = pd.DatetimeIndex((utc_s * 1e9).astype("datetime64[ns]"), tz="UTC")
    spa_python(instants, SITE.latitude_deg, SITE.longitude_deg, SITE.elevation_m, how="numpy")


def _precise(utc_s: FloatArray) -> None:
    sun_position("precise", utc_s, SITE)


def _fast(utc_s: FloatArray) -> None:
    SiteEphemeris(SITE, float(utc_s[0]), float(utc_s[-1])).horizontal_deg(utc_s)


def _deviation_arcsec() -> float:
    utc_s = _times(20_011)
    exact = sun_position("precise", utc_s, SITE)
    azimuth, zenith = SiteEphemeris(SITE, START_UTC_S, START_UTC_S + YEAR_S).horizontal_deg(utc_s)
    across = wrap_deg(azimuth - exact.azimuth_deg) * np.sin(np.radians(exact.zenith_deg))
    return float(3600.0 * np.hypot(across, zenith - exact.zenith_deg).max())


if __name__ == "__main__":
    print("\n".join(run()))
