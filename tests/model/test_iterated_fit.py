"""TPOINT terms fitted at the encoder places, as PMFIT does, and a published model beside them."""

import math
from pathlib import Path

import numpy as np
import pytest

from solarcal.errors import FitError
from solarcal.model.fit import PMFIT_TERMS, fit_iterated, fit_linear
from solarcal.model.points import Points
from solarcal.mount.geometry import MountGeometry
from solarcal.session.interchange.altaz import read_pmfit
from solarcal.session.interchange.tpoint_model import TpointModel, read_tpoint_model
from solarcal.station.published_model import compare_model, write_model

AZEL = MountGeometry("azel", -30.24)
ARCSEC = math.pi / 180.0 / 3600.0


def night(noise_arcsec: float = 2.0) -> tuple[Points, list[tuple[float, float, float, float]]]:
    """Forty observations, one near the zenith; as points, and as azimuths and elevations."""
    generator = np.random.default_rng(87)
    azimuth = generator.uniform(0.0, 360.0, 40)
    elevation = np.append(generator.uniform(20.0, 80.0, 39), 87.0)
    a, e = np.radians(azimuth), np.radians(elevation)
    cross = 110 * np.cos(e) + 40 - 60 * np.sin(a) * np.sin(e) - 25 * np.cos(a) * np.sin(e)
    up = -380 - 60 * np.cos(a) + 25 * np.sin(a) - 30 * np.cos(e)
    cross, up = (part + generator.normal(0.0, noise_arcsec, 40) for part in (cross, up))
    encoder_azimuth = azimuth - cross / np.cos(e) / 3600.0
    encoder_elevation = elevation - up / 3600.0
    points = Points(
        geometry=AZEL,
        ax1_deg=180.0 - azimuth,
        ax2_deg=90.0 - elevation,
        err1_deg=azimuth - encoder_azimuth,
        err2_deg=elevation - encoder_elevation,
    )
    rows = np.column_stack((azimuth, elevation, encoder_azimuth, encoder_elevation))
    return points, [tuple(row) for row in rows.tolist()]


def basis(azimuth: float, elevation: float) -> list[tuple[float, float]]:
    """Left-right and up-down per unit of IA, IE, CA, AN, AW, TF; radians."""
    sa, ca, se, ce = math.sin(azimuth), math.cos(azimuth), math.sin(elevation), math.cos(elevation)
    return [(-ce, 0), (0, 1), (-1, 0), (-sa * se, -ca), (-ca * se, sa), (0, -ce)]


def normal_equations(
    rows: list[tuple[float, float, float, float]],
) -> tuple[list[float], list[float], float]:
    """Values, sigmas and sky sigma in arcsec, one observation after another, by the definition."""
    observed = [[math.radians(angle) for angle in row] for row in rows]
    model = np.zeros(6)

    def left(row: list[float]) -> tuple[float, float]:
        azimuth, elevation = row[2], row[3]
        for value, (cross, up) in zip(model, basis(row[2], row[3]), strict=True):
            azimuth += value * cross / math.cos(elevation)
            elevation += value * up
        return (row[0] - azimuth) * math.cos(row[1]), row[1] - elevation

    for _ in range(8):
        matrix, vector = np.zeros((6, 6)), np.zeros(6)
        for row in observed:
            x, y = left(row)
            terms = np.array(basis(row[0], row[1]))
            matrix += terms @ terms.T
            vector += terms @ (x, y)
        model = model + np.linalg.solve(matrix, vector)
    squares = sum(x * x + y * y for x, y in map(left, observed))
    variance = squares / (len(rows) - 6)
    sigmas = np.sqrt(variance * np.diag(np.linalg.inv(matrix)))
    return (
        list(model / ARCSEC),
        list(sigmas / ARCSEC),
        math.sqrt(variance) / ARCSEC,
    )


def test_the_iterated_fit_is_pmfits_to_the_printed_digit() -> None:
    points, rows = night()
    values, sigmas, sky = normal_equations(rows)
    solution = fit_iterated(points, PMFIT_TERMS)
    np.testing.assert_allclose(solution.values, values, atol=5e-5)
    assert solution.sigmas is not None
    np.testing.assert_allclose(solution.sigmas, sigmas, rtol=1e-6)
    assert solution.population_sd_deg is not None
    assert solution.population_sd_deg * 3600.0 == pytest.approx(sky, rel=1e-6)
    assert any("divide by n - k = 34" in note for note in solution.notes)


