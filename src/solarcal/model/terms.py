"""The named error terms a pointing model is made of.

Every term gives the axis errors E1, E2 (reading minus ideal, axis degrees) that one unit of it
causes. P1..P6 are the controller's own formula (see ``mount.formula``); C, N and SAG are what a
rigid, square, stiff mechanism does not have; IA..TX are the TPOINT alt-azimuth terms under their
own names, signs and arcseconds:

    (A - A_enc) cos E = -IA cos E - CA - NPAE sin E - AN sin A sin E - AW cos A sin E
    E - E_enc         =  IE - AN cos A + AW sin A - TF cos E - TX cot E

with AX1 = 180 - A and AX2 = 90 - E, so that E1 = A - A_enc and E2 = E - E_enc.

A term is one row here and nothing elsewhere: fits, tests of the residuals, findings and reports
are made from it. Only an exact effect that bends the geometry itself is an equation of
``mount.mechanism``, which the row names.

References
----------
Wallace (2000), TPOINT Software: the terms and harmonics of that name.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from solarcal.errors import FitError
from solarcal.model.finding import Kind as FindingKind
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.units import ARCSEC_PER_DEG, RAD_PER_DEG, FloatArray

CONTROLLER_TERMS = COEFFICIENT_NAMES
"""P1..P6: all parameters of the controller's formula."""

LEAN_PRIOR_DEG = 2.0
ZERO_PRIOR_DEG = 5.0
SCALE_PRIOR = 0.002
CROSS_PRIOR_DEG = 0.5
SAG_PRIOR_DEG = 0.2
AIR_PRIOR = 1.0
"""Forgotten refraction, as a part of the standard air's."""

MOST_SAG = 0.5
"""Degrees. A steel cantilever of length L may bend by L / 180 (BS EN 1993-1-1, UK national annex,
NA.2.23); under its own weight its end then turns by 4 / 3 / 180 = 7.4 mrad, 0.42 deg."""
MORE_AIR = (-1.0, 1.5)
"""Beside the assumed air: none to 2.5 times the standard air in all. Refraction goes with pressure
over temperature (Meeus, ch. 16): 1.3 times the standard at 1050 hPa and -50 C, and 1.6 times as
much where a site 4 km high is given as at the sea."""

Kind: TypeAlias = Literal["lean", "zero", "scale", "other"]
Row: TypeAlias = FloatArray | float


@dataclass(frozen=True, slots=True)
class NativeAngles:
    """Places in the native frame, with the sines and cosines every term needs."""

    geometry: MountGeometry
    ax1_deg: FloatArray
    ax2_deg: FloatArray
    sin1: FloatArray
    cos1: FloatArray
    sin2: FloatArray
    cos2: FloatArray

    @classmethod
    def at(
        cls, geometry: MountGeometry, ax1_deg: FloatArray, ax2_deg: FloatArray
    ) -> "NativeAngles":
        """Places at AX1 (branch value) and AX2, degrees, arrays of one shape (n,)."""
        ax1 = ax1_deg * RAD_PER_DEG
        ax2 = ax2_deg * RAD_PER_DEG
        return cls(geometry, ax1_deg, ax2_deg, np.sin(ax1), np.cos(ax1), np.sin(ax2), np.cos(ax2))


@dataclass(frozen=True, slots=True)
class LookedFor:
    """How the tests of the residuals look for a term.

    Attributes
    ----------
    worth_knowing : an amount that occurs in practice. Where it would go unnoticed, the report says
        so.
    large : so large that it will be looked at anyway: a weaker proof will do.
    largest : more is no answer of the equations.
    natural : from and to what mechanisms and the air have, as far as that is known.
    finding : the kind of finding it makes.
    both_sides_of : the axis (1 or 2) that must have come from both sides before anything is
        reported.
    """

    worth_knowing: float
    large: float
    largest: float
    finding: FindingKind = "unmodelled"
    both_sides_of: int | None = None
    natural: tuple[float, float] = (-np.inf, np.inf)


