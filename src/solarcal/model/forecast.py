"""How wrong will this tracker be over the year?

What is uploaded is known; the mechanism is known up to its posterior. Both together give the
angle between collector and Sun at every moment of the year's grid: the uncertainty of the
parameters, what the controller's first-order formula cannot follow, and the refraction and the
ephemeris it leaves out.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solarcal.model.mechanism_solution import MechanismSolution
from solarcal.model.methods import posterior_without_prior
from solarcal.model.prior import MechanismPosterior
from solarcal.model.sky_context import SkyContext
from solarcal.model.solution import Solution
from solarcal.model.unmodelled import CROSS_AXIS, widened, year_columns
from solarcal.model.year_grid import SLOTS, SunGrid, year_grid
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, correction_deg
from solarcal.mount.mechanism import Linearised
from solarcal.stopping_rule import DEFAULT_RULE, StoppingRule, Unmodelled, percent
from solarcal.units import FloatArray, wrap_deg

CROSS_AXIS_WORDS = ("collimation", "axes not square")
SHARE_WITHIN = 0.95
"""Of the year's moments: within the tolerance means that this share of them is."""
_MOST_DEG = 180.0
_ALL = slice(None)
_DRAWS_AT_ONCE = 32
"""Their errors stay in the processor's cache."""
_SAMPLE = 4096
_SAMPLE_MARGIN = 1.5
_SURE_DRAWS = 1024
_SURE_MOMENTS = 250
"""A probability of 0.95 is known to 0.007 with so many draws; a quarter of the moments is enough to
say whether 95 % of them are within the tolerance."""


@dataclass(frozen=True, eq=False, slots=True)
class SkyErrors:
    """Errors on sky of m draws from a posterior at g moments, made when they are asked for.

    All of them are half a million numbers, and new memory costs more than the arithmetic.
    ``known`` (2, g) of the mean, ``slopes`` (6, 2 g) of the mechanism, ``away`` (m, 6) the draws
    less the mean.
    """

    known: FloatArray
    slopes: FloatArray
    away: FloatArray

    def of(self, draws: slice = _ALL) -> FloatArray:
        """Cross and along error of these draws, (m, 2, g) degrees."""
        errors = self.away[draws] @ self.slopes
        np.subtract(self.known.reshape(-1), errors, out=errors)
        return errors.reshape(len(errors), 2, -1)


@dataclass(frozen=True, slots=True)
class LargeCrossAxis:
    """The draws in which an error, ``what``, is above ``above_deg``.

    They are ``share`` of the posterior, and ``within``, a part of them, is within the tolerance.
    """

    what: str
    above_deg: float
    share: float
    within: float


