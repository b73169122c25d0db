"""Coefficients of a saved session into its unit, back out again, and the proof that they hold."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from solarcal.decimals import counted
from solarcal.errors import InputFileError, LinkError, ProcedureRefused
from solarcal.model.analysis import Analysis
from solarcal.model.evidence.unit_state import check_limit_deg
from solarcal.model.fit import FEWEST_POINTS
from solarcal.model.forecast import Forecast
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.mount.formula import COEFFICIENT_NAMES, COEFFICIENT_UNITS, Coefficients, Offsets
from solarcal.session.records import CheckRecord, UnitRecord, UploadRecord
from solarcal.session.view import SessionView, read_session
from solarcal.station.analysing import analyse_session
from solarcal.station.procedure import Station
from solarcal.station.state import newest_upload
from solarcal.stopping_rule import StoppingRule
from solarcal.timescale import parse_utc
from solarcal.unit.tracker import UnitIdentity
from solarcal.units import rms

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
    kept = judgement.forecast.uploading(rounded)
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
                f"of {100.0 * better:.0f} %"
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


CHECK_POINTS = 2
"""Within the tolerance, after the upload: the proof that the manual asks for."""
DRAWN = 0.01
"""To so much a probability is known from its draws: what the unit's decimals take of one that was
just enough is no reason to upload again."""
CHECKS_APART_S = 600.0
"""Between the first and the last of them: in less the Sun stands where it stood."""


@dataclass(frozen=True, slots=True)
class SignOff:
    """What the uploads and check points of some sessions come to.

    Attributes
    ----------
    signed_off : the newest upload reads back equal, ``CHECK_POINTS`` after it and no fewer are all
        within the tolerance, the verdict is ``done``, and what was uploaded is as sure over the
        year as the stopping rule asks.
    reason : the sentence that says so, or why not.
    proven : whether the check points have decided: there are enough of them, ``CHECKS_APART_S``
        apart, or one is beyond.
    uploads : every live upload and rollback, oldest first.
    checks : accepted check points after the newest upload.
    sky_rms_deg, sky_max_deg : of these; None without any.
    """

    signed_off: bool
    reason: str
    proven: bool = False
    uploads: tuple[UploadRecord, ...] = ()
    checks: tuple[CheckRecord, ...] = ()
    sky_rms_deg: float | None = None
    sky_max_deg: float | None = None

    @property
    def newest(self) -> UploadRecord | None:
        return self.uploads[-1] if self.uploads else None

    @property
    def sentence(self) -> str:
        return f"{'SIGNED OFF' if self.signed_off else 'Not signed off'}: {self.reason}."


def sign_off(views: Sequence[SessionView], judgement: Analysis | None) -> SignOff:
    """Judge uploads and check points of sessions of one unit, one of them perhaps still running.

    Without the judgement of their points nothing is signed off.
    """
    # Within a file its order counts; between files only the laptop's time is left.
    told = (view for view in views if view.uploads or view.checks)
    views = sorted(told, key=lambda view: view.uploads[-1].utc if view.uploads else "")
    uploads = tuple(upload for view in views for upload in view.uploads)
    if not uploads:
        return SignOff(False, "nothing was uploaded")
    newest = uploads[-1]
    checks = tuple(
        check
        for view in views
        for check in (view.checks_after(newest) if newest in view.uploads else view.checks)
        if check.status == "accepted"
        and check.sky_error_deg is not None
        and (newest in view.uploads or check.utc > newest.utc)
    )
    left = np.array([check.sky_error_deg for check in checks], dtype=np.float64)
    rule = views[-1].header.rule if judgement is None else judgement.forecast.rule
    noise_deg = 0.0 if judgement is None else judgement.solution.noise_deg
    limit_deg = check_limit_deg(rule.tolerance_deg, noise_deg)
    beyond = int((left > limit_deg).sum())
    times_s = [parse_utc(check.utc) for check in checks]
    apart_s = max(times_s, default=0.0) - min(times_s, default=0.0)
    if not all(view.holds_upload for view in views):
        against = "the unit does not hold what was uploaded; upload again"
    else:
        against = _against(newest, rule, left, apart_s, beyond, judgement)
    reason = against or f"{_those(left)}: all {_within(left, rule)}"
    aside = [
        record
        for view in views
        for record in view.records
        if isinstance(record, CheckRecord)
        and record.utc > newest.utc
        and record.seq not in [check.seq for check in checks]
        and (record.sky_error_deg or 0.0) > limit_deg
    ]
    if aside:
        worst_deg = max(record.sky_error_deg or 0.0 for record in aside)
        reason += f"; {len(aside)} beyond it, up to {worst_deg:.3f} deg, rejected or struck out"
    return SignOff(
        not against,
        reason,
        beyond > 0 or (left.size >= CHECK_POINTS and apart_s >= CHECKS_APART_S),
        uploads,
        checks,
        rms(left) if left.size else None,
        float(left.max()) if left.size else None,
    )


Errors = np.ndarray[tuple[int], np.dtype[np.float64]]


def _those(left_deg: Errors) -> str:
    return f"{counted(left_deg.size, 'check point')} after the upload"


def _within(left_deg: Errors, rule: StoppingRule) -> str:
    worst_deg = float(left_deg.max())
    noise = " and the noise of a reading" if worst_deg > rule.tolerance_deg else ""
    return f"within the tolerance{noise}, the worst {worst_deg:.3f} deg"


def _against(
    newest: UploadRecord,
    rule: StoppingRule,
    left_deg: Errors,
    apart_s: float,
    beyond: int,
    judgement: Analysis | None,
) -> str:
    """Why it is not signed off, or nothing."""
    if newest.rollback:
        return "the newest upload was rolled back"
    if not newest.verified:
        return "the unit did not read back what was uploaded"
    if not left_deg.size:
        return "no check point was taken after the upload"
    if beyond:
        worst = f"the worst {left_deg.max():.3f} deg"
        return f"{beyond} of {_those(left_deg)}: beyond the tolerance, {worst}"
    within = f"{counted(left_deg.size, 'check point')} {_within(left_deg, rule)}"
    if left_deg.size < CHECK_POINTS:
        return f"{within}; {CHECK_POINTS} are needed"
    if apart_s < CHECKS_APART_S:
        return f"{within}, but all in one direction: take another one half an hour later"
    if judgement is None:
        return f"{within}, but there is no verdict on the points"
    expected = forecast_with(judgement, *newest.writes)
    if expected.probability_within_tolerance < expected.rule.probability - DRAWN:
        cure = "upload again" if judgement.forecast.sure else "take more points"
        return f"{within}, but the year is {expected.sure_words}: {cure}"
    if judgement.verdict.state != "done":
        return f"{within}, but the verdict is not DONE: {judgement.verdict.reasons[0]}"
    return ""


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


@lru_cache(maxsize=2)
def _year(known: Forecast, coefficients: Coefficients) -> Forecast:
    """Screens ask for the same year every second."""
    return known.uploading(coefficients)
