"""Scenarios of the two-mirror tracker: its hidden truth and the loop's settings, as TOML."""

import math
from importlib import resources
from pathlib import Path
from typing import Protocol

import msgspec

from solarcal.emulator.scenario import SiteSettings, built_in, read_scenario
from solarcal.emulator.settings import checked, refuse_unknown, require_ranges, with_setting
from solarcal.errors import ConfigurationError
from solarcal.sun.day import daylight
from solarcal.sun.ephemeris import SiteEphemeris
from solarcal.sun.moon import BRIGHT_ENOUGH, MoonLight, moon_day
from solarcal.timescale import parse_utc
from solarcal.two_mirror.mirrors import EulerBase, fixed_mirrors_matrix

DEFAULT_SCENARIO = "maido"
TARGETS = ("sun", "moon")
CONTROLS = ("step", "pid", "calculated")


class Sky(Protocol):
    """Where the target stands."""

    def horizontal_deg(self, utc_s: float) -> tuple[float, float]:
        """Azimuth (north through east) and airless zenith angle at POSIX UTC seconds."""
        ...


class MirrorLoop(msgspec.Struct, frozen=True, kw_only=True):
    """What the tracker's controller is set to.

    ``control``: ``pid`` (steps until the spot is near the centre, then PID), ``step`` or
    ``calculated``. ``believed_*_deg``: the Euler angles it begins with. ``step_margin``: a step is
    that many times what the Sun moves in a period. ``search_deg``: how far the spiral goes.
    """

    control: str = "pid"
    period_s: float = 1.0
    near_zenith_deg: float = 3.0
    step_margin: float = 3.0
    points: int = 100
    search_deg: float = 12.0
    believed_alpha_deg: float = 0.0
    believed_beta_deg: float = 0.0
    believed_gamma_deg: float = 0.0

    def __post_init__(self) -> None:
        if self.control not in CONTROLS:
            raise ConfigurationError(f"loop.control must be one of {', '.join(CONTROLS)}")
        ranges = {
            "period_s": (0.1, 10.0),
            "near_zenith_deg": (0.5, 15.0),
            "step_margin": (1.0, 20.0),
            "points": (3.0, 1000.0),
            "search_deg": (1.0, 30.0),
        }
        require_ranges(self, "loop", ranges)

    def believed(self) -> EulerBase:
        return EulerBase(self.believed_alpha_deg, self.believed_beta_deg, self.believed_gamma_deg)


class MirrorTruth(msgspec.Struct, frozen=True, kw_only=True):
    """What the controller does not know.

    ``flip1``, ``flip2``: that error signal of the diode is wired the wrong way round. ``clouds``:
    stretches without Sun, in minutes since the first instant. ``signal_noise``: one sigma of each
    quadrant, in parts of the whole light.
    """

    alpha_deg: float = 0.0
    beta_deg: float = 0.0
    gamma_deg: float = 0.0
    axis1_deg_s: float = 0.5
    axis2_deg_s: float = 0.5
    lag_s: float = 0.6
    counts_per_deg: float = 2000.0
    field_mrad: float = 20.0
    sun_radius_mrad: float = 4.65
    signal_noise: float = 0.003
    temperature_c: float = 15.0
    flip1: bool = False
    flip2: bool = False
    clouds: list[tuple[float, float]] = []
    fixed_mirrors: list[tuple[float, float, float]] = []

    def __post_init__(self) -> None:
        ranges = {
            "axis1_deg_s": (0.02, 20.0),
            "axis2_deg_s": (0.02, 20.0),
            "lag_s": (0.0, 10.0),
            "counts_per_deg": (10.0, 1e7),
            "field_mrad": (5.0, 200.0),
            "sun_radius_mrad": (1.0, 20.0),
            "signal_noise": (0.0, 0.1),
        }
        require_ranges(self, "truth", ranges)
        out = fixed_mirrors_matrix(self.fixed_mirrors)[:, 2]
        if out[2] < 1.0 - 1e-9:
            raise ConfigurationError(
                "truth.fixed_mirrors: the diode must look along the tracker's axis; behind these "
                f"it looks {math.degrees(math.acos(max(-1.0, out[2]))):.2f} deg beside it"
            )

    def base(self) -> EulerBase:
        return EulerBase(self.alpha_deg, self.beta_deg, self.gamma_deg)


class MirrorScenario(msgspec.Struct, frozen=True, kw_only=True):
    """A whole scenario. ``day``: the local date that is tracked from sunrise to sunset; of the Moon
    (``target``) the passage whose transit is nearest to that day's noon."""

    site: SiteSettings
    name: str = ""
    summary: str = ""
    day: str = "2026-09-12"
    target: str = "sun"
    loop: MirrorLoop = MirrorLoop()
    truth: MirrorTruth = MirrorTruth()

    def __post_init__(self) -> None:
        if self.target not in TARGETS:
            raise ConfigurationError(f"target must be one of {', '.join(TARGETS)}")

    def above(self, lowest_deg: float) -> tuple[float, float]:
        """When the target is above an airless elevation that day, POSIX UTC seconds.

        Raises
        ------
        ConfigurationError
            It does not get so high, or the Moon is not bright enough.
        """
        place, noon_s = self.site.place(), self.noon_utc_s()
        if self.target == "sun":
            span = daylight(place, noon_s, lowest_deg)
        else:
            passage = moon_day(noon_s, place, altitude_deg=lowest_deg)
            lit = float(passage.at_transit.illuminated)
            if lit < BRIGHT_ENOUGH:
                raise ConfigurationError(
                    f"day {self.day}: the Moon is {lit:.0%} lit, less than the {BRIGHT_ENOUGH:.0%} "
                    "a diode can follow; choose a day nearer to full Moon"
                )
            rises, sets = passage.rise_utc_s, passage.set_utc_s
            span = None if rises is None or sets is None else (rises, sets)
        if span is None:
            name = self.target.capitalize()
            raise ConfigurationError(
                f"day {self.day}: the {name} does not get {lowest_deg:g} deg high at this site; "
                "choose another day"
            )
        return span

    def sky(self, first_utc_s: float, last_utc_s: float) -> "Sky":
        """The target's exact airless place between two instants."""
        place = self.site.place()
        if self.target == "sun":
            return SiteEphemeris(place, first_utc_s, last_utc_s)
        return MoonLight(place, first_utc_s, last_utc_s)

    def noon_utc_s(self) -> float:
        """Local noon of the day by the zone, POSIX seconds."""
        return parse_utc(self.day.strip()[:10]) + (12.0 + self.site.zone_west_h) * 3600.0


def mirror_scenario_names() -> list[str]:
    """The built-in scenarios."""
    return built_in(_folder())


def load_mirror_scenario(
    name_or_path: str | Path, settings: list[str] | None = None
) -> MirrorScenario:
    """A built-in scenario by its name or one from a TOML file, with ``key=value`` applied.

    Raises
    ------
    ConfigurationError
        Unknown scenario or key, a value of another type or out of range, an unreadable file.
    """
    document, name = read_scenario(
        str(name_or_path), _folder(), "two-mirror scenario", mirror_scenario_names()
    )
    refuse_unknown(document, MirrorScenario, name)
    source = f"scenario {name}"
    for setting in settings or []:
        document = with_setting(document, setting, MirrorScenario)
        source += f" --set {setting}"
    scenario = checked(document, MirrorScenario, source)
    try:
        scenario.noon_utc_s()
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: day {error}") from None
    return scenario


def _folder() -> resources.abc.Traversable:
    return resources.files("solarcal.two_mirror") / "scenarios"
