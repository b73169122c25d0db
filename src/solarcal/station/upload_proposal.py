"""What an upload would write, what it would change, and what speaks against it."""

from dataclasses import dataclass

from solarcal.model.fit import FEWEST_POINTS, Solution
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients
from solarcal.station.fitting import solve
from solarcal.station.state import SessionView


@dataclass(frozen=True, slots=True)
class CoefficientChange:
    """One coefficient as it is and as it would be, in its unit.

    ``sigmas``: the change over the new value's sigma, ``None`` without one.
    """

    name: str
    unit: str
    old: float
    new: float
    sigma: float | None

    @property
    def sigmas(self) -> float | None:
        return (self.new - self.old) / self.sigma if self.sigma else None


@dataclass(frozen=True, slots=True)
class UploadProposal:
    """``coefficients`` are rounded as the unit keeps them; ``doubts`` each want a reason."""

    solution: Solution
    coefficients: Coefficients
    changes: tuple[CoefficientChange, ...]
    doubts: tuple[str, ...]


def propose_upload(session: SessionView, in_force: Coefficients) -> UploadProposal | None:
    """The upload this session's points ask for; ``None`` while there are too few."""
    solution = solve(session)
    if solution is None or len(session.accepted) < FEWEST_POINTS:
        return None
    unit = session.header.unit
    new = solution.coefficients().rounded(unit.tilt_decimals, unit.scale_decimals)
    sigma = solution.sigma_coefficients()
    sigmas = sigma.as_tuple() if sigma is not None else (None,) * 6
    changes = tuple(
        CoefficientChange(*row)
        for row in zip(
            COEFFICIENT_NAMES,
            COEFFICIENT_UNITS,
            in_force.as_tuple(),
            new.as_tuple(),
            sigmas,
            strict=True,
        )
    )
    doubts = []
    if solution.message is not None:
        doubts.append(f"{solution.message}.")
    if solution.rank < len(solution.terms):
        doubts.append(f"{solution.n_points} points do not determine all six coefficients.")
    return UploadProposal(solution, new, changes, tuple(doubts))


def too_few_points(session: SessionView) -> str:
    """Why there is nothing to upload yet."""
    n = len(session.accepted)
    return f"{n} accepted point{'' if n == 1 else 's'}: {FEWEST_POINTS} are the least."
