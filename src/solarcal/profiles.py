"""Site, unit and operator profiles: what the technician would otherwise type every morning."""

import re
from collections.abc import Mapping
from pathlib import Path

import msgspec

from solarcal.config import config_dir, read_toml, write_toml
from solarcal.errors import ConfigurationError
from solarcal.inclinometer import Inclinometer
from solarcal.plain_text import harmless
from solarcal.site import Site, Weather

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,39}")


class Profile(msgspec.Struct, frozen=True, kw_only=True):
    """One site with its unit and operator. What is ``None`` or empty is taken from the unit."""

    name: str = "default"
    operator: str = ""
    pointing_device: str = ""
    tolerance_deg: float = 0.1
    port: str = ""
    driver: str = "solartrak"
    baudrate: int = 9600
    site: Site | None = None
    weather: Weather | None = None
    inclinometer: Inclinometer | None = None

    def summary(self) -> str:
        """One line for the start screen."""
        parts = [f"profile {self.name}"]
        if self.site is not None:
            place = f"{self.site.latitude_deg:+.4f} {self.site.longitude_deg:+.4f}"
            parts.append(f"{self.site.name} {place}".strip())
        else:
            parts.append("site as the unit says")
        parts.append(f"operator {self.operator}" if self.operator else "no operator named")
        return ", ".join(parts)


def profiles_dir() -> Path:
    return config_dir() / "profiles"


def profile_names() -> list[str]:
    folder = profiles_dir()
    return sorted(path.stem for path in folder.glob("*.toml")) if folder.is_dir() else []


def load_profile(name: str) -> Profile:
    """A saved profile; the empty one when there is none of that name.

    Raises
    ------
    ConfigurationError
        The file is damaged or a value in it cannot be.
    """
    if not name:
        return Profile()
    path = _path(name)
    return read_toml(path, Profile) if path.exists() else Profile(name=name)


def save_profile(profile: Profile) -> Path:
    """Write a profile into the profiles folder, nowhere else.

    Raises
    ------
    ConfigurationError
        A name that is no file's, or the file cannot be written.
    """
    path = _path(profile.name)
    write_toml(path, profile)
    return path


def _path(name: str) -> Path:
    """The file of a profile. A name comes from a file too and must not lead out of the folder."""
    if not _NAME.fullmatch(name):
        raise ConfigurationError(
            f"profile {name!r}: use 1 to 40 letters, digits, spaces, - and _ for a name"
        )
    return profiles_dir() / f"{name}.toml"


# -- the form --------------------------------------------------------------------------------

FIELDS: tuple[tuple[str, str, str], ...] = (
    ("name", "Profile name", "letters, digits, - and _"),
    ("operator", "Operator", "your name, kept in every session"),
    ("pointing_device", "Pointing device", "e.g. sunspot plate, 1 m"),
    ("tolerance_deg", "Tolerance, deg", "0.1"),
    ("port", "Port of the unit", "device or socket://host:port"),
    ("baudrate", "Baud rate", "9600"),
    ("site_name", "Site name", "optional"),
    ("latitude_deg", "Latitude, deg north", "south negative; empty: the unit's"),
    ("longitude_deg", "Longitude, deg EAST", "west negative; empty: the unit's"),
    ("elevation_m", "Elevation, m", "0"),
    ("pressure_hpa", "Station pressure, hPa", "empty: from the elevation"),
    ("temperature_c", "Temperature, C", "15"),
    ("lean_north_deg", "Inclinometer: lean north, deg", "empty: not read"),
    ("lean_east_deg", "Inclinometer: lean east, deg", "empty: not read"),
    ("lean_sigma_deg", "Inclinometer: sigma, deg", "e.g. 0.05"),
)
"""Field, label, hint; in the order of the form."""


class FieldError(ConfigurationError):
    """A field of the form that cannot be; ``field`` is its name."""

    def __init__(self, field: str, message: str) -> None:
        label = next((label for name, label, _ in FIELDS if name == field), field)
        super().__init__(f"{label}: {message}")
        self.field = field