@dataclass(frozen=True, slots=True)
class Term:
    """One named error term.

    Attributes
    ----------
    name, unit, meaning : as reports have them.
    prior_sigma : how large the term may physically be, one sigma, in its own unit.
    rows : to first order: (E1, E2) in axis degrees per unit of the term. None where the direction
        alone does not give it: such a term is tested for and never fitted.
    kind : which of the limits of "unrealistic" apply.
    only : the one geometry that has it.
    called : what a technician calls it on a given mount.
    exact : the number of ``Mechanism`` that is its exact effect; None: ``rows`` already are.
    tested : how the residuals are tested for it; None: they are not.
    """

    name: str
    unit: Literal["deg", "deg/deg", "arcsec", "standard air"]
    meaning: str
    prior_sigma: float
    rows: Callable[[NativeAngles], tuple[Row, Row]] | None
    kind: Kind = "other"
    only: str | None = None
    called: dict[str, str] = field(default_factory=dict)
    exact: str | None = None
    tested: LookedFor | None = None


def labels(terms: Iterable[Term], geometry_name: str) -> list[str]:
    """The terms as a technician says them: 'elevation zero (P4)'."""
    return [f"{term.called.get(geometry_name, term.meaning)} ({term.name})" for term in terms]


def degrees_per_unit(terms: Iterable[Term]) -> FloatArray:
    """Of each term, (k,)."""
    return np.array([1.0 / ARCSEC_PER_DEG if term.unit == "arcsec" else 1.0 for term in terms])


def design_matrix(terms: Sequence[Term], at: NativeAngles) -> FloatArray:
    """E1, E2 per unit of each term at each place, shape (k, 2, n), axis degrees.

    FitError for a term that is only tested for.
    """
    design = np.empty((len(terms), 2, len(at.ax1_deg)))
    for block, term in zip(design, terms, strict=True):
        if term.rows is None:
            raise FitError(f"{term.name} ({term.meaning}) is only tested for, never fitted")
        block[0], block[1] = term.rows(at)
    return design


def terms_tested(geometry_name: str) -> tuple[Term, ...]:
    """The terms beside P1..P6 that the residuals of such a mount are tested for."""
    return tuple(
        term
        for term in TERMS.values()
        if term.tested is not None and term.only in (None, geometry_name)
    )


def occurs(name: str, amount: float, sigma: float) -> bool:
    """Whether so much of a term, within two of its sigmas, is natural."""
    tested = TERMS[name].tested
    least, most = (-np.inf, np.inf) if tested is None else tested.natural
    return bool(least - 2.0 * sigma <= amount <= most + 2.0 * sigma)


def _sag(at: NativeAngles) -> tuple[Row, Row]:
    # The tube droops away from the zenith, so the axes must stand that much nearer to it: the
    # components of 'up' along the two axes' motions, whatever way the primary axis points.
    x, y, z = at.geometry.up_components()
    towards1 = (y * at.cos1 - x * at.sin1) / at.sin2
    towards2 = (x * at.cos1 + y * at.sin1) * at.cos2 - z * at.sin2
    return towards1, towards2


def tpoint(
    name: str,
    meaning: str,
    prior_deg: float,
    rows_deg: Callable[[NativeAngles], tuple[Row, Row]],
    kind: Kind = "other",
) -> Term:
    """One of TPOINT's terms, of alt-azimuth mounts and in arcseconds; its rows in degrees here."""

    def rows(at: NativeAngles) -> tuple[Row, Row]:
        e1, e2 = rows_deg(at)
        return e1 / ARCSEC_PER_DEG, e2 / ARCSEC_PER_DEG

    prior = prior_deg * ARCSEC_PER_DEG
    return Term(name, "arcsec", meaning, prior, rows, kind, only="azel")


def _four(azel: str, ew: str, ns: str, polar: str) -> dict[str, str]:
    return {"azel": azel, "tiltroll-ew": ew, "tiltroll-ns": ns, "polar": polar}


