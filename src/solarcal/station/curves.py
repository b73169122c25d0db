"""The numbers behind the error plot: errors, and the model, against apparent solar time.

Nothing here draws. Solar time folds the days of a session onto one another; every array keeps a day
number (1 for the first day with a point) so that a plot can tell them apart. A 'day' runs from one
solar midnight to the next, which is the only day a site near the date line agrees with.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from solarcal.errors import ConfigurationError
from solarcal.model.solution import Solution
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import Limits, MountGeometry
from solarcal.optics.offset_mirror import Heliostat
from solarcal.session.points import PointTable, table_of_points
from solarcal.session.records import CheckRecord, Header, PointRecord, UploadRecord
from solarcal.session.view import SessionView
from solarcal.site import Site
from solarcal.station.sun_path import (
    STEP_H,
    STEPS_PER_DAY,
    SunModel,
    day_grid,
    solar_day,
    solar_time_from_direction_h,
)
from solarcal.station.uploading import held
from solarcal.sun.position import sun_known
from solarcal.timescale import parse_utc
from solarcal.units import RAD_PER_DEG, FloatArray


@dataclass(frozen=True, slots=True)
class PlottedPoints:
    """Points with a known error, arrays of shape (n,).

    ``day`` is 0 where no time is known. Residuals are error minus model, axis degrees, NaN without
    a model; ``azimuth_deg`` (from north through east) and ``elevation_deg`` are those of the ideal
    direction.
    """

    labels: tuple[int, ...]
    used: tuple[bool, ...]
    day: tuple[int, ...]
    solar_time_h: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    residual1_deg: FloatArray
    residual2_deg: FloatArray
    azimuth_deg: FloatArray
    elevation_deg: FloatArray

    @property
    def cross_deg(self) -> FloatArray:
        """Residual of axis 1 on the sky, (n,)."""
        return self.residual1_deg * np.sin(self.ax2_deg * RAD_PER_DEG)

    @property
    def along_deg(self) -> FloatArray:
        """Residual of axis 2 on the sky, (n,)."""
        return self.residual2_deg


@dataclass(frozen=True, slots=True)
class ModelDots:
    """What the solution says every ten minutes within limits; (m,) arrays, axis degrees.

    ``sigma1_deg`` and ``sigma2_deg`` are NaN where the solution knows no sigmas.
    """

    day: tuple[int, ...]
    solar_time_h: FloatArray
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    err1_deg: FloatArray
    err2_deg: FloatArray
    sigma1_deg: FloatArray
    sigma2_deg: FloatArray


@dataclass(frozen=True, slots=True)
class SunPath:
    """The Sun above the horizon every ten minutes of the days plotted; arrays of shape (k,)."""

    day: tuple[int, ...]
    solar_time_h: FloatArray
    azimuth_deg: FloatArray
    elevation_deg: FloatArray
    within_limits: tuple[bool, ...]


@dataclass(frozen=True, slots=True)
class ErrorPlotData:
    """All a plot of errors, residuals or the sky needs. ``outside_h``: intervals of solar time in
    which the Sun is up and beyond the limits on every day plotted."""

    points: PlottedPoints
    model: ModelDots
    path: SunPath
    outside_h: tuple[tuple[float, float], ...]
    days: int
    has_model: bool
    latitude_deg: float
    tolerance_deg: float


def _runs_h(outside: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Runs of true cells of the ten-minute grid as intervals of solar time."""
    padded = np.concatenate(([0], outside.astype(int), [0]))
    starts, ends = np.flatnonzero(np.diff(padded) == 1), np.flatnonzero(np.diff(padded) == -1)
    return tuple(
        (max(0.0, (first - 0.5) * STEP_H), min(24.0, (last - 0.5) * STEP_H))
        for first, last in zip(starts.tolist(), ends.tolist(), strict=True)
    )


