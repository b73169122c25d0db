"""The exact mechanism, both ways."""

import csv
import math
from pathlib import Path

import katpoint
import msgspec
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism

REFERENCE = Path(__file__).parents[3] / "shared" / "data" / "geometry_reference.csv"

names = st.sampled_from(GEOMETRIES)
latitudes = st.floats(-66.0, 66.0)


def within(limit):
    return st.floats(-limit, limit)


def leaning(lean_deg, bearing_deg, **others):
    bearing = math.radians(bearing_deg)
    return Mechanism(P1=lean_deg * math.cos(bearing), P3=lean_deg * math.sin(bearing), **others)


mechanisms = st.builds(
    leaning,
    lean_deg=st.floats(0.0, 8.0),
    bearing_deg=st.floats(0.0, 360.0),
    P2=within(30.0),
    P4=within(30.0),
    P5=within(0.02),
    P6=within(0.02),
    collimation_deg=within(1.5),
    nonperpendicularity_deg=within(1.5),
    sag_deg=within(1.0),
)


def reference_rows():
    if not REFERENCE.exists():
        pytest.skip(f"reference data {REFERENCE.name} is not beside the project")
    with REFERENCE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_nothing_is_wrong_with_a_mechanism_unless_it_is_said():
    assert set(msgspec.structs.astuple(Mechanism())) == {0.0}
    assert set(msgspec.structs.astuple(Coefficients())) == {0.0}
    assert set(msgspec.structs.astuple(Offsets())) == {0.0}


def test_all_rows_of_the_geometry_reference():
    rows = reference_rows()
    assert len(rows) == 80
    assert {row["geometry"] for row in rows} == set(GEOMETRIES)
    for row in rows:
        name = row.pop("geometry")
        value = {column: float(text) for column, text in row.items()}
        mount = MountGeometry(name, value["lat_deg"], 0.0)
        p = Coefficients(
            *(value[column] for column in ("P1_deg", "P2_deg", "P3_deg", "P4_deg", "P5", "P6"))
        )
        axes = mount.axes_from_horizontal(value["azimuth_north_east_deg"], value["zenith_deg"])
        assert axes == pytest.approx((value["ax1_deg"], value["ax2_deg"]), abs=1e-6)
        assert Mechanism(*p.as_tuple()).errors_deg(mount, *axes) == pytest.approx(
            (value["exact_err1_deg"], value["exact_err2_deg"]), abs=1e-6
        )
        assert correction_deg(p, *axes) == pytest.approx(
            (value["first_order_err1_deg"], value["first_order_err2_deg"]), abs=1e-6
        )


@given(
    name=names,
    latitude=latitudes,
    centre=st.sampled_from([0.0, 180.0, -75.0]),
    mechanism=mechanisms,
    turn=st.floats(-180.0, 180.0, exclude_min=True),
    polar=st.floats(0.0, 1.0),
)
@settings(derandomize=True, deadline=None, max_examples=300)
def test_pointing_undoes_readings(name, latitude, centre, mechanism, turn, polar):
    mount = MountGeometry(name, latitude, centre)
    # Beyond what lean, C, N and sag together can carry onto the mechanism's own axis.
    margin = math.hypot(mechanism.P1, mechanism.P3) + 6.0
    ax1, ax2 = centre + turn, margin + polar * (180.0 - 2.0 * margin)
    back1, back2 = mechanism.pointing_deg(mount, *mechanism.readings_deg(mount, ax1, ax2))
    # On the seam of the branch rounding may choose either end.
    assert abs((back1 - ax1 + 180.0) % 360.0 - 180.0) < 1e-9
    assert abs(back2 - ax2) < 1e-9


@given(name=names, latitude=latitudes, mechanism=mechanisms, seed=st.integers(0, 2**16))
@settings(derandomize=True, deadline=None, max_examples=40)
def test_arrays_close_and_agree_with_single_angles(name, latitude, mechanism, seed):
    mount = MountGeometry(name, latitude, 0.0)
    rng = np.random.default_rng(seed)
    ax1, ax2 = rng.uniform(-179.0, 179.0, (5, 4)), rng.uniform(20.0, 160.0, (5, 4))
    readings = mechanism.readings_deg(mount, ax1, ax2)
    back = mechanism.pointing_deg(mount, *readings)
    np.testing.assert_allclose(back, (ax1, ax2), rtol=0.0, atol=1e-9)
    for at in ((0, 0), (4, 3)):
        single = mechanism.readings_deg(mount, float(ax1[at]), float(ax2[at]))
        assert all(type(angle) is float for angle in single)
        assert single == pytest.approx((readings[0][at], readings[1][at]), abs=1e-11)
        assert all(type(a) is float for a in mechanism.pointing_deg(mount, *single))


