"""The controller's own formula in P1..P6."""

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism


@pytest.mark.parametrize(
    ("coefficients", "e1", "e2"),
    [
        # At AX1 = 30, AX2 = 45 deg: sin, cos = 0.5, 0.8660; tan = 1.
        (Coefficients(P1=1.0), -0.5, np.sqrt(0.75)),
        (Coefficients(P2=1.0), 1.0, 0.0),
        (Coefficients(P3=1.0), -np.sqrt(0.75), -0.5),
        (Coefficients(P4=1.0), 0.0, 1.0),
        (Coefficients(P5=0.01), -0.3, 0.0),
        (Coefficients(P6=0.01), 0.0, -0.45),
    ],
)
def test_each_term_alone(coefficients, e1, e2):
    assert correction_deg(coefficients, 30.0, 45.0) == pytest.approx((e1, e2), abs=1e-12)
    arrays = correction_deg(coefficients, np.array([30.0, 30.0]), np.array([45.0, 45.0]))
    np.testing.assert_allclose(arrays, [[e1, e1], [e2, e2]], atol=1e-12)


def test_floats_give_floats():
    corrections = correction_deg(Coefficients(0.1, 0.2, 0.3, 0.4, 0.001, 0.002), 10.0, 50.0)
    assert [type(e) for e in corrections] == [float, float]


@pytest.mark.parametrize("ax2", [0.0, 180.0, np.array([40.0, 180.0]), np.array([0.0])])
def test_a_leaning_mount_has_no_correction_on_its_primary_axis(ax2):
    with pytest.raises(ConfigurationError, match="AX2 = 0 or 180 deg"):
        correction_deg(Coefficients(P3=0.1), ax2 * 0.0 + 20.0, ax2)


def test_an_upright_mount_has_one_everywhere():
    corrections = correction_deg(Coefficients(P2=0.5, P4=-0.25, P5=0.01), 20.0, 0.0)
    assert corrections == pytest.approx((0.3, -0.25))


def test_a_small_mechanism_errs_as_the_formula_says():
    """What is left between the two forms falls with the square of the lean."""
    ax1, ax2 = np.meshgrid(np.linspace(-150.0, 170.0, 17), np.linspace(15.0, 165.0, 11))
    for name in GEOMETRIES:
        mount = MountGeometry(name, 35.0)
        left = []
        for lean in (1e-2, 1e-3):
            p = Coefficients(P1=0.8 * lean, P2=0.3, P3=-0.6 * lean, P4=-0.2, P5=2e-3, P6=-1e-3)
            exact = Mechanism(*p.as_tuple()).errors_deg(mount, ax1, ax2)
            left.append(np.max(np.abs(np.subtract(exact, correction_deg(p, ax1, ax2)))))
        assert left[0] < 3e-5
        assert left[0] / left[1] == pytest.approx(100.0, rel=0.05)


# 10-physics, section 2: worst over a year with the Sun above 10 deg at latitude 35.
FIRST_ORDER_DEPARTURE = [
    ("azel", 0.5, 0.012),
    ("azel", 1.0, 0.05),
    ("azel", 2.0, 0.21),
    ("azel", 5.0, 1.4),
    ("tiltroll-ew", 0.5, 0.014),
    ("tiltroll-ew", 1.0, 0.06),
    ("tiltroll-ew", 2.0, 0.24),
    ("tiltroll-ew", 5.0, 1.7),
    ("tiltroll-ns", 0.5, 0.004),
    ("tiltroll-ns", 1.0, 0.017),
    ("tiltroll-ns", 2.0, 0.07),
    ("tiltroll-ns", 5.0, 0.44),
    # Not in that table; as docs/physics.md prints it.
    ("polar", 0.5, 0.0015),
    ("polar", 5.0, 0.15),
]


@pytest.fixture(scope="module")
def year_of_sun():
    """(azimuth, zenith) at latitude 35, Sun above 10 deg, from declination and hour angle."""
    declination, hour_angle = np.meshgrid(
        np.radians(np.linspace(-23.44, 23.44, 41)), np.radians(np.arange(-180.0, 180.0, 0.5))
    )
    latitude = np.radians(35.0)
    east = -np.cos(declination) * np.sin(hour_angle)
    north = np.cos(latitude) * np.sin(declination) - np.sin(latitude) * np.cos(
        declination
    ) * np.cos(hour_angle)
    up = np.sin(latitude) * np.sin(declination) + np.cos(latitude) * np.cos(declination) * np.cos(
        hour_angle
    )
    high = up > np.sin(np.radians(10.0))
    return np.degrees(np.arctan2(east, north))[high], np.degrees(np.arccos(up[high]))


@pytest.mark.parametrize(("name", "lean_deg", "departure_deg"), FIRST_ORDER_DEPARTURE)
def test_how_far_the_formula_departs_from_the_mechanism(name, lean_deg, departure_deg, year_of_sun):
    mount = MountGeometry(name, 35.0)
    ax1, ax2 = mount.axes_from_horizontal(*year_of_sun)
    worst = 0.0
    for bearing in np.radians(np.arange(0.0, 360.0, 15.0)):
        p = Coefficients(P1=lean_deg * np.cos(bearing), P3=lean_deg * np.sin(bearing))
        exact = Mechanism(*p.as_tuple()).errors_deg(mount, ax1, ax2)
        formula = correction_deg(p, ax1, ax2)
        cross = (exact[0] - formula[0]) * np.sin(np.radians(ax2))
        worst = max(worst, np.max(np.hypot(cross, exact[1] - formula[1])))
    # The table has two digits; at 5 deg the worst case is as sharp as the grid is fine.
    assert worst == pytest.approx(departure_deg, rel=0.06)


def test_what_the_controller_keeps_is_rounded_without_negative_zero():
    kept = Coefficients(0.123456, -0.00001, 1.0, -2.0, 0.00012345, -1e-9).rounded(4, 6)
    assert kept.as_tuple() == (0.1235, 0.0, 1.0, -2.0, 0.000123, 0.0)
    assert "-0.0" not in str(kept.as_tuple()[1]) + str(kept.P6)
