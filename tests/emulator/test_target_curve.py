"""When the controller moves next: instants against those of a target that moves evenly."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solarcal.emulator.following import BLOCK, CHANGE_S, NODE_S, SEARCH_BLOCKS, TargetCurve

RATE_DEG_S = 15.0 / 3600.0


def evenly(rate_deg_s: float = RATE_DEG_S, leaves_s: float = math.inf) -> TargetCurve:
    """Both axes run at one rate from 0 deg on; the room ends at ``leaves_s``."""

    def targets(now_s):
        room = np.minimum((leaves_s - now_s) * RATE_DEG_S, 90.0)
        return np.vstack([now_s * rate_deg_s, now_s * rate_deg_s]), room

    return TargetCurve(targets)


@given(
    st.floats(0.0, 40_000.0),
    st.floats(0.005, 2.0),
    st.sampled_from([RATE_DEG_S, -RATE_DEG_S, 8.0 * RATE_DEG_S]),
)
def test_an_update_is_due_once_the_target_is_half_the_range_ahead(now_s, half_deg, rate):
    reading_deg = now_s * rate
    due_s = evenly(rate).next_update_s(0, reading_deg, half_deg, now_s)
    assert due_s == pytest.approx(now_s + half_deg / abs(rate), abs=1e-6)


@pytest.mark.parametrize("nodes", [1, 2, 7, BLOCK, BLOCK + 1])
def test_an_update_due_exactly_at_a_node_is_found_there(nodes):
    for rate in (RATE_DEG_S, 1.0 / 3.0, -0.1):
        half_deg = nodes * NODE_S * abs(rate)
        due_s = evenly(rate).next_update_s(1, 0.0, half_deg, 0.0)
        assert due_s == pytest.approx(nodes * NODE_S, abs=1e-6)


def test_what_is_overdue_is_due_now():
    assert evenly().next_update_s(0, -1.0, 0.5, 100.0) == 100.0


def test_a_target_that_stands_is_looked_at_again_after_a_day():
    assert evenly(0.0).next_update_s(0, 0.0, 0.5, 100.0) == SEARCH_BLOCKS * BLOCK * NODE_S
    assert evenly(0.0).next_change_s(True, 100.0) == SEARCH_BLOCKS * BLOCK * NODE_S


@given(st.floats(0.0, 40_000.0), st.floats(0.01, 40_000.0))
def test_a_limit_is_met_just_after_the_room_ends(now_s, ahead_s):
    curve = evenly(leaves_s=now_s + ahead_s)
    met_s = curve.next_change_s(True, now_s)
    assert 0.0 < met_s - (now_s + ahead_s) <= 2.0 * CHANGE_S
    assert not curve.is_within(met_s)


@pytest.mark.parametrize("nodes", [1, 2, BLOCK])
def test_a_limit_exactly_at_a_node_is_met_once(nodes):
    curve = evenly(leaves_s=nodes * NODE_S)
    met_s = curve.next_change_s(True, 0.0)
    assert met_s == pytest.approx(nodes * NODE_S, abs=2.0 * CHANGE_S)
    assert not curve.is_within(met_s)
    # A day later it is still outside: nobody meets the limit a second time.
    assert curve.next_change_s(False, met_s) - met_s > 80_000.0
