"""Real telescope data: the two reference solutions, and katpoint's own fit of the same points."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from solarcal.model.fit import fit_linear
from solarcal.model.points import Points
from solarcal.mount.geometry import MountGeometry
from solarcal.units import wrap_deg

FOLDER = Path(__file__).parents[2].parent / "shared" / "data" / "tpoint"
JANUARY = "auxtel-2020-Jan-26-UTC-1-47-15.dat"
MARCH = "auxtel-2020-Mar-15-UTC-2-27-13.dat"


def observed(name: str, centre_deg: float = 0.0) -> Points:
    path = FOLDER / name
    if not path.exists():
        pytest.skip("the TPOINT reference files are not beside the project")
    rows = [line.split() for line in path.read_text().splitlines()]
    numbers = np.array([row for row in rows if len(row) == 5 and row[0][:1].isdigit()], dtype=float)
    az, el, az_enc, el_enc, _ = numbers.T
    geometry = MountGeometry("azel", -30.24, centre_deg)
    return Points(
        geometry=geometry,
        ax1_deg=geometry.branch(180.0 - az),
        ax2_deg=90.0 - el,
        err1_deg=wrap_deg(az - az_enc),
        err2_deg=el - el_enc,
    )


@pytest.mark.parametrize("centre_deg", [0.0, 180.0])
@pytest.mark.parametrize(
    ("name", "arcsec", "sky_rms_arcsec"),
    [
        (JANUARY, (-211.16, -255.55, 57.16, 67.42, -43.07), 17.41),
        (MARCH, (-239.22, -283.22, 45.30, 63.89, -49.75), 23.96),
    ],
)
def test_reference_solutions(
    name: str, arcsec: tuple[float, ...], sky_rms_arcsec: float, centre_deg: float
) -> None:
    solution = fit_linear(observed(name, centre_deg), ("IA", "IE", "AN", "AW", "CA"))
    # 0.01 arcsec, of which the two printed decimals take half.
    np.testing.assert_allclose(solution.values, arcsec, atol=0.0051)
    assert solution.sky_rms_deg * 3600.0 == pytest.approx(sky_rms_arcsec, abs=0.0051)
    assert solution.message is None
    assert solution.units == ("arcsec",) * 5


@pytest.mark.parametrize(
    ("terms", "sky_rms_arcsec"),
    [((), 29.1), (("C",), 19.7), (("N",), 19.6)],
)
def test_march_lacks_a_cross_axis_term(terms: tuple[str, ...], sky_rms_arcsec: float) -> None:
    solution = fit_linear(observed(MARCH), ("P1", "P2", "P3", "P4", "P5", "P6", *terms))
    assert solution.sky_rms_deg * 3600.0 == pytest.approx(sky_rms_arcsec, abs=0.06)


def test_march_cannot_tell_collimation_from_axes_not_square() -> None:
    solution = fit_linear(observed(MARCH), ("P1", "P2", "P3", "P4", "P5", "P6", "C", "N"))
    assert solution.correlations["C,N"] == pytest.approx(-0.99, abs=0.01)
    assert any(
        "collimation (C)" in sentence and "axes not square (N)" in sentence
        for sentence in solution.inseparable
    )


@pytest.mark.parametrize("name", [JANUARY, MARCH])
def test_six_terms_predict_what_katpoint_predicts(name: str) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        katpoint = pytest.importorskip("katpoint")
    points = observed(name)
    # katpoint weights azimuth by cos(elevation), our sin(AX2), and takes encoder minus true.
    az, el = np.radians(180.0 - points.ax1_deg), np.radians(90.0 - points.ax2_deg)
    model = katpoint.PointingModel()
    params, sigmas = model.fit(
        az,
        el,
        np.radians(-points.err1_deg),
        np.radians(-points.err2_deg),
        enabled_params=[1, 5, 6, 7, 9, 12],
        keep_disabled_params=True,
    )
    solution = fit_linear(points)
    ax1, ax2 = np.meshgrid(np.linspace(-175.0, 175.0, 29), np.linspace(5.0, 85.0, 17))
    delta_az, delta_el = model.offset(np.radians(180.0 - ax1), np.radians(90.0 - ax2))
    e1, e2 = solution.predict_deg(ax1, ax2)
    np.testing.assert_allclose(e1, -np.degrees(delta_az), atol=1e-6)
    np.testing.assert_allclose(e2, -np.degrees(delta_el), atol=1e-6)
    # Leans are the same parameter in both, so their sigmas can be compared one to one.
    assert solution.covariance is not None
    assert params[4] == pytest.approx(np.radians(solution.values[0]), abs=1e-12)
    unit_sigma = np.sqrt(np.diag(solution.least_squares.data_covariance))
    np.testing.assert_allclose(unit_sigma[[0, 2]], sigmas[[4, 5]], rtol=1e-9)
