"""Readings of one instant are one measurement, whatever they read; others are not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solarcal.model.points import Points
from solarcal.model.repeats import contradicted, repeats
from solarcal.mount.geometry import MountGeometry
from solarcal.units import FloatArray

N = 6


def made(**changes: Any) -> Points:
    """Points of a morning, half an hour apart."""
    columns: dict[str, Any] = {
        "ax1_deg": 60.123456 - 8.0 * np.arange(N),
        "ax2_deg": 70.654321 - 6.0 * np.arange(N),
        "err1_deg": 0.4123 + 0.01 * np.arange(N),
        "err2_deg": -0.2321 + 0.01 * np.arange(N),
        "utc_s": 1.78e9 + 1800.0 * np.arange(N),
    }
    return Points(geometry=MountGeometry("azel", 35.0, 0.0), **(columns | changes))


def twice(points: Points, **changes: Any) -> Points:
    again = replace(points, labels=tuple(range(101, 101 + N)), **changes)
    return Points.joined((points, again)).distinct()


def rounded(points: Points, decimals: int) -> dict[str, Any]:
    names = ("ax1_deg", "ax2_deg", "err1_deg", "err2_deg")
    return {name: getattr(points, name).round(decimals) for name in names}


@pytest.mark.parametrize("decimals", [1, 2, 3, 9])
def test_rounded_copies_with_a_rounded_time_add_nothing(decimals: int) -> None:
    points = made()
    once = twice(points, utc_s=points.utc_s + 0.7, **rounded(points, decimals))
    assert once.labels == points.labels
    assert once.err1_deg.tolist() == points.err1_deg.tolist()
    assert [copy[:2] for copy in once.copies] == [(100 + k, k) for k in range(1, N + 1)]
    (said,) = once.remarks()
    assert said.startswith("points 101, 102, 103, 104, 105 and 106 repeat points 1, 2, 3, 4, 5 and")


def test_readings_of_one_instant_that_differ_are_said_with_their_size() -> None:
    points = made()
    once = twice(points, err2_deg=points.err2_deg + np.array([0.0, 0.002, 0.009, 0.1, 0.0, 0.0]))
    assert len(once) == N
    (finding,) = contradicted(once.copies)
    said = finding.sentence
    assert said.startswith("point 104 contradicts its first reading of the same instant (points 4 ")
    assert "differ by 0.100 deg on the sky" in said


def test_readings_may_differ_by_their_sigmas_and_axis_1_by_its_share_on_the_sky() -> None:
    points = made(sigma_deg=np.full(N, 0.05))
    assert not contradicted(twice(points, err2_deg=points.err2_deg + 0.04).copies)
    assert contradicted(twice(points, err2_deg=points.err2_deg + 0.06).copies)
    steep = made(ax2_deg=np.full(N, 5.0))
    assert not contradicted(twice(steep, err1_deg=steep.err1_deg + 0.1).copies)


def test_other_times_or_other_directions_are_other_points() -> None:
    points = made()
    assert len(twice(points, utc_s=points.utc_s + 3.0)) == 2 * N
    assert len(twice(points, ax2_deg=points.ax2_deg + 0.2)) == 2 * N
    assert len(made(utc_s=np.full(N, 1.78e9)).distinct()) == N


def test_near_the_pole_of_axis_2_directions_are_compared_on_the_sky() -> None:
    steep = made(ax2_deg=np.full(N, 0.5))
    assert len(twice(steep, ax1_deg=steep.ax1_deg + 3.0)) == N


def test_without_times_only_equal_angles_and_errors_are_a_repetition() -> None:
    points = made(utc_s=None)
    assert len(twice(points)) == N
    assert len(twice(points, err1_deg=points.err1_deg + 1e-9)) == N
    assert len(twice(points, err1_deg=points.err1_deg + 0.0002)) == 2 * N


def test_a_time_that_one_of_two_lacks_tells_them_not_apart() -> None:
    points = made()
    assert len(twice(points, utc_s=np.full(N, np.nan))) == N
    assert len(twice(points, utc_s=np.full(N, np.nan), ax1_deg=points.ax1_deg + 1e-3)) == 2 * N


def test_a_stream_of_readings_counts_at_most_every_two_seconds() -> None:
    n = 81
    angles = np.tile([30.0, 40.0, 0.1, 0.2], (n, 1))
    left = {row for row, _, _ in repeats(0.125 * np.arange(n), angles, None)}
    assert sorted(set(range(n)) - left) == [0, 17, 34, 51, 68]


@pytest.mark.parametrize("dated", [True, False])
def test_the_grouping_is_that_of_comparing_every_pair(dated: bool) -> None:
    """Places on all sides of the cells' borders, negative ones too."""
    rng = np.random.default_rng(5)
    n, scale = 400, 0.1 if dated else 1e-4
    angles = np.array([0.0, 90.0, 0.0, 0.0]) + 3.0 * scale * rng.uniform(-1.0, 1.0, (n, 4))
    utc_s = 6.0 * rng.uniform(-1.0, 1.0, n) if dated else np.full(n, np.nan)
    found = {row: first for row, first, _ in repeats(utc_s, angles, None)}
    assert 50 < len(found) < n - 50
    assert found == _by_pairs(utc_s, angles)


def _by_pairs(utc_s: FloatArray, angles: FloatArray) -> dict[int, int]:
    counted: list[int] = []
    found = {}
    ax1, ax2 = np.radians(angles[:, :2]).T
    sky = np.column_stack([np.sin(ax2) * np.cos(ax1), np.sin(ax2) * np.sin(ax1), np.cos(ax2)])
    for row in range(len(angles)):
        for first in counted:
            if np.isfinite(utc_s).all():
                same = abs(utc_s[row] - utc_s[first]) <= 2.0
                same &= np.abs(sky[row] - sky[first]).max() <= np.radians(0.1)
            else:
                same = np.abs(angles[row] - angles[first]).max() <= 1e-4
            if same:
                found[row] = first
                break
        else:
            counted.append(row)
    return found
