"""Weighted linear least squares that knows what the data cannot tell.

Columns are normalised before the singular value decomposition, so that rank and condition number
do not depend on the units of the parameters. Directions with a singular value below ``RANK_LIMIT``
are not fixed by the data; along them the solution is the one of minimum norm in units of the prior
sigmas, and the covariance carries the prior itself, because nothing else is known there.
"""

import contextlib
from dataclasses import dataclass

import numpy as np
from scipy import linalg

from solarcal.units import FloatArray

RANK_LIMIT = 1e-6
MANY = 10_000
"""Data from which on a QR decomposition before the singular values pays."""
NEGLIGIBLE = 1e-9
"""A column whose effect at one prior sigma is below this part of the data's weight is no column:
it is the rounding of cos(90 deg), and normalising it would make a parameter out of nothing."""


ROUNDING = 1e-14
"""Of the trace: by so much a matrix that rounding left singular is made definite again."""


def inverse(normal: FloatArray) -> FloatArray:
    """Of normal matrices (..., k, k), whose weights may differ by more than float64 resolves."""
    with contextlib.suppress(np.linalg.LinAlgError):
        found = np.asarray(np.linalg.inv(normal), dtype=np.float64)
        if (np.einsum("...ii->...i", found) > 0.0).all():
            return found
    return np.asarray(np.linalg.inv(_definite(normal)), dtype=np.float64)


def solution_of(normal: FloatArray, wanted: FloatArray) -> FloatArray:
    """x (k,) of normal @ x = wanted, of a normal matrix (k, k) as of ``inverse``."""
    try:
        return np.asarray(np.linalg.solve(normal, wanted), dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.solve(_definite(normal), wanted), dtype=np.float64)


def _definite(normal: FloatArray) -> FloatArray:
    size = ROUNDING * np.einsum("...ii->...", normal)[..., np.newaxis, np.newaxis]
    raised: FloatArray = normal + size * np.eye(normal.shape[-1])
    return raised


@dataclass(frozen=True, eq=False, slots=True)
class LeastSquares:
    """What k parameters come out of m weighted data.

    ``values`` (k,). ``data_covariance`` (k, k): what unit-variance data leave, along the
    directions they fix. ``prior_covariance`` (k, k): the prior's share along the others, None at
    full rank. ``null_directions`` (k, k - rank): those others, orthonormal, in column-normalised
    parameters. ``weighted_residuals`` (m,).
    """

    values: FloatArray
    data_covariance: FloatArray
    prior_covariance: FloatArray | None
    null_directions: FloatArray
    weighted_residuals: FloatArray
    rank: int
    condition_number: float


def solve(
    rows: FloatArray, measured: FloatArray, prior_sigma: FloatArray, data_weight: float
) -> LeastSquares:
    """Solve rows.T @ x = measured in the least-squares sense.

    Parameters
    ----------
    rows : (k, m), effect of each parameter on each datum, weighted. One row a parameter: it is the
        transposed design matrix, which keeps every parameter contiguous in memory.
    measured : (m,), the data, weighted.
    prior_sigma : (k,), units in which the norm is minimised where the data leave a choice.
    data_weight : root sum square of the weights: what an effect of one on every datum would amount
        to.
    """
    k, m = rows.shape
    norms = np.sqrt(np.einsum("ij,ij->i", rows, rows))
    absent = norms * prior_sigma <= NEGLIGIBLE * data_weight
    if absent.any():
        rows = np.where(absent[:, np.newaxis], 0.0, rows)
        norms = np.where(absent, 1.0 / prior_sigma, norms)
    even = rows / norms[:, np.newaxis]
    if m > MANY:
        # The same with the k rotated data that the others are orthogonal to.
        measured_then, triangle = linalg.qr_multiply(even.T, measured, overwrite_a=True)
        even = triangle.T
    else:
        measured_then = measured
    left, singular, right = linalg.svd(even, full_matrices=m < k, check_finite=False)
    rank = int(np.count_nonzero(singular >= RANK_LIMIT))
    fixed = left[:, :rank] / norms[:, np.newaxis]
    values = fixed @ ((right[:rank] @ measured_then) / singular[:rank])
    spread = fixed / singular[:rank]
    null = left[:, rank:]
    prior_covariance = None
    if rank < k:
        # In prior units the free directions are projected out of the values and of their scatter.
        free, _ = linalg.qr(null / (norms * prior_sigma)[:, np.newaxis], mode="economic")
        free_share = free @ free.T
        keep = np.eye(k) - free_share
        values = prior_sigma * (keep @ (values / prior_sigma))
        spread = prior_sigma[:, np.newaxis] * (keep @ (spread / prior_sigma[:, np.newaxis]))
        prior_covariance = free_share * np.outer(prior_sigma, prior_sigma)
    return LeastSquares(
        values=values,
        data_covariance=spread @ spread.T,
        prior_covariance=prior_covariance,
        null_directions=null,
        weighted_residuals=measured - values @ rows,
        rank=rank,
        condition_number=float(singular[0] / singular[-1]) if rank == k else float("inf"),
    )