def rotation_oracle(mount, mechanism, reading1, reading2):
    """ENU direction looked at (no sag, no scales), with scipy's rotations instead of ours."""
    to_enu = Rotation.from_matrix(mount.basis().T)
    lean = Rotation.from_rotvec(np.radians([-mechanism.P3, -mechanism.P1, 0.0]))
    arm = (
        Rotation.from_euler("z", reading1 - mechanism.P2, degrees=True)
        * Rotation.from_euler("x", mechanism.nonperpendicularity_deg, degrees=True)
        * Rotation.from_euler("y", reading2 - mechanism.P4, degrees=True)
        * Rotation.from_euler("x", mechanism.collimation_deg, degrees=True)
    )
    return (to_enu * lean * arm).apply([0.0, 0.0, 1.0])


@given(
    name=names,
    latitude=latitudes,
    mechanism=mechanisms,
    reading1=within(179.0),
    reading2=st.floats(15.0, 165.0),
)
@settings(derandomize=True, deadline=None)
def test_pointing_is_the_plain_product_of_rotations(name, latitude, mechanism, reading1, reading2):
    mount = MountGeometry(name, latitude)
    stiff = Mechanism(
        P1=mechanism.P1,
        P2=mechanism.P2,
        P3=mechanism.P3,
        P4=mechanism.P4 / 10.0,
        collimation_deg=mechanism.collimation_deg,
        nonperpendicularity_deg=mechanism.nonperpendicularity_deg,
    )
    azimuth, zenith = np.radians(
        mount.horizontal_from_axes(*stiff.pointing_deg(mount, reading1, reading2))
    )
    looked_at = (
        np.sin(zenith) * np.sin(azimuth),
        np.sin(zenith) * np.cos(azimuth),
        np.cos(zenith),
    )
    np.testing.assert_allclose(
        looked_at, rotation_oracle(mount, stiff, reading1, reading2), atol=1e-13
    )


@pytest.mark.parametrize(
    ("name", "p1_tip", "p3_tip"),
    [
        # Where the top (azel), east end, north end or pole end of the primary axis goes: E, N, U.
        ("azel", (0, 1, 0), (1, 0, 0)),
        ("tiltroll-ew", (0, 0, -1), (0, -1, 0)),
        ("tiltroll-ns", (0, 0, -1), (1, 0, 0)),
        ("polar", (0, math.sin(math.radians(35.0)), -math.cos(math.radians(35.0))), (1, 0, 0)),
    ],
)
def test_where_the_primary_axis_leans(name, p1_tip, p3_tip):
    mount = MountGeometry(name, 35.0)
    axis = mount.basis()[2]
    for mechanism, tip in ((Mechanism(P1=0.01), p1_tip), (Mechanism(P3=0.01), p3_tip)):
        # With AX2 at zero the collector looks along the mechanism's own primary axis.
        azimuth, zenith = np.radians(
            mount.horizontal_from_axes(*mechanism.pointing_deg(mount, 25.0, 0.0))
        )
        looks = np.array(
            [np.sin(zenith) * np.sin(azimuth), np.sin(zenith) * np.cos(azimuth), np.cos(zenith)]
        )
        moved = (looks - axis) / math.radians(0.01)
        np.testing.assert_allclose(moved, tip, atol=2e-4)


def test_a_tower_leaning_north_sees_a_southern_sun_too_low():
    """The everyday case: top to the north, Sun in the south, so more zenith angle is needed."""
    e1, e2 = Mechanism(P1=0.5).errors_deg(MountGeometry("azel", 35.0), 0.0, 40.0)
    assert e1 == pytest.approx(0.0, abs=1e-12)
    assert e2 == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
@pytest.mark.parametrize("ax2", [20.0, 60.0, 90.0, 130.0])
def test_first_order_of_collimation_and_of_axes_not_square(name, ax2):
    mount, small = MountGeometry(name, 35.0), 1e-3
    sin2, tan2 = math.sin(math.radians(ax2)), math.tan(math.radians(ax2))
    for mechanism, expected in (
        (Mechanism(collimation_deg=small), small / sin2),
        (Mechanism(nonperpendicularity_deg=small), small / tan2),
    ):
        e1, e2 = mechanism.errors_deg(mount, 33.0, ax2)
        assert e1 == pytest.approx(expected, abs=1e-7)
        assert e2 == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_first_order_of_sag(name):
    """E2 = SAG u.t2 and E1 = SAG u.t1 / sin AX2, u the vertical, t1, t2 the axes' tangents."""
    mount, small = MountGeometry(name, 35.0), 1e-3
    up = np.array(mount.up_components())
    for ax1, ax2 in ((-60.0, 40.0), (0.0, 75.0), (50.0, 110.0)):
        a1, a2 = np.radians([ax1, ax2])
        t1 = np.array([-np.sin(a1), np.cos(a1), 0.0])
        t2 = np.array([np.cos(a2) * np.cos(a1), np.cos(a2) * np.sin(a1), -np.sin(a2)])
        expected = (small * (up @ t1) / np.sin(a2), small * (up @ t2))
        got = Mechanism(sag_deg=small).errors_deg(mount, ax1, ax2)
        assert got == pytest.approx(expected, abs=1e-7)


