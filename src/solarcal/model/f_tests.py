"""Least squares on some columns, and F-tests of more: one column, or points set free."""

from collections.abc import Sequence

import numpy as np

from solarcal.units import FloatArray

RANK_LIMIT = 1e-6
UNSEEN = 1e-9
"""A column this small is the rounding of another."""


def squares_beside(base: FloatArray, residuals: FloatArray) -> float:
    """Sum of squares that columns (m, k) leave of residuals (m,)."""
    return ColumnFit(base, residuals).squares


def norm_beside(base: FloatArray, column: FloatArray) -> float:
    """Length of the part of a column (m,) that columns (m, k) do not hold; 0 where rounding."""
    basis = basis_of(base)
    rest = column - basis @ (basis.T @ column)
    norm = float(np.linalg.norm(rest))
    return norm if norm > UNSEEN * max(float(np.linalg.norm(column)), 1.0) else 0.0


def basis_of(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of the span of columns (m, k), judged column-normalised."""
    norms = np.linalg.norm(columns, axis=0)
    used = columns[:, norms > UNSEEN] / norms[norms > UNSEEN]
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    return np.asarray(left[:, singular >= RANK_LIMIT], dtype=np.float64)


class ColumnFit:
    """Least squares of residuals on some columns, and tests of one more."""

    def __init__(self, base: FloatArray, residuals: FloatArray) -> None:
        self.basis = basis_of(base)
        self.left = residuals - self.basis @ (self.basis.T @ residuals)
        self.squares = float(self.left @ self.left)
        self.spare = len(residuals) - self.basis.shape[1]

    @property
    def noise(self) -> float:
        """Of one datum; never so small that a prior would count for nothing."""
        return max(float(np.sqrt(self.squares / max(self.spare, 1))), 1e-4)

    def column(self, column: FloatArray) -> tuple[float, float, float]:
        """Amount, sigma and probability of one more column; probability 1 where it has none."""
        rest = column - self.basis @ (self.basis.T @ column)
        square = float(rest @ rest)
        if self.spare <= 1 or square <= (UNSEEN * max(float(np.linalg.norm(column)), 1.0)) ** 2:
            return 0.0, np.inf, 1.0
        amount = float(rest @ self.left) / square
        explained = amount * amount * square
        variance = max(self.squares - explained, 1e-300) / (self.spare - 1)
        return (
            amount,
            float(np.sqrt(variance / square)),
            f_probability(explained / variance, 1, self.spare - 1),
        )

    def group(self, indices: Sequence[int]) -> tuple[FloatArray, FloatArray, float]:
        """Shifts (2q,) of these points, the (2q, 2q) of their covariance per unit variance, p."""
        rows = np.array([2 * i + axis for i in indices for axis in (0, 1)])
        block = np.eye(len(rows)) - self.basis[rows] @ self.basis[rows].T
        if np.linalg.eigvalsh(block)[0] < UNSEEN or self.spare - len(rows) < 1:
            return np.zeros(len(rows)), np.full(block.shape, np.inf), 1.0
        covariance = np.linalg.inv(block)
        shift = covariance @ self.left[rows]
        explained = float(self.left[rows] @ shift)
        spare = self.spare - len(rows)
        variance = max(self.squares - explained, 1e-300) / spare
        p = f_probability(explained / len(rows) / variance, len(rows), spare)
        return shift, covariance * variance, p

    def single_points(self) -> FloatArray:
        """What ``group`` gives as probability for each point alone, (n,)."""
        left = self.left.reshape(-1, 2)
        basis = self.basis.reshape(len(left), 2, -1)
        probabilities = np.ones(len(left))
        spare = self.spare - 2
        if spare < 1:
            return probabilities
        # 1 - B B^T of two rows: [[a, b], [b, d]].
        a = 1.0 - np.einsum("nk,nk->n", basis[:, 0], basis[:, 0])
        d = 1.0 - np.einsum("nk,nk->n", basis[:, 1], basis[:, 1])
        b = -np.einsum("nk,nk->n", basis[:, 0], basis[:, 1])
        smallest = 0.5 * (a + d) - np.hypot(0.5 * (a - d), b)
        seen = smallest >= UNSEEN
        r1, r2 = left[seen].T
        a, b, d = a[seen], b[seen], d[seen]
        explained = (d * r1 * r1 - 2.0 * b * r1 * r2 + a * r2 * r2) / (a * d - b * b)
        variance = np.maximum(self.squares - explained, 1e-300) / spare
        probabilities[seen] = f_probabilities(explained / 2.0 / variance, 2, spare)
        return probabilities


def f_probability(f: float, over: int, under: int) -> float:
    """Chance of a larger F with these degrees of freedom."""
    return float(f_probabilities(np.asarray(f), over, under))


def f_probabilities(f: FloatArray, over: int, under: int) -> FloatArray:
    """The same for many."""
    # scipy takes long to import; it is not needed before there are points.
    from scipy.special import betainc

    return np.asarray(betainc(under / 2.0, over / 2.0, under / (under + over * f)))


def t_limit(level: float, spare: int) -> float:
    """|t| exceeded with this chance."""
    from scipy.special import stdtrit

    return float(stdtrit(spare, 1.0 - level / 2.0))
