"""The records of a session file: one JSON object a line, the header first.

A record is frozen and complete in itself: whoever replays a session needs nothing but its records,
and every number the fit uses is in them, so that a replay gives the same answer to the last bit.
Angles are degrees, ``utc`` the laptop's time (ISO 8601, milliseconds), AX1 on the branch.
"""

from typing import Any, Literal

import msgspec

from solarcal.decimals import Pair
from solarcal.mount.drive import Drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import Limits
from solarcal.optics.offset_mirror import Heliostat
from solarcal.site import BoltCircle, Inclinometer, Site, Weather
from solarcal.stopping_rule import StoppingRule, Unmodelled

FORMAT_VERSION = 2
"""Format 2: a checksum on every line, sequence numbers without gaps."""

TYPED_FIRMWARE = "typed"
IMPORTED_MODEL = "imported"
"""Firmware name of a unit without a connection: its display was read, and typed."""

PointStatus = Literal["accepted", "aborted", "rejected"]


class UnitRecord(msgspec.Struct, frozen=True, kw_only=True):
    """Who was on the line. No port and no path: the same run on another line is the same file."""

    model: str
    serial: str
    firmware: str
    zone_west_h: float
    drive1: Drive
    drive2: Drive
    limits: Limits
    update_range_deg: float
    reference1_deg: float
    reference2_deg: float
    tilt_decimals: int
    scale_decimals: int
    site: Site
    heliostat: Heliostat | None = None
    """Target and mirror, where the axes turn a mirror's normal."""
    has_switches: bool = True
    """Whether reference checks end on switches."""

    @property
    def imported(self) -> bool:
        """No unit of ours was there: the points come from another program."""
        return self.model == IMPORTED_MODEL

    @property
    def typed(self) -> bool:
        """A person read its display and typed."""
        return self.firmware == TYPED_FIRMWARE


class Header(msgspec.Struct, frozen=True, kw_only=True, tag="header"):
    """First line of a session file. ``refraction`` is the one the CONTROLLER applies.

    ``true_sun`` is the Sun the points are taken on: ``precise``, unless an emulated world was given
    another; there, a pressure of 0 hPa means a world without air.

    ``sun_model`` of an imported session is what its ideal angles are: ``apparent``, ``airless`` or
    ``solartrak``. ``unknown`` names what an import did not contain (``latitude``, ``longitude``):
    the site then holds a zero in its place.
    """

    format: int = FORMAT_VERSION
    seq: int = 0
    utc: str
    software: str
    unit: UnitRecord
    site: Site
    geometry: str
    ax1_centre_deg: float
    sun_model: str = "solartrak"
    refraction: str = "none"
    true_sun: str = "precise"
    target: str = "sun"
    """What the points are taken on: ``sun``, or ``moon``. On the Moon their ideal angles are its
    apparent place, computed by this program: the unit's own are the Sun's."""
    tolerance_deg: float = 0.1
    done_probability: float = 0.95
    """With which the year must be within the tolerance before the calibration is done."""
    unmodelled: Unmodelled | None = None
    """What may be there beside P1..P6, the laptop's clock among it; None: of an older version."""
    coefficients: Coefficients = Coefficients()
    offsets: Offsets = Offsets()
    operator: str = ""
    weather: Weather = Weather()
    pointing_device: str = ""
    continues: str = ""
    unknown: tuple[str, ...] = ()
    inclinometer: Inclinometer | None = None
    """The lean as read on the tower; a fit takes it as known beforehand."""
    last_coefficients: Coefficients | None = None
    """Of the calibration before; a fit takes them as known beforehand, as far as they agree with
    the points."""
    bolt_circle: BoltCircle | None = None
    """The base plate's bolts, for shims."""

    @property
    def rule(self) -> StoppingRule:
        """When this calibration is done."""
        return StoppingRule(
            self.tolerance_deg, self.done_probability, self.unmodelled or Unmodelled()
        )


