"""The proof of an upload: whether a calibration is signed off, and why not."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.model.evidence.unit_state import check_limit_deg
from solarcal.session.records import CheckRecord, PointRecord, SunOffset, UploadRecord
from solarcal.session.view import SessionView, held_instead
from solarcal.station.uploading import forecast_with
from solarcal.stopping_rule import StoppingRule
from solarcal.timescale import clock_utc, parse_utc
from solarcal.units import FloatArray, rms

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
    open : everything that is still against it, none where it is signed off.
    superseded : whether the coefficients of all points are to be uploaded: with them the year is
        sure enough, with those uploaded it is not.
    proven : whether the check points have decided: there are enough of them, ``CHECKS_APART_S``
        apart, or one is beyond.
    uploads : every live upload and rollback, oldest first.
    checks : accepted check points after the newest upload.
    sky_rms_deg, sky_max_deg : of these; None without any.
    """

    signed_off: bool
    reason: str
    open: tuple[str, ...] = ()
    superseded: bool = False
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
    held = held_instead(views)
    # Within a file its order counts; between files only the laptop's time is left.
    told = (view for view in views if view.uploads or view.checks)
    views = sorted(told, key=lambda view: view.uploads[-1].utc if view.uploads else "")
    uploads = tuple(upload for view in views for upload in view.uploads)
    if not uploads:
        return SignOff(False, "nothing was uploaded")
    newest = uploads[-1]
    checks = tuple(c for view in views for c in _after(newest, view, view.checks) if _counts(c))
    left = np.array([check.sky_error_deg for check in checks], dtype=np.float64)
    rule = views[-1].header.rule if judgement is None else judgement.forecast.rule
    noise_deg = 0.0 if judgement is None else judgement.solution.noise_deg
    limit_deg = check_limit_deg(rule.tolerance_deg, noise_deg)
    beyond = int((left > limit_deg).sum())
    times_s = [parse_utc(check.utc) for check in checks]
    apart_s = max(times_s, default=0.0) - min(times_s, default=0.0)
    year, superseded = _year_against(newest, judgement)
    if held is not None:
        against: tuple[str, ...] = ("the unit does not hold what was uploaded; upload again",)
    elif newest.rollback:
        against = ("the newest upload was rolled back",)
    elif not newest.verified:
        against = ("the unit did not read back what was uploaded",)
    else:
        checks_against = _checks_against(left, apart_s, beyond)
        # What a check point alone does not settle comes first.
        against = (*checks_against, *year) if beyond else (*year, *checks_against)
        if (left_in := views[-1].offset_left) is not None:
            against = (*against, _still_in_force(left_in, settles=not year))
        if judgement is None:
            against = (*against, "there is no verdict on the points")
    reason = "; ".join(against)
    if left.size and not beyond and held is None and newest.verified and not newest.rollback:
        within = _within(left, rule)
        reason = (
            f"{counted(left.size, 'check point')} {within}, but {reason}"
            if against
            else f"{_those(left)}: all {within}"
        )
    missed = [
        check.sky_error_deg or 0.0
        for view in views
        for check in _after(newest, view, (r for r in view.records if isinstance(r, CheckRecord)))
        if check.seq not in {one.seq for one in view.checks if _counts(one)}
    ]
    if aside := [left_deg for left_deg in missed if left_deg > limit_deg]:
        worst = f"up to {max(aside):.3f} deg"
        reason += f"; {len(aside)} beyond it, {worst}, rejected or struck out"
    return SignOff(
        not against,
        reason,
        against,
        superseded and not newest.rollback,
        beyond > 0 or (left.size >= CHECK_POINTS and apart_s >= CHECKS_APART_S),
        uploads,
        checks,
        rms(left) if left.size else None,
        float(left.max()) if left.size else None,
    )


def _after(
    newest: UploadRecord, view: SessionView, checks: Iterable[CheckRecord]
) -> list[CheckRecord]:
    """Those of a session that were taken since what was uploaded last is in the unit."""
    if newest not in view.uploads:
        return [check for check in checks if check.utc > newest.utc]
    since = view.written_since(newest)
    return [check for check in checks if check.seq > since]


def _counts(check: CheckRecord) -> bool:
    return check.status == "accepted" and check.sky_error_deg is not None


def _those(left_deg: FloatArray) -> str:
    return f"{counted(left_deg.size, 'check point')} after the upload"


def _within(left_deg: FloatArray, rule: StoppingRule) -> str:
    worst_deg = float(left_deg.max())
    noise = " and the noise of a reading" if worst_deg > rule.tolerance_deg else ""
    return f"within the tolerance{noise}, the worst {worst_deg:.3f} deg"


def _checks_against(left_deg: FloatArray, apart_s: float, beyond: int) -> tuple[str, ...]:
    """What the check points still want to prove an upload."""
    if not left_deg.size:
        return ("no check point was taken after the upload",)
    if beyond:
        worst = f"the worst {left_deg.max():.3f} deg"
        return (f"{beyond} of {_those(left_deg)} beyond the tolerance: {worst}",)
    if left_deg.size < CHECK_POINTS:
        return (f"{CHECK_POINTS} check points are needed",)
    if apart_s < CHECKS_APART_S:
        return ("all of them are in one direction: take another one half an hour later",)
    return ()


def _year_against(newest: UploadRecord, judgement: Analysis | None) -> tuple[tuple[str, ...], bool]:
    """What the points say against what was uploaded, and whether theirs is to be uploaded."""
    if judgement is None:
        return (), False
    verdict, expected = judgement.verdict, forecast_with(judgement, *newest.writes)
    unsure = expected.probability_within_tolerance < expected.rule.probability - DRAWN
    done = verdict.state == "done"
    against = []
    if unsure:
        cure = ": upload the coefficients of all points" if done else ": take more points"
        cure = "" if verdict.first else cure
        against.append(f"the year with what was uploaded is {expected.sure_words}{cure}")
    if not done and (verdict.first or not unsure):
        against.append(f"the verdict is not DONE: {verdict.reasons[0]}")
    return tuple(against), done and unsure


def _still_in_force(left: SunOffset | PointRecord | CheckRecord, *, settles: bool) -> str:
    """``settles``: whether nothing else is to be done first."""
    at = clock_utc(parse_utc(getattr(left, "read_utc", None) or left.utc))
    still = f"the Set Sun Offset of {at} is still in force"
    return f"{still}: upload again, or set it anew and take a check point" if settles else still
