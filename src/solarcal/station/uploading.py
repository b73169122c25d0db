"""Coefficients of a saved session into its unit, and back out again."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from solarcal.decimals import counted
from solarcal.errors import InputFileError, LinkError, ProcedureRefused
from solarcal.model.analysis import Analysis
from solarcal.model.fit import FEWEST_POINTS
from solarcal.model.forecast import Forecast
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients, Offsets
from solarcal.session.records import UnitRecord
from solarcal.session.view import SessionView, read_session
from solarcal.station.analysing import analyse_session
from solarcal.station.procedure import Station
from solarcal.station.state import newest_upload
from solarcal.stopping_rule import percent
from solarcal.unit.tracker import UnitIdentity

BETTER_PROBABILITY = 0.95
"""With which the new coefficients must be better than those in force."""


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
class UploadOffer:
    """What a judged session would write, and what the unit's resolution makes of it.

    Attributes
    ----------
    rounded : the coefficients as the unit keeps them.
    held : the year with what the unit holds now; None where that is not known.
    better : probability that the new coefficients point better over the year than those held.
    against : the reasons that forbid it unless they are overruled.
    in_force : what the unit corrects by now, where it is asked what changes.
    """

    judgement: Analysis
    fitted: Coefficients
    rounded: Coefficients
    kept: Forecast
    held: Forecast | None
    better: float | None
    against: tuple[str, ...]
    in_force: Coefficients = field(default_factory=Coefficients)

    @property
    def changes(self) -> tuple[CoefficientChange, ...]:
        """What it changes of the coefficients in force."""
        sigma = self.judgement.solution.sigma_coefficients()
        sigmas = sigma.as_tuple() if sigma is not None else (None,) * 6
        old, new = self.in_force.as_tuple(), self.rounded.as_tuple()
        rows = zip(COEFFICIENT_NAMES, COEFFICIENT_UNITS, old, new, sigmas, strict=True)
        return tuple(CoefficientChange(*row) for row in rows)


def offer_upload(
    judgement: Analysis, unit: UnitRecord, held: tuple[Coefficients, Offsets] | None = None
) -> UploadOffer:
    """The offer for the unit a session tells of; ``held`` is what that holds now, P and O."""
    fitted = judgement.solution.coefficients()
    rounded = fitted.rounded(unit.tilt_decimals, unit.scale_decimals)
    verdict = judgement.verdict
    kept = _year(judgement.forecast, rounded)
    against = list(verdict.reasons[:1] if verdict.state == "does_not_fit" else ())
    now: Forecast | None = None
    better: float | None = None
    if held is not None:
        now = forecast_with(judgement, *held)
        # The draws are the same ones, so each pair is one tracker with either.
        better = float(np.mean(kept.sample_rms_deg < now.sample_rms_deg))
        # What the unit holds already changes nothing: it may be stored once more.
        if better < BETTER_PROBABILITY and held != (rounded, Offsets()):
            against.append(
                "no improvement beyond its uncertainty: 95 % of the year within "
                f"{now.year_p95_deg:.3f} deg with the P and O it holds now, "
                f"{kept.year_p95_deg:.3f} deg with the new coefficients, better with a probability "
                f"of {percent(better, BETTER_PROBABILITY)}"
            )
    return UploadOffer(judgement, fitted, rounded, kept, now, better, tuple(against))


def refuse_doubtful(offer: UploadOffer, force: str | None) -> str:
    """The reason to record: empty where nothing speaks against the upload.

    Refused (ProcedureRefused) where something does, and no reason to upload anyway was given.
    """
    if not offer.against:
        return ""
    if force is None:
        raise ProcedureRefused(
            f"upload refused: {offer.against[0]}; to upload anyway, give a reason with --force "
            "REASON"
        )
    return force


@contextlib.contextmanager
def losses_recorded(station: Station) -> Iterator[None]:
    """A line that is lost meanwhile is recorded in the session."""
    try:
        yield
    except LinkError as error:
        station.link_lost(error)
        raise


def find_upload(folder: Path, identity: UnitIdentity) -> tuple[Path, tuple[str, ...]]:
    """The session in a folder with the newest upload to a unit, and what could not be read.

    ProcedureRefused where there is none.
    """
    best: tuple[str, Path] | None = None
    unreadable = []
    for path in sorted(folder.glob("*.jsonl")):
        try:
            session = read_session(path)
        except InputFileError as error:
            unreadable.append(str(error))
            continue
        unit = session.header.unit
        upload = newest_upload(session.uploads)
        if upload is None or (unit.model, unit.serial) != (identity.model, identity.serial):
            continue
        if best is None or upload.utc > best[0]:
            best = (upload.utc, path)
    if best is None:
        raise ProcedureRefused(
            f"no session in {folder} records an upload to unit {identity.model} "
            f"{identity.serial}; name the session file"
        )
    return best[1], tuple(unreadable)


def newest_session(paths: Sequence[Path]) -> Path:
    """The session that an upload of these is recorded in: the one begun last that is no import."""

    def begun(path: Path) -> tuple[bool, str, str]:
        session = read_session(path)
        # An earlier state of the same session was begun with it.
        last = max((record.utc for record in session.records), default="")
        return not session.header.unit.imported, session.header.utc, last

    return max(paths, key=begun)


def propose_upload(
    session: SessionView,
    in_force: Coefficients,
    method: str = DEFAULT_METHOD,
    *,
    offsets: Offsets | None = None,
    judgement: Analysis | None = None,
) -> UploadOffer | None:
    """The upload this session's points ask for; ``None`` while there are too few.

    ``judgement``: their analysis, where it is on the screen already.
    """
    if len(session.accepted) < FEWEST_POINTS:
        return None
    judgement = judgement or analyse_session(session, method)
    if judgement is None:
        return None
    held = None if offsets is None else (in_force, offsets)
    return replace(offer_upload(judgement, session.header.unit, held), in_force=in_force)


def too_few_points(session: SessionView) -> str:
    """Why there is nothing to upload yet."""
    n = len(session.accepted)
    return f"{counted(n, 'accepted point')}: {FEWEST_POINTS} are needed."


def held(coefficients: Coefficients, offsets: Offsets) -> Coefficients:
    """What P and O correct together: reading = ideal + E(P) + O, so O adds to P2 and P4."""
    return Coefficients(
        coefficients.P1,
        coefficients.P2 + offsets.O1,
        coefficients.P3,
        coefficients.P4 + offsets.O2,
        coefficients.P5,
        coefficients.P6,
    )


def forecast_with(judgement: Analysis, coefficients: Coefficients, offsets: Offsets) -> Forecast:
    """The year with these P and O in force."""
    return _year(judgement.forecast, held(coefficients, offsets))


@lru_cache(maxsize=4)
def _year(known: Forecast, coefficients: Coefficients) -> Forecast:
    """Screens ask for the same year every second."""
    return known.uploading(coefficients)
