"""What an upload would write, what it would change, and what speaks against it."""

from dataclasses import dataclass

from solarcal.model.analysis import Analysis
from solarcal.model.fit import FEWEST_POINTS, Solution
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients, Offsets
from solarcal.station.analysing import analyse_session
from solarcal.station.state import SessionView
from solarcal.station.uploading import UploadOffer, offer_upload


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
    """The offer, and what it changes in the unit on the line."""

    offer: UploadOffer
    changes: tuple[CoefficientChange, ...]

    @property
    def solution(self) -> Solution:
        return self.offer.judgement.solution

    @property
    def judgement(self) -> Analysis:
        return self.offer.judgement

    @property
    def coefficients(self) -> Coefficients:
        """Rounded as the unit keeps them."""
        return self.offer.rounded

    @property
    def doubts(self) -> tuple[str, ...]:
        """What forbids the upload unless a reason is given."""
        return self.offer.against


def propose_upload(
    session: SessionView,
    in_force: Coefficients,
    method: str = DEFAULT_METHOD,
    *,
    offsets: Offsets | None = None,
    judgement: Analysis | None = None,
) -> UploadProposal | None:
    """The upload this session's points ask for; ``None`` while there are too few.

    ``judgement``: their analysis, where it is on the screen already.
    """
    if len(session.accepted) < FEWEST_POINTS:
        return None
    judgement = judgement or analyse_session(session, method)
    if judgement is None:
        return None
    held = None if offsets is None else (in_force, offsets)
    offer = offer_upload(judgement, session.header.unit, held)
    sigma = judgement.solution.sigma_coefficients()
    sigmas = sigma.as_tuple() if sigma is not None else (None,) * 6
    changes = tuple(
        CoefficientChange(*row)
        for row in zip(
            COEFFICIENT_NAMES,
            COEFFICIENT_UNITS,
            in_force.as_tuple(),
            offer.rounded.as_tuple(),
            sigmas,
            strict=True,
        )
    )
    return UploadProposal(offer, changes)


def too_few_points(session: SessionView) -> str:
    """Why there is nothing to upload yet."""
    n = len(session.accepted)
    return f"{n} accepted point{'' if n == 1 else 's'}: {FEWEST_POINTS} are the least."
