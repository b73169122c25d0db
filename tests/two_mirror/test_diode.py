"""Four quadrants, traced back to axis corrections; the field of view."""

import math

import numpy as np
import pytest

from solarcal.errors import ConfigurationError
from solarcal.two_mirror.diode import (
    DISC_GAIN_PER_RAD,
    QuadrantDiode,
    field_of_view,
    quadrant_errors,
)
from solarcal.two_mirror.mirrors import (
    axes_of,
    direction_components,
    fixed_mirrors_matrix,
    ray_from_sky,
    tracker_matrix,
)


@pytest.mark.parametrize(
    ("lit", "signs"),
    [("A", (-1.0, 1.0)), ("B", (1.0, 1.0)), ("C", (1.0, -1.0)), ("D", (-1.0, -1.0))],
)
def test_quadrant_signs(lit: str, signs: tuple[float, float]) -> None:
    """Section 6: 'Quadrants lie at A(-,+) B(+,+) C(+,-) D(-,-) of (d1, d2)'."""
    a, b, c, d = (2.0 if name == lit else 0.0 for name in "ABCD")
    assert quadrant_errors((a, b, c, d)) == signs


def test_e1_and_e2_of_section_6() -> None:
    """e1 = (B+C)-(A+D), e2 = (A+B)-(C+D), over the whole light."""
    a, b, c, d = 1.0, 2.0, 4.0, 8.0
    e1, e2 = quadrant_errors((a, b, c, d))
    assert e1 == pytest.approx(((b + c) - (a + d)) / 15.0)
    assert e2 == pytest.approx(((a + b) - (c + d)) / 15.0)


def test_haze_changes_nothing() -> None:
    assert quadrant_errors((1.0, 2.0, 3.0, 4.0)) == pytest.approx(
        quadrant_errors((0.1, 0.2, 0.3, 0.4))
    )


@pytest.mark.parametrize("t1", [-150.0, -20.0, 75.0])
@pytest.mark.parametrize("t2", [4.0, 40.0, 84.0])
def test_the_corrections_lead_to_the_sun(t1: float, t2: float) -> None:
    """A Sun beside the axis, seen by the diode as e = +k d, is found exactly by the trace."""
    sun = (t1 + 0.2 / math.sin(math.radians(t2)), t2 - 0.15)
    d1, d2, d3 = ray_from_sky(direction_components(*sun), t1, t2)
    diode = QuadrantDiode()
    e1, e2 = diode.gain_per_rad * d1 / d3, diode.gain_per_rad * d2 / d3
    turn1, turn2 = diode.corrections_deg(e1, e2, t1, t2)
    assert (t1 + turn1, t2 + turn2) == pytest.approx(sun, abs=1e-10)


def test_the_formula_of_section_6_with_fixed_mirrors_and_set_points() -> None:
    """(xs, ys, zs) = M_tracker F (e1-e1c, e2-e2c, L)."""
    mirrors = [(0.0, 1.0, 0.1), (0.2, -1.0, 0.05)]
    diode = QuadrantDiode.with_fixed_mirrors(
        mirrors, gain_per_rad=200.0, set_point1=0.1, set_point2=-0.2
    )
    e1, e2, t1, t2 = 0.3, 0.25, 33.0, 48.0
    sun = tracker_matrix(t1, t2) @ fixed_mirrors_matrix(mirrors) @ np.array([0.2, 0.45, 200.0])
    assert diode.sun_axes_deg(e1, e2, t1, t2) == pytest.approx(axes_of((sun[0], sun[1], sun[2])))


def test_at_the_set_point_nothing_is_corrected() -> None:
    diode = QuadrantDiode(set_point1=0.12, set_point2=-0.3)
    assert diode.corrections_deg(0.12, -0.3, 70.0, 20.0) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert diode.off_centre_mrad(0.12, -0.3) == 0.0


def test_the_slope_of_a_disc_across_a_split() -> None:
    """k = 4/(pi r): by counting the light of a disc moved by a hundredth of its radius."""
    radius = 4.65e-3
    y = (np.arange(100_000) + 0.5) / 100_000 * 2.0 - 1.0
    half = np.sqrt(1.0 - y**2)
    right = (0.01 + half).clip(0.0, None).sum() / (2.0 * half).sum()
    e1 = 2.0 * right - 1.0
    assert e1 / (0.01 * radius) == pytest.approx(DISC_GAIN_PER_RAD, rel=2e-3)


def test_field_of_view_of_section_6() -> None:
    """6 mm, 200 mm: 30 mrad; 10 cm, 5 m: 20 mrad."""
    field = field_of_view()
    assert field.diode_mrad == pytest.approx(30.0, abs=0.01)
    assert field.tracker_mrad == pytest.approx(20.0, abs=0.01)
    assert field.diode_mrad == 1e3 * math.atan(6.0 / 200.0)
    assert field.tracker_mrad == 1e3 * math.atan(0.10 / 5.0)


def test_the_budget_against_the_suns_nine_milliradians() -> None:
    field = field_of_view(sun_mrad=9.0)
    assert field.limited_by == "tracker"
    assert field.any_light_mrad == pytest.approx(10.0, abs=0.01)
    assert field.whole_sun_mrad == pytest.approx(5.5, abs=0.01)
    assert field_of_view(distance_m=15.0).whole_sun_mrad < 0.0


def test_bad_input_is_answered_in_one_line() -> None:
    for wrong, said in (
        (lambda: quadrant_errors((0.0, 0.0, 0.0, 0.0)), "no light"),
        (lambda: quadrant_errors((math.nan, 0.0, 0.0, 1.0)), "no light"),
        (lambda: QuadrantDiode(gain_per_rad=0.0), "greater than zero"),
        (lambda: QuadrantDiode(set_point1=1.5), "between -1 and 1"),
        (lambda: field_of_view(focal_length_mm=0.0), "focal length"),
        (lambda: field_of_view(distance_m=-1.0), "distance"),
    ):
        with pytest.raises(ConfigurationError, match=said):
            wrong()