PUBLISHED = Path(__file__).with_name("published_pmfit_105.dat")
"""Observations of an 8 m telescope whose solution the documentation of PMFIT prints (P. T. Wallace,
SPK pointing kernel, 2023)."""
PRINTED = (
    ("-142.148", "4.378"), ("-117.293", "3.016"), ("+19.843", "3.022"),
    ("-23.758", "0.965"), ("+19.261", "0.960"), ("+279.752", "4.361"),
)  # fmt: skip


def test_the_published_solution_of_105_observations_comes_out_to_the_printed_digit() -> None:
    table = read_pmfit(PUBLISHED)
    points = Points(
        geometry=MountGeometry("azel", -30.240667, table.ax1_centre_deg),
        ax1_deg=table.ax1_deg,
        ax2_deg=table.ax2_deg,
        err1_deg=table.err1_deg,
        err2_deg=table.err2_deg,
    )
    solution = fit_iterated(points, PMFIT_TERMS)
    assert solution.sigmas is not None
    assert solution.population_sd_deg is not None
    assert [
        (f"{value:+.3f}", f"{sigma:.3f}")
        for value, sigma in zip(solution.values, solution.sigmas, strict=True)
    ] == list(PRINTED)
    assert f"{3600.0 * solution.population_sd_deg:.3f}" == "8.349"
    zeros = fit_iterated(points, ("IA", "IE")).population_sd_deg
    assert zeros is not None
    assert f"{3600.0 * zeros:.2f}" == "60.44"


def test_near_the_zenith_the_linear_fit_differs_in_tenths_of_an_arcsecond() -> None:
    points, _ = night(noise_arcsec=0.0)
    apart = fit_iterated(points, PMFIT_TERMS).values - fit_linear(points, PMFIT_TERMS).values
    assert 0.01 < np.abs(apart).max() < 3.0


def test_the_two_conventions_of_sigma_are_named() -> None:
    points, _ = night()
    linear = fit_linear(points, PMFIT_TERMS)
    assert any("2n - k = 74" in note for note in linear.notes)


@pytest.mark.parametrize(
    ("terms", "complaint"),
    [
        (("P1", "P2"), "is of TPOINT terms"),
        (("IA", "IE", "CA", "NPAE", "AN", "AW", "TF", "TX", "HESE", "HECE"), "cannot separate"),
        (("IA", "XX"), "no error term 'XX'"),
    ],
)
def test_what_it_does_not_fit(terms: tuple[str, ...], complaint: str) -> None:
    with pytest.raises(FitError, match=complaint):
        fit_iterated(night()[0], terms)


def test_as_many_points_as_terms_give_no_sigma_and_no_fit() -> None:
    with pytest.raises(FitError, match="needs more points than terms"):
        fit_iterated(night()[0].subset(range(6)), PMFIT_TERMS)


def test_a_published_model_is_judged_by_what_it_leaves() -> None:
    points, _ = night(noise_arcsec=0.0)
    solution = fit_linear(points, ("IA", "IE"))
    model = TpointModel(
        "published",
        "T",
        61,
        3.5,
        ("IA", "IE", "CA", "AN", "AW", "TF"),
        (-110.0, -380.0, -40.0, 60.0, 25.0, 30.0),
        (1.0, 1.0, None, 1.0, 1.0, 1.0),
    )
    comparison = compare_model(solution, model)
    assert comparison.sky_rms_deg * 3600.0 < 1e-6
    assert [row[0] for row in comparison.rows] == ["IA", "IE", "CA", "AN", "AW", "TF"]
    assert comparison.as_json()["terms"]["CA"] == {
        "unit": "arcsec",
        "published": -40.0,
        "published_sigma": None,
        "fitted": None,
        "fitted_sigma": None,
    }


def test_a_fit_is_written_as_a_model_with_its_scatter_and_read_again(tmp_path: Path) -> None:
    points, _ = night()
    solution = fit_iterated(points, PMFIT_TERMS)
    write_model(solution, [Path("night.dat"), Path("later.dat")], tmp_path / "fitted.mod")
    model = read_tpoint_model(tmp_path / "fitted.mod")
    assert model.caption == "night.dat, later.dat"
    assert (model.observations, model.names) == (len(points), PMFIT_TERMS)
    assert model.sky_rms_arcsec == pytest.approx(solution.sky_rms_deg * 3600.0, abs=0.01)
    assert model.values == pytest.approx(tuple(solution.values), abs=0.01)
