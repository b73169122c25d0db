"""Points are checked when the set is made: what is wrong is said with the point's label."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solarcal.errors import FitError
from solarcal.model.points import Points
from solarcal.model.sky_context import _seen_from
from solarcal.mount.geometry import MountGeometry


def made(centre_deg: float = 0.0, **changes: Any) -> Points:
    columns: dict[str, Any] = {
        "ax1_deg": [-40.0, -10.0, 10.0, 40.0],
        "ax2_deg": [60.0, 40.0, 41.0, 62.0],
        "err1_deg": [0.1, 0.2, 0.3, 0.4],
        "err2_deg": [0.5, 0.6, 0.7, 0.8],
        "labels": (7, 9, 12, 15),
    }
    return Points(geometry=MountGeometry("azel", 35.0, centre_deg), **(columns | changes))


@pytest.mark.parametrize(
    ("column", "value", "complaint"),
    [
        ("err1_deg", np.nan, "point 9: err1_deg is nan"),
        ("ax1_deg", np.inf, "point 9: ax1_deg is inf"),
        ("ax1_deg", 1e9, "point 9: AX1 1e.09 deg is more than two turns"),
        ("ax2_deg", 0.0, "point 9: AX2 0 deg is at a pole"),
        ("ax2_deg", 179.999, "point 9: AX2 179.999 deg is at a pole"),
        ("ax2_deg", -3.0, "point 9: AX2 -3 is not between 0 and 180"),
        ("err1_deg", 359.9, "point 9: the axis 1 error of 359.9 deg is more than half a turn"),
        ("sigma_deg", 0.0, "point 9: sigma 0 deg must be greater than zero"),
        ("sigma_deg", -0.02, "point 9: sigma -0.02 deg must be greater than zero"),
        ("sigma_deg", np.nan, "point 9: sigma_deg is nan"),
    ],
)
def test_an_unusable_number_is_refused_with_the_points_label(
    column: str, value: float, complaint: str
) -> None:
    good = [0.02] * 4 if column == "sigma_deg" else [30.0] * 4
    with pytest.raises(FitError, match=complaint) as refused:
        made(**{column: [good[0], value, *good[2:]]})
    assert "\n" not in str(refused.value)


def test_columns_of_different_length_are_refused() -> None:
    with pytest.raises(FitError, match="err2_deg has 3 numbers for 4 points"):
        made(err2_deg=[0.1, 0.2, 0.3])
    with pytest.raises(FitError, match="2 labels were given for 4 points"):
        made(labels=(1, 2))


def test_angles_off_the_branch_are_moved_onto_it_and_said_so() -> None:
    points = made(centre_deg=180.0)
    np.testing.assert_allclose(points.ax1_deg, [320.0, 350.0, 10.0, 40.0])
    assert points.moved_to_branch == (7, 9)
    assert (
        "AX1 of points 7 and 9 was given off the mount's branch (0, 360] deg" in points.remarks()[0]
    )


def test_points_on_the_branch_are_kept_to_the_last_bit() -> None:
    points = made(ax1_deg=[-180.0 + 1e-12, 0.1, 0.2, 180.0])
    assert points.ax1_deg.tolist() == [-180.0 + 1e-12, 0.1, 0.2, 180.0]
    assert points.moved_to_branch == ()
    assert points.remarks() == ()


def test_a_point_given_twice_is_one_point_and_named() -> None:
    points = made().subset([0, 1, 0, 3]).distinct()
    assert points.labels == (7, 9, 15)
    assert points.remarks() == ("point 7 repeats point 7: a measurement counts once",)
    assert made().distinct().remarks() == ()


def test_the_same_reading_at_another_time_is_another_point() -> None:
    points = made(utc_s=[0.0, 1.0, 2.0, 3.0])
    again = replace(points.subset([0, 1, 0]), utc_s=np.array([0.0, 1.0, 9.0]))
    assert len(again.distinct()) == 3


def test_a_path_across_the_end_of_the_branch_is_named() -> None:
    across = made(ax1_deg=[160.0, 175.0, -170.0, -150.0], utc_s=[0.0, 1.0, 2.0, 3.0])
    assert (
        "between points 9 and 12 axis 1 passes the end of its branch at 180 deg"
        in (across.remarks()[0])
    )
    assert made(ax1_deg=[160.0, 175.0, -170.0, -150.0]).remarks() == ()


def test_nobody_can_change_a_point_afterwards() -> None:
    source = np.array([-40.0, -10.0, 10.0, 40.0])
    points = made(ax1_deg=source)
    source[0] = 99.0
    assert points.ax1_deg[0] == -40.0
    with pytest.raises(ValueError, match="read-only"):
        points.ax1_deg[0] = 1.0


def test_a_subset_keeps_everything_that_belongs_to_a_point() -> None:
    points = made(sigma_deg=[0.1, 0.2, 0.3, 0.4], utc_s=[1.0, 2.0, 3.0, 4.0])
    kept = points.subset(np.array([True, False, False, True]))
    assert kept.labels == (7, 15)
    assert kept.sigma_deg is not None
    assert kept.utc_s is not None
    assert kept.sigma_deg.tolist() == [0.1, 0.4]
    assert kept.utc_s.tolist() == [1.0, 4.0]
    assert kept.err2_deg.tolist() == [0.5, 0.8]


def test_an_error_across_the_end_of_the_branch_is_a_small_one() -> None:
    """The unit's angle just before the end, the true one just beyond it, or the other way round."""
    points = made(ax1_deg=[179.95, -179.95, 10.0, 40.0])
    true1_deg = np.array([-179.95, 179.95, 10.1, 40.0])
    seen = _seen_from(points, true1_deg, points.ax2_deg, np.full(4, 45.0))
    assert seen.err1_deg == pytest.approx([0.0, 0.3, 0.2, 0.4], abs=1e-9)
