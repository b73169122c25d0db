"""The profile form: texts of its fields to a profile and back; an error names its field."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, get_args

from solarcal.decimals import decimal, shortest
from solarcal.errors import ConfigurationError, harmless
from solarcal.profiles import (
    NAME,
    DisplayShows,
    GeometryName,
    MountDescription,
    Profile,
    parse_coefficients,
)
from solarcal.site import BoltCircle, Inclinometer, Site, Weather, parse_bolt_circle
from solarcal.unit.drivers import DRIVERS

FIELDS: tuple[tuple[str, str, str], ...] = (
    ("name", "Profile name", "letters, digits, - and _"),
    ("operator", "Operator", "your name, recorded in every session"),
    ("pointing_device", "Pointing device", "e.g. sunspot plate, 1 m"),
    ("tolerance_deg", "Tolerance, deg", "0.1"),
    ("driver", "Driver", ", ".join(DRIVERS)),
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
    ("last_coefficients", "Last coefficients P1..P6", "six numbers; empty: none"),
    ("bolt_circle", "Bolt circle, for shims", "diameter mm,bolts,azimuth; e.g. 400,4,45"),
    ("unit_name", "Mount: name of the unit", "the rest is for units that do not report it"),
    ("geometry", "Mount: geometry", "azel, tiltroll-ew, tiltroll-ns or polar"),
    ("ax1_centre_deg", "Mount: centre of axis 1, deg", "empty: by the site"),
    ("drive1", "Mount: drive of axis 1", "rotary:COUNTS_PER_DEG or screwjack:..."),
    ("drive2", "Mount: drive of axis 2", "the same"),
    ("limits1_deg", "Mount: limits of axis 1, deg", "e.g. -130 130; empty: the unit's"),
    ("limits2_deg", "Mount: limits of axis 2, deg", "e.g. 3 88"),
    ("reference_deg", "Mount: reference read-outs, deg", "both axes; empty: 0 80 (south: 180 80)"),
    ("update_range_deg", "Mount: update range, deg", "0.1"),
    ("zone_west_h", "Mount: zone, hours WEST of UTC", "of the unit's clock, standard time; e.g. 7"),
    ("display", "Mount: display shows", "angles or counts; for driver typed"),
    ("display_sun", "Mount: display shows the Sun", "yes or no: its axis angles too"),
)
"""Field, label, hint; in the order of the form."""

MOUNT_FIELDS = FIELDS[-12:]


@dataclass(frozen=True, slots=True)
class Kind:
    """How the value of a field is read from its text, and how it is shown."""

    read: Callable[[str], Any] = str
    show: Callable[[Any], str] = str


def _general(value: float) -> str:
    return f"{value:g}" if abs(value) < 1e5 else repr(value)


def _number(low: float, high: float, show: Callable[[float], str] = _general) -> Kind:
    # A technician's keyboard may have a decimal comma.
    return Kind(partial(decimal, low=low, high=high, comma=True), show)


def _pair(low: float, high: float, *, rising: bool = False) -> Kind:
    def read(text: str) -> tuple[float, ...]:
        parts = text.replace(";", " ").split()
        if len(parts) != 2:
            raise ConfigurationError(f"write two numbers with a space between, not {text!r}")
        pair = tuple(decimal(part, low, high, comma=True) for part in parts)
        if rising and not pair[0] < pair[1]:
            raise ConfigurationError("the lower one comes first")
        return pair

    return Kind(read, lambda pair: f"{pair[0]:g} {pair[1]:g}")


def _word(*words: str) -> Kind:
    def read(text: str) -> str:
        if text not in words:
            raise ConfigurationError(f"{text!r} is none of {', '.join(words)}")
        return text

    return Kind(read)


def _name(text: str) -> str:
    if not NAME.fullmatch(text):
        raise ConfigurationError("use 1 to 40 letters, digits, spaces, - and _")
    return text


def _drive(text: str) -> str:
    # Numpy comes with it: not before the first paint.
    from solarcal.mount.drive import parse_drive  # noqa: PLC0415

    parse_drive(text)
    return text


def _yes(text: str) -> bool:
    return bool(_word("yes", "no").read(text) == "yes")


TEXT = Kind()
KINDS = {
    "name": Kind(_name),
    "tolerance_deg": _number(0.001, 10.0),
    "driver": _word(*DRIVERS),
    "baudrate": Kind(lambda text: int(decimal(text, 300.0, 4e6, comma=True))),
    "latitude_deg": _number(-90.0, 90.0, repr),
    "longitude_deg": _number(-180.0, 360.0, repr),
    "elevation_m": _number(-500.0, 9000.0),
    "pressure_hpa": _number(300.0, 1100.0),
    "temperature_c": _number(-60.0, 70.0),
    "lean_north_deg": _number(-20.0, 20.0, repr),
    "lean_east_deg": _number(-20.0, 20.0, repr),
    "lean_sigma_deg": _number(0.0001, 10.0, repr),
    "last_coefficients": Kind(parse_coefficients, lambda six: " ".join(map(shortest, six))),
    "bolt_circle": Kind(parse_bolt_circle, BoltCircle.words),
    "geometry": _word(*get_args(GeometryName)),
    "ax1_centre_deg": _number(-360.0, 360.0),
    "drive1": Kind(_drive),
    "drive2": Kind(_drive),
    "limits1_deg": _pair(-540.0, 540.0, rising=True),
    "limits2_deg": _pair(-180.0, 360.0, rising=True),
    "reference_deg": _pair(-540.0, 540.0),
    "update_range_deg": _number(0.001, 5.0),
    "zone_west_h": _number(-14.0, 14.0),
    "display": _word(*get_args(DisplayShows)),
    "display_sun": Kind(_yes, lambda shown: "yes" if shown else "no"),
}
"""Of the fields that are no plain texts."""

PARTS: dict[str, tuple[str, ...]] = {
    "site": ("site_name", "latitude_deg", "longitude_deg", "elevation_m"),
    "weather": ("pressure_hpa", "temperature_c"),
    "inclinometer": ("lean_north_deg", "lean_east_deg", "lean_sigma_deg"),
    "mount": tuple(name for name, _, _ in MOUNT_FIELDS),
}
"""The fields of what is a part of the profile; the others are its own."""

CALLED = {
    "site_name": "name",
    "lean_sigma_deg": "sigma_deg",
    "reference_deg": "reference1_deg reference2_deg",
}
"""What a field fills, where that has another name."""

NEEDED = {"site": ("latitude_deg", "longitude_deg"), "inclinometer": PARTS["inclinometer"]}
"""Fields without which there is no such part."""


class FieldError(ConfigurationError):
    """A field of the form that cannot be; ``field`` is its name."""

    def __init__(self, field: str, message: str) -> None:
        label = next((label for name, label, _ in FIELDS if name == field), field)
        super().__init__(f"{label}: {message}")
        self.field = field


def form_texts(profile: Profile) -> dict[str, str]:
    """What each field of the form shows for a profile."""
    return {name: _shown(name, profile) for name, _, _ in FIELDS}


def _shown(name: str, profile: Profile) -> str:
    part = next((part for part, names in PARTS.items() if name in names), None)
    owner = profile if part is None else getattr(profile, part)
    values = [] if owner is None else [getattr(owner, one) for one in _attributes(name)]
    if not values or None in values:
        return ""
    return KINDS.get(name, TEXT).show(values[0] if len(values) == 1 else values)


def _attributes(name: str) -> list[str]:
    return CALLED.get(name, name).split()


def profile_from_form(texts: Mapping[str, str], before: Profile | None = None) -> Profile:
    """The profile the form describes.

    Parameters
    ----------
    before : the profile the form was filled from; what it has no field for stays as it was.

    Raises
    ------
    FieldError
        The first field that cannot be, by name.
    """
    before = before or Profile()
    typed = {name: harmless(texts.get(name, "")).strip() for name, _, _ in FIELDS}
    # A profile without a name is none; every other field may be empty.
    values = {name: _read(name, text) for name, text in typed.items() if text or name == "name"}
    own = values.keys() - {name for names in PARTS.values() for name in names}
    return Profile(
        **{name: values[name] for name in own},
        done_probability=before.done_probability,
        unmodelled=before.unmodelled,
        site=_site(values),
        weather=_weather(values),
        inclinometer=_inclinometer(values),
        mount=_mount(values, before.mount or MountDescription()),
    )


def _read(name: str, text: str) -> Any:
    try:
        return KINDS.get(name, TEXT).read(text)
    except ConfigurationError as error:
        raise FieldError(name, str(error)) from None


def _filled(part: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """What the form says of a part of the profile."""
    for name in NEEDED.get(part, ()):
        if name not in values:
            raise FieldError(name, "is missing")
    found: dict[str, Any] = {}
    for name in PARTS[part]:
        if name in values:
            filled = _attributes(name)
            found |= zip(filled, values[name] if len(filled) > 1 else [values[name]], strict=True)
    return found


def _site(values: Mapping[str, Any]) -> Site | None:
    if "latitude_deg" not in values and "longitude_deg" not in values:
        if "elevation_m" in values:
            raise FieldError("latitude_deg", "an elevation needs latitude and longitude as well")
        return None
    return Site(**_filled("site", values))


def _weather(values: Mapping[str, Any]) -> Weather | None:
    if "pressure_hpa" not in values:
        if "temperature_c" in values:
            raise FieldError("pressure_hpa", "a temperature needs the station pressure as well")
        return None
    return Weather(**_filled("weather", values))


def _inclinometer(values: Mapping[str, Any]) -> Inclinometer | None:
    if values.keys().isdisjoint(PARTS["inclinometer"]):
        return None
    return Inclinometer(**_filled("inclinometer", values))


def _mount(values: Mapping[str, Any], before: MountDescription) -> MountDescription | None:
    """Of the fields that were filled; ``None`` where the unit is left to tell all of it."""
    if values.keys().isdisjoint(PARTS["mount"]):
        return None
    return MountDescription(
        # What the form has no field for.
        tilt_decimals=before.tilt_decimals,
        scale_decimals=before.scale_decimals,
        **_filled("mount", values),
    )