def test_sag_of_azel_makes_it_point_higher_and_is_exact():
    for zenith in (0.001, 30.0, 90.0):
        e1, e2 = Mechanism(sag_deg=0.4).errors_deg(MountGeometry("azel", 10.0), 20.0, zenith)
        assert e1 == pytest.approx(0.0, abs=1e-9)
        assert e2 == pytest.approx(-0.4 * math.sin(math.radians(zenith)), abs=1e-12)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_sag_bends_down_by_its_sine_in_the_vertical_plane(name):
    """A stiff and a bending collector at the same read-outs: same azimuth, lower by sag sin z."""
    mount = MountGeometry(name, 47.0)
    readings = (np.array([-50.0, 5.0, 40.0]), np.array([60.0, 80.0, 100.0]))
    stiff = mount.horizontal_from_axes(*Mechanism(P1=1.0).pointing_deg(mount, *readings))
    bent = mount.horizontal_from_axes(
        *Mechanism(P1=1.0, sag_deg=0.7).pointing_deg(mount, *readings)
    )
    np.testing.assert_allclose(bent[0], stiff[0], atol=1e-10)
    np.testing.assert_allclose(
        bent[1] - stiff[1], 0.7 * np.sin(np.radians(bent[1])), rtol=0.0, atol=1e-10
    )


def test_offsets_and_scales_act_on_the_ideal_branch_angle():
    mechanism = Mechanism(P1=1.0, P2=0.4, P4=-0.3, P5=0.002, P6=-0.001)
    bare = Mechanism(P1=1.0)
    south = MountGeometry("azel", -33.9, 180.0)
    ax1, ax2 = 215.0, 50.0
    e1, e2 = bare.errors_deg(south, ax1, ax2)
    assert mechanism.errors_deg(south, ax1, ax2) == pytest.approx(
        (e1 + 0.4 - 0.002 * 215.0, e2 - 0.3 + 0.001 * 50.0), abs=1e-12
    )
    # The same direction given on the other branch is the same direction of this mount.
    assert mechanism.errors_deg(south, ax1 - 360.0, ax2) == pytest.approx(
        mechanism.errors_deg(south, ax1, ax2), abs=1e-11
    )


def test_read_outs_beyond_the_branch_do_not_jump_with_the_gear():
    """An axis driven past c + 180 turns on: no step in the direction it looks at."""
    mount, mechanism = MountGeometry("azel", 35.0), Mechanism(P5=0.01)
    before = mechanism.pointing_deg(mount, 178.1, 50.0)
    after = mechanism.pointing_deg(mount, 178.3, 50.0)
    assert before[0] == pytest.approx(178.1 / 0.99, abs=1e-9)
    assert after[0] == pytest.approx(178.3 / 0.99 - 360.0, abs=1e-9)


def test_errors_near_the_seam_of_the_branch_are_small():
    e1, _ = Mechanism(P3=1.0).errors_deg(MountGeometry("azel", 35.0), 179.9, 45.0)
    assert e1 == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize(
    ("mechanism", "theirs", "sign"),
    [
        (Mechanism(P1=1e-4), "P5", 1.0),
        (Mechanism(P3=1e-4), "P6", 1.0),
        (Mechanism(collimation_deg=1e-4), "P4", 1.0),
        (Mechanism(nonperpendicularity_deg=1e-4), "P3", -1.0),
        (Mechanism(P2=1e-4), "P1", -1.0),
        (Mechanism(P4=1e-4), "P7", -1.0),
        (Mechanism(sag_deg=1e-4), "P8", 1.0),
    ],
)
def test_azel_agrees_with_katpoint_to_first_order(mechanism, theirs, sign):
    """katpoint: encoder - true in azimuth and elevation; AX1 = 180 - A, AX2 = 90 - E."""
    model = katpoint.PointingModel()
    model[theirs] = sign * np.radians(1e-4)
    for azimuth, elevation in ((40.0, 20.0), (160.0, 60.0), (285.0, 75.0)):
        delta = np.degrees(model.offset(np.radians(azimuth), np.radians(elevation)))
        got = mechanism.errors_deg(MountGeometry("azel", 35.0), 180.0 - azimuth, 90.0 - elevation)
        assert got == pytest.approx((-delta[0], -delta[1]), abs=5e-9)


