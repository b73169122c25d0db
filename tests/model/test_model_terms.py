"""The registry of error terms: what one unit of each does to the axes."""

import numpy as np
import pytest
from calibration_days import design_of

from solarcal.errors import FitError
from solarcal.model.evidence.residuals import diagnose
from solarcal.model.fit import chosen_terms, fit_linear, harmonic
from solarcal.model.methods import fit
from solarcal.model.points import Points
from solarcal.model.sky_context import SkyContext
from solarcal.model.terms import TERMS, LookedFor, Term, labels, terms_tested
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.report.judgement import coefficients_table

AX1 = np.array([-115.0, -40.0, 10.0, 60.0])
AX2 = np.array([80.0, 50.0, 20.0, 95.0])


@pytest.mark.parametrize("name", ["P1", "P2", "P3", "P4", "P5", "P6"])
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_controller_terms_are_the_controllers_formula(name: str, geometry: str) -> None:
    one = Coefficients(**{name: 1.0})
    expected = np.column_stack(np.broadcast_arrays(*correction_deg(one, AX1, AX2)))
    design = design_of(TERMS[name], MountGeometry(geometry, 35.0), AX1, AX2)
    np.testing.assert_allclose(design, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(
    ("term", "field"),
    [
        ("P1", "P1"),
        ("P3", "P3"),
        ("P5", "P5"),
        ("P6", "P6"),
        ("C", "collimation_deg"),
        ("N", "nonperpendicularity_deg"),
        ("SAG", "sag_deg"),
    ],
)
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_every_term_is_the_slope_of_the_exact_mechanism(
    term: str, field: str, geometry: str
) -> None:
    mount = MountGeometry(geometry, 35.0)
    step = 1e-4
    up = np.array(Mechanism(**{field: step}).errors_deg(mount, AX1, AX2))
    down = np.array(Mechanism(**{field: -step}).errors_deg(mount, AX1, AX2))
    np.testing.assert_allclose(
        design_of(TERMS[term], mount, AX1, AX2).T, (up - down) / (2.0 * step), atol=1e-7
    )


def test_tpoint_terms_are_their_printed_equations() -> None:
    azimuth, elevation = 180.0 - AX1, 90.0 - AX2
    sin_a, cos_a = np.sin(np.radians(azimuth)), np.cos(np.radians(azimuth))
    sin_e, cos_e = np.sin(np.radians(elevation)), np.cos(np.radians(elevation))
    zero = np.zeros(4)
    cross_and_up = {
        "IA": (-cos_e, zero),
        "IE": (zero, zero + 1.0),
        "AN": (-sin_a * sin_e, -cos_a),
        "AW": (-cos_a * sin_e, sin_a),
        "CA": (zero - 1.0, zero),
        "NPAE": (-sin_e, zero),
        "TF": (zero, -cos_e),
        "TX": (zero, -cos_e / sin_e),
        "HASA": (sin_a * cos_e, zero),
        "HACA2": (np.cos(2.0 * np.radians(azimuth)) * cos_e, zero),
        "HSSA3": (np.sin(3.0 * np.radians(azimuth)), zero),
        "HESE": (zero, sin_e),
        "HECA2": (zero, np.cos(2.0 * np.radians(azimuth))),
        "HZSZ": (zero, -cos_e),
        "HESA2CE": (zero, np.sin(2.0 * np.radians(azimuth)) * cos_e),
    }
    for name, (cross, up) in cross_and_up.items():
        mount = MountGeometry("azel", 35.0)
        (term,) = chosen_terms((name,), mount)
        design = design_of(term, mount, AX1, AX2) * 3600.0
        np.testing.assert_allclose(design[:, 0] * cos_e, cross, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(design[:, 1], up, atol=1e-12, err_msg=name)
        assert term.unit == "arcsec"


@pytest.mark.parametrize("name", ["H", "HA", "HASB", "HQSA", "HASA100", "HASA0", "hasa", "HASAS"])
def test_what_is_no_harmonic_is_no_term(name: str) -> None:
    with pytest.raises(FitError, match=f"no error term '{name}'"):
        chosen_terms((name,), MountGeometry("azel", 35.0))


TPOINT_NAMES = ("IA", "IE", "AN", "AW", "CA", "NPAE", "TF", "TX")
HARMONICS = ("HASA2", "HACA2", "HSSA3", "HSCA2", "HESA2", "HECA3", "HESE2", "HZCZ4", "HECA2SE2")


@pytest.mark.parametrize(
    "names", [TPOINT_NAMES[:6] + TPOINT_NAMES[7:], TPOINT_NAMES[:7], HARMONICS]
)
def test_a_fit_gives_back_the_tpoint_terms_a_sky_was_made_with(names: tuple[str, ...]) -> None:
    mount = MountGeometry("azel", 35.0)
    generator = np.random.default_rng(14)
    ax1 = generator.uniform(-180.0, 180.0, 60)
    ax2 = generator.uniform(8.0, 80.0, 60)
    truth = generator.uniform(-90.0, 90.0, len(names))
    terms = chosen_terms(names, mount)
    errors = sum(
        value * design_of(term, mount, ax1, ax2) for value, term in zip(truth, terms, strict=True)
    )
    points = Points(
        geometry=mount, ax1_deg=ax1, ax2_deg=ax2, err1_deg=errors[:, 0], err2_deg=errors[:, 1]
    )
    solution = fit_linear(points, names)
    np.testing.assert_allclose(solution.values, truth, atol=1e-6)
    assert solution.sky_rms_deg * 3600.0 < 1e-6


def test_tx_has_no_value_at_the_horizon() -> None:
    points = Points(
        geometry=MountGeometry("azel", 35.0),
        ax1_deg=np.array([0.0, 40.0, 80.0]),
        ax2_deg=np.array([30.0, 90.0, 60.0]),
        err1_deg=np.zeros(3),
        err2_deg=np.zeros(3),
    )
    with pytest.raises(FitError, match="point 2: term TX has no value at AX2 90 deg"):
        fit_linear(points, ("IA", "IE", "TX"))


def test_tpoint_lean_and_flexure_agree_with_ours() -> None:
    mount = MountGeometry("azel", 35.0)
    for tpoint, ours, sign in (
        ("AN", "P1", 1),
        ("AW", "P3", -1),
        ("TF", "SAG", 1),
        ("CA", "C", -1),
    ):
        np.testing.assert_allclose(
            design_of(TERMS[tpoint], mount, AX1, AX2) * 3600.0,
            sign * design_of(TERMS[ours], mount, AX1, AX2),
            atol=1e-12,
        )


def test_terms_are_called_what_the_technician_calls_them() -> None:
    both = [TERMS["P4"], TERMS["C"]]
    assert labels(both, "azel") == ["elevation zero (P4)", "collimation (C)"]
    assert labels(both, "polar") == ["declination zero (P4)", "collimation (C)"]
    assert labels(both, "tiltroll-ew")[1] == "collimation (C)"


@pytest.mark.parametrize(
    ("names", "complaint"),
    [
        (("P1", "P9"), "no error term 'P9'"),
        (("P1", "P2", "P1"), "P1 is named twice"),
        ((), "no error term was named"),
    ],
)
def test_terms_that_cannot_be_fitted_are_refused(names: tuple[str, ...], complaint: str) -> None:
    with pytest.raises(FitError, match=complaint):
        chosen_terms(names, MountGeometry("azel", 35.0))


@pytest.mark.parametrize("geometry", ["tiltroll-ew", "tiltroll-ns", "polar"])
def test_tpoint_terms_belong_to_azel_mounts(geometry: str) -> None:
    with pytest.raises(FitError, match=f"AN is defined for azel mounts only.*{geometry}"):
        chosen_terms(("P1", "AN"), MountGeometry(geometry, 35.0))


def test_a_term_added_as_one_row_is_fitted_diagnosed_and_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A roller with one flat side: axis 2 follows the sine of twice axis 1."""
    row = Term(
        "ROLLER",
        "deg",
        "roller out of round",
        0.2,
        lambda at: (0.0, np.sin(np.radians(2.0 * at.ax1_deg))),
        called={"azel": "azimuth roller out of round"},
        tested=LookedFor(worth_knowing=0.2, large=0.2, largest=5.0),
    )
    monkeypatch.setitem(TERMS, row.name, row)
    geometry = MountGeometry("azel", 35.0)
    ax1 = np.linspace(-110.0, 110.0, 24)
    ax2 = 75.0 - 55.0 * np.cos(np.radians(ax1 * 0.75))
    e1, e2 = Mechanism(P1=0.4, P2=-0.3, P3=0.2, P5=0.001).errors_deg(geometry, ax1, ax2)
    e2 = e2 + 0.25 * np.sin(np.radians(2.0 * ax1))
    noise1, noise2 = np.random.default_rng(5).normal(0.0, 0.01, (2, 24))
    points = Points(
        geometry=geometry, ax1_deg=ax1, ax2_deg=ax2, err1_deg=e1 + noise1, err2_deg=e2 + noise2
    )

    fitted = fit_linear(points, ("P1", "P2", "P3", "P4", "P5", "P6", "ROLLER"))
    assert fitted.values[6] == pytest.approx(0.25, abs=0.02)
    last = coefficients_table(fitted).rows[-1]
    assert (last[0], last[-1]) == ("ROLLER", "roller out of round")
    assert labels([row], "azel") == ["azimuth roller out of round (ROLLER)"]

    (found,) = [
        finding
        for finding in diagnose(fit(points, SkyContext.for_points(points)))
        if finding.subject == "roller out of round"
    ]
    assert found.certainty == "found"
    assert found.number == pytest.approx(0.25, abs=0.02)
    assert "roller out of round of +0.2" in found.sentence


def test_what_the_direction_alone_does_not_give_is_tested_for_and_never_fitted() -> None:
    mount = MountGeometry("azel", 35.0)
    for name in ("REFRACTION", "BACKLASH1", "BACKLASH2"):
        assert name in {term.name for term in terms_tested("azel")}
        with pytest.raises(FitError, match=f"no error term '{name}'"):
            chosen_terms((name,), mount)
        with pytest.raises(FitError, match="only tested for"):
            design_of(TERMS[name], mount, AX1, AX2)


@pytest.mark.parametrize(
    ("name", "function"),
    [("HASA2", "sin 2"), ("HACA", "cos "), ("HESE3", "sin 3"), ("HECE", "cos ")],
)
def test_a_harmonic_says_its_function(name: str, function: str) -> None:
    assert function in harmonic(name).meaning
