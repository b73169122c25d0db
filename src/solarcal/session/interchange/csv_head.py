"""What stands above a points table: ``key=value`` comments about unit and site."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypedDict

from solarcal.decimals import decimal
from solarcal.errors import ConfigurationError, InputFileError, one_line
from solarcal.mount.geometry import GEOMETRIES, default_ax1_centre
from solarcal.optics.offset_mirror import (
    Heliostat,
    format_mirror,
    format_target,
    heliostat_of,
    parse_mirror,
    parse_target,
)
from solarcal.session.points import IDEALS, PointTable
from solarcal.site import Site
from solarcal.timescale import format_utc, parse_utc

NUMBER_KEYS = ("lat_deg", "lon_deg", "elevation_m", "ax1_centre_deg")
SEPARATOR_LINE = re.compile(r"sep=([,;|\t])", re.IGNORECASE)
"""What a spreadsheet writes before a table, to know its own separator again."""
KEYS = ("geometry", "unit", "ideal", "target", "mirror", *NUMBER_KEYS)


class UnitFillIn(TypedDict, total=False):
    """What the command line knows of the unit and a file may lack."""

    geometry: str | None
    latitude_deg: float | None
    longitude_deg: float | None
    elevation_m: float | None
    unit: str | None
    ideal: str | None


_FILLED = {
    "geometry": "geometry",
    "lat_deg": "latitude_deg",
    "lon_deg": "longitude_deg",
    "elevation_m": "elevation_m",
    "unit": "unit",
    "ideal": "ideal",
}
"""Key of a file -> what fills it in."""


@dataclass(frozen=True, slots=True)
class Head:
    """Unit and site of a points file, options filled in."""

    geometry: str
    latitude_deg: float | None
    longitude_deg: float | None
    elevation_m: float
    unit: str
    ax1_centre_deg: float
    ideal: str
    warnings: tuple[str, ...]
    heliostat: Heliostat | None = None

    def of_unit(self) -> dict[str, Any]:
        """What a ``PointTable`` has of unit and site, as its keywords."""
        names = (
            "geometry", "latitude_deg", "longitude_deg", "elevation_m", "unit", "ax1_centre_deg",
            "ideal", "heliostat",
        )  # fmt: skip
        return {name: getattr(self, name) for name in names}


def read_head(text: str, path: str | Path, fill_in: UnitFillIn) -> Head:
    """The ``# key=value`` lines before the header line, completed by ``fill_in``.

    Raises
    ------
    InputFileError
        A known key given twice or with a value that cannot be.
    ConfigurationError
        The geometry is neither in the file nor given.
    """
    written: dict[str, str | float] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        bare = line.strip().strip('"')
        if bare and not bare.startswith("#"):
            break
        take_key(written, bare.lstrip("# \t"), f"{path}:{number}")
    return complete_head(written, path, fill_in)


def without_separator_line(text: str) -> tuple[str, str]:
    """The text with an empty first line where that was ``sep=,``, and the separator it named."""
    first, end, rest = text.partition("\n")
    named = SEPARATOR_LINE.fullmatch(first.rstrip("\r").strip('"'))
    return (text, ",") if named is None else (end + rest, named[1])


def take_key(written: dict[str, str | float], text: str, where: str) -> None:
    """Enter ``key=value`` into ``written`` if the key is a known one; other text is a remark."""
    key, equals, value = text.partition("=")
    key, value = key.strip().lower(), value.strip().rstrip(", \t")
    if not equals or key not in KEYS:
        return
    if key in written:
        raise InputFileError(f"{where}: {key} is given twice")
    if key in NUMBER_KEYS:
        try:
            number = decimal(value)
        except ConfigurationError as error:
            raise InputFileError(f"{where}: {key}={error}") from None
        if key == "ax1_centre_deg" and abs(number) > 360.0:
            raise InputFileError(f"{where}: ax1_centre_deg={number:g} is not within 360 of zero")
        written[key] = number
        return
    allowed = {"geometry": GEOMETRIES, "ideal": IDEALS}.get(key)
    if allowed is not None and value not in allowed:
        raise InputFileError(f"{where}: {key}={value!r} is none of {', '.join(allowed)}")
    written[key] = value


def complete_head(
    written: Mapping[str, str | float], path: str | Path, fill_in: UnitFillIn
) -> Head:
    """The file's own word first, then ``fill_in``, then the defaults."""
    supplied: Mapping[str, Any] = fill_in
    pairs = [(key, written.get(key), supplied.get(name)) for key, name in _FILLED.items()]
    warnings = [w for key, own, option in pairs if (w := fill(key, path, own, option))]
    known = {key: own if own is not None else option for key, own, option in pairs}
    geometry = known["geometry"]
    if geometry is None:
        raise ConfigurationError(
            f"{path} does not say its geometry; add --geometry or a line # geometry=azel "
            f"(one of {', '.join(GEOMETRIES)})"
        )
    if geometry not in GEOMETRIES:
        raise ConfigurationError(f"geometry {geometry!r} is none of {', '.join(GEOMETRIES)}")
    latitude = _number(known["lat_deg"])
    longitude = _number(known["lon_deg"])
    told = _number(known["elevation_m"])
    elevation = 0.0 if told is None else told
    try:
        Site(latitude or 0.0, longitude or 0.0, elevation)
        heliostat = heliostat_of(
            parse_target(str(written.get("target", "-"))),
            parse_mirror(str(written.get("mirror", "0:0:0"))),
        )
    except ConfigurationError as error:
        raise InputFileError(f"{path}: {error}") from None
    centre = _number(written.get("ax1_centre_deg"))
    return Head(
        geometry=str(geometry),
        latitude_deg=latitude,
        longitude_deg=longitude,
        elevation_m=elevation,
        unit=str(known["unit"] or ""),
        ax1_centre_deg=default_ax1_centre(str(geometry), latitude or 0.0)
        if centre is None
        else centre,
        ideal=str(known.get("ideal") or "apparent"),
        warnings=tuple(warnings),
        heliostat=heliostat,
    )


def head_lines(table: PointTable) -> list[str]:
    """``key=value`` of all that is known; numbers to the last bit."""
    values = {
        "geometry": table.geometry,
        "lat_deg": table.latitude_deg,
        "lon_deg": table.longitude_deg,
        "elevation_m": table.elevation_m,
        # A name is one line, whatever was typed.
        "unit": one_line(table.unit).rstrip(",") or None,
        "ax1_centre_deg": table.ax1_centre_deg,
        "ideal": table.ideal,
        "target": None if table.heliostat is None else format_target(table.heliostat.target),
        "mirror": None
        if table.heliostat is None
        else format_mirror(table.heliostat.reduced_offset),
    }
    return [
        f"{key}={value if isinstance(value, str) else repr(float(value))}"
        for key, value in values.items()
        if value is not None
    ]


def instant_text(utc_s: float) -> str:
    """ISO 8601 with milliseconds where they say it all, else microseconds."""
    short = format_utc(utc_s, 3)
    return short if parse_utc(short) == utc_s else format_utc(utc_s, 6)


def _number(value: str | float | None) -> float | None:
    return None if value is None else float(value)


def fill(given: str, path: str | Path, written: object, supplied: object) -> str | None:
    """A warning where an option contradicts what the file says; the file is believed."""
    if supplied is None or written is None or written == supplied:
        return None
    return f"{path}: its own {given} {written} was used, not the option's {supplied}"