@pytest.mark.parametrize("ax2", [0.0, 180.0])
def test_on_its_own_axis_the_first_read_out_is_undetermined(ax2):
    with pytest.raises(ConfigurationError, match="axis 1 is undetermined"):
        Mechanism().errors_deg(MountGeometry("azel", 35.0), 30.0, ax2)
    # A leaning mount sees the same direction off its axis, and knows its read-out.
    assert np.isfinite(Mechanism(P1=0.5).errors_deg(MountGeometry("azel", 35.0), 30.0, ax2)).all()


def test_collimation_keeps_a_cone_round_the_axis_out_of_reach():
    mechanism = Mechanism(collimation_deg=1.0)
    mount = MountGeometry("azel", 35.0)
    assert np.isfinite(mechanism.errors_deg(mount, 30.0, 1.01)).all()
    with pytest.raises(ConfigurationError, match=r"collimation 1 .* out of reach"):
        mechanism.errors_deg(mount, np.array([30.0, 30.0]), np.array([40.0, 0.99]))


def test_stowed_on_the_primary_axis_the_direction_is_known():
    mount = MountGeometry("azel", 35.0)
    assert Mechanism().pointing_deg(mount, 30.0, 0.0) == pytest.approx((30.0, 0.0))
    _, zenith = mount.horizontal_from_axes(*Mechanism(P1=0.6).pointing_deg(mount, 0.0, 0.0))
    assert zenith == pytest.approx(0.6)


def test_an_inverse_that_does_not_settle_says_so():
    wild = Mechanism(P1=7.7, P5=0.02, P6=0.3)
    with pytest.raises(ConfigurationError, match=r"no direction found .* P6 = 0\.3 are too large"):
        wild.pointing_deg(MountGeometry("azel", 0.0), 14.841667997, 2.768912040)


def test_missing_values_stay_missing():
    mount, mechanism = MountGeometry("polar", 35.0), Mechanism(P1=0.5, P5=0.001, sag_deg=0.1)
    with_gap = np.array([10.0, np.nan])
    for result in (
        mechanism.readings_deg(mount, with_gap, with_gap + 50.0),
        mechanism.pointing_deg(mount, with_gap, with_gap + 50.0),
    ):
        assert np.isfinite(result[0][0])
        assert np.isnan(result[0][1])


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        ({"P1": -50.0}, "-50"),
        ({"P3": np.array([[1.0], [-50.0], [46.0]])}, "-50"),
        ({"P5": 0.7}, "0.7"),
        ({"P2": math.nan}, "nan"),
        ({"sag_deg": math.inf}, "inf"),
    ],
)
def test_a_mechanism_that_cannot_be_is_refused_with_its_worst_value(values, shown):
    ((name, _),) = values.items()
    with pytest.raises(ConfigurationError, match=f"a mechanism with {name} = {shown} cannot be"):
        Mechanism(**values)


@pytest.mark.parametrize(
    ("names", "largest"),
    [
        (("P1", "P3", "collimation_deg", "nonperpendicularity_deg", "sag_deg"), 45.0),
        (("P2", "P4", "backlash1_deg", "backlash2_deg"), 360.0),
        (("P5", "P6"), 0.5),
        (("air",), 100.0),
    ],
)
def test_the_largest_a_mechanism_can_have_of_each(names, largest):
    for name in names:
        for value in (-largest, largest):
            Mechanism(**{name: value})
            with pytest.raises(ConfigurationError, match=f"not within \\+-{largest:g}"):
                Mechanism(**{name: 1.0001 * value})


def test_slopes_are_continuous_where_a_mount_stands_turned_by_half_a_turn():
    """Between its own axis and the nominal one: there an error may be +180 or -180 deg."""
    mount, values = MountGeometry("azel", 35.0), np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    places = np.array([179.0, 179.999, 180.0, 180.001, 181.0])
    slopes = Mechanism.linearised(values, mount, places, np.full(5, 0.5), ("P1", "P3")).slopes
    # Half a degree from the axis a tip across moves axis 1 by 1 / sin(0.5 deg).
    assert slopes[1, 0] == pytest.approx(np.full(5, -114.593), rel=1e-3)