class _Record(msgspec.Struct, frozen=True, kw_only=True):
    seq: int
    utc: str


class Initialised(_Record, frozen=True, kw_only=True, tag="initialised"):
    """The technician began the calibration proper (Alt-F3)."""

    distance_to_limits_deg: float


class ClockSet(_Record, frozen=True, kw_only=True, tag="clock_set"):
    """Unit clock minus laptop clock, before and after setting."""

    before_s: float
    after_s: float
    tick_minus_laptop_s: float | None = None
    tick_sigma_s: float | None = None


class RefCheck(_Record, frozen=True, kw_only=True, tag="ref_check"):
    """Counts found at the reference switches, 0 expected; ``None``: the unit does not show them.

    Where ``at_switches`` is false: how far the read-outs came to stand from the reference position,
    in nominal counts; such a check cannot find counts that were missed.
    """

    number: int
    complete: bool
    difference_counts: tuple[int, int] | None
    at_switches: bool = True


class SunOffset(_Record, frozen=True, kw_only=True, tag="sun_offset", omit_defaults=True):
    """Set Sun Offset: the axes stood on the Sun at this instant.

    ``read_utc`` is that instant where it is not ``utc``: read off a display, and typed after that.
    ``slack_axes``: those that were seen to come forward by too little to take their backlash up.
    """

    ideal_deg: Pair
    reading_deg: Pair
    counts: tuple[int, int]
    offsets: Offsets
    coefficients: Coefficients
    approach: tuple[int, int]
    read_utc: str | None = None
    slack_axes: tuple[int, ...] = ()

    @property
    def instant(self) -> str:
        """When the axes stood there."""
        return self.read_utc or self.utc


class Answers(msgspec.Struct, frozen=True, kw_only=True):
    """The three questions in the manual's order; ``None`` was not asked."""

    ref_check: bool | None = None
    sun_offset: bool | None = None
    tracking: bool | None = None


class PointRecord(_Record, frozen=True, kw_only=True, tag="point"):
    """A data point, or the attempt at one.

    ``error_deg`` is the axis error, reading - ideal on the Sun: E(coefficients in force) + O, the
    TOTAL correction. ``ideal_deg``, ``reading_deg``, ``counts`` and ``offsets`` belong to the
    instant ``read_utc``: the Set Sun Offset the error is taken from (``basis`` "sun_offset"),
    or, where the offset was set without us seeing it, the gathering ("gathering"). On the Moon
    ("moon") they belong to the read-outs at rest, and there is no offset.
    """

    status: PointStatus
    answers: Answers
    reason: str = ""
    basis: Literal["sun_offset", "gathering", "moon"] | None = None
    read_utc: str | None = None
    unit_minus_laptop_s: float | None = None
    ideal_deg: Pair | None = None
    precise_deg: Pair | None = None
    reading_deg: Pair | None = None
    counts: tuple[int, int] | None = None
    offsets: Offsets | None = None
    coefficients: Coefficients | None = None
    approach: tuple[int, int] | None = None
    distance_to_limits_deg: float | None = None
    error_deg: Pair | None = None
    expected_counts: Pair | None = None
    found_counts: tuple[int, int] | None = None
    sigma_deg: float | None = None


class CheckRecord(_Record, frozen=True, kw_only=True, tag="check"):
    """A check point after an upload: never fitted. ``error_deg`` is what is LEFT, O on the Sun."""

    status: PointStatus
    answers: Answers
    reason: str = ""
    read_utc: str | None = None
    ideal_deg: Pair | None = None
    error_deg: Pair | None = None
    sky_error_deg: float | None = None


class FitRecord(_Record, frozen=True, kw_only=True, tag="fit"):
    """What the fit said after a point: for the history, never read back as truth."""

    method: str
    points: int
    coefficients: Coefficients
    sigmas: Coefficients | None
    sky_rms_deg: float
    message: str | None = None


