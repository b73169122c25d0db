"""What ``import solarcal`` offers: read points, fit, analyse, forecast, the Sun, in a few calls.

These names stay; everything else in the package may move. The program's own commands go through
the same functions, so a notebook and a terminal show the same numbers.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Unpack

from solarcal.errors import ConfigurationError
from solarcal.model.analysis import Analysis
from solarcal.model.analysis import analyse as analyse_points
from solarcal.model.evidence.direct import Evidence
from solarcal.model.forecast import Forecast
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.methods import fit as fit_points
from solarcal.model.points import Points
from solarcal.model.sky_context import Ideal, SkyContext
from solarcal.model.solution import Solution
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.session.interchange import FillIn
from solarcal.site import Site, Weather
from solarcal.station.analysing import UnitFiles, analyse_files, read_files
from solarcal.station.fitting import points_table
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule
from solarcal.sun import SunPosition, sun_position

__all__ = [
    "Analysis",
    "Forecast",
    "Mechanism",
    "MountGeometry",
    "Points",
    "Site",
    "Solution",
    "SunPosition",
    "Weather",
    "analyse",
    "fit",
    "forecast",
    "read",
    "sun_position",
]


def read(*paths: str | Path, **fill_in: Unpack[FillIn]) -> UnitFiles:
    """Read files of one unit: sessions, points CSV, or other programs' files.

    Parameters
    ----------
    paths
        One file or more; their points are fitted together.
    **fill_in
        What a points CSV leaves out: ``geometry``, ``latitude_deg``,
        ``longitude_deg``, ``elevation_m``, ``unit``.

    Raises
    ------
    InputFileError, ConfigurationError
        A file that cannot be read, or files of different units.
    """
    return read_files(paths, fill_in)


def fit(
    source: UnitFiles | Points,
    *,
    method: str = DEFAULT_METHOD,
    terms: Sequence[str] = COEFFICIENT_NAMES,
) -> Solution:
    """Fit the coefficients P1..P6.

    Parameters
    ----------
    source
        What :func:`read` returned, or points of your own.
    method
        ``robust`` (default), ``linear`` or ``exact``.
    terms
        For ``linear`` only: which of the six.

    Returns
    -------
    Solution
        ``coefficients()`` in degrees and degrees per degree, sigmas, residuals, ``as_json()``.

    Raises
    ------
    FitError
        Points that allow no fit.
    """
    if isinstance(source, Points):
        return fit_points(source, method=method, terms=terms)
    chosen = None if tuple(terms) == COEFFICIENT_NAMES else terms
    return analyse_files(source, method=method, terms=chosen).solution


def analyse(
    source: UnitFiles | Points,
    *,
    method: str = DEFAULT_METHOD,
    tolerance_deg: float | None = None,
    site: Site | None = None,
    ideal: Ideal = "apparent",
) -> Analysis:
    """Fit, forecast the year, weigh the evidence, and judge.

    Parameters
    ----------
    source
        What :func:`read` returned, or points of your own.
    method
        As for :func:`fit`.
    tolerance_deg
        What 95 % of the year's pointing shall be within; default that of the session, else 0.1
        deg.
    site
        Of points of your own: where the tracker is. Where they have ``utc_s``, their ideal angles
        are compared with the Sun, as those of files are.
    ideal
        Of points of your own: ``apparent``, ``airless`` or ``solartrak`` ideal angles.

    Raises
    ------
    ConfigurationError, FitError
        Points of your own without a site; points that allow no fit.
    """
    if isinstance(source, Points):
        if site is None:
            raise ConfigurationError("points of your own need a site: site=Site(LAT, LON)")
        context = SkyContext.for_points(source, site, ideal=ideal)
        evidence = Evidence(points_table(source, site, ideal))
        rule = DEFAULT_RULE if tolerance_deg is None else StoppingRule(tolerance_deg)
        return analyse_points(source, context, evidence, method=method, rule=rule)
    return analyse_files(source, method=method, tolerance_deg=tolerance_deg).of_the_controller()


def forecast(
    source: UnitFiles | Points,
    *,
    method: str = DEFAULT_METHOD,
    tolerance_deg: float | None = None,
    site: Site | None = None,
    ideal: Ideal = "apparent",
) -> Forecast:
    """Forecast the pointing error over the year; parameters as for :func:`analyse`."""
    return analyse(
        source, method=method, tolerance_deg=tolerance_deg, site=site, ideal=ideal
    ).forecast
