"""Which causes the residuals ask for: F-tests, Holm's correction, one cause at a time.

The six numbers of the mechanism are fitted without prior (only what no six numbers can explain
counts), the noise is what is left over. Each cause is one column, each bad point two free numbers.
The most significant cause is taken into the model and the others are tested again beside it, at
Holm's levels: the chance that a clean day fires anything at all is 5 %.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import comb

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.f_tests import (
    FAMILY_LEVEL,
    POWER_QUANTILE,
    ColumnFit,
    PointsTested,
    Rows,
    basis_of,
    norms_beside,
    t_limit,
)
from solarcal.model.least_squares import solution_of
from solarcal.model.prior import Prior
from solarcal.model.terms import TERMS, occurs
from solarcal.units import FloatArray

SURE_LEVEL = 5e-5
"""A cause is separated from its rival when it is needed beside it at this level: a name
sends a person to a bolt, and a wrong one to the wrong bolt."""
LARGE_LEVEL = 0.03
"""Enough for an effect so large that it will be looked at anyway."""
NATURAL_ODDS = 100.0
"""Up to this factor of probabilities a cause is preferred to an unnatural amount of another."""
RIVAL_SHARE = 0.5
"""A rival explains at least this part of what the cause explains."""

_SPARE_NEEDED = 3
_TURNS = 3
_MOST_BAD_SHARE = 0.25


@dataclass(frozen=True, slots=True)
class Cause:
    """A cause the residuals ask for.

    ``value``, ``sigma``: beside all others found. ``rivals``: causes that would make it
    insignificant, in the order of what they leave; ``leaves_deg``: sky rms with this cause, then
    with each rival instead, beside what was found before it; ``without_deg``: with none of them;
    ``correlations`` with each rival when both are fitted.
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
    """``weakest``: the smallest amount of each cause not found that would be, nine times in ten;
    ``unnatural``: the cause that explains what is left best, in an amount that nature has not."""

    causes: tuple[Cause, ...]
    bad: tuple[BadPoint, ...]
    weakest: dict[str, float]
    unnatural: Cause | None = None


def run_residual_tests(
    model: PointsTested,
    rows: Rows,
    values: FloatArray,
    prior: Prior,
    *,
    suspects: Sequence[int],
    noise_deg: float,
) -> ResidualTests:
    """Test every cause and every point.

    Parameters
    ----------
    rows, values : (6,), the points about the fitted mechanism, and that mechanism.
    prior : its sigmas are the units in which the place moves when a cause is taken in.
    suspects : points to be tested together: bad ones can hide each other.
    noise_deg : for ``weakest``.
    """
    search = _Search(model, rows, values, prior, tuple(suspects))
    search.run()
    return search.concluded(noise_deg)


