"""The numbers behind the plots: solar time, days, limits, model dots, residuals."""

from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import GEOMETRIES, AxisLimits, Limits, MountGeometry
from solarcal.session.points import PointTable, table_of_points
from solarcal.site import Site
from solarcal.station.curves import (
    error_plot_data,
    session_plot_data,
    table_plot_data,
)
from solarcal.station.sun_path import SunModel, day_grid, solar_time_from_direction_h
from solarcal.sun import sun_position
from solarcal.timescale import parse_utc
from tests.report.made_up_session import fit_points, header_of, hourly, points_at

WIDE = Limits(AxisLimits(-1000.0, 1000.0), AxisLimits(-1000.0, 1000.0))


@pytest.fixture
def june_day():
    """Header and twelve points from 07 h to 18 h solar time."""
    header = header_of()
    return header, points_at(header, hourly("2026-06-21", 14, 25))


def test_points_stand_at_their_apparent_solar_time(june_day):
    header, points = june_day
    data = session_plot_data(header, points, fit_points(header, points))
    assert data.points.labels == tuple(p.seq for p in points)
    assert np.all(np.diff(data.points.solar_time_h) > 0.99)
    # The azimuth from south, positive east, changes sign at apparent noon.
    before_noon = data.points.solar_time_h < 12.0
    assert np.array_equal(before_noon, data.points.ax1_deg > 0.0)
    # 106.48 deg west and the equation of time of 21 June (-1.8 min): 14:00 UTC is 06:52.
    assert data.points.solar_time_h[0] == pytest.approx(14.0 - 106.48 / 15.0 - 1.8 / 60.0, abs=0.01)


def test_the_model_has_a_dot_every_ten_minutes_where_the_solution_says(june_day):
    header, points = june_day
    solution = fit_points(header, points)
    model = session_plot_data(header, points, solution).model
    assert np.allclose(model.solar_time_h * 6.0, np.rint(model.solar_time_h * 6.0))
    assert np.all(np.diff(model.solar_time_h) == pytest.approx(1.0 / 6.0))
    e1, e2 = solution.predict_deg(model.ax1_deg, model.ax2_deg)
    assert np.array_equal(model.err1_deg, e1)
    assert np.array_equal(model.err2_deg, e2)
    assert np.all(model.sigma1_deg > 0.0)
    noon = np.argmin(np.abs(model.solar_time_h - 12.0))
    assert model.ax1_deg[noon] == pytest.approx(0.0, abs=1e-3)


def test_the_day_grid_is_on_whole_ten_minutes_of_apparent_solar_time():
    site, sun = Site(-33.9, 18.4), SunModel("solartrak")
    utc_s, hours = day_grid(20400.0, site, sun)
    off_h = (sun.solar_time_h(utc_s, site) - hours + 12.0) % 24.0 - 12.0
    assert len(hours) == 144
    assert np.abs(off_h).max() * 3600.0 < 0.4


def test_residuals_are_those_of_the_fit_and_go_on_the_sky(june_day):
    header, points = june_day
    solution = fit_points(header, points)
    shown = session_plot_data(header, points, solution).points
    assert shown.residual1_deg == pytest.approx(solution.residual1_deg, abs=1e-12)
    assert np.hypot(shown.cross_deg, shown.along_deg) == pytest.approx(solution.sky_deg, abs=1e-12)


def test_dots_stop_where_the_limits_shut_the_sun_out(june_day):
    header, points = june_day
    solution = fit_points(header, points)
    data = session_plot_data(header, points, solution)
    (morning_start, morning_end), (evening_start, evening_end) = data.outside_h
    assert morning_start < morning_end < evening_start < evening_end
    assert data.model.solar_time_h.min() > morning_end
    assert data.model.solar_time_h.max() < evening_start
    # Read-outs, not ideal angles, are limited: the fitted correction is part of the comparison.
    reading1 = data.model.ax1_deg + data.model.err1_deg
    assert np.all(np.abs(reading1) <= 110.0)
    free = session_plot_data(
        msgspec.structs.replace(header, unit=msgspec.structs.replace(header.unit, limits=WIDE)),
        points,
        solution,
    )
    assert free.outside_h == ()
    assert len(free.model.solar_time_h) == len(free.path.solar_time_h)


def test_two_days_fold_onto_one_another_and_keep_their_number():
    header = header_of()
    june = points_at(header, hourly("2026-06-21", 15, 23))
    december = points_at(header, hourly("2026-12-21", 16, 22), first_seq=100)
    data = session_plot_data(header, june + december, fit_points(header, june + december))
    assert data.days == 2
    assert data.points.day == (1,) * 9 + (2,) * 7
    assert set(data.model.day) == {1, 2}
    assert data.points.solar_time_h.max() < 18.0


def test_the_curve_of_each_day_is_of_the_session_that_its_points_are_from():
    header = header_of()
    points = points_at(header, hourly("2026-06-21", 15, 23))
    points += points_at(header, hourly("2026-12-21", 16, 22), first_seq=100)
    table = replace(table_of_points(header, points), sources=("june",) * 9 + ("december",) * 7)

    def errors_of(sources, ax1_deg, ax2_deg):
        return np.array([1.0 + (source == "december") for source in sources]), 0.0 * ax2_deg

    solution = SimpleNamespace(message=None, covariance=None, predict_of_deg=errors_of)
    geometry = MountGeometry(header.geometry, header.site.latitude_deg)
    model = error_plot_data(geometry, header.site, table, solution).model
    assert set(model.day) == {1, 2}
    assert tuple(model.err1_deg) == model.day