@dataclass(frozen=True, eq=False, slots=True)
class Forecast:
    """Expected error on sky, degrees.

    Attributes
    ----------
    year_rms_deg, year_p95_deg, year_max_deg : the contract's: root mean square over posterior and
        grid; 95th percentile over both together; 95 % posterior quantile of the largest of the
        year.
    parameters_rms_deg : the part of the year's rms that more or better points can remove.
    known_rms_deg : the part the formula, refraction and ephemeris leave although the mechanism were
        known.
    map_rms_deg : (days, 48), day by half hour of mean solar time; NaN where the Sun is low or out
        of reach.
    days_utc_s : (days,), mean solar midnights at which the rows begin.
    sample_rms_deg : (m,), year rms of each posterior draw.
    rule : the tolerance, and how sure one must be of it.
    probability_within_tolerance : posterior probability that this tracker's own 95th percentile
        over the grid is within the tolerance: what ``done`` is decided on.
    large_cross_axis : what a large collimation, and axes far from square, would make of that
        probability, each where the posterior holds it.
    posterior : what is known of the mechanism, for a ``robust`` fit with what may be there beside
        it.
    errors : cross and along error of each draw at each moment of ``grid``.
    """

    year_rms_deg: float
    year_p95_deg: float
    year_max_deg: float
    parameters_rms_deg: float
    known_rms_deg: float
    map_rms_deg: FloatArray
    days_utc_s: FloatArray
    sample_rms_deg: FloatArray
    rule: StoppingRule
    probability_within_tolerance: float
    large_cross_axis: tuple[LargeCrossAxis, ...]
    posterior: MechanismPosterior = field(repr=False)
    errors: "SkyErrors" = field(repr=False)
    grid: SunGrid = field(repr=False)

    @property
    def sure(self) -> bool:
        """Whether the stopping rule is met, as far as the forecast goes."""
        return self.probability_within_tolerance >= self.rule.probability

    @property
    def sure_words(self) -> str:
        """``90 % sure (95 % needed)``."""
        needed = self.rule.probability
        sure = percent(self.probability_within_tolerance, needed)
        return f"{sure} sure ({100.0 * needed:g} % needed)"

    def uploading(self, coefficients: Coefficients) -> "Forecast":
        """The same tracker's year with these coefficients uploaded: the same draws."""
        return forecast_of(self.posterior, coefficients, self.grid, rule=self.rule)

    @property
    def map_hours(self) -> FloatArray:
        """Mean solar hours of the map's columns, (48,)."""
        return np.arange(SLOTS) * 24.0 / SLOTS

    def year_rms_below_deg(self, probability: float) -> float:
        """The year's rms stays below this with the given probability."""
        return float(np.quantile(self.sample_rms_deg, probability))

    def as_json(self) -> dict[str, Any]:
        """The contract's keys and what they are made of; the map with null for no Sun."""
        return {
            "year_rms_deg": self.year_rms_deg,
            "year_p95_deg": self.year_p95_deg,
            "year_max_deg": self.year_max_deg,
            "probability_within_tolerance": self.probability_within_tolerance,
            "year_rms_68_deg": self.year_rms_below_deg(0.68),
            "year_rms_95_deg": self.year_rms_below_deg(0.95),
            "parameters_rms_deg": self.parameters_rms_deg,
            "known_rms_deg": self.known_rms_deg,
        }

    def map_json(self) -> dict[str, Any]:
        """The map, its days and hours, for ``solarcal forecast --json``."""
        return {
            "days_utc_s": self.days_utc_s.tolist(),
            "solar_hours": self.map_hours.tolist(),
            "rms_deg": [
                [None if np.isnan(cell) else cell for cell in row]
                for row in self.map_rms_deg.tolist()
            ],
        }


def forecast(
    solution: Solution,
    context: SkyContext | None = None,
    *,
    rule: StoppingRule = DEFAULT_RULE,
) -> Forecast:
    """The year's forecast for a solution of any method, its own numbers uploaded.

    Parameters
    ----------
    context : needed for ``linear``; the others carry theirs.
    rule : what is asked of the year, and what may be there beside the six numbers.

    Notes
    -----
    A ``linear`` solution knows no exact mechanism: it is judged by what its points alone say of
    one, without prior.
    """
    posterior, context = _knowledge(solution, context, rule.unmodelled)
    return forecast_of(posterior, solution.coefficients(), year_grid(context), rule=rule)


def _knowledge(
    solution: Solution, context: SkyContext | None, unmodelled: Unmodelled
) -> tuple[MechanismPosterior, SkyContext]:
    if isinstance(solution, MechanismSolution):
        if solution.method == "robust":
            return widened(solution, unmodelled), solution.context
        return solution.posterior, solution.context
    if context is None:
        context = SkyContext.for_points(solution.points, limits=solution.limits)
    return posterior_without_prior(solution.points, context), context


def forecast_of(
    posterior: MechanismPosterior,
    uploaded: Coefficients,
    grid: SunGrid,
    *,
    rule: StoppingRule = DEFAULT_RULE,
) -> Forecast:
    """What a mechanism known so far does over a grid with these coefficients uploaded."""
    known, slopes = known_and_slopes(posterior.mean, uploaded, grid)
    away = posterior.samples() - posterior.mean
    errors = SkyErrors(known, slopes.reshape(len(slopes), -1), away)
    square = np.empty((len(away), len(grid)))
    for low in range(0, len(away), _DRAWS_AT_ONCE):
        part = slice(low, low + _DRAWS_AT_ONCE)
        of_draws = errors.of(part)
        np.einsum("mag,mag->mg", of_draws, of_draws, out=square[part])
    largest = square.max(axis=1)
    if largest.max() > _MOST_DEG**2:
        np.minimum(square, _MOST_DEG**2, out=square)
        np.minimum(largest, _MOST_DEG**2, out=largest)
    of_moment = square.mean(axis=0)
    of_draw = square.mean(axis=1)
    known_square = float(np.mean(np.sum(known**2, axis=0)))
    drawn = posterior.samples(_SURE_DRAWS)
    within = _within(known, slopes, drawn - posterior.mean, rule.tolerance_deg)
    day_by_hour = np.full((len(grid.days_utc_s), SLOTS), np.nan)
    day_by_hour[grid.day, grid.slot] = np.sqrt(of_moment)
    return Forecast(
        year_rms_deg=float(np.sqrt(of_moment.mean())),
        year_p95_deg=float(np.sqrt(upper_quantile(square.reshape(-1), 0.95))),
        year_max_deg=float(np.sqrt(np.quantile(largest, 0.95))),
        parameters_rms_deg=float(np.sqrt(max(of_moment.mean() - known_square, 0.0))),
        known_rms_deg=float(np.sqrt(known_square)),
        map_rms_deg=day_by_hour,
        days_utc_s=grid.days_utc_s,
        sample_rms_deg=np.sqrt(of_draw),
        rule=rule,
        probability_within_tolerance=float(np.mean(within)),
        large_cross_axis=_with_large_cross_axis(drawn, within, rule.unmodelled),
        posterior=posterior,
        errors=errors,
        grid=grid,
    )


