"""Native frames: what the axes of each mount read, and on which branch."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solarcal.errors import ConfigurationError
from solarcal.mount.geometry import (
    GEOMETRIES,
    MountGeometry,
    crosses_branch,
    default_ax1_centre,
    maths_for,
    unit_vector,
)

EAST, NORTH, SOUTH, UP = (90.0, 90.0), (0.0, 90.0), (180.0, 90.0), (0.0, 0.0)

azimuths = st.floats(0.0, 359.999)
latitudes = st.floats(-66.0, 66.0)
names = st.sampled_from(GEOMETRIES)


def native_of(ax1_deg, ax2_deg):
    """The direction of axis angles in native components."""
    return unit_vector(maths_for(ax1_deg, ax2_deg), np.radians(ax1_deg), np.radians(ax2_deg))


@pytest.mark.parametrize(
    ("name", "direction", "ax1", "ax2"),
    [
        # azel: azimuth from South, positive East; zenith angle.
        ("azel", SOUTH, 0.0, 90.0),
        ("azel", EAST, 90.0, 90.0),
        ("azel", (270.0, 30.0), -90.0, 30.0),
        # tiltroll-ew: tilt 0 straight up, positive South; roll 0 at due East, 90 in the meridian.
        ("tiltroll-ew", UP, 0.0, 90.0),
        ("tiltroll-ew", SOUTH, 90.0, 90.0),
        ("tiltroll-ew", (180.0, 40.0), 40.0, 90.0),
        ("tiltroll-ew", (90.0, 60.0), 0.0, 30.0),
        # tiltroll-ns: 0 straight up, positive East; angle from North.
        ("tiltroll-ns", UP, 0.0, 90.0),
        ("tiltroll-ns", EAST, 90.0, 90.0),
        ("tiltroll-ns", (0.0, 60.0), 0.0, 30.0),
        # polar at latitude 35: the pole stands 35 deg high, the equator culminates at zenith 35.
        ("polar", (180.0, 35.0), 0.0, 90.0),
        ("polar", EAST, 90.0, 90.0),
        ("polar", UP, 0.0, 55.0),
    ],
)
def test_cardinal_directions_read_as_the_frames_table_says(name, direction, ax1, ax2):
    got = MountGeometry(name, 35.0).axes_from_horizontal(*direction)
    assert got == pytest.approx((ax1, ax2), abs=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_every_native_frame_is_right_handed(name):
    x, y, z = MountGeometry(name, 28.3).basis()
    np.testing.assert_allclose(np.cross(x, y), z, atol=1e-15)
    np.testing.assert_allclose([x @ x, y @ y, x @ y], [1.0, 1.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("latitude_deg", [-34.0, 0.0, 51.0])
def test_polar_axis_points_at_the_north_celestial_pole_in_both_hemispheres(latitude_deg):
    east, north, up = MountGeometry("polar", latitude_deg).basis()[2]
    assert east == 0.0
    assert np.degrees(np.arctan2(up, north)) == pytest.approx(latitude_deg)


@given(name=names, latitude=latitudes, azimuth=azimuths, zenith=st.floats(0.01, 179.99))
@settings(derandomize=True, deadline=None)
def test_horizontal_angles_come_back(name, latitude, azimuth, zenith):
    mount = MountGeometry(name, latitude)
    back_azimuth, back_zenith = mount.horizontal_from_axes(
        *mount.axes_from_horizontal(azimuth, zenith)
    )
    assert 0.0 <= back_azimuth < 360.0
    turn = (back_azimuth - azimuth + 180.0) % 360.0 - 180.0
    assert abs(turn) * np.sin(np.radians(zenith)) < 1e-11
    assert back_zenith == pytest.approx(zenith, abs=1e-11)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_arrays_give_what_single_angles_give(name):
    mount = MountGeometry(name, -12.0, 90.0)
    azimuth, zenith = np.meshgrid(np.linspace(3.0, 357.0, 12), np.linspace(5.0, 85.0, 7))
    ax1, ax2 = mount.axes_from_horizontal(azimuth, zenith)
    back = mount.horizontal_from_axes(ax1, ax2)
    native = native_of(ax1, ax2)
    for at in np.ndindex(azimuth.shape):
        single = mount.axes_from_horizontal(float(azimuth[at]), float(zenith[at]))
        assert all(type(angle) is float for angle in single)
        assert single == pytest.approx((ax1[at], ax2[at]), abs=1e-12)
        assert mount.horizontal_from_axes(*single) == pytest.approx(
            (back[0][at], back[1][at]), abs=1e-12
        )
        np.testing.assert_allclose(native_of(*single), [x[at] for x in native], atol=1e-15)


def test_a_scalar_axis_broadcasts_against_an_array():
    mount = MountGeometry("azel", 40.0)
    azimuth, zenith = mount.horizontal_from_axes(np.array([-30.0, 0.0, 30.0]), 50.0)
    np.testing.assert_allclose(azimuth, [210.0, 180.0, 150.0], atol=1e-12)
    np.testing.assert_allclose(zenith, 50.0, atol=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_up_in_native_components_is_the_zenith(name):
    mount = MountGeometry(name, 41.0)
    zenith = native_of(*mount.axes_from_horizontal(0.0, 0.0))
    assert zenith == pytest.approx(mount.up_components(), abs=1e-12)


@pytest.mark.parametrize(
    ("centre", "ax1", "on_branch"),
    [
        (0.0, 180.0, 180.0),
        (0.0, -180.0, 180.0),
        (0.0, 181.0, -179.0),
        (180.0, -10.0, 350.0),
        (180.0, 0.0, 360.0),
        (180.0, 359.0, 359.0),
        (-90.0, 100.0, -260.0),
    ],
)
def test_branch_is_open_below_and_closed_above(centre, ax1, on_branch):
    mount = MountGeometry("azel", 0.0, centre)
    assert mount.branch(ax1) == on_branch
    np.testing.assert_array_equal(mount.branch(np.array([ax1, ax1])), [on_branch, on_branch])


def test_southern_azel_day_is_continuous_on_branch_180():
    # Sydney-like afternoon: the Sun goes from east through NORTH to west.
    azimuth = np.array([80.0, 40.0, 5.0, 355.0, 320.0, 280.0])
    ax1, _ = MountGeometry("azel", -33.9, 180.0).axes_from_horizontal(azimuth, 50.0)
    np.testing.assert_allclose(ax1, [100.0, 140.0, 175.0, 185.0, 220.0, 260.0], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "latitude_deg", "centre"),
    [
        ("azel", 35.0, 0.0),
        ("azel", 0.0, 0.0),
        ("azel", -33.9, 180.0),
        ("polar", -33.9, 0.0),
        ("tiltroll-ns", -33.9, 0.0),
        ("tiltroll-ew", -33.9, 0.0),
    ],
)
def test_default_branch_keeps_the_day_in_one_piece(name, latitude_deg, centre):
    assert default_ax1_centre(name, latitude_deg) == centre
    assert MountGeometry(name, latitude_deg) == MountGeometry(name, latitude_deg, centre)


def day_path(mount, declination_deg):
    """The Sun's AX1 above 10 deg through one day, every minute; below it NaN."""
    hour_angle = np.radians(np.arange(-180.0, 180.0, 0.25))
    latitude, declination = np.radians(mount.latitude_deg), np.radians(declination_deg)
    east = -np.cos(declination) * np.sin(hour_angle)
    north = np.cos(latitude) * np.sin(declination) - np.sin(latitude) * np.cos(
        declination
    ) * np.cos(hour_angle)
    up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(
        hour_angle
    )
    ax1, _ = mount.axes_from_horizontal(
        np.degrees(np.arctan2(east, north)), np.degrees(np.arccos(up))
    )
    return np.where(up > np.sin(np.radians(10.0)), ax1, np.nan)


