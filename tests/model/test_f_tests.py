"""Extra sums of squares against the same by a QR decomposition, and where columns nearly agree."""

import numpy as np
import pytest

from solarcal.model.f_tests import ColumnFit


def left_of(columns, values):
    q, _ = np.linalg.qr(columns)
    rest = values - q @ (q.T @ values)
    return float(rest @ rest)


@pytest.mark.parametrize("seed", range(5))
def test_more_columns_together_are_the_extra_sum_of_squares(seed):
    # Half a second that hardly another test needs.
    from scipy.stats import f as f_distribution

    rng = np.random.default_rng(seed)
    base, more, values = (rng.normal(size=size) for size in ((20, 6), (20, 2), 20))
    p, amounts = ColumnFit(base, values).columns(more)
    without, together = left_of(base, values), left_of(np.hstack((base, more)), values)
    f = (without - together) / 2 / (together / (20 - 8))
    assert p == pytest.approx(f_distribution.sf(f, 2, 12), rel=1e-9)
    exact = np.linalg.lstsq(np.hstack((base, more)), values, rcond=None)[0]
    assert amounts == pytest.approx(exact[6:], rel=1e-9)


@pytest.mark.parametrize("exponent", range(3, 12))
def test_columns_that_nearly_agree_give_a_probability_all_the_same(exponent):
    """On a polar mount near the equator the scale of an axis is nearly a lean, for some hours."""
    rng = np.random.default_rng(exponent)
    base, values = rng.normal(size=(20, 6)), rng.normal(size=20)
    base[:, 5] = base[:, 4] + 10.0**-exponent * rng.normal(size=20)
    for more in (
        np.column_stack((base[:, 0] + 10.0**-exponent * rng.normal(size=20), base[:, 4])),
        np.column_stack((base[:, 5] - base[:, 4], rng.normal(size=20))),
        base[:, :2],
    ):
        p, amounts = ColumnFit(base, values).columns(more)
        assert 0.0 <= p <= 1.0
        assert np.isfinite(amounts).all()


def test_columns_that_the_model_holds_already_explain_nothing():
    rng = np.random.default_rng(1)
    base, values = rng.normal(size=(20, 6)), rng.normal(size=20)
    assert ColumnFit(base, values).columns(base[:, :2])[0] == 1.0


@pytest.mark.parametrize(("apart", "seen"), [(1e-11, False), (1e-7, True)])
def test_a_column_that_differs_from_the_others_by_rounding_only_is_not_seen(apart, seen):
    """A thousandth of a millionth of its length is where rounding begins."""
    rng = np.random.default_rng(3)
    base, values, beside = (rng.normal(size=size) for size in ((20, 6), 20, 20))
    beside -= base @ np.linalg.lstsq(base, beside, rcond=None)[0]
    column = base[:, 0] / np.linalg.norm(base[:, 0]) + apart * beside / np.linalg.norm(beside)
    (amount,), (sigma,), (probability,) = ColumnFit(base, values).each(column[:, np.newaxis])
    assert np.isfinite(sigma) == seen
    assert (probability < 1.0) == seen
    assert (amount != 0.0) == seen
