"""Before and after: what a unit would have done and will do, and whether the proof was taken."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.model.forecast import Forecast
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.records import CheckRecord, UploadRecord
from solarcal.session.view import SessionView
from solarcal.units import rms


@dataclass(frozen=True, slots=True)
class SignOff:
    """What the uploads and check points of some sessions come to.

    Attributes
    ----------
    signed_off
        The newest upload reads back equal, and every accepted check point after it is within the
        tolerance; at least one there is.
    reason
        The sentence that says so, or why not.
    uploads
        Every live upload and rollback, oldest first.
    checks
        Accepted check points after the newest upload.
    sky_rms_deg, sky_max_deg
        Of these; None without any.
    """

    signed_off: bool
    reason: str
    uploads: tuple[UploadRecord, ...] = ()
    checks: tuple[CheckRecord, ...] = ()
    sky_rms_deg: float | None = field(default=None)
    sky_max_deg: float | None = field(default=None)

    @property
    def newest(self) -> UploadRecord | None:
        return self.uploads[-1] if self.uploads else None


def sign_off(views: Sequence[SessionView], tolerance_deg: float) -> SignOff:
    """Judge the check points of sessions of one unit, one of them perhaps still running."""
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
        for check in view.checks
        if check.status == "accepted"
        and check.sky_error_deg is not None
        and (check.seq > newest.seq if newest in view.uploads else check.utc > newest.utc)
    )
    left = np.array([check.sky_error_deg for check in checks], dtype=np.float64)
    signed_off, reason = _conclusion(newest, left, tolerance_deg)
    if not all(view.holds_upload for view in views):
        signed_off, reason = False, "the unit does not hold what was uploaded; upload again"
    return SignOff(
        signed_off,
        reason,
        uploads,
        checks,
        rms(left) if left.size else None,
        float(left.max()) if left.size else None,
    )


def _conclusion(
    newest: UploadRecord, left_deg: "np.ndarray[tuple[int], np.dtype[np.float64]]", limit_deg: float
) -> tuple[bool, str]:
    if newest.rollback:
        return False, "the newest upload was rolled back"
    if not newest.verified:
        return False, "the unit did not read back what was uploaded"
    if not left_deg.size:
        return False, "no check point was taken after the upload"
    n, worst = left_deg.size, float(left_deg.max())
    those = f"{counted(n, 'check point')} after the upload"
    if worst > limit_deg:
        beyond = int((left_deg > limit_deg).sum())
        return False, f"{beyond} of {those}: beyond the tolerance, the worst {worst:.3f} deg"
    return True, f"{those}: all within the tolerance, the worst {worst:.3f} deg"


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
    return judgement.forecast.uploading(held(coefficients, offsets))
