"""The profile form: texts of its fields to a profile and back; an error names its field."""

from collections.abc import Callable, Mapping
from typing import TypeVar

from solarcal.decimals import decimal, shortest
from solarcal.errors import ConfigurationError, harmless
from solarcal.profiles import NAME, MountDescription, Profile, parse_coefficients
from solarcal.site import Inclinometer, Site, Weather, parse_bolt_circle
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS

Value = TypeVar("Value")

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
        "driver": profile.driver,
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
        "last_coefficients": " ".join(map(shortest, profile.last_coefficients or ())),
        "bolt_circle": profile.bolt_circle.words() if profile.bolt_circle else "",
        **_mount_texts(profile.mount),
    }


def _mount_texts(mount: MountDescription | None) -> dict[str, str]:
    if mount is None:
        return {name: "" for name, _, _ in MOUNT_FIELDS}
    return {
        "unit_name": mount.unit_name,
        "geometry": mount.geometry,
        "ax1_centre_deg": "" if mount.ax1_centre_deg is None else f"{mount.ax1_centre_deg:g}",
        "drive1": mount.drive1,
        "drive2": mount.drive2,
        "limits1_deg": "" if mount.limits1_deg is None else _pair_text(mount.limits1_deg),
        "limits2_deg": "" if mount.limits2_deg is None else _pair_text(mount.limits2_deg),
        "reference_deg": ""
        if mount.reference1_deg is None
        else _pair_text((mount.reference1_deg, mount.reference2_deg)),
        "update_range_deg": f"{mount.update_range_deg:g}",
        "zone_west_h": f"{mount.zone_west_h:g}",
        "display": mount.display,
        "display_sun": "yes" if mount.display_sun else "no",
    }


def _pair_text(pair: tuple[float, float]) -> str:
    return f"{pair[0]:g} {pair[1]:g}"


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
    form = {name: harmless(texts.get(name, "")).strip() for name, _, _ in FIELDS}
    if not NAME.fullmatch(form["name"]):
        raise FieldError("name", "use 1 to 40 letters, digits, spaces, - and _")
    tolerance = _number(form, "tolerance_deg", 0.001, 10.0, default=0.1)
    baudrate = _number(form, "baudrate", 300.0, 4e6, default=9600.0)
    return Profile(
        name=form["name"],
        operator=form["operator"],
        pointing_device=form["pointing_device"],
        tolerance_deg=tolerance,
        done_probability=Profile().done_probability if before is None else before.done_probability,
        unmodelled={} if before is None else before.unmodelled,
        driver=_driver(form),
        port=form["port"],
        baudrate=int(baudrate),
        site=_site(form),
        weather=_weather(form),
        inclinometer=_inclinometer(form),
        last_coefficients=_parsed(form, "last_coefficients", parse_coefficients),
        bolt_circle=_parsed(form, "bolt_circle", parse_bolt_circle),
        mount=_mount(form, before.mount if before is not None else None),
    )


def _driver(form: Mapping[str, str]) -> str:
    name = form["driver"] or DEFAULT_DRIVER
    if name not in DRIVERS:
        raise FieldError("driver", f"{name!r} is none of {', '.join(DRIVERS)}")
    return name


def _mount(form: Mapping[str, str], before: MountDescription | None) -> MountDescription | None:
    """Of the fields that were filled; ``None`` where the unit is left to tell all of it."""
    if not any(form[name] for name, _, _ in MOUNT_FIELDS):
        return None
    # Numpy comes with these: not before the first paint.
    from solarcal.mount.drive import parse_drive  # noqa: PLC0415
    from solarcal.mount.geometry import GEOMETRIES  # noqa: PLC0415

    new = {name: form[name] for name in ("unit_name", "geometry", "drive1", "drive2") if form[name]}
    if new.get("geometry", "azel") not in GEOMETRIES:
        raise FieldError("geometry", f"{form['geometry']!r} is none of {', '.join(GEOMETRIES)}")
    for name in ("drive1", "drive2"):
        try:
            parse_drive(new.get(name, MountDescription().drive1))
        except ConfigurationError as error:
            raise FieldError(name, str(error)) from None
    numbers: dict[str, object] = {
        "limits1_deg": _pair(form, "limits1_deg", -540.0, 540.0),
        "limits2_deg": _pair(form, "limits2_deg", -180.0, 360.0),
        "ax1_centre_deg": None
        if not form["ax1_centre_deg"]
        else _number(form, "ax1_centre_deg", -360.0, 360.0),
    }
    reference = _pair(form, "reference_deg", -540.0, 540.0)
    if reference is not None:
        numbers["reference1_deg"], numbers["reference2_deg"] = reference
    if form["update_range_deg"]:
        numbers["update_range_deg"] = _number(form, "update_range_deg", 0.001, 5.0)
    if form["zone_west_h"]:
        numbers["zone_west_h"] = _number(form, "zone_west_h", -14.0, 14.0)
    numbers |= _display(form)
    for name in ("limits1_deg", "limits2_deg"):
        limits = numbers[name]
        if isinstance(limits, tuple) and not limits[0] < limits[1]:
            raise FieldError(name, "the lower one comes first")
    # What the form has no field for.
    kept = {
        name: getattr(before or MountDescription(), name)
        for name in ("tilt_decimals", "scale_decimals")
    }
    return MountDescription(**{**kept, **new, **numbers})


def _display(form: Mapping[str, str]) -> dict[str, object]:
    """What the unit's display shows, where the form says it."""
    told: dict[str, object] = {}
    if form["display"]:
        if form["display"] not in ("angles", "counts"):
            raise FieldError("display", f"{form['display']!r} is neither angles nor counts")
        told["display"] = form["display"]
    if form["display_sun"]:
        if form["display_sun"] not in ("yes", "no"):
            raise FieldError("display_sun", f"{form['display_sun']!r} is neither yes nor no")
        told["display_sun"] = form["display_sun"] == "yes"
    return told


def _pair(
    form: Mapping[str, str], field: str, low: float, high: float
) -> tuple[float, float] | None:
    if not form[field]:
        return None
    parts = form[field].replace(";", " ").split()
    if len(parts) != 2:
        raise FieldError(field, f"write two numbers with a space between, not {form[field]!r}")
    first, second = (_number({field: part}, field, low, high) for part in parts)
    return first, second


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


def _parsed(form: Mapping[str, str], field: str, parse: Callable[[str], Value]) -> Value | None:
    """The field's value; None where it is empty."""
    if not form[field]:
        return None
    try:
        return parse(form[field])
    except ConfigurationError as error:
        raise FieldError(field, str(error)) from None


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
        return decimal(text, low, high, comma=True)
    except ConfigurationError as error:
        raise FieldError(field, str(error)) from None
