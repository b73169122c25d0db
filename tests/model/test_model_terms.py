"""The registry of error terms: what one unit of each does to the axes."""

import numpy as np
import pytest

from solarcal.errors import FitError
from solarcal.model.terms import TERMS, chosen_terms
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.mount.geometry import GEOMETRIES, MountGeometry
from solarcal.mount.mechanism import Mechanism

AX1 = np.array([-115.0, -40.0, 10.0, 60.0])
AX2 = np.array([80.0, 50.0, 20.0, 95.0])


@pytest.mark.parametrize("name", ["P1", "P2", "P3", "P4", "P5", "P6"])
@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_controller_terms_are_the_controllers_formula(name: str, geometry: str) -> None:
    one = Coefficients(**{name: 1.0})
    expected = np.column_stack(np.broadcast_arrays(*correction_deg(one, AX1, AX2)))
    design = TERMS[name].design(MountGeometry(geometry, 35.0), AX1, AX2)
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
        TERMS[term].design(mount, AX1, AX2).T, (up - down) / (2.0 * step), atol=1e-7
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
    }
    for name, (cross, up) in cross_and_up.items():
        design = TERMS[name].design(MountGeometry("azel", 35.0), AX1, AX2) * 3600.0
        np.testing.assert_allclose(design[:, 0] * cos_e, cross, atol=1e-12, err_msg=name)
        np.testing.assert_allclose(design[:, 1], up, atol=1e-12, err_msg=name)
        assert TERMS[name].unit == "arcsec"


def test_tpoint_lean_and_flexure_agree_with_ours() -> None:
    mount = MountGeometry("azel", 35.0)
    for tpoint, ours, sign in (
        ("AN", "P1", 1),
        ("AW", "P3", -1),
        ("TF", "SAG", 1),
        ("CA", "C", -1),
    ):
        np.testing.assert_allclose(
            TERMS[tpoint].design(mount, AX1, AX2) * 3600.0,
            sign * TERMS[ours].design(mount, AX1, AX2),
            atol=1e-12,
        )


def test_terms_are_called_what_the_technician_calls_them() -> None:
    assert TERMS["P4"].label("azel") == "elevation zero (P4)"
    assert TERMS["P4"].label("polar") == "declination zero (P4)"
    assert TERMS["C"].label("tiltroll-ew") == "collimation (C)"


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