# TPOINT in native angles: sin A = sin AX1, cos A = -cos AX1, sin E = cos AX2, cos E = sin AX2.
_ALL = (
    Term(
        "P1",
        "deg",
        "lean of the primary axis about native y",
        LEAN_PRIOR_DEG,
        lambda a: (-a.sin1 * a.cos2 / a.sin2, a.cos1),
        "lean",
        called=_four("north lean", "east end down", "north end down", "pole end down"),
    ),
    Term(
        "P2",
        "deg",
        "zero of axis 1",
        ZERO_PRIOR_DEG,
        lambda a: (1.0, 0.0),
        "zero",
        called=_four("azimuth zero", "tilt zero", "tilt zero", "hour angle zero"),
    ),
    Term(
        "P3",
        "deg",
        "lean of the primary axis about native x",
        LEAN_PRIOR_DEG,
        lambda a: (-a.cos1 * a.cos2 / a.sin2, -a.sin1),
        "lean",
        called=_four(
            "east lean", "east end to the south", "north end to the east", "pole end to the east"
        ),
    ),
    Term(
        "P4",
        "deg",
        "zero of axis 2",
        ZERO_PRIOR_DEG,
        lambda a: (0.0, 1.0),
        "zero",
        called=_four("elevation zero", "roll zero", "roll zero", "declination zero"),
    ),
    Term(
        "P5",
        "deg/deg",
        "scale of axis 1",
        SCALE_PRIOR,
        lambda a: (-a.ax1_deg, 0.0),
        "scale",
        called=_four("azimuth scale", "tilt scale", "tilt scale", "hour angle scale"),
    ),
    Term(
        "P6",
        "deg/deg",
        "scale of axis 2",
        SCALE_PRIOR,
        lambda a: (0.0, -a.ax2_deg),
        "scale",
        called=_four("elevation scale", "roll scale", "roll scale", "declination scale"),
    ),
    Term(
        "C",
        "deg",
        "collimation",
        CROSS_PRIOR_DEG,
        lambda a: (1.0 / a.sin2, 0.0),
        exact="collimation_deg",
        tested=LookedFor(worth_knowing=0.5, large=0.45, largest=20.0, finding="collimation"),
    ),
    Term(
        "N",
        "deg",
        "axes not square",
        CROSS_PRIOR_DEG,
        lambda a: (a.cos2 / a.sin2, 0.0),
        exact="nonperpendicularity_deg",
        tested=LookedFor(
            worth_knowing=0.5, large=0.45, largest=20.0, finding="nonperpendicularity"
        ),
    ),
    Term(
        "SAG",
        "deg",
        "gravity sag",
        SAG_PRIOR_DEG,
        _sag,
        exact="sag_deg",
        tested=LookedFor(
            0.2, large=0.2, largest=20.0, finding="sag", natural=(-MOST_SAG, MOST_SAG)
        ),
    ),
    Term(
        "REFRACTION",
        "standard air",
        "refraction other than assumed",
        AIR_PRIOR,
        None,
        exact="air",
        tested=LookedFor(1.0, large=0.5, largest=50.0, finding="refraction", natural=MORE_AIR),
    ),
    *(
        Term(
            f"BACKLASH{axis}",
            "deg",
            f"backlash of axis {axis}",
            CROSS_PRIOR_DEG,
            None,
            exact=f"backlash{axis}_deg",
            tested=LookedFor(
                worth_knowing=0.1, large=0.1, largest=360.0, finding="backlash", both_sides_of=axis
            ),
        )
        for axis in (1, 2)
    ),
    tpoint("IA", "azimuth zero", ZERO_PRIOR_DEG, lambda a: (-1.0, 0.0), "zero"),
    tpoint("IE", "elevation zero", ZERO_PRIOR_DEG, lambda a: (0.0, 1.0), "zero"),
    tpoint(
        "AN",
        "north-south lean",
        LEAN_PRIOR_DEG,
        lambda a: (-a.sin1 * a.cos2 / a.sin2, a.cos1),
        "lean",
    ),
    tpoint(
        "AW", "east-west lean", LEAN_PRIOR_DEG, lambda a: (a.cos1 * a.cos2 / a.sin2, a.sin1), "lean"
    ),
    tpoint("CA", "collimation", CROSS_PRIOR_DEG, lambda a: (-1.0 / a.sin2, 0.0)),
    tpoint("NPAE", "axes not square", CROSS_PRIOR_DEG, lambda a: (-a.cos2 / a.sin2, 0.0)),
    tpoint("TF", "tube flexure", SAG_PRIOR_DEG, lambda a: (0.0, -a.sin2)),
    tpoint(
        "TX",
        "tube flexure as the cotangent of elevation",
        SAG_PRIOR_DEG,
        lambda a: (0.0, -a.sin2 / a.cos2),
    ),
)

TERMS: dict[str, Term] = {term.name: term for term in _ALL}
"""Every error term by name."""
