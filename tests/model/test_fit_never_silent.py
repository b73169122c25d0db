"""Whatever the numbers, a fit ends in one clear line or in a document of finite numbers."""

import json
import warnings

import numpy as np
import pytest

from solarcal.errors import FitError
from solarcal.model.fit import fit_linear
from solarcal.model.points import Points
from solarcal.model.terms import TERMS
from solarcal.mount.geometry import GEOMETRIES, AxisLimits, Limits, MountGeometry
from solarcal.units import FloatArray

LIMITS = Limits(AxisLimits(-130.0, 130.0), AxisLimits(0.0, 90.0))


def awkward(rng: np.random.Generator, n: int, low: float, high: float) -> FloatArray:
    """Columns of the kind that break fits: constant, on round angles, repeated."""
    match rng.integers(4):
        case 0:
            return np.full(n, rng.choice([low, high, (low + high) / 2.0, 90.0]))
        case 1:
            return np.round(rng.uniform(low, high, n) / 45.0) * 45.0
        case 2:
            return rng.choice(rng.uniform(low, high, n + 1), n)
        case _:
            return rng.uniform(low, high, n)


def awkward_points(rng: np.random.Generator, geometry: str) -> Points:
    n = int(rng.integers(0, 9))
    sigma = 10.0 ** rng.uniform(-9.0, 2.5, n)
    return Points(
        geometry=MountGeometry(geometry, rng.choice([-33.9, 0.0, 35.0, 90.0])),
        ax1_deg=awkward(rng, n, -180.0, 180.0),
        ax2_deg=awkward(rng, n, 0.0, 180.0),
        err1_deg=awkward(rng, n, -1.0, 1.0) * rng.choice([0.0, 1e-300, 1.0]),
        err2_deg=awkward(rng, n, -1.0, 1.0) * rng.choice([0.0, 1.0]),
        sigma_deg=sigma if rng.integers(2) else None,
    )


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_awkward_points_end_in_a_line_or_in_numbers(geometry: str) -> None:
    rng = np.random.default_rng(20)
    names = [
        name
        for name, term in TERMS.items()
        if term.only in (None, geometry) and term.rows is not None
    ]
    fitted, refusals = 0, []
    for _ in range(400):
        terms = [str(t) for t in rng.permutation(names)[: rng.integers(1, len(names) + 1)]]
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                solution = fit_linear(
                    awkward_points(rng, geometry),
                    terms,
                    limits=LIMITS if rng.integers(2) else None,
                )
                document = json.dumps(solution.as_json(), allow_nan=False)
        except FitError as error:
            refusals.append(str(error))
            continue
        fitted += 1
        assert document
        named = any(
            "cannot be separated" in sentence or "say nothing about" in sentence
            for sentence in solution.inseparable
        )
        assert named == (solution.rank < len(terms))
    assert fitted > 100
    assert len(refusals) > 100
    assert not any("\n" in line for line in refusals)