def error_plot_data(
    geometry: MountGeometry,
    site: Site | None,
    points: PointTable,
    solution: Solution | None = None,
    *,
    limits: Limits | None = None,
    sun: SunModel | None = None,
    empty_day_utc_s: float | None = None,
    tolerance_deg: float = 0.1,
    heliostat: Heliostat | None = None,
) -> ErrorPlotData:
    """Errors and model against solar time.

    Parameters
    ----------
    site : without one (a file that does not say) solar time follows from the angles.
    points : what was measured, all with their errors; may be empty.
    solution : without one there are no model dots and no residuals.
    limits : of the read-outs; the model's correction is added to the ideal angles before comparing.
    empty_day_utc_s : the day to show while there is no point.
    heliostat : where the axes turn a mirror's normal; the Sun's path and places stay the Sun's.
    """
    sun = sun or SunModel()
    n = len(points.labels)
    azimuth, zenith = geometry.horizontal_from_axes(points.ax1_deg, points.ax2_deg)
    if heliostat is not None:
        azimuth, zenith = heliostat.sun_deg(azimuth, zenith)
    hours = solar_time_from_direction_h(azimuth, 90.0 - zenith, geometry.latitude_deg)
    day_of_point, days = np.full(n, np.nan), np.empty(0)
    if site is not None:
        taken_utc_s = points.utc_s if points.stamp_utc_s is None else points.stamp_utc_s
        timed = sun_known(taken_utc_s)
        utc_s = taken_utc_s[timed]
        hours[timed] = sun.solar_time_h(utc_s, site)
        day_of_point[timed] = solar_day(utc_s, hours[timed], site)
        days = np.unique(day_of_point[timed])
        if not n and empty_day_utc_s is not None:
            instant = np.array([empty_day_utc_s])
            days = solar_day(instant, sun.solar_time_h(instant, site), site)
    numbers = {day: number for number, day in enumerate(days.tolist(), start=1)}
    residual1, residual2 = np.full(n, np.nan), np.full(n, np.nan)
    if solution is not None:
        e1, e2 = solution.predict_of_deg(points.sources, points.ax1_deg, points.ax2_deg)
        residual1, residual2 = points.err1_deg - e1, points.err2_deg - e2
    if site is not None and days.size:
        grids = [day_grid(day, site, sun) for day in days.tolist()]
        # Of a day, what the session held that its first point is from.
        of_day = dict(zip(day_of_point.tolist()[::-1], points.sources[::-1], strict=True))
        sources = [of_day.get(day, "") for day in days.tolist()]
        model, path, outside_h = _curves(
            grids, sources, geometry, site, solution, limits, sun, heliostat
        )
    else:
        # Without a single time the Sun's path is unknown: show the model where the points are.
        model = _dots(solution, (0,) * n, points.sources, hours, points.ax1_deg, points.ax2_deg)
        nothing = np.empty(0)
        path, outside_h = SunPath((), nothing, nothing, nothing, ()), ()
    return ErrorPlotData(
        points=PlottedPoints(
            labels=points.labels,
            used=tuple(status == "accepted" for status in points.status),
            day=tuple(numbers.get(day, 0) for day in day_of_point.tolist()),
            solar_time_h=hours,
            ax1_deg=points.ax1_deg,
            ax2_deg=points.ax2_deg,
            err1_deg=points.err1_deg,
            err2_deg=points.err2_deg,
            residual1_deg=residual1,
            residual2_deg=residual2,
            azimuth_deg=azimuth,
            elevation_deg=90.0 - zenith,
        ),
        model=model,
        path=path,
        outside_h=outside_h,
        days=len(days),
        has_model=solution is not None,
        latitude_deg=geometry.latitude_deg,
        tolerance_deg=tolerance_deg,
    )


def _dots(
    solution: Solution | None,
    day: tuple[int, ...],
    sources: Sequence[str],
    hours: FloatArray,
    ax1_deg: FloatArray,
    ax2_deg: FloatArray,
) -> ModelDots:
    if solution is None:
        nothing = np.empty(0)
        return ModelDots((), *(nothing,) * 7)
    e1, e2 = solution.predict_of_deg(sources, ax1_deg, ax2_deg)
    s1, s2 = np.full(len(hours), np.nan), np.full(len(hours), np.nan)
    if solution.covariance is not None:
        s1, s2 = solution.predict_sigma_deg(ax1_deg, ax2_deg)
    return ModelDots(day, hours, ax1_deg, ax2_deg, e1, e2, s1, s2)