def form_texts(profile: Profile) -> dict[str, str]:
    """What each field of the form shows for a profile."""

    def number(value: float | None) -> str:
        return "" if value is None else f"{value:g}" if abs(value) < 1e5 else repr(value)

    site, weather, lean = profile.site, profile.weather, profile.inclinometer
    return {
        "name": profile.name,
        "operator": profile.operator,
        "pointing_device": profile.pointing_device,
        "tolerance_deg": number(profile.tolerance_deg),
        "port": profile.port,
        "baudrate": str(profile.baudrate),
        "site_name": site.name if site else "",
        "latitude_deg": repr(site.latitude_deg) if site else "",
        "longitude_deg": repr(site.longitude_deg) if site else "",
        "elevation_m": number(site.elevation_m) if site else "",
        "pressure_hpa": number(weather.pressure_hpa) if weather else "",
        "temperature_c": number(weather.temperature_c) if weather else "",
        "lean_north_deg": repr(lean.lean_north_deg) if lean else "",
        "lean_east_deg": repr(lean.lean_east_deg) if lean else "",
        "lean_sigma_deg": repr(lean.sigma_deg) if lean else "",
    }


def profile_from_form(texts: Mapping[str, str]) -> Profile:
    """The profile the form describes.

    Raises
    ------
    FieldError
        The first field that cannot be, by name.
    """
    form = {name: harmless(texts.get(name, "")).strip() for name, _, _ in FIELDS}
    if not _NAME.fullmatch(form["name"]):
        raise FieldError("name", "use 1 to 40 letters, digits, spaces, - and _")
    tolerance = _number(form, "tolerance_deg", 0.001, 10.0, default=0.1)
    baudrate = _number(form, "baudrate", 300.0, 4e6, default=9600.0)
    return Profile(
        name=form["name"],
        operator=form["operator"],
        pointing_device=form["pointing_device"],
        tolerance_deg=tolerance,
        port=form["port"],
        baudrate=int(baudrate),
        site=_site(form),
        weather=_weather(form),
        inclinometer=_inclinometer(form),
    )


def _site(form: Mapping[str, str]) -> Site | None:
    if not form["latitude_deg"] and not form["longitude_deg"]:
        if form["elevation_m"]:
            raise FieldError("latitude_deg", "an elevation needs latitude and longitude as well")
        return None
    return Site(
        _number(form, "latitude_deg", -90.0, 90.0),
        _number(form, "longitude_deg", -180.0, 360.0),
        _number(form, "elevation_m", -500.0, 9000.0, default=0.0),
        form["site_name"],
    )


def _weather(form: Mapping[str, str]) -> Weather | None:
    if not form["pressure_hpa"]:
        if form["temperature_c"]:
            raise FieldError("pressure_hpa", "a temperature needs the station pressure as well")
        return None
    return Weather(
        _number(form, "pressure_hpa", 300.0, 1100.0),
        _number(form, "temperature_c", -60.0, 70.0, default=15.0),
    )


def _inclinometer(form: Mapping[str, str]) -> Inclinometer | None:
    names = ("lean_north_deg", "lean_east_deg", "lean_sigma_deg")
    if not any(form[name] for name in names):
        return None
    return Inclinometer(
        lean_north_deg=_number(form, names[0], -20.0, 20.0),
        lean_east_deg=_number(form, names[1], -20.0, 20.0),
        sigma_deg=_number(form, names[2], 0.0001, 10.0),
    )


def _number(
    form: Mapping[str, str], field: str, low: float, high: float, default: float | None = None
) -> float:
    text = form[field]
    if not text:
        if default is None:
            raise FieldError(field, "is missing")
        return default
    try:
        # A technician's keyboard may have a decimal comma.
        value = float(text.replace(",", "."))
    except ValueError:
        raise FieldError(field, f"{text!r} is not a number") from None
    if not low <= value <= high:
        raise FieldError(field, f"{value:g} is not between {low:g} and {high:g}")
    return value