class _Search:
    def __init__(
        self,
        model: PointsTested,
        rows: Rows,
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
        self.left_then: dict[str, tuple[float, dict[str, float]]] = {}
        self.refused: set[str] = set()
        self.unnatural: Cause | None = None
        self.rows = rows
        self.family = len(self.rows.causes) + 1
        self.count = len(self.model.points)

    def run(self) -> None:
        while True:
            fit = self._fit()
            if fit.spare < _SPARE_NEEDED:
                return
            level = FAMILY_LEVEL / max(self.family - len(self.amounts) - bool(self.bad), 1)
            room = int(_MOST_BAD_SHARE * self.count) - len(self.bad)
            others = [name for name in self.rows.causes if name not in self.amounts]
            each = list(self._each(fit, others))
            best = min((one for one in each if not occurs(*one[1:])), default=(1.0, "", 0.0, 0.0))
            tests: list[tuple[float, str | tuple[int, ...]]] = [
                one[:2] for one in each if occurs(*one[1:]) and one[1] not in self.refused
            ]
            tests += [(p, chosen) for chosen, p in self._point_tests(fit, room)]
            p, taken = min(tests, key=lambda test: test[0], default=(1.0, ""))
            if p > level or NATURAL_ODDS * best[0] < p:
                if best[0] <= level:
                    leaves = self._rms(self._fit([*self.amounts, best[1]]).left)
                    without = self._rms(fit.left)
                    self.unnatural = Cause(*best[1:], best[0], (), (leaves,), (), without)
                return
            if isinstance(taken, str):
                # As it stood then: what is found later must not change what this one explained.
                instead = {
                    name: self._rms(self._fit([*self.amounts, name]).left) for name in others
                }
                self.left_then[taken] = (self._rms(fit.left), instead)
                self.amounts[taken] = 0.0
            else:
                self.bad.extend(taken)
            self._move()
            self._refuse_what_vanished()

    def _each(
        self, fit: ColumnFit, names: Sequence[str]
    ) -> Iterator[tuple[float, str, float, float]]:
        """Probability, name, amount and sigma of each, alone beside what is in the fit."""
        amounts, sigmas, p = map(np.ndarray.tolist, fit.each(self._columns(names)))
        yield from zip(p, names, amounts, sigmas, strict=True)

    def _refuse_what_vanished(self) -> None:
        """Begin again from here without a cause that beside the others is none, or not natural."""
        for name in self.amounts:
            alone = self._fit([other for other in self.amounts if other != name])
            ((p, _, value, sigma),) = self._each(alone, [name])
            if p > FAMILY_LEVEL / self.family or not occurs(name, value, sigma):
                self.refused.add(name)
                self.amounts, self.bad, self.left_then = {}, [], {}
                with suppress(ConfigurationError):
                    self.rows = self.model.rows(self.values, {})
                return

    def _point_tests(self, fit: ColumnFit, room: int) -> list[tuple[tuple[int, ...], float]]:
        """Every point, and the suspects together; probabilities corrected for the choice."""
        kept = self._kept_points()
        n = len(kept)
        tests: list[tuple[tuple[int, ...], float]] = []
        if room >= 1:
            alone = (n * fit.single_points()).tolist()
            tests = [((i,), p) for i, p in zip(kept, alone, strict=True)]
        together = tuple(i for i in self.suspects if i not in self.bad)
        if 1 < len(together) <= room:
            places = [kept.index(i) for i in together]
            tests.append((together, comb(n, len(together)) * fit.group(places)[2]))
        return tests

    def _kept_points(self) -> list[int]:
        bad = set(self.bad)
        return [i for i in range(self.count) if i not in bad]

    def _kept(self, rows: FloatArray) -> FloatArray:
        kept = np.ones(self.count, dtype=np.bool_)
        kept[self.bad] = False
        return rows[np.repeat(kept, 2)]

    def _columns(self, names: Sequence[str]) -> FloatArray:
        """Of these causes at the points that are not bad."""
        return self._kept(self.rows.columns(names))

    def _base(self, *, names: Sequence[str]) -> FloatArray:
        return np.column_stack((self.rows.six, self.rows.columns(names)))

    def _fit(self, names: Sequence[str] | None = None) -> ColumnFit:
        """With these causes in the model; their present amounts count as not yet explained."""
        chosen = tuple(self.amounts) if names is None else tuple(names)
        return ColumnFit(self._kept(self._base(names=chosen)), self._kept(self._open_residuals()))

    def _open_residuals(self) -> FloatArray:
        taken = [amount * self.rows.causes[name] for name, amount in self.amounts.items()]
        return self.rows.residuals + sum(taken, np.zeros_like(self.rows.residuals))

    def _move(self) -> None:
        """To the fit with what has been taken in, the prior holding what the points leave open."""
        for _ in range(_TURNS):
            fit = self._fit()
            noise = fit.noise
            step = self._step(tuple(self.amounts), self._kept_points(), noise)
            values = self.values + step[:6]
            amounts = {
                name: float(amount) for name, amount in zip(self.amounts, step[6:], strict=True)
            }
            try:
                self.rows = self.model.rows(values, amounts)
            except ConfigurationError:
                # A mechanism so bent reaches not every point: the linear answer has to do.
                return
            self.values, self.amounts = values, amounts

    def _step(self, names: Sequence[str], kept: Sequence[int], noise: float) -> FloatArray:
        """Of the six numbers from their place, and the full amounts of these causes."""
        n = self.count
        base = self._base(names=names).reshape(n, 2, -1)[kept].reshape(2 * len(kept), -1)
        residuals = self._open_residuals().reshape(n, 2)[kept].reshape(-1)
        precision = np.concatenate(((noise / self.unit) ** 2, np.full(len(names), 1e-12)))
        normal = base.T @ base + np.diag(precision)
        return solution_of(normal, base.T @ residuals)

    def concluded(self, noise_deg: float) -> ResidualTests:
        spare = self._fit().spare
        taken: list[Cause] = []
        weakest = dict.fromkeys(self.rows.causes, np.inf)
        if spare >= _SPARE_NEEDED:
            taken = self._taken_together()
            factor = t_limit(FAMILY_LEVEL / self.family, spare - 1) + POWER_QUANTILE
            told = {name for cause in taken for name in (cause.name, *cause.rivals)}
            base = self._kept(self._base(names=tuple(self.amounts)))
            names = [name for name in self.rows.causes if name not in told]
            norms = norms_beside(base, self._columns(names)).tolist()
            weakest = {
                name: factor * noise_deg / norm if norm > 0.0 else np.inf
                for name, norm in zip(names, norms, strict=True)
            }
        return ResidualTests(
            causes=tuple(taken),
            bad=tuple(self._bad_point(i) for i in sorted(self.bad)),
            weakest=weakest,
            unnatural=self.unnatural,
        )

    def _taken_together(self) -> list[Cause]:
        causes = []
        for name in self.amounts:
            others = [other for other in self.amounts if other != name]
            alone, together = self._fit(others), self._fit()
            column = self._columns([name])
            ((p, _, value, sigma),) = self._each(alone, [name])
            tested = TERMS[name].tested
            large = tested is not None and abs(value) >= tested.large
            level = LARGE_LEVEL if large else SURE_LEVEL
            explained = alone.squares - together.squares
            rivals = []
            for rival in self.rows.causes:
                beside = self._fit([*others, rival])
                ((_, _, amount, spread),) = self._each(alone, [rival])
                if (
                    rival not in self.amounts
                    and occurs(rival, amount, spread)
                    and alone.squares - beside.squares >= RIVAL_SHARE * explained
                    and beside.each(column)[2][0] > level
                ):
                    r = self._correlation(others, (name, rival))
                    rivals.append((beside.squares, rival, r))
            rivals.sort()
            names = tuple(rival for _, rival, _ in rivals)
            without, instead = self.left_then[name]
            causes.append(
                Cause(
                    name=name,
                    value=value,
                    sigma=sigma,
                    probability=p,
                    rivals=names,
                    leaves_deg=tuple(instead[one] for one in (name, *names)),
                    correlations=tuple(r for _, _, r in rivals),
                    without_deg=without,
                )
            )
        return causes

    def _correlation(self, others: Sequence[str], two: tuple[str, str]) -> float:
        """Of two causes' estimates when both are fitted."""
        basis, columns = basis_of(self._kept(self._base(names=others))), self._columns(two)
        a, b = (columns - basis @ (basis.T @ columns)).T
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
        sigma = size / float(np.sqrt(max(float(shift @ ways), 1e-300)))
        with_rms = self._rms(fit.left)
        noise = fit.noise
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