@pytest.mark.parametrize("longitude_deg", [179.9, -179.9, 180.1])
def test_a_day_at_the_date_line_is_one_day(longitude_deg):
    site = Site(-17.0, longitude_deg)
    header = header_of(site=site, geometry="tiltroll-ns", limits=WIDE)
    # Daylight there runs across midnight UTC.
    points = points_at(header, hourly("2026-11-20", 19, 29))
    data = session_plot_data(header, points)
    assert data.days == 1
    assert set(data.points.day) == {1}
    assert data.points.solar_time_h[0] == pytest.approx(7.2, abs=0.2)
    assert np.all(np.diff(data.points.solar_time_h) > 0.0)


def test_in_the_polar_day_the_path_goes_round():
    header = header_of(site=Site(80.0, 20.0), limits=WIDE)
    points = points_at(header, hourly("2026-06-21", 0, 21))
    data = session_plot_data(header, points, fit_points(header, points))
    assert data.days == 1
    assert len(data.path.solar_time_h) == 144
    assert np.all(data.path.elevation_deg > 10.0)


def test_in_the_polar_night_there_is_no_path():
    header = header_of(site=Site(80.0, 20.0), utc="2026-12-21T10:00:00.000Z")
    data = session_plot_data(header, [])
    assert len(data.path.solar_time_h) == 0
    assert data.outside_h == ()


def test_without_points_the_day_of_the_header_is_shown():
    data = session_plot_data(header_of(), [])
    assert data.days == 1
    assert len(data.path.solar_time_h) == pytest.approx(6 * 14.5, abs=3)
    assert len(data.model.solar_time_h) == 0
    assert not data.has_model


def test_rejected_points_are_shown_as_not_used_and_aborted_ones_are_not_shown(june_day):
    header, points = june_day
    rejected = points_at(header, ["2026-06-21T18:30:00Z"], first_seq=80, status="rejected")
    aborted = [
        msgspec.structs.replace(
            rejected[0], seq=90, status="aborted", ideal_deg=None, error_deg=None
        )
    ]
    shown = session_plot_data(header, points + rejected + aborted).points
    assert shown.labels[-1] == 80
    assert shown.used == (True,) * 12 + (False,)


@pytest.mark.parametrize("latitude_deg", [-70.0, -33.9, 0.0, 35.0, 66.0])
def test_a_direction_to_the_sun_tells_the_solar_time(latitude_deg):
    site = Site(latitude_deg, 10.0)
    utc_s = parse_utc("2026-03-05T00:00:00Z") + np.arange(0.0, 86400.0, 1801.0)
    sun = sun_position("solartrak", utc_s, site)
    found = solar_time_from_direction_h(sun.azimuth_deg, sun.elevation_deg, latitude_deg)
    assert (found - sun.solar_time_h + 12.0) % 24.0 - 12.0 == pytest.approx(0.0, abs=1e-6)


def test_points_without_time_keep_their_place_and_the_model_is_shown_at_them(june_day):
    header, points = june_day
    solution = fit_points(header, points)
    timed = session_plot_data(header, points, solution)
    geometry = MountGeometry(header.geometry, header.site.latitude_deg)
    columns = replace(table_of_points(header, points), utc_s=np.full(12, np.nan))
    for site in (header.site, None):
        untimed = error_plot_data(geometry, site, columns, solution)
        assert untimed.points.solar_time_h == pytest.approx(timed.points.solar_time_h, abs=1e-4)
        assert untimed.points.day == (0,) * 12
        assert untimed.model.err1_deg + untimed.points.residual1_deg == pytest.approx(
            timed.points.err1_deg
        )
        assert len(untimed.path.solar_time_h) == 0


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("latitude_deg", [-33.9, 35.0])
def test_every_mount_in_both_hemispheres(geometry, latitude_deg):
    centre = 180.0 if geometry == "azel" and latitude_deg < 0.0 else 0.0
    header = header_of(
        site=Site(latitude_deg, 20.0), geometry=geometry, centre_deg=centre, limits=WIDE
    )
    points = points_at(header, hourly("2026-05-10", 6, 15))
    data = session_plot_data(header, points, fit_points(header, points))
    assert np.all(np.isfinite(data.model.err1_deg))
    close = np.interp(data.points.solar_time_h, data.model.solar_time_h, data.model.err2_deg)
    assert close == pytest.approx(data.points.err2_deg, abs=0.1)


def test_a_table_without_latitude_is_refused():
    empty = np.empty(0)
    table = PointTable(
        geometry="azel",
        latitude_deg=None,
        longitude_deg=None,
        elevation_m=0.0,
        unit="",
        ax1_centre_deg=0.0,
        ideal="apparent",
        utc_s=empty,
        ax1_deg=empty,
        ax2_deg=empty,
        err1_deg=empty,
        err2_deg=empty,
        sigma_deg=None,
        status=(),
        approach=(),
        note=(),
        labels=(),
        sources=(),
    )
    with pytest.raises(ConfigurationError, match="--lat"):
        table_plot_data(table)
    known = table_plot_data(replace(table, latitude_deg=35.0, longitude_deg=-106.0))
    assert known.points.labels == ()
