"""Fixtures of the report floor."""

import pytest
from made_up_session import fit_points as fit
from made_up_session import header_of, hourly, points_at


@pytest.fixture
def make_header():
    return header_of


@pytest.fixture
def make_points():
    return points_at


@pytest.fixture
def fit_points():
    return fit


@pytest.fixture
def june_day():
    """Header and twelve points from 07 h to 18 h solar time."""
    header = header_of()
    return header, points_at(header, hourly("2026-06-21", 14, 25))
