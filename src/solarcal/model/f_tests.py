"""Points about a mechanism as columns; least squares on some, and F-tests of more.

References
----------
Cook and Weisberg (1982), Residuals and Influence in Regression, ch. 2: a point set free as two
columns of its own. Draper and Smith (1998), Applied Regression Analysis, ch. 6: the extra sum of
squares.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc, stdtrit

from solarcal.errors import ConfigurationError
from solarcal.model.least_squares import RANK_LIMIT
from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext, TruePoints, true_points
from solarcal.model.terms import TERMS, NativeAngles, Term, design_matrix, terms_tested
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.mechanism import Circumstances, Mechanism
from solarcal.units import FloatArray, wrap_deg

UNSEEN = 1e-9
"""A column this small is the rounding of another."""
NO_SQUARES = 1e-200
"""In the place of squares that vanish, so that quotients by them stay finite."""
FAMILY_LEVEL = 0.05
"""Of a family of tests together, Holm-corrected."""
POWER_QUANTILE = 1.2816
"""90 % power."""
SIDES_NEEDED = 2
"""Points that came from either side, before backlash is anything but a bad point."""


@dataclass(frozen=True, eq=False, slots=True)
class Rows:
    """Linearisation on sky, in units of the points' relative noise; rows alternate between axes.

    ``residuals`` (2n,) measured minus computed; ``six`` (2n, 6); ``causes`` name -> (2n,).
    """

    residuals: FloatArray
    six: FloatArray
    causes: dict[str, FloatArray]

    def columns(self, names: Iterable[str]) -> FloatArray:
        """Of these causes, (2n, q)."""
        return np.array([self.causes[name] for name in names]).reshape(-1, len(self.residuals)).T


@dataclass(frozen=True, eq=False, slots=True)
class PointsTested:
    """Points of one mount against a mechanism that may have more wrong with it than six numbers.

    Every tested term of ``model.terms`` has its exact effect at the fitted lean: near the zenith a
    degree of lean changes what a collimation error does by more than the noise. ``seen`` the
    points from the true Sun; ``weights`` (n,) one over the relative noise; ``terms``: what they
    can be tested for, backlash only where an axis came from both sides.
    """

    points: Points
    seen: TruePoints
    circumstances: Circumstances
    weights: FloatArray
    terms: tuple[Term, ...]

    @classmethod
    def of(
        cls,
        points: Points,
        context: SkyContext,
        approach: NDArray[np.int_] | None = None,
        seen: TruePoints | None = None,
    ) -> "PointsTested":
        """``approach`` (n, 2): sense of the last motion of each axis, +1, -1 or 0 (unknown);
        ``seen``: the points from the true Sun, where they are looked at already."""
        n = len(points)
        weights = np.ones(n)
        if points.sigma_deg is not None:
            weights = np.exp(np.mean(np.log(points.sigma_deg))) / points.sigma_deg
        sides = np.zeros((n, 2), dtype=np.int_) if approach is None else np.asarray(approach)
        terms = tuple(
            term
            for term in terms_tested(points.geometry.name)
            if term.tested is not None and _told(sides, term.tested.both_sides_of)
        )
        seen = true_points(points, context) if seen is None else seen
        circumstances = Circumstances(sides.T, context.lifted(seen.ax1_deg, seen.ax2_deg))
        return cls(points, seen, circumstances, weights, terms)

    def rows(self, values: FloatArray, amounts: Mapping[str, float]) -> Rows:
        """Linearise about six numbers (6,) and amounts of tested terms.

        ConfigurationError where no mechanism has such amounts, or does not reach every point.
        """
        exact: dict[str, float] = {}
        for name, amount in amounts.items():
            term = TERMS[name]
            if term.tested is not None and abs(amount) > term.tested.largest:
                raise ConfigurationError(f"no mechanism has {name} = {amount:g}")
            if term.exact is not None:
                exact[term.exact] = amount
        geometry, ax1, ax2 = self.points.geometry, self.seen.ax1_deg, self.seen.ax2_deg
        bent = [term for term in self.terms if term.exact is not None]
        plain = [term for term in self.terms if term.exact is None]
        names = (*COEFFICIENT_NAMES, *(term.exact for term in bent if term.exact is not None))
        at = Mechanism.linearised(values, geometry, ax1, ax2, names, self.circumstances, **exact)
        design = design_matrix(plain, NativeAngles.at(geometry, ax1, ax2))
        more = np.array([amounts.get(term.name, 0.0) for term in plain])
        left = np.stack((self.seen.err1_deg, self.seen.err2_deg)) - at.errors
        left -= np.einsum("k,kan->an", more, design)
        left[0] = wrap_deg(left[0])
        scale = at.sky * self.weights

        def flat(axes: FloatArray) -> FloatArray:
            return (axes * scale).T.reshape(-1)

        columns = [flat(slope) for slope in at.slopes]
        called = [term.name for term in (*bent, *plain)]
        effects = dict(zip(called, (*columns[6:], *map(flat, design)), strict=True))
        return Rows(
            flat(left),
            np.column_stack(columns[:6]),
            {term.name: effects[term.name] for term in self.terms},
        )


def _told(approach: NDArray[np.int_], axis: int | None) -> bool:
    if axis is None:
        return True
    sides = [int(np.count_nonzero(approach[:, axis - 1] == way)) for way in (1, -1)]
    return min(sides) >= SIDES_NEEDED


def norms_beside(base: FloatArray, columns: FloatArray) -> FloatArray:
    """Length of the part of each column (m, q) that columns (m, k) do not hold, (q,); 0 where
    rounding."""
    basis = basis_of(base)
    norms = np.linalg.norm(columns - basis @ (basis.T @ columns), axis=0)
    least = UNSEEN * np.maximum(np.linalg.norm(columns, axis=0), 1.0)
    return np.where(norms > least, norms, 0.0)


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

    def each(self, columns: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Amounts, sigmas and probabilities (q,) of one more column, of each of (m, q) alone;
        probability 1 where it has none."""
        rest = columns - self.basis @ (self.basis.T @ columns)
        squares = np.einsum("mq,mq->q", rest, rest)
        seen = squares > (UNSEEN * np.maximum(np.linalg.norm(columns, axis=0), 1.0)) ** 2
        amounts = np.zeros(len(squares))
        sigmas, probabilities = np.full(len(squares), np.inf), np.ones(len(squares))
        if self.spare > 1:
            squares = squares[seen]
            amounts[seen] = rest[:, seen].T @ self.left / squares
            explained = amounts[seen] ** 2 * squares
            variance = np.maximum(self.squares - explained, NO_SQUARES) / (self.spare - 1)
            sigmas[seen] = np.sqrt(variance / squares)
            probabilities[seen] = f_probabilities(explained / variance, 1, self.spare - 1)
        return amounts, sigmas, probabilities

    def columns(self, columns: FloatArray) -> tuple[float, FloatArray]:
        """Probability and amounts (k,) of more columns (m, k) together; probability 1 of none."""
        rest = columns - self.basis @ (self.basis.T @ columns)
        seen = np.linalg.norm(rest, axis=0) > RANK_LIMIT * np.linalg.norm(columns, axis=0)
        basis = basis_of(rest[:, seen])
        amounts = np.zeros(columns.shape[1])
        over, spare = basis.shape[1], self.spare - basis.shape[1]
        if over == 0 or spare < 1:
            return 1.0, amounts
        explained = float(np.sum((basis.T @ self.left) ** 2))
        variance = max(self.squares - explained, NO_SQUARES) / spare
        amounts[seen] = np.linalg.lstsq(rest[:, seen], self.left, rcond=None)[0]
        return f_probability(explained / over / variance, over, spare), amounts

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
        variance = max(self.squares - explained, NO_SQUARES) / spare
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
        variance = np.maximum(self.squares - explained, NO_SQUARES) / spare
        probabilities[seen] = f_probabilities(explained / 2.0 / variance, 2, spare)
        return probabilities


