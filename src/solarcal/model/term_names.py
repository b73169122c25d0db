"""Error terms by name: the built-in ones, and the harmonics whose names say what they are."""

import re
from collections.abc import Iterable

import numpy as np

from solarcal.errors import FitError
from solarcal.model.terms import SAG_PRIOR_DEG, TERMS, NativeAngles, Row, Term, tpoint
from solarcal.mount.geometry import MountGeometry
from solarcal.units import RAD_PER_DEG

_HARMONIC = re.compile(r"H([AESZ])([SC])([AEZ])([0-9]{0,2})(?:([SC])([AEZ])([0-9]{0,2}))?")
_RESULTS = {"A": "azimuth", "E": "elevation", "S": "left-right on the sky", "Z": "zenith distance"}


def harmonic(name: str) -> Term | None:
    """The TPOINT harmonic of this name; None where the name is no harmonic.

    ``H``, what is changed (A azimuth, E elevation, S left-right on the sky, Z zenith distance),
    then one or two factors: S sine or C cosine, of A, E or Z, times a whole number (1 if none).
    ``HASA2``: A - A_enc = HASA2 sin 2A. ``HSCA``: (A - A_enc) cos E = HSCA cos A.
    """
    parts = _HARMONIC.fullmatch(name)
    if parts is None:
        return None
    result, *rest = parts.groups()
    factors = [
        (rest[at], rest[at + 1], int(rest[at + 2] or 1)) for at in (0, 3) if rest[at] is not None
    ]
    if any(function == "S" and times == 0 for function, _, times in factors):
        return None

    def rows(at: NativeAngles) -> tuple[Row, Row]:
        value: Row = 1.0
        for function, angle, times in factors:
            # A = 180 - AX1, Z = AX2, E = 90 - AX2.
            turn = {"A": 180.0 - at.ax1_deg, "E": 90.0 - at.ax2_deg, "Z": at.ax2_deg}[angle]
            wave = np.sin if function == "S" else np.cos
            value = value * wave(times * turn * RAD_PER_DEG)
        if result == "A":
            return value, 0.0
        if result == "S":
            return value / at.sin2, 0.0
        return 0.0, value if result == "E" else -value

    wording = " ".join(
        f"{'sin' if function == 'S' else 'cos'} {times if times > 1 else ''}{angle}"
        for function, angle, times in factors
    )
    return tpoint(name, f"{_RESULTS[result]} harmonic, {wording}", SAG_PRIOR_DEG, rows)


def chosen_terms(names: Iterable[str], geometry: MountGeometry) -> tuple[Term, ...]:
    """The terms of these names, in this order.

    Raises
    ------
    FitError
        No term, an unknown or repeated one, or one that this mount does not have.
    """
    terms: list[Term] = []
    for name in names:
        term = TERMS.get(name) or harmonic(name)
        if term is None or term.rows is None:
            known = ", ".join(known for known, one in TERMS.items() if one.rows is not None)
            raise FitError(
                f"there is no error term {name!r}; known are {known} and harmonics "
                "such as HASA2 or HECE"
            )
        if term.only not in (None, geometry.name):
            raise FitError(
                f"term {name} is defined for {term.only} mounts only and this one is "
                f"{geometry.name}; use P1..P6, C, N, SAG"
            )
        terms.append(term)
    named = [term.name for term in terms]
    if len(set(named)) < len(named):
        twice = next(name for name in named if named.count(name) > 1)
        raise FitError(f"term {twice} is named twice")
    if not terms:
        raise FitError("no error term was named; give at least one, for example P1,P2,P3")
    return tuple(terms)