class _Upload(_Record, frozen=True, kw_only=True):
    """What an upload replaces, and by what."""

    old_coefficients: Coefficients
    old_offsets: Offsets
    new_coefficients: Coefficients
    new_offsets: Offsets
    method: str = "linear"
    forced: str = ""
    rollback: bool = False

    @property
    def replaces(self) -> tuple[Coefficients, Offsets]:
        return self.old_coefficients, self.old_offsets

    @property
    def writes(self) -> tuple[Coefficients, Offsets]:
        return self.new_coefficients, self.new_offsets


class UploadBegun(_Upload, frozen=True, kw_only=True, tag="upload_begun"):
    """Written before the first write of an upload.

    The ``upload`` record after it is the outcome. Without one the unit may hold either.
    """

    def outcome(self, seq: int, utc: str, *, verified: bool, failure: str = "") -> "UploadRecord":
        """The record of how it ended."""
        fields = msgspec.structs.asdict(self) | {"seq": seq, "utc": utc}
        return UploadRecord(**fields, verified=verified, failure=failure)


class UploadRecord(_Upload, frozen=True, kw_only=True, tag="upload"):
    """How an upload ended: whether the unit read back exactly the new P and O.

    ``failure``: what went wrong on the way, where something did.
    """

    verified: bool
    failure: str = ""

    @property
    def changed(self) -> bool:
        """Whether the unit held anything else before."""
        return self.replaces != self.writes


class InForce(_Record, frozen=True, kw_only=True, tag="in_force"):
    """What the unit holds was compared with the newest upload, and the answer has changed."""

    coefficients: Coefficients
    offsets: Offsets
    as_uploaded: bool


class Restarted(_Record, frozen=True, kw_only=True, tag="restarted"):
    """The unit was noticed to have lost its reference: it was without power since ``since``."""

    since: str = ""


class Note(_Record, frozen=True, kw_only=True, tag="note"):
    text: str


class Typed(_Record, frozen=True, kw_only=True, tag="typed"):
    """What a person read off a unit's display and typed, by field, in their own digits.

    ``form`` is the step (``open``, ``clock``, ``reference``, ``offset``, ``point``, ``upload``,
    ``zero``, ``held``), ``read_utc`` the laptop's time of the look. ``kept``: what was doubted and
    kept all the same. ``corrected``: what had been typed before a doubt made them look again.
    """

    form: str
    read_utc: str
    values: dict[str, str]
    kept: tuple[str, ...] = ()
    corrected: tuple[dict[str, str], ...] = ()


class Void(_Record, frozen=True, kw_only=True, tag="void"):
    """Strikes record ``voids``. Voiding a void restores what it struck."""

    voids: int
    reason: str


class Override(_Record, frozen=True, kw_only=True, tag="override"):
    """A guard the technician overruled, in so many words."""

    guard: str
    reason: str


class LinkLost(_Record, frozen=True, kw_only=True, tag="link_lost"):
    reason: str


class LinkRestored(_Record, frozen=True, kw_only=True, tag="link_restored"):
    """``losses``: how often it was lost again since the ``link_lost`` before, each time within
    half a minute; those have no record of their own."""

    serial: str
    losses: int = 0


class Closed(_Record, frozen=True, kw_only=True, tag="closed"):
    """The file was closed on purpose; ``next`` names the file that continues, if any."""

    reason: str
    next: str = ""


class UnknownRecord(msgspec.Struct, frozen=True, kw_only=True):
    """A type this version does not know: kept in the file, ignored by everything."""

    seq: int
    utc: str
    type: str
    fields: dict[str, Any]


KnownRecord = (
    Header | Initialised | ClockSet | RefCheck | SunOffset | PointRecord | CheckRecord | FitRecord
    | UploadBegun | UploadRecord | InForce | Restarted | Note | Typed | Void | Override | LinkLost
    | LinkRestored | Closed
)  # fmt: skip
Record = KnownRecord | UnknownRecord
