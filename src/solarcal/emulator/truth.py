"""The hidden truth of an emulated tracker: the ``[truth]`` table of a scenario."""

import math

import msgspec

from solarcal.errors import ConfigurationError
from solarcal.mount.drive import Drive, parse_drive
from solarcal.mount.mechanism import Mechanism
from solarcal.optics.offset_mirror import Heliostat, MirrorOffset
from solarcal.optics.reflection import Target
from solarcal.site import Site, Weather, standard_pressure_hpa
from solarcal.sun import REFRACTIONS, SUN_MODELS

MOST_NOISE_DEG = 10.0
LIGHTS = ("sun", "moon")


class MissedCounts(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Counts the encoder of ``axis`` (1 or 2) loses at ``at``, a time after the start ("+4h").

    ``counts`` is by how much the register reads too high from then on, hence the difference the
    next reference check finds.
    """

    at: str
    axis: int
    counts: int

    def __post_init__(self) -> None:
        if self.axis not in (1, 2):
            raise ConfigurationError(f"missed counts: axis {self.axis} is neither 1 nor 2")
        after_start_s(self.at)


class WorldTruth(msgspec.Struct, frozen=True, kw_only=True):
    """What is really so. Angles in degrees; counts, seconds and rates as the names say.

    The lean tilts the primary axis by ``lean_deg`` from -x (bearing 0) over y (bearing 90) of the
    native frame: P1 = lean cos(bearing), P3 = lean sin(bearing). For ``azel`` the bearing is the
    compass direction the tower's top leans to; ``tiltroll-ew``: 0 east end down, 90 southwards;
    ``tiltroll-ns``: 0 north end down, 90 eastwards; ``polar``: 0 pole end down, 90 eastwards.

    ``light`` is what shines on the sunspot device, ``sun`` or ``moon``; the controller computes the
    Sun whatever shines.
    """

    lean_deg: float = 0.0
    lean_bearing_deg: float = 0.0
    P1: float | None = None
    P2: float = 0.0
    P3: float | None = None
    P4: float = 0.0
    P5: float = 0.0
    P6: float = 0.0
    collimation_deg: float = 0.0
    nonperpendicularity_deg: float = 0.0
    sag_deg: float = 0.0

    drive1: str = ""
    drive2: str = ""
    backlash1_deg: float = 0.0
    backlash2_deg: float = 0.0
    motor_speed1_deg_s: float = 0.8
    motor_speed2_deg_s: float = 0.8
    missed_counts: tuple[MissedCounts, ...] = ()
    missed_per_hour1: float = 0.0
    missed_per_hour2: float = 0.0
    switch_sigma_counts: float = 0.5
    stands1_deg: float = 0.0
    stands2_deg: float = 90.0

    light: str = "sun"
    sun: str = "precise"
    refraction: str = "hughes"
    pressure_hpa: float | None = None
    temperature_c: float = 20.0
    dut1_s: float = 0.0
    laptop_offset_s: float = 0.0
    unit_offset_s: float = 0.0
    unit_drift_s_per_day: float = 0.0

    target: tuple[float, float, float] | None = None
    mirror_offset: tuple[float, float, float] | None = None

    noise_deg: float = 0.02
    spot_range_deg: float = 3.0

    def __post_init__(self) -> None:
        if self.noise_deg > MOST_NOISE_DEG:
            raise ConfigurationError(
                f"truth.noise_deg: {self.noise_deg:g} is more than {MOST_NOISE_DEG:g}: "
                "use the noise of a real reading"
            )
        for name, value, known in (
            ("light", self.light, LIGHTS),
            ("sun", self.sun, SUN_MODELS),
            ("refraction", self.refraction, REFRACTIONS),
        ):
            if value not in known:
                raise ConfigurationError(
                    f"truth.{name}: {value!r} is not one of {', '.join(known)}"
                )
        for name in (
            "backlash1_deg", "backlash2_deg", "missed_per_hour1", "missed_per_hour2",
            "switch_sigma_counts", "noise_deg", "spot_range_deg",
        ):  # fmt: skip
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ConfigurationError(f"truth.{name} must be a number that is not negative")
        for name in ("motor_speed1_deg_s", "motor_speed2_deg_s"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ConfigurationError(f"truth.{name} must be greater than zero")

    def mechanism(self) -> Mechanism:
        bearing = math.radians(self.lean_bearing_deg)
        return Mechanism(
            P1=self.lean_deg * math.cos(bearing) if self.P1 is None else self.P1,
            P2=self.P2,
            P3=self.lean_deg * math.sin(bearing) if self.P3 is None else self.P3,
            P4=self.P4,
            P5=self.P5,
            P6=self.P6,
            collimation_deg=self.collimation_deg,
            nonperpendicularity_deg=self.nonperpendicularity_deg,
            sag_deg=self.sag_deg,
        )

    def drives(self, nominal1: Drive, nominal2: Drive) -> tuple[Drive, Drive]:
        """The drives as built; the nominal ones where the truth names no others."""
        return (
            parse_drive(self.drive1) if self.drive1 else nominal1,
            parse_drive(self.drive2) if self.drive2 else nominal2,
        )

    def heliostat(self, told: Heliostat | None) -> Heliostat | None:
        """True position of target and mirror; the configured one where the truth gives none."""
        if told is None:
            return None
        return Heliostat(
            told.target if self.target is None else Target(*self.target),
            told.offset if self.mirror_offset is None else MirrorOffset(*self.mirror_offset),
        )

    def weather(self, site: Site) -> Weather:
        """Air at the station; standard pressure of its elevation unless given."""
        pressure = self.pressure_hpa
        if pressure is None:
            pressure = standard_pressure_hpa(site.elevation_m)
        return Weather(pressure_hpa=pressure, temperature_c=self.temperature_c)


_UNIT_S = {"s": 1.0, "m": 60.0, "min": 60.0, "h": 3600.0}


def after_start_s(text: str) -> float:
    """Seconds of a time after the start: ``+4h``, ``+90min``, ``+300s``."""
    stripped = text.strip().removeprefix("+")
    number = stripped.rstrip("hmins")
    try:
        seconds = float(number) * _UNIT_S[stripped[len(number) :]]
    except (ValueError, KeyError):
        seconds = math.nan
    if not 0.0 <= seconds < math.inf:
        raise ConfigurationError(f"{text!r} is no time after the start; write +4h, +90min or +300s")
    return seconds
