"""Forms about heliostats: aim, target, drift, and two small sums."""

from typing import TYPE_CHECKING

from solarcal.tui.calculators.form import (
    GEOMETRY_FIELDS,
    PLACE_FIELDS,
    REFRACTION_FIELD,
    TIME_FIELD,
    Calculator,
    Form,
    FormField,
)

if TYPE_CHECKING:
    from solarcal.mount.geometry import MountGeometry
    from solarcal.optics.aiming import Heliostat
    from solarcal.report.field.answer import Answer

SIGHTINGS = 4
_BOARD = (
    FormField("target_azimuth", "Target azimuth", "deg", "180"),
    FormField("target_zenith", "Target zenith", "deg", "80"),
)
_OFFSET = (
    FormField("azimpivot_r", "AzimPivot_R", "length", "0"),
    FormField("pivotrefl_r", "PivotRefl_R", "length", "0"),
    FormField("pivotrefl_z", "PivotRefl_Z", "length", "0"),
)
DRAWN_LATITUDE_DEG = 45.0
"""Which way round the sky is drawn while no place is given."""


def sun_deg(form: Form) -> tuple[float, float]:
    """Azimuth and zenith angle: typed, or the apparent ones of place and time."""
    from solarcal.report.field.heliostat_aim import apparent_sun

    typed = form.pair("sun")
    if typed is not None:
        return typed
    sun = apparent_sun(form.utc_s("at"), form.site(), form.choice("refraction"))
    return float(sun.azimuth_deg), float(sun.zenith_deg)


def drawn_latitude_deg(form: Form) -> float:
    """The latitude there, or one north of the tropics."""
    latitude = form.optional("lat")
    return DRAWN_LATITUDE_DEG if latitude is None else latitude


def _heliostat(form: Form) -> "Heliostat":
    from solarcal.optics.aiming import Heliostat
    from solarcal.optics.heliostat import Target
    from solarcal.optics.offset_mirror import MirrorOffset

    offset = MirrorOffset(*(form.number(field.name) for field in _OFFSET))
    # Without an offset directions say everything, and any distance will do.
    distance = form.number("distance") if offset else form.optional("distance")
    azimuth, zenith = form.number("target_azimuth"), form.number("target_zenith")
    return Heliostat(Target(azimuth, zenith, 1.0 if distance is None else distance), offset)


def _geometry(form: Form) -> "MountGeometry":
    from solarcal.mount.geometry import MountGeometry, default_ax1_centre

    name, latitude, centre = form.choice("geometry"), form.optional("lat"), form.optional("centre")
    if name == "polar" and latitude is None:
        raise form.error("lat", "is missing; a polar mount's axes stand by the latitude")
    if centre is None:
        centre = default_ax1_centre(name, latitude or 0.0)
    return MountGeometry(name, latitude or 0.0, centre)


def _aim(form: Form) -> "Answer":
    from solarcal.report.field.heliostat_aim import aim

    return aim(
        sun_deg(form),
        _heliostat(form),
        _geometry(form),
        distance_known=form.optional("distance") is not None,
        latitude_deg=drawn_latitude_deg(form),
    )


def _drift(form: Form) -> "Answer":
    from solarcal.report.field.heliostat_aim import drift

    site, heliostat = form.site(), _heliostat(form)
    form.number("distance")
    return drift(site, heliostat, form.day_utc_s("at", site), form.choice("refraction"))


def _target(form: Form) -> "Answer":
    from solarcal.report.field.heliostat_target import Sighting, from_axes, target

    rows: list[Sighting] = []
    for number in range(1, SIGHTINGS + 1):
        row = _sighting(form, f"seen{number}")
        if row is not None:
            rows.append(row)
    if not rows:
        form.number("seen1")
    if form.choice("read") == "AX1 AX2":
        geometry = _geometry(form)
        rows = [from_axes(row, geometry) for row in rows]
    return target(rows, latitude_deg=drawn_latitude_deg(form))


def _sighting(form: Form, name: str) -> tuple[float, float, float, float] | None:
    """Sun and normal; a time with a T in it stands for the Sun."""
    from solarcal.report.field.heliostat_aim import apparent_sun

    text = form.text(name)
    if "T" not in text:
        found = form.numbers(name, 4)
        return None if found is None else (found[0], found[1], found[2], found[3])
    parts = text.split()
    if len(parts) != 3:
        raise form.error(name, "write the time and the normal's two angles")
    sun = apparent_sun(form.instant(name, parts[0]), form.site(), form.choice("refraction"))
    try:
        normal = float(parts[1].replace(",", ".")), float(parts[2].replace(",", "."))
    except ValueError:
        raise form.error(name, "the normal's angles must be numbers") from None
    return float(sun.azimuth_deg), float(sun.zenith_deg), *normal


def _circle(form: Form) -> "Answer":
    from solarcal.report.field.heliostat_target import circle

    return circle(form.number("angle"), form.number("distance"), form.number("radius"))


def _shift(form: Form) -> "Answer":
    from solarcal.report.field.heliostat_target import shift

    return shift(form.number("by"), form.number("distance"))


CALCULATORS = (
    Calculator(
        "heliostat-aim", "Heliostat", "Aim", "the mirror's normal; what its offset does to it",
        (
            FormField("sun", "Sun az, zenith", "deg", "180 40", "by time"),
            *_BOARD,
            FormField("distance", "Target distance", "length", hint="none"),
            *_OFFSET, *GEOMETRY_FIELDS, *PLACE_FIELDS, TIME_FIELD, REFRACTION_FIELD,
        ),
        _aim,
    ),
    Calculator(
        "heliostat-target", "Heliostat", "Targeting",
        "where the beam goes, from normals read there",
        (
            *(
                FormField(
                    f"seen{number}", f"{number}: Sun, normal", hint="az zen n1 n2"
                )
                for number in range(1, SIGHTINGS + 1)
            ),
            FormField(
                "read", "Normal read as", default="az zenith", choices=("az zenith", "AX1 AX2")
            ),
            *GEOMETRY_FIELDS, *PLACE_FIELDS, REFRACTION_FIELD,
        ),
        _target,
    ),
    Calculator(
        "heliostat-drift", "Heliostat", "Drift", "of an uncorrected mirror offset over a day",
        (
            *PLACE_FIELDS, TIME_FIELD, *_BOARD,
            FormField("distance", "Target distance", "length", "120"),
            FormField("azimpivot_r", "AzimPivot_R", "length", "0.12"),
            FormField("pivotrefl_r", "PivotRefl_R", "length", "0"),
            FormField("pivotrefl_z", "PivotRefl_Z", "length", "0.35"),
            REFRACTION_FIELD,
        ),
        _drift,
    ),
    Calculator(
        "heliostat-circle", "Heliostat", "Mirror on a circle", "both roots, front and back",
        (
            FormField("angle", "Sun to target", "deg", "22.5"),
            FormField("distance", "Target distance", "length", "5"),
            FormField("radius", "Circle's radius", "length", "1"),
        ),
        _circle,
    ),
    Calculator(
        "heliostat-shift", "Heliostat", "Translation", "by how much it turns the target",
        (
            FormField("by", "Moved by", "length", "3"),
            FormField("distance", "Distance", "length", "800"),
        ),
        _shift,
    ),
)  # fmt: skip
