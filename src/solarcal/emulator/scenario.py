"""Scenarios: a tracker with its hidden truth, as TOML, every key settable with ``key=value``."""

from collections.abc import Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from solarcal.emulator.settings import UnitSettings, checked, refuse_unknown, with_setting
from solarcal.emulator.truth import WorldTruth
from solarcal.emulator.world import World
from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import parse_toml, read_utf8
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.sun.moon import LUNAR_DAY_S, moon_position
from solarcal.timescale import SECONDS_PER_DAY, parse_utc

DEFAULT_SCENARIO = "tijeras-azel"
START_ELEVATION_DEG = 12.0
"""Elevation of the light when a scenario begins: high enough for a first point."""


class SiteSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Where the tracker truly stands. Longitude positive EAST; zone in hours WEST of UTC."""

    latitude_deg: float
    longitude_deg: float
    elevation_m: float = 0.0
    zone_west_h: float = 0.0

    def __post_init__(self) -> None:
        if not -15.0 <= self.zone_west_h <= 15.0:
            raise ConfigurationError("site.zone_west_h must lie between -15 and 15")
        self.place()

    def place(self) -> Site:
        return Site(self.latitude_deg, self.longitude_deg, self.elevation_m)


class Plan(msgspec.Struct, frozen=True, kw_only=True):
    """What an automatic technician is advised to do here."""

    points: int = 12
    every_min: float = 45.0


class Scenario(msgspec.Struct, frozen=True, kw_only=True):
    """A whole scenario.

    ``start`` is a date (when the Sun, or the Moon where that is the light, has risen to 12 deg
    that local day) or an ISO 8601 instant.
    """

    site: SiteSettings
    name: str = ""
    summary: str = ""
    start: str = "2026-06-03"
    unit: UnitSettings = UnitSettings()
    truth: WorldTruth = WorldTruth()
    plan: Plan = Plan()

    def start_utc_s(self) -> float:
        """The first true instant, POSIX seconds, a whole minute for a date.

        Raises
        ------
        ConfigurationError
            Neither a date nor an instant, or the light does not get 12 deg high that day.
        """
        try:
            return self._start_utc_s(self.start.strip())
        except ConfigurationError as error:
            raise ConfigurationError(f"start {self.start.strip()}: {error}") from None

    def _start_utc_s(self, text: str) -> float:
        instant_s = parse_utc(text)
        if len(text) > len("2026-06-03"):
            return instant_s
        midnight_s = instant_s + self.site.zone_west_h * 3600.0
        if self.truth.light == "moon":
            # Of a lunar day: in every month one date has no moonrise.
            minutes = midnight_s + np.arange(0.0, LUNAR_DAY_S, 60.0)
            elevation = moon_position(minutes, self.site.place()).elevation_deg
        else:
            minutes = midnight_s + np.arange(0.0, SECONDS_PER_DAY, 60.0)
            elevation = sun_position("solartrak", minutes, self.site.place()).elevation_deg
        # The zone may be far from the meridian: look for the rise, not for the first high Sun.
        rises = np.flatnonzero(
            (elevation[:-1] < START_ELEVATION_DEG) & (elevation[1:] >= START_ELEVATION_DEG)
        )
        if not rises.size:
            raise ConfigurationError(
                f"the {self.truth.light.capitalize()} does not rise through "
                f"{START_ELEVATION_DEG:g} deg that day "
                "at this site; give an instant like 2026-06-21T15:30:00Z"
            )
        return float(minutes[rises[0] + 1])

    @property
    def unit_zone_west_h(self) -> float:
        """The zone set in the unit."""
        own = self.unit.zone_west_h
        return self.site.zone_west_h if own is None else own

    def world(self, start_utc_s: float, seed: int) -> World:
        """The hidden truth at work from a true instant on."""
        unit, truth, site = self.unit, self.truth, self.site.place()
        return World(
            truth,
            site,
            unit.mount(site),
            truth.drives(*unit.drives()),
            (unit.reference1_deg, unit.reference2_deg),
            start_utc_s,
            seed,
            truth.heliostat(unit.heliostat()),
        )

    def with_settings(self, settings: Sequence[str]) -> "Scenario":
        """The scenario with ``key=value`` applied in order; see ``load_scenario``."""
        document = msgspec.to_builtins(self)
        for setting in settings:
            document = with_setting(document, setting, Scenario)
        return _build(document, " ".join(f"--set {setting}" for setting in settings))


def scenario_names() -> list[str]:
    """The built-in scenarios, the default first."""
    return sorted(built_in(_folder()), key=lambda name: name != DEFAULT_SCENARIO)


def built_in(folder: resources.abc.Traversable) -> list[str]:
    """Names of the scenarios in a folder of the package."""
    names = (entry.name for entry in folder.iterdir())
    return sorted(name.removesuffix(".toml") for name in names if name.endswith(".toml"))


def load_scenario(name_or_path: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """A built-in scenario by its name or one from a TOML file, with settings applied.

    ``settings`` are ``key=value`` with dotted keys (``truth.lean_deg=0.1``) and TOML values, where
    a text needs no quotes. A file may begin with ``extends = "NAME"``.

    Raises
    ------
    ConfigurationError
        Unknown scenario or key (the nearest is named), a value of another type or out of range, a
        file that cannot be read.
    """
    document = _document(str(name_or_path), extended=())
    scenario = _build(document, f"scenario {name_or_path}")
    return scenario.with_settings(settings) if settings else scenario


def _document(name_or_path: str, extended: tuple[str, ...]) -> dict[str, Any]:
    """The merged TOML document of a scenario and of those it extends."""
    if name_or_path in extended:
        raise ConfigurationError(f"scenario {name_or_path} extends itself")
    document, source = read_scenario(name_or_path, _folder(), "scenario", scenario_names())
    base_name = document.pop("extends", None)
    refuse_unknown(document, Scenario, source)
    if base_name is None:
        return document
    if not isinstance(base_name, str):
        raise ConfigurationError(f"{source}: extends must name a scenario")
    try:
        base = _document(base_name, (*extended, name_or_path))
    except ConfigurationError as error:
        raise ConfigurationError(f"scenario {source}: extends: {error}") from None
    return _merged(base, document)


def read_scenario(
    name_or_path: str, folder: resources.abc.Traversable, kind: str, names: list[str]
) -> tuple[dict[str, Any], str]:
    """The document of a scenario of that folder or of a file, and what messages call it.

    Raises
    ------
    ConfigurationError
        None of the ``names``, a file that cannot be read or is no TOML.
    """
    if name_or_path.endswith(".toml") or "/" in name_or_path:
        path = Path(name_or_path)
        try:
            text = read_utf8(path)
        except InputFileError as error:
            raise ConfigurationError(f"scenario {error}") from None
        source, name = str(path), path.stem
    else:
        if name_or_path not in names:
            raise ConfigurationError(
                f"no {kind} {name_or_path!r}; there is: {', '.join(names)} "
                "(or give a file NAME.toml)"
            )
        text = (folder / f"{name_or_path}.toml").read_text(encoding="utf-8")
        source = name = name_or_path
    try:
        document = parse_toml(text)
    except ValueError as error:
        raise ConfigurationError(f"scenario {source}: {error}") from None
    document["name"] = name
    return document, source


def _build(document: dict[str, Any], source: str) -> Scenario:
    scenario = checked(document, Scenario, source)
    try:
        # What only shows when it is used must be refused here, where its source is known.
        scenario.unit.mount(scenario.site.place())
        _require_reach(scenario)
        scenario.truth.mechanism()
        scenario.truth.heliostat(scenario.unit.heliostat())
        scenario.truth.weather(scenario.site.place())
    except ConfigurationError as error:
        raise ConfigurationError(f"{source}: {error}") from None
    return scenario


def _require_reach(scenario: Scenario) -> None:
    """Refuse drives, nominal or true, that cannot reach where the axes must or do stand."""
    unit, truth = scenario.unit, scenario.truth
    nominal = unit.drives()
    for axis, angles_deg, stands_deg in (
        (0, (*unit.limits1_deg, unit.reference1_deg, unit.stow1_deg), truth.stands1_deg),
        (1, (*unit.limits2_deg, unit.reference2_deg, unit.stow2_deg), truth.stands2_deg),
    ):
        true = truth.drives(*nominal)[axis]
        for angle_deg in angles_deg:
            nominal[axis].counts(angle_deg)
            true.counts(angle_deg)
        true.counts(stands_deg)


def _merged(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """``over`` merged into ``base``, table by table."""
    merged = dict(base)
    for key, value in over.items():
        below = merged.get(key)
        merged[key] = (
            _merged(below, value) if isinstance(below, dict) and isinstance(value, dict) else value
        )
    return merged


def _folder() -> resources.abc.Traversable:
    return resources.files("solarcal.emulator") / "scenarios"