def _curves(
    grids: list[tuple[FloatArray, FloatArray]],
    sources: Sequence[str],
    geometry: MountGeometry,
    site: Site,
    solution: Solution | None,
    limits: Limits | None,
    sun: SunModel,
    heliostat: Heliostat | None,
) -> tuple[ModelDots, SunPath, tuple[tuple[float, float], ...]]:
    """Ten-minute dots of all days, the Sun's path, and what the limits shut out.

    ``sources``: the session of each day.
    """
    utc_s = np.concatenate([grid[0] for grid in grids])
    hours = np.concatenate([grid[1] for grid in grids])
    number = np.repeat(np.arange(1, len(grids) + 1), STEPS_PER_DAY)
    place = sun.position(utc_s, site)
    up = place.zenith_deg < 90.0
    aim = (place.azimuth_deg, place.zenith_deg)
    if heliostat is not None:
        aim = heliostat.controller_normal_deg(*aim)
    ax1, ax2 = geometry.axes_from_horizontal(*aim)
    within = np.ones(len(hours), dtype=bool)
    if limits is not None:
        e1, e2 = np.zeros(len(hours)), np.zeros(len(hours))
        # What the controller would not be given must not decide what it can reach.
        if solution is not None and solution.message is None:
            e1, e2 = solution.predict_deg(ax1, ax2)
        within = np.asarray(limits.distance_deg(ax1 + e1, ax2 + e2)) >= 0.0
    shown = up & within
    by_day = (len(grids), STEPS_PER_DAY)
    outside = np.any(up.reshape(by_day), axis=0) & ~np.any(shown.reshape(by_day), axis=0)
    path = SunPath(
        day=tuple(number[up].tolist()),
        solar_time_h=hours[up],
        azimuth_deg=place.azimuth_deg[up],
        elevation_deg=place.elevation_deg[up],
        within_limits=tuple(within[up].tolist()),
    )
    of = [sources[day - 1] for day in number[shown].tolist()]
    model = _dots(solution, tuple(number[shown].tolist()), of, hours[shown], ax1[shown], ax2[shown])
    return model, path, _runs_h(outside)


def before_and_after(
    session: SessionView, solution: Solution, upload: UploadRecord
) -> tuple[ErrorPlotData, ErrorPlotData]:
    """The errors as found, and what is left of them after an upload.

    Before: the points less what the unit corrected when the session began. After: the check points,
    which measure what is left, and what the solution expects there.
    """
    header = session.header
    found = held(header.coefficients, header.offsets)
    measured = session_plot_data(header, session.accepted, solution)
    points = measured.points
    c1, c2 = correction_deg(found, points.ax1_deg, points.ax2_deg)
    before = replace(
        measured,
        points=replace(points, err1_deg=points.err1_deg - c1, err2_deg=points.err2_deg - c2),
        model=_left(measured.model, found),
    )
    left = session_plot_data(header, session.checks_after(upload), solution)
    given = held(upload.new_coefficients, upload.new_offsets)
    return before, replace(left, model=_left(left.model, given))


def _left(model: ModelDots, given: Coefficients) -> ModelDots:
    """What the solution expects to be left of its errors with these numbers in the unit."""
    c1, c2 = correction_deg(given, model.ax1_deg, model.ax2_deg)
    return replace(model, err1_deg=model.err1_deg - c1, err2_deg=model.err2_deg - c2)


def session_plot_data(
    header: Header, points: Sequence[PointRecord | CheckRecord], solution: Solution | None = None
) -> ErrorPlotData:
    """For a session: its live points (voided ones left out by the caller) and a solution.

    Accepted points count as used; rejected ones with an error are shown as not used; attempts
    without an error are not shown.
    """
    known = [p for p in points if p.error_deg is not None and p.ideal_deg is not None]
    return error_plot_data(
        MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg),
        header.site,
        table_of_points(header, known),
        solution,
        limits=header.unit.limits,
        sun=SunModel.of_session(header),
        empty_day_utc_s=parse_utc(header.utc),
        tolerance_deg=header.tolerance_deg,
        heliostat=header.unit.heliostat,
    )


def table_plot_data(
    table: PointTable, solution: Solution | None = None, limits: Limits | None = None
) -> ErrorPlotData:
    """For a points table (CSV, TPOINT, merged sessions); rows without an error are not shown.

    Refused (ConfigurationError) without a latitude.
    """
    if table.latitude_deg is None:
        raise ConfigurationError("the points have no latitude; give it with --lat")
    known = table.rows(np.flatnonzero(np.isfinite(table.err1_deg + table.err2_deg)))
    return error_plot_data(
        MountGeometry(table.geometry, table.latitude_deg, table.ax1_centre_deg),
        table.site,
        known,
        solution,
        limits=limits,
        sun=SunModel("solartrak" if table.ideal == "solartrak" else "precise"),
        heliostat=table.heliostat,
    )
