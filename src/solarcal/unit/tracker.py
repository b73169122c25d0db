"""The ``Tracker`` interface: what the station asks of any controller, whatever its wire.

A driver turns these calls into its own protocol. Nothing here knows the Sun: ``ideal`` angles are
the UNIT's own.
"""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import Any, Protocol

import msgspec

from solarcal.decimals import Pair
from solarcal.mount.drive import Drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import Limits
from solarcal.optics.offset_mirror import Heliostat, MirrorOffset, heliostat_of
from solarcal.optics.reflection import Target
from solarcal.site import Site, Weather


class Mode(StrEnum):
    """What the unit is doing."""

    TRACK = "TRACK"
    MANUAL = "MANUAL"
    JOG = "JOG"
    REF = "REF"
    STOW = "STOW"
    STOP = "STOP"
    LIMIT = "LIMIT"
    FAULT = "FAULT"


class Capabilities(msgspec.Struct, frozen=True):
    """What a controller has. The defaults are those of a SolarTrak on a line.

    Attributes
    ----------
    has_link : it is read and commanded over a line; else a person reads its display and types.
    has_controller : it follows the Sun itself; else the station is its controller.
    has_clock : it has a clock of its own, which can be set; else it uses the laptop's.
    has_switches : a reference check ends on switches; else it goes to the reference position.
    has_offsets : it keeps reference offsets; else the station does.
    stores_coefficients : it keeps P1..P6 in a memory of its own; else the station does.
    emulated : its world is emulated too: ``Tracker.emulation`` answers.
    """

    has_link: bool = True
    has_controller: bool = True
    has_clock: bool = True
    has_switches: bool = True
    has_offsets: bool = True
    stores_coefficients: bool = True
    emulated: bool = False


TYPED = Capabilities(has_link=False)
"""A controller whose display a person reads."""

ROTATOR = Capabilities(
    has_controller=False,
    has_clock=False,
    has_switches=False,
    has_offsets=False,
    stores_coefficients=False,
)
"""A machine that turns where it is sent, no more."""


class UnitIdentity(msgspec.Struct, frozen=True):
    """Who answers. ``extensions`` are letters it announces."""

    model: str
    serial: str
    firmware: str
    protocol: int = 1
    extensions: frozenset[str] = frozenset()


class UnitSite(msgspec.Struct, frozen=True):
    """The unit's own site, and how it is mounted. Zone in hours WEST of UTC.

    ``heliostat`` is not part of the reply to ``SITE``: whoever read the parameters adds it.
    """

    site: Site
    zone_west_h: float
    geometry: str
    ax1_centre_deg: float = 0.0
    heliostat: Heliostat | None = None


class UnitParameters(msgspec.Struct, frozen=True):
    """What is set in the unit and needed to judge it. Reference position: absolute read-outs."""

    drive1: Drive
    drive2: Drive
    limits: Limits
    update_range_deg: float
    reference1_deg: float
    reference2_deg: float
    tilt_decimals: int
    scale_decimals: int
    target: Target | None = None
    """A heliostat's; ``None`` where the unit follows the Sun itself."""
    mirror: MirrorOffset = MirrorOffset()
    """A heliostat's REDUCED offsets, in units of the target's distance."""

    @property
    def heliostat(self) -> Heliostat | None:
        """Target and offsets in one unit of length; ``None`` where it is no heliostat."""
        return heliostat_of(self.target, self.mirror)


class Status(msgspec.Struct, frozen=True):
    """One exchange: what the unit believed and where its axes stood at one instant.

    ``unit_utc_s`` is the unit's local clock plus its zone. ``moving`` and ``approach`` hold the
    sense of motion of each axis now and of the last finished one: +1, -1, 0 (at rest / unknown).
    ``update_phase`` runs from 0 just after an update to 1 when the next one is due.
    ``memories_differ``: what is in force has not been stored permanently.

    Of a unit without a link, clock and Sun are computed; read-outs and offsets are those typed
    last, at ``typed_utc_s`` of the laptop's clock (``None``: not typed yet).
    """

    mode: Mode
    unit_utc_s: float
    ideal1_deg: float
    ideal2_deg: float
    reading1_deg: float
    reading2_deg: float
    counts1: int
    counts2: int
    target1_deg: float
    target2_deg: float
    offsets: Offsets
    moving: tuple[int, int]
    approach: tuple[int, int]
    update_phase: float
    referenced: bool
    unlocked_s: float
    memories_differ: bool = False
    typed_utc_s: float | None = None

    @property
    def ideal_deg(self) -> Pair:
        """Ideal AX1, AX2 as the unit computed them."""
        return self.ideal1_deg, self.ideal2_deg

    @property
    def reading_deg(self) -> Pair:
        """Where the axes stood."""
        return self.reading1_deg, self.reading2_deg

    @property
    def off_ideal_deg(self) -> Pair:
        """Where the axes stood minus the ideal angles."""
        return self.reading1_deg - self.ideal1_deg, self.reading2_deg - self.ideal2_deg

    @property
    def off_target_deg(self) -> Pair:
        """Where the axes stood minus where they were driven."""
        return self.reading1_deg - self.target1_deg, self.reading2_deg - self.target2_deg

    def on_sky_deg(self, axis1_deg: float, axis2_deg: float) -> float:
        """The angle on the sky that axis angles make where the unit's Sun stood."""
        return math.hypot(axis1_deg * math.sin(math.radians(self.ideal2_deg)), axis2_deg)

    @property
    def counts(self) -> tuple[int, int]:
        """What the registers said."""
        return self.counts1, self.counts2


