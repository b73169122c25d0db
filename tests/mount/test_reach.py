"""When the Sun is within a mount's limits."""

import numpy as np
import pytest

from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.mount.reach import axis_path, reach_of_day
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.day import day_events
from solarcal.timescale import parse_utc

TIJERAS = Site(35.05, -106.48, 1830.0)
ANYWHERE = AxisLimits(-180.0, 180.0)
POLAR_DISTANCES = AxisLimits(0.0, 180.0)


def reach(geometry: str, limits: Limits, date: str, site: Site = TIJERAS, lowest_deg: float = 0.0):
    transit_s = day_events(parse_utc(f"{date}T19:00Z"), site).transit_utc_s
    mount = MountGeometry(geometry, site.latitude_deg)
    return reach_of_day(site, mount, limits, transit_s, lowest_deg=lowest_deg)


def test_120_deg_of_swing_is_about_8_hours_in_summer() -> None:
    # About the pole the Sun turns by 15 deg an hour: 120 deg are 8 h of a day of 14.5 h.
    limits = Limits(AxisLimits(-60.0, 60.0), POLAR_DISTANCES)
    summer = reach("polar", limits, "2026-06-21")
    assert summer.hours == pytest.approx(8.0, abs=0.01)
    assert len(summer.spans_utc_s) == 1


def test_the_same_swing_on_other_mounts() -> None:
    # Tilt-roll axes do not stand along the pole: some more hours for the same swing.
    roll = Limits(ANYWHERE, AxisLimits(30.0, 150.0))
    tilt = Limits(AxisLimits(-60.0, 60.0), POLAR_DISTANCES)
    assert reach("tiltroll-ew", roll, "2026-06-21").hours == pytest.approx(9.43, abs=0.02)
    assert reach("tiltroll-ns", tilt, "2026-06-21").hours == pytest.approx(9.23, abs=0.02)
    # An azimuth axis turns fast under a high Sun.
    assert reach("azel", tilt, "2026-06-21").hours == pytest.approx(2.54, abs=0.02)


def test_edges_are_where_the_axis_meets_its_limit() -> None:
    limits = Limits(AxisLimits(-60.0, 45.0), POLAR_DISTANCES)
    ((first_s, last_s),) = reach("polar", limits, "2026-06-21").spans_utc_s
    mount = MountGeometry("polar", TIJERAS.latitude_deg)
    for at_s, limit_deg in ((first_s, 45.0), (last_s, -60.0)):
        sun = sun_position("precise", at_s, TIJERAS)
        ax1, _ = mount.axes_from_horizontal(sun.azimuth_deg, sun.zenith_deg)
        assert ax1 == pytest.approx(limit_deg, abs=5e-4)


def test_without_limits_it_is_the_time_above_the_elevation() -> None:
    everywhere = Limits(ANYWHERE, POLAR_DISTANCES)
    found = reach("azel", everywhere, "2026-12-21", lowest_deg=10.0)
    day = day_events(parse_utc("2026-12-21T19:00Z"), TIJERAS, altitude_deg=10.0)
    assert found.hours == pytest.approx(day.daylight_s / 3600.0, abs=1e-4)


def test_unless_told_otherwise_the_sun_counts_from_the_horizon_on() -> None:
    everywhere = Limits(ANYWHERE, POLAR_DISTANCES)
    transit_s = day_events(parse_utc("2026-12-21T19:00Z"), TIJERAS).transit_utc_s
    mount = MountGeometry("azel", TIJERAS.latitude_deg)
    found = reach_of_day(TIJERAS, mount, everywhere, transit_s)
    day = day_events(parse_utc("2026-12-21T19:00Z"), TIJERAS, altitude_deg=0.0)
    assert found.hours == pytest.approx(day.daylight_s / 3600.0, abs=1e-4)


def test_a_mount_that_cannot_reach_its_zenith_has_two_spans() -> None:
    overhead = Site(23.0, -106.5)
    limits = Limits(ANYWHERE, AxisLimits(20.0, 90.0))
    found = reach("azel", limits, "2026-06-21", overhead)
    assert len(found.spans_utc_s) == 2
    middle_s = 0.5 * (found.spans_utc_s[0][1] + found.spans_utc_s[1][0])
    assert sun_position("precise", middle_s, overhead).zenith_deg < 1.0


def test_never_within_limits_is_no_span_and_polar_day_is_all_of_it() -> None:
    narrow = Limits(ANYWHERE, AxisLimits(0.0, 5.0))
    assert reach("azel", narrow, "2026-12-21").spans_utc_s == ()
    assert reach("azel", narrow, "2026-12-21").hours == 0.0
    svalbard = Site(80.0, -106.0)
    everywhere = Limits(AxisLimits(-181.0, 181.0), POLAR_DISTANCES)
    assert reach("azel", everywhere, "2026-06-21", svalbard).hours == pytest.approx(24.0)


def test_a_tropical_azel_path_crosses_the_branch_in_june_only() -> None:
    kourou = Site(5.2, -52.7, 20.0)
    everywhere = Limits(ANYWHERE, POLAR_DISTANCES)
    assert reach("azel", everywhere, "2026-06-10", kourou).crosses_branch
    assert not reach("azel", everywhere, "2026-12-10", kourou).crosses_branch
    assert not reach("azel", everywhere, "2026-06-10").crosses_branch


def test_the_margin_is_the_nearest_of_limits_and_elevation() -> None:
    limits = Limits(AxisLimits(-60.0, 60.0), AxisLimits(2.0, 88.0))
    times = parse_utc("2026-06-21T12:00Z") + 600.0 * np.arange(40)
    mount = MountGeometry("azel", TIJERAS.latitude_deg)
    path = axis_path(TIJERAS, mount, limits, times, lowest_deg=10.0)
    by_hand = np.min(
        [
            path.ax1_deg + 60.0,
            60.0 - path.ax1_deg,
            path.ax2_deg - 2.0,
            88.0 - path.ax2_deg,
            path.elevation_deg - 10.0,
        ],
        axis=0,
    )
    assert path.margin_deg == pytest.approx(by_hand)
