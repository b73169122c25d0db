"""From a session's points to a solution, the same way live, in replay and from files."""

import functools
from collections.abc import Callable
from typing import cast

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.earlier_sessions import weigh_inclinometer, weigh_last
from solarcal.model.finding import Finding
from solarcal.model.fit import FEWEST_POINTS
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import DEFAULT_METHOD, DEFAULT_PRIOR, fit, fit_exact
from solarcal.model.points import Points
from solarcal.model.prior import Prior
from solarcal.model.sky_context import Ideal, SkyContext
from solarcal.model.solution import Solution
from solarcal.model.terms import LEAN_PRIOR_DEG
from solarcal.mount.formula import Coefficients
from solarcal.mount.geometry import MountGeometry
from solarcal.session.points import NUMBERS, PointTable, table_of_points
from solarcal.session.records import Header, PointRecord
from solarcal.session.view import SessionView
from solarcal.site import Site
from solarcal.sun.position import sun_known


def prior_of(header: Header | None) -> Prior:
    """The prior of a session's fit without its unit's last coefficients: the usual one, its lean as
    read where the header has it.

    An inclinometer tells nothing of a base turned about the vertical: on mounts whose primary axis
    is not vertical that part of P1 or P3 keeps the usual width.
    """
    if header is None or header.inclinometer is None:
        return DEFAULT_PRIOR
    reading = header.inclinometer
    basis = MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg).basis()
    # A rotation w (east, north, up) moves the tower's top by w x up; P = -(w in native y, x).
    turned_deg = np.array([-reading.lean_north_deg, reading.lean_east_deg, 0.0])
    P3_deg, P1_deg = (-(basis @ turned_deg)[:2]).tolist()
    spread_deg = np.array([reading.sigma_deg, reading.sigma_deg, LEAN_PRIOR_DEG])
    P3_sigma_deg, P1_sigma_deg = np.hypot.reduce(basis[:2] * spread_deg, axis=1).tolist()
    known = DEFAULT_PRIOR.with_inclinometer(P1_deg, P3_deg, reading.sigma_deg)
    zero1, zero2, scale1, scale2 = (known.sigmas[i] for i in (1, 3, 4, 5))
    return msgspec.structs.replace(
        known, sigmas=(P1_sigma_deg, zero1, P3_sigma_deg, zero2, scale1, scale2)
    )


def chosen_prior(
    points: Points,
    context: SkyContext,
    header: Header | None,
    method: str,
    last: Coefficients | None = None,
    solve: Callable[[Prior], MechanismSolution] | None = None,
) -> tuple[Prior, tuple[Finding, ...]]:
    """The prior of a fit, and what the points say against an inclinometer's reading and the unit's
    last coefficients.

    ``last`` are those asked for; None: the header's. ``solve`` is the fit by a prior, of
    these points where None.
    """
    usual = prior_of(header)
    held = last or (None if header is None else header.last_coefficients)
    if method != DEFAULT_METHOD or (held is None and usual is DEFAULT_PRIOR):
        return usual, ()
    distinct = points.distinct()
    by_prior = solve or (lambda prior: fit_exact(distinct, context, prior=prior))
    against: tuple[Finding, ...] = ()
    if usual is not DEFAULT_PRIOR:
        usual, against = weigh_inclinometer(usual, by_prior)
    if held is None:
        return usual, against
    prior, more = weigh_last(held, context, usual, by_prior)
    return prior, (*against, *more)


def point_set(table: PointTable) -> Points:
    """The accepted points of a table, as the fitter takes them."""
    if table.latitude_deg is None:
        raise ConfigurationError("the points have no latitude; give it with --lat")
    geometry = MountGeometry(table.geometry, table.latitude_deg, table.ax1_centre_deg)
    used = table.accepted()
    return Points(
        geometry=geometry,
        ax1_deg=used.ax1_deg,
        ax2_deg=used.ax2_deg,
        err1_deg=used.err1_deg,
        err2_deg=used.err2_deg,
        labels=used.labels,
        utc_s=used.utc_s,
        **{name: getattr(used, name) for name in NUMBERS},
    )


def points_table(points: Points, site: Site, ideal: Ideal) -> PointTable:
    """Points of one's own as a table: accepted rows without a session; ``point_set`` backwards."""
    n = len(points)
    return PointTable(
        geometry=points.geometry.name,
        latitude_deg=site.latitude_deg,
        longitude_deg=site.longitude_deg,
        elevation_m=site.elevation_m,
        unit="",
        ax1_centre_deg=points.geometry.ax1_centre_deg,
        ideal=ideal,
        utc_s=np.full(n, np.nan) if points.utc_s is None else points.utc_s,
        ax1_deg=points.ax1_deg,
        ax2_deg=points.ax2_deg,
        err1_deg=points.err1_deg,
        err2_deg=points.err2_deg,
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=("",) * n,
        labels=points.labels,
        sources=("",) * n,
        **{name: getattr(points, name) for name in NUMBERS},
    )


def newest_point_utc_s(table: PointTable) -> float | None:
    """When the newest accepted point was taken; ``None`` where no time is known or the
    Sun models do not cover it and the year a plan looks ahead."""
    times = table.accepted().utc_s
    known = times[sun_known(times, year_ahead=True)]
    return float(known.max()) if known.size else None


def sky_context(
    table: PointTable, header: Header | None = None, points: Points | None = None
) -> SkyContext:
    """Where and under what sky the points were taken: what a fit may take as known physics.

    ``points`` are the table's accepted ones, where they are made already.
    """
    points = point_set(table) if points is None else points
    # An import's limits are placeholders.
    from_a_unit = header is not None and not header.unit.imported
    return SkyContext.for_points(
        points,
        site=table.site,
        limits=header.unit.limits if header is not None and from_a_unit else None,
        ideal=cast(Ideal, table.ideal),
        weather=None if header is None else header.weather,
        heliostat=table.heliostat,
    )


def solve_table(
    table: PointTable, method: str = DEFAULT_METHOD, header: Header | None = None
) -> Solution:
    """Fit the accepted points of a table; ``header`` is that of the session they come from."""
    points = point_set(table)
    context = sky_context(table, header, points)
    prior, _ = chosen_prior(points, context, header, method)
    return fit(points, context, method=method, prior=prior)


def solve(session: SessionView, method: str = DEFAULT_METHOD) -> Solution | None:
    """The fit of the session so far; ``None`` while there are too few points for ``method``."""
    accepted = session.accepted
    if len(accepted) < fewest_points(method):
        return None
    return _solved(session.header, accepted, method)


@functools.lru_cache(maxsize=8)
def _solved(header: Header, accepted: tuple[PointRecord, ...], method: str) -> Solution:
    """Remembered: the questions at a point, its counts and its record ask for the same fit."""
    return solve_table(table_of_points(header, accepted), method, header)


def last_doubts(session: SessionView, solution: Solution | None) -> tuple[str, ...]:
    """Sentences on an inclinometer's reading and last coefficients that a fit did not use."""
    header = session.header
    told = header.last_coefficients is not None or header.inclinometer is not None
    if not told or not isinstance(solution, MechanismSolution):
        return ()
    points = point_set(session.table)
    context = sky_context(session.table, header, points)
    _, found = chosen_prior(points, context, header, DEFAULT_METHOD)
    return tuple(finding.sentence for finding in found)


def fewest_points(method: str) -> int:
    """``linear`` needs three points; with a prior, one says something."""
    return 1 if method == "robust" else FEWEST_POINTS