@pytest.mark.parametrize(
    ("name", "latitude_deg", "declination_deg", "crosses"),
    [
        ("azel", 35.0, 23.4, False),
        ("azel", 35.0, -23.4, False),
        ("azel", -33.9, 23.4, False),
        ("azel", -33.9, -23.4, False),
        # In the tropics the Sun culminates now north, now south of the zenith.
        ("azel", 10.0, 23.4, True),
        ("azel", 10.0, -23.4, False),
        ("azel", -10.0, -23.4, True),
        ("azel", -10.0, 23.4, False),
        ("polar", 10.0, 23.4, False),
        ("tiltroll-ns", 10.0, 23.4, False),
        ("tiltroll-ew", 10.0, 23.4, False),
    ],
)
def test_a_tropical_azel_day_crosses_its_branch(name, latitude_deg, declination_deg, crosses):
    mount = MountGeometry(name, latitude_deg)
    path = day_path(mount, declination_deg)
    assert np.isfinite(path).sum() > 100
    assert crosses_branch(path, mount.ax1_centre_deg) is crosses


def test_a_night_between_two_days_is_not_a_crossing():
    evening_and_morning = np.array([-90.0, -100.0, np.nan, 100.0, 90.0])
    assert not crosses_branch(evening_and_morning)
    assert crosses_branch(np.delete(evening_and_morning, 2))


def test_a_path_is_judged_on_the_branch_it_is_asked_about():
    through_north = np.array([170.0, 178.0, -174.0, -166.0])
    assert crosses_branch(through_north, 0.0)
    assert not crosses_branch(through_north, 180.0)


@given(
    name=names,
    first=st.tuples(st.floats(-180.0, 180.0), st.floats(0.0, 180.0)),
    second=st.tuples(st.floats(-180.0, 180.0), st.floats(0.0, 180.0)),
)
@settings(derandomize=True, deadline=None)
def test_separation_is_the_angle_between_the_directions(name, first, second):
    mount = MountGeometry(name, 20.0)
    a, b = np.array(native_of(*first)), np.array(native_of(*second))
    expected = np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))
    assert mount.sky_separation_deg(*first, *second) == pytest.approx(expected, abs=1e-6)


def test_separation_keeps_its_digits_when_small():
    mount = MountGeometry("azel", 20.0)
    assert mount.sky_separation_deg(10.0, 30.0, 10.0, 30.0 + 1e-7) == pytest.approx(1e-7, rel=1e-6)
    across = mount.sky_separation_deg(10.0, 30.0, 10.0 + 1e-7, 30.0)
    assert across == pytest.approx(0.5e-7, rel=1e-6)
    assert mount.sky_separation_deg(0.0, 90.0, 180.0, 90.0) == 180.0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("equatorial", 35.0), "unknown geometry 'equatorial': choose azel"),
        (("azel", 95.0), "latitude 95 is not between -90 and 90"),
        (("azel", float("nan")), "latitude nan"),
        (("azel", 35.0, 500.0), "branch centre 500"),
    ],
)
def test_a_mount_that_cannot_be_is_refused(arguments, says):
    with pytest.raises(ConfigurationError, match=says):
        MountGeometry(*arguments)


@pytest.mark.parametrize("ax1_deg", [-180.0, np.nextafter(180.0, 181.0), 180.0])
def test_a_hair_west_of_north_is_north_not_a_whole_turn(ax1_deg):
    azimuth, zenith = MountGeometry("azel", 35.0).horizontal_from_axes(ax1_deg, 50.0)
    assert 0.0 <= azimuth < 1e-12
    assert zenith == pytest.approx(50.0)
