"""Which causes the residuals ask for: F-tests, Holm's correction, one cause at a time.

The six numbers of the mechanism are fitted without prior (only what no six numbers can explain
counts), the noise is what is left over. Each cause is one column, each bad point two free numbers.
The most significant cause is taken into the model and the others are tested again beside it, at
Holm's levels: the chance that a clean day fires anything at all is 5 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

import numpy as np

from solarcal.model.extended_mechanism import ExtendedMechanism, Rows
from solarcal.model.prior import Prior
from solarcal.units import FloatArray

FAMILY_LEVEL = 0.05
NAME_LEVEL = 0.05
"""A cause that another one makes insignificant at this level cannot be told from it."""
POWER_QUANTILE = 1.2816
"""90 % power."""

_SPARE_NEEDED = 3
_RANK_LIMIT = 1e-6
_UNSEEN = 1e-9
_TURNS = 3
_MOST_BAD_SHARE = 0.25


@dataclass(frozen=True, slots=True)
class Cause:
    """A cause the residuals ask for.

    ``rivals``: causes that would make it insignificant, in the order of what they leave;
    ``leaves_deg``: sky rms with this cause, then with each rival instead; ``correlations`` with
    each rival when both are fitted.
    """

    name: str
    value: float
    sigma: float
    probability: float
    rivals: tuple[str, ...]
    leaves_deg: tuple[float, ...]
    correlations: tuple[float, ...]
    without_deg: float


@dataclass(frozen=True, slots=True)
class BadPoint:
    """Point ``index``, off on sky by ``sky_deg`` +- ``sigma_deg`` from what the others say."""

    index: int
    sky_deg: float
    sigma_deg: float
    rms_with_deg: float
    rms_without_deg: float
    step: FloatArray
    """(6,): how leaving it out moves the six numbers."""


@dataclass(frozen=True, eq=False, slots=True)
class ResidualTests:
    """``weakest``: the smallest amount of each cause not found that would be, nine times in ten."""

    causes: tuple[Cause, ...]
    bad: tuple[BadPoint, ...]
    weakest: dict[str, float]
    values: FloatArray
    noise_deg: float | None


def run_residual_tests(
    model: ExtendedMechanism,
    values: FloatArray,
    prior: Prior,
    *,
    suspects: Sequence[int] = (),
    noise_deg: float | None = None,
) -> ResidualTests:
    """Test every cause and every point.

    Parameters
    ----------
    values : (6,)
        The fitted mechanism, about which everything is linearised.
    prior
        Its sigmas are the units in which the place moves when a cause is taken in.
    suspects
        Points to be tested together: bad ones can hide each other.
    noise_deg
        For ``weakest``; default what is left over.
    """
    search = _Search(model, values, prior, tuple(suspects))
    search.run()
    return search.concluded(noise_deg)


def cause_sigmas(rows: Rows, noise_deg: float) -> dict[str, float]:
    """One sigma of each cause alone beside the six numbers; infinite where it has no effect."""
    return {
        name: noise_deg / norm if (norm := _norm_beside(rows.six, column)) > 0.0 else np.inf
        for name, column in rows.causes.items()
    }


def _norm_beside(base: FloatArray, column: FloatArray) -> float:
    basis = _basis(base)
    rest = column - basis @ (basis.T @ column)
    norm = float(np.linalg.norm(rest))
    return norm if norm > _UNSEEN * max(float(np.linalg.norm(column)), 1.0) else 0.0


def _basis(columns: FloatArray) -> FloatArray:
    """Orthonormal basis of the span of columns (m, k), judged column-normalised."""
    norms = np.linalg.norm(columns, axis=0)
    used = columns[:, norms > _UNSEEN] / norms[norms > _UNSEEN]
    left, singular, _ = np.linalg.svd(used, full_matrices=False)
    basis: FloatArray = left[:, singular >= _RANK_LIMIT]
    return basis


class _Fit:
    """Least squares of residuals on some columns, and tests of one more."""

    def __init__(self, base: FloatArray, residuals: FloatArray) -> None:
        self.basis = _basis(base)
        self.left = residuals - self.basis @ (self.basis.T @ residuals)
        self.squares = float(self.left @ self.left)
        self.spare = len(residuals) - self.basis.shape[1]

    def column(self, column: FloatArray) -> tuple[float, float, float]:
        """Amount, sigma and probability of one more column; probability 1 where it has none."""
        rest = column - self.basis @ (self.basis.T @ column)
        square = float(rest @ rest)
        if self.spare <= 1 or square <= (_UNSEEN * max(float(np.linalg.norm(column)), 1.0)) ** 2:
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
        if np.linalg.eigvalsh(block)[0] < _UNSEEN or self.spare - len(rows) < 1:
            return np.zeros(len(rows)), np.full(block.shape, np.inf), 1.0
        covariance = np.linalg.inv(block)
        shift = covariance @ self.left[rows]
        explained = float(self.left[rows] @ shift)
        spare = self.spare - len(rows)
        variance = max(self.squares - explained, 1e-300) / spare
        p = f_probability(explained / len(rows) / variance, len(rows), spare)
        return shift, covariance * variance, p


def f_probability(f: float, over: int, under: int) -> float:
    """Chance of a larger F with these degrees of freedom."""
    # scipy takes long to import; nobody waits for it before there are points.
    from scipy.special import betainc

    return float(betainc(under / 2.0, over / 2.0, under / (under + over * f)))


def t_limit(level: float, spare: int) -> float:
    """|t| exceeded with this chance."""
    from scipy.special import stdtrit

    return float(stdtrit(spare, 1.0 - level / 2.0))


class _Search:
    def __init__(
        self,
        model: ExtendedMechanism,
        values: FloatArray,
        prior: Prior,
        suspects: tuple[int, ...],
    ) -> None:
        self.model = model
        self.values = values
        self.unit = prior.sigma_array()
        self.suspects = suspects
        self.amounts: dict[str, float] = {}
        self.bad: list[int] = []
        self.rows = model.rows(values, {})
        self.family = len(self.rows.causes) + 1

    def run(self) -> None:
        n = len(self.model.points)
        while True:
            fit = self._fit()
            if fit.spare < _SPARE_NEEDED:
                return
            level = FAMILY_LEVEL / max(self.family - len(self.amounts) - bool(self.bad), 1)
            best: tuple[float, str | tuple[int, ...]] = (1.0, ())
            for name in self.rows.causes:
                if name not in self.amounts:
                    p = fit.column(self._kept(self.rows.causes[name]))[2]
                    best = min(best, (p, name), key=_first)
            room = int(_MOST_BAD_SHARE * n) - len(self.bad)
            for chosen, p in self._point_tests(fit, room):
                best = min(best, (p, chosen), key=_first)
            if best[0] > level or not best[1]:
                return
            if isinstance(best[1], str):
                self.amounts[best[1]] = 0.0
            else:
                self.bad.extend(best[1])
            self._move()

    def _point_tests(self, fit: _Fit, room: int) -> list[tuple[tuple[int, ...], float]]:
        """Every point, and the suspects together; probabilities corrected for the choice."""
        kept = self._kept_points()
        n = len(kept)
        tests: list[tuple[tuple[int, ...], float]] = []
        if room >= 1:
            tests = [((i,), n * fit.group((at,))[2]) for at, i in enumerate(kept)]
        together = tuple(i for i in self.suspects if i not in self.bad)
        if 1 < len(together) <= room:
            places = [kept.index(i) for i in together]
            tests.append((together, comb(n, len(together)) * fit.group(places)[2]))
        return tests

    def _kept_points(self) -> list[int]:
        return [i for i in range(len(self.model.points)) if i not in self.bad]

    def _kept(self, column: FloatArray) -> FloatArray:
        pairs: FloatArray = column.reshape(len(self.model.points), 2, -1)[self._kept_points()]
        return pairs.reshape(-1, *column.shape[1:])

    def _base(self, *, names: Sequence[str]) -> FloatArray:
        return np.column_stack((self.rows.six, *(self.rows.causes[name] for name in names)))

    def _fit(self, names: Sequence[str] | None = None) -> _Fit:
        """With these causes in the model; their present amounts count as not yet explained."""
        chosen = tuple(self.amounts) if names is None else tuple(names)
        return _Fit(self._kept(self._base(names=chosen)), self._kept(self._open_residuals()))

    def _open_residuals(self) -> FloatArray:
        taken = [amount * self.rows.causes[name] for name, amount in self.amounts.items()]
        return self.rows.residuals + sum(taken, np.zeros_like(self.rows.residuals))

    def _move(self) -> None:
        """To the fit with what has been taken in, the prior holding what the points leave open."""
        for _ in range(_TURNS):
            fit = self._fit()
            noise = max(np.sqrt(fit.squares / max(fit.spare, 1)), 1e-4)
            step = self._step(tuple(self.amounts), self._kept_points(), noise)
            self.values = self.values + step[:6]
            self.amounts = {
                name: float(amount)
                for name, amount in zip(self.amounts, step[6:], strict=True)
            }
            self.rows = self.model.rows(self.values, self.amounts)

    def _step(self, names: Sequence[str], kept: Sequence[int], noise: float) -> FloatArray:
        """Of the six numbers from their place, and the full amounts of these causes."""
        n = len(self.model.points)
        base = self._base(names=names).reshape(n, 2, -1)[kept].reshape(2 * len(kept), -1)
        residuals = self._open_residuals().reshape(n, 2)[kept].reshape(-1)
        precision = np.concatenate(((noise / self.unit) ** 2, np.full(len(names), 1e-12)))
        step: FloatArray = np.linalg.solve(base.T @ base + np.diag(precision), base.T @ residuals)
        return step

    def concluded(self, noise_deg: float | None) -> ResidualTests:
        fit = self._fit()
        spare = fit.spare
        noise = float(np.sqrt(fit.squares / spare)) if spare > 0 else None
        taken = self._taken_together() if spare >= _SPARE_NEEDED else []
        said = noise_deg if noise_deg is not None else noise
        weakest: dict[str, float] = {}
        if said is not None and spare >= _SPARE_NEEDED:
            factor = t_limit(FAMILY_LEVEL / self.family, spare - 1) + POWER_QUANTILE
            told = {name for cause in taken for name in (cause.name, *cause.rivals)}
            base = self._kept(self._base(names=tuple(self.amounts)))
            for name, column in self.rows.causes.items():
                if name not in told:
                    norm = _norm_beside(base, self._kept(column))
                    weakest[name] = factor * said / norm if norm > 0.0 else np.inf
        else:
            weakest = dict.fromkeys(self.rows.causes, np.inf)
        return ResidualTests(
            causes=tuple(taken),
            bad=tuple(self._bad_point(i) for i in sorted(self.bad)),
            weakest=weakest,
            values=self.values,
            noise_deg=noise,
        )

    def _taken_together(self) -> list[Cause]:
        causes = []
        for name in self.amounts:
            others = [other for other in self.amounts if other != name]
            column = self._kept(self.rows.causes[name])
            alone = self._fit(others)
            value, sigma, p = alone.column(column)
            rivals: list[tuple[float, str, float]] = []
            for rival, effect in self.rows.causes.items():
                if rival in self.amounts:
                    continue
                beside = self._fit([*others, rival])
                if beside.column(column)[2] > NAME_LEVEL:
                    r = self._correlation(others, column, self._kept(effect))
                    rivals.append((self._rms(beside.left), rival, r))
            rivals.sort()
            causes.append(
                Cause(
                    name=name,
                    value=value,
                    sigma=sigma,
                    probability=p,
                    rivals=tuple(rival for _, rival, _ in rivals),
                    leaves_deg=(self._rms(self._fit().left), *(rms for rms, _, _ in rivals)),
                    correlations=tuple(r for _, _, r in rivals),
                    without_deg=self._rms(alone.left),
                )
            )
        return causes

    def _correlation(self, others: Sequence[str], one: FloatArray, two: FloatArray) -> float:
        """Of two causes' estimates when both are fitted."""
        basis = _basis(self._kept(self._base(names=others)))
        a, b = (column - basis @ (basis.T @ column) for column in (one, two))
        return float(-(a @ b) / np.sqrt((a @ a) * (b @ b)))

    def _rms(self, left: FloatArray) -> float:
        """On sky, of the points that are not bad."""
        kept = self._kept_points()
        sky = left.reshape(-1, 2) / self.model.weights[kept, np.newaxis]
        return float(np.sqrt(np.mean(np.sum(sky**2, axis=1))))

    def _bad_point(self, index: int) -> BadPoint:
        """Against all others but the other bad ones."""
        others_bad, self.bad = self.bad, [i for i in self.bad if i != index]
        kept = self._kept_points()
        fit = self._fit()
        shift, covariance, _ = fit.group((kept.index(index),))
        size = float(np.hypot(*shift)) / float(self.model.weights[index])
        ways = np.linalg.solve(covariance, shift)
        # So that size / sigma is the studentised distance, both axes together.
        sigma = size / float(np.sqrt(max(shift @ ways, 1e-300)))
        with_rms = self._rms(fit.left)
        noise = max(np.sqrt(fit.squares / max(fit.spare, 1)), 1e-4)
        names = tuple(self.amounts)
        before = self._step(names, kept, noise)[:6]
        after = self._step(names, [i for i in kept if i != index], noise)[:6]
        self.bad = others_bad
        return BadPoint(
            index=index,
            sky_deg=size,
            sigma_deg=sigma,
            rms_with_deg=with_rms,
            rms_without_deg=self._rms(self._fit().left),
            step=after - before,
        )


def _first(test: tuple[float, str | tuple[int, ...]]) -> float:
    return test[0]