def f_probability(f: float, over: int, under: int) -> float:
    """Chance of a larger F with these degrees of freedom."""
    return float(f_probabilities(np.asarray(f), over, under))


def f_probabilities(f: FloatArray, over: int, under: int) -> FloatArray:
    """The same for many; f is never below zero."""
    # scipy takes long to import; it is not needed before there are points.
    return np.asarray(betainc(under / 2.0, over / 2.0, under / (under + over * f)))


def t_limit(level: float, spare: int) -> float:
    """|t| exceeded with this chance."""
    return float(stdtrit(spare, 1.0 - level / 2.0))


SessionIndex = NDArray[np.intp]
"""(n,): the session each point belongs to."""

ZEROS, LEAN = (1, 3), (0, 2)

_SPARE_NEEDED = 3
_UNSEEN = 1e-9


def shift_columns(six: FloatArray, session: SessionIndex, which: Sequence[int]) -> FloatArray:
    """Columns (2n, (s - 1) q): these of the six numbers, free in every session but the last."""
    rows = np.repeat(session, 2)[:, np.newaxis]
    return np.hstack([six[:, list(which)] * (rows == k) for k in range(int(session.max()))])


def what_changed(
    points: Points, session: SessionIndex, context: SkyContext, values: FloatArray
) -> list[tuple[int, ...]]:
    """``ZEROS``, ``LEAN``, both or none, in the order found; about these six numbers (6,).

    A single bad point that explains more is left out first: it is no move.
    """
    rows = PointsTested.of(points, context).rows(values, {})
    n = len(points)
    kept = list(range(n))
    taken: list[tuple[int, ...]] = []
    most_bad = n // 4
    while True:
        at = np.array([2 * i + axis for i in kept for axis in (0, 1)])
        columns = [rows.six, *(shift_columns(rows.six, session, which) for which in taken)]
        base = np.hstack(columns)[at]
        fit = ColumnFit(base, rows.residuals[at])
        if fit.spare < _SPARE_NEEDED:
            return taken
        tests: list[tuple[float, tuple[int, ...] | int]] = []
        for which in (ZEROS, LEAN):
            if which not in taken:
                more = shift_columns(rows.six, session, which)[at]
                tests.append((fit.columns(more)[0], which))
        if n - len(kept) < most_bad:
            chances = [fit.group((place,))[2] for place in range(len(kept))]
            tests += [(len(kept) * p, i) for p, i in zip(chances, kept, strict=True)]
        p, best = min(tests, key=lambda test: test[0], default=(1.0, -1))
        if p > FAMILY_LEVEL / (3 - len(taken)):
            return taken
        if isinstance(best, tuple):
            taken.append(best)
        else:
            kept.remove(best)


def weakest_change_deg(points: Points, session: SessionIndex, solution: MechanismSolution) -> float:
    """The change of lean or zero, in its worst direction, that would show nine times in ten."""
    tested = PointsTested.of(points, solution.context, seen=solution.seen)
    rows = tested.rows(solution.posterior.mean, {})
    worst = 0.0
    for which in (ZEROS, LEAN):
        fit = ColumnFit(rows.six, rows.residuals)
        if fit.spare < _SPARE_NEEDED:
            return float("inf")
        more = shift_columns(rows.six, session, which)
        rest = more - fit.basis @ (fit.basis.T @ more)
        least = float(np.linalg.svd(rest, compute_uv=False)[-1])
        if least <= _UNSEEN:
            return float("inf")
        factor = t_limit(FAMILY_LEVEL / 2.0, fit.spare) + POWER_QUANTILE
        worst = max(worst, factor * solution.noise_deg / least)
    return worst