class RefCheckResult(msgspec.Struct, frozen=True):
    """Counts found on the register when the reference switches were reached (0 expected).

    Of a unit without switches: how far the read-outs are from the reference position it was sent
    to. That says nothing of whether the read-outs are true.

    ``number`` 0: none yet since power-up. Neither ``complete`` nor ``running``: stopped before
    the end. A display may not show the counts: ``None``.
    """

    number: int
    complete: bool
    difference1: int | None
    difference2: int | None
    running: bool = False


class Stored(msgspec.Struct, frozen=True):
    """Coefficients and offsets in force (temporary memory) and in permanent memory."""

    coefficients: Coefficients
    offsets: Offsets
    permanent_coefficients: Coefficients
    permanent_offsets: Offsets


class Spot(msgspec.Struct, frozen=True):
    """What the sunspot device shows: by how much each axis must move to centre the Sun.

    Axis degrees, eye noise included; ``visible`` is false when the spot is off the target plate
    or the Sun is down.
    """

    visible: bool
    error1_deg: float
    error2_deg: float


class Truth(msgspec.Struct, frozen=True):
    """An emulator's hidden truth: the world's P1..P6 and the true error with what is in force."""

    coefficients: Coefficients
    day_rms_deg: float
    day_max_deg: float
    year_rms_deg: float


class EmulatedSky(msgspec.Struct, frozen=True):
    """What an almanac, a barometer and a thermometer of the emulated world say.

    ``sun`` is the model its Sun follows: ``precise``, as in the real world, or another for tests.
    """

    sun: str
    weather: Weather


class Emulation(Protocol):
    """The emulator-only requests (``X``). Never sent to a unit that does not announce them."""

    def time(self) -> tuple[float, float]:
        """True UTC and the laptop's UTC, POSIX seconds."""
        ...

    def speed(self) -> float:
        """Virtual seconds per real second; 0 when time moves only by ``advance``."""
        ...

    def set_speed(self, speed: float) -> float:
        """Let that many virtual seconds pass in a real one from now on; the speed as taken."""
        ...

    def advance(self, seconds: float) -> tuple[float, float]:
        """Let that much virtual time pass; the two times afterwards, as ``time`` gives them."""
        ...

    def spot(self) -> Spot: ...

    def sky(self) -> EmulatedSky: ...

    def truth(self) -> Truth: ...

    def fault(self, name: str) -> None: ...


class TypedDisplay(Protocol):
    """What a person reads a unit without a line by, and types."""

    @property
    def identity(self) -> UnitIdentity:
        """As it is described, before anything was typed."""
        ...

    def listen(self, heard: Callable[[Any], object]) -> None:
        """Call ``heard`` with every form as soon as it is answered, and with those before."""
        ...

    def read_display(self) -> Status:
        """Ask for what the display shows now, while the unit tracks."""
        ...


class Tracker(Protocol):
    """A controller. Every method may raise ``LinkError``, ``ProtocolError`` or ``UnitRefused``.

    Methods that write or move ask the unit for its unlock first; ``stop`` and ``stow`` never need
    one and may be called from another thread while another call is waiting.
    """

    @property
    def capabilities(self) -> Capabilities:
        """What this controller has; known once it is open."""
        ...

    @property
    def emulation(self) -> Emulation | None:
        """Its emulated world; None where it has none (``Capabilities.emulated``)."""
        ...

    @property
    def display(self) -> TypedDisplay | None:
        """What a person reads it by; None where it has a line (``Capabilities.has_link``)."""
        ...

    def open(self) -> UnitIdentity:
        """Open the line and learn who is there; again after a lost link."""
        ...

    def close(self) -> None: ...

    def site(self) -> UnitSite: ...

    def parameters(self) -> UnitParameters: ...

    def status(self) -> Status: ...

    def set_clock(self, utc_s: float) -> None: ...

    def set_mode(self, mode: Mode) -> None:
        """TRACK or MANUAL."""
        ...

    def stop(self) -> None: ...

    def stow(self) -> None: ...

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        """Go to absolute read-outs. The target expires after 5 s unless renewed."""
        ...

    def set_sun_offset(self) -> Status:
        """Set O so that reading = ideal + E + O where the axes now stand; that instant's status."""
        ...

    def start_ref_check(self) -> None:
        """Begin a reference check; ``ref_check_result`` tells when it is complete."""
        ...

    def ref_check_result(self) -> RefCheckResult: ...

    def stored(self) -> Stored: ...

    def write_coefficients(
        self, coefficients: Coefficients, offsets: Offsets, *, store: bool = True
    ) -> Stored:
        """One unlocked transaction: write P and O, store them if asked to, read both back."""
        ...

    def recent_traffic(self) -> tuple[str, ...]:
        """What went over its line last, oldest first: ``>`` sent to the unit, ``<`` received."""
        ...