def _within(
    known: FloatArray, slopes: FloatArray, away: FloatArray, tolerance_deg: float
) -> NDArray[np.bool_]:
    """Which draws have their own 95th percentile over the grid within the tolerance, (m,).

    A percentile is below a limit where enough of the moments are: counting needs no sorting.
    """
    step = thinning(known.shape[1], _SURE_MOMENTS)
    part = SkyErrors(known[:, ::step].copy(), slopes[:, :, ::step].reshape(len(slopes), -1), away)
    held = np.empty(len(away), dtype=np.bool_)
    for low in range(0, len(away), 4 * _DRAWS_AT_ONCE):
        some = slice(low, low + 4 * _DRAWS_AT_ONCE)
        errors = part.of(some)
        square = np.einsum("mag,mag->mg", errors, errors)
        share = np.count_nonzero(square <= tolerance_deg**2, axis=1) / square.shape[1]
        held[some] = share >= SHARE_WITHIN
    return held


def _with_large_cross_axis(
    drawn: FloatArray, within: NDArray[np.bool_], unmodelled: Unmodelled
) -> tuple[LargeCrossAxis, ...]:
    above_deg = 0.5 * unmodelled.large_cross_axis_deg
    found = []
    for what, amounts in zip(CROSS_AXIS_WORDS, drawn.T[CROSS_AXIS], strict=False):
        large = np.abs(amounts) > above_deg
        if large.any():
            share = float(np.mean(large))
            found.append(LargeCrossAxis(what, above_deg, share, float(np.mean(within[large]))))
    return tuple(found)


def thinning(moments: int, wanted: int) -> int:
    """Every so many moments of a grid: odd, so that no hour of the day is favoured."""
    return max(1, moments // wanted) | 1


def upper_quantile(values: FloatArray, share: float) -> float:
    """The smallest of the values (n,) that at least this share of them does not exceed.

    Exactly; but a sample says first where to look, so that only the few values above are sorted.
    """
    rank = int(np.ceil(share * values.size)) - 1
    sample = values[:: max(1, values.size // _SAMPLE)]
    place = int((1.0 - _SAMPLE_MARGIN * (1.0 - share)) * (len(sample) - 1))
    high = values[values >= np.partition(sample, place)[place]]
    # Counted from the top; a sample that misled leaves all values to be looked at.
    from_top = values.size - rank
    if from_top > high.size:
        high = values
    return float(np.partition(high, high.size - from_top)[high.size - from_top])


def known_and_slopes(
    values: FloatArray, uploaded: Coefficients, grid: SunGrid, at: Linearised | None = None
) -> tuple[FloatArray, FloatArray]:
    """Sky error (2, g) of these coefficients on the mechanism of six numbers, and the slopes
    (6, 2, g) of the mechanism's own sky errors; with ``values`` of the amounts beside the six,
    theirs too (11, 2, g). ``at``: the mechanism over the grid, where it is computed already."""
    if len(values) > len(COEFFICIENT_NAMES):
        known, slopes = known_and_slopes(values[:6], uploaded, grid)
        columns = year_columns(values[:6], grid)
        known = known - np.einsum("m,mag->ag", values[6:], columns)
        return known, np.concatenate((slopes, columns))
    sun = grid.sun
    at = grid.linearised(values) if at is None else at
    driven = np.stack(correction_deg(uploaded, sun.ideal1_deg, sun.ideal2_deg))
    beside = driven - at.errors - grid.gap_deg
    beside[0] = wrap_deg(beside[0])
    return beside * at.sky, at.sky_slopes
