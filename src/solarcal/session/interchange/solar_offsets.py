"""Offsets of a solar radio telescope from maps of the Sun (``.tsv``), as solaris-pointing writes.

    # Location: MZS, Antarctica            metadata, "key: value"
    # offset_az: observed azimuth - solar azimuth [deg]
    timestamp  azimuth  elevation  offset_az  offset_el  [map_id, temperature, pressure, humidity]

Tabs between cells, degrees, azimuth from North through East, times UTC. Newer files give the Sun's
azimuth and elevation and offsets observed minus solar, older ones the observed place and solar
minus observed; the metadata say which. With AX1 = 180 - A and AX2 = 90 - E the errors are the
negative of observed minus solar.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Literal, Unpack

import numpy as np

from solarcal.errors import InputFileError
from solarcal.input_files import read_text
from solarcal.session.interchange.csv_head import UnitFillIn, complete_head
from solarcal.session.interchange.csv_points import TAB, Sheet, read_sheet
from solarcal.session.points import PointTable
from solarcal.units import RAD_PER_DEG, FloatArray, rms, wrap_deg

Offsets = Literal["plain", "on-sky"]

COLUMNS = ("timestamp", "azimuth", "elevation", "offset_az", "offset_el")
_SITE_KEYS = {
    "latitude": "lat_deg",
    "longitude": "lon_deg",
    "height": "elevation_m",
    "altitude": "elevation_m",
}
_FEWEST_TO_JUDGE = 12
_CLEARLY = 1.5
_HIGHEST_DEG = 89.9


def read_solar_offsets(
    path: str | Path, *, offsets: Offsets | None = None, **fill_in: Unpack[UnitFillIn]
) -> PointTable:
    """Read an offsets file.

    ``offsets`` says whether ``offset_az`` is ``plain`` azimuth or ``on-sky`` (already times
    cos E). Without it the metadata decide, else the data where one of the two fits a mount
    clearly better, else plain; a warning says which was taken and why.

    Raises
    ------
    InputFileError
        A missing column or a bad cell, named by line and column.
    ConfigurationError
        Another geometry than azel is asked for.
    """
    text = read_text(path)
    metadata = _metadata(text)
    sheet = read_sheet(text, path, COLUMNS, ("map_id",), TAB)
    missing = np.full(len(sheet.lines), True)
    utc_s = sheet.instants("timestamp", missing)
    azimuth = _numbers(sheet, "azimuth", -360.0, 720.0)
    elevation = _numbers(sheet, "elevation", -90.0, 90.0)
    offset_az = _numbers(sheet, "offset_az", -180.0, 180.0)
    offset_el = _numbers(sheet, "offset_el", -180.0, 180.0)
    sign = -1.0 if _solar_minus_observed(metadata.get("offset_az", "")) else 1.0
    # Observed minus solar from here on.
    offset_az, offset_el = sign * offset_az, sign * offset_el
    whole = np.isfinite(azimuth + elevation + offset_az + offset_el + utc_s)
    for row in np.flatnonzero(whole & (np.abs(elevation) > _HIGHEST_DEG))[:1]:
        raise sheet.error(int(row), "elevation", "is at the zenith, where azimuth has no meaning")
    kind, reason = _kind(
        offsets, metadata.get("offset_az", ""), azimuth[whole], elevation[whole], offset_az[whole]
    )
    cos_e = np.cos(elevation * RAD_PER_DEG)
    plain_az = offset_az / cos_e if kind == "on-sky" else offset_az
    warnings = [f"{path}: offset_az was taken as {_WORDS[kind]}, {reason}"]
    if "observed" in metadata.get("azimuth", ""):
        azimuth, elevation = azimuth - plain_az, elevation - offset_el
    keys = _site_keys(metadata, path)
    fill_in["unit"] = fill_in.get("unit") or metadata.get("location")
    head = complete_head({"geometry": "azel", **keys}, path, fill_in)
    n = len(whole)
    if not whole.all():
        warnings.append(
            f"{path}: {n - int(whole.sum())} of {n} rows have no offset and are left out"
        )
    return PointTable(
        **head.of_unit(),
        utc_s=utc_s,
        ax1_deg=wrap_deg(180.0 - azimuth, head.ax1_centre_deg),
        ax2_deg=90.0 - elevation,
        err1_deg=-plain_az,
        err2_deg=-offset_el,
        status=tuple("accepted" if good else "rejected" for good in whole.tolist()),
        approach=((0, 0),) * n,
        note=tuple(sheet.column("map_id")),
        labels=tuple(sheet.lines),
        sources=(str(path),) * n,
        warnings=(*warnings, *head.warnings),
    )


_WORDS: dict[Offsets, str] = {
    "plain": "plain azimuth",
    "on-sky": "on the sky (azimuth times cos E)",
}


def _metadata(text: str) -> dict[str, str]:
    """``# key: value`` lines before the header line, keys in lower case."""
    found: dict[str, str] = {}
    for line in text.splitlines():
        bare = line.strip()
        if bare and not bare.startswith("#"):
            break
        key, colon, value = bare.lstrip("# \t").partition(":")
        if colon:
            found.setdefault(key.strip().lower(), value.strip())
    return found


def _site_keys(metadata: Mapping[str, str], path: str | Path) -> dict[str, str | float]:
    keys: dict[str, str | float] = {}
    for name, key in _SITE_KEYS.items():
        if name in metadata:
            value, *_ = (*metadata[name].split(), "")
            try:
                keys[key] = float(value)
            except ValueError:
                raise InputFileError(f"{path}: {name} {metadata[name]!r} is not a number") from None
    return keys


def _numbers(sheet: Sheet, name: str, low: float, high: float) -> FloatArray:
    """A column in which NaN stands for what was not measured."""
    cells = sheet.column(name)
    if "nan" in "".join(cells).lower():
        cells = tuple("" if cell.strip().lower() == "nan" else cell for cell in cells)
        sheet = Sheet(sheet.path, {**sheet.columns, name: cells}, sheet.lines)
    return sheet.numbers(name, np.full(len(cells), True), low, high)


def _solar_minus_observed(description: str) -> bool:
    minuend, _, subtrahend = description.replace("\N{MINUS SIGN}", "-").partition("-")
    return "solar" in minuend.lower() and "observed" in subtrahend.lower()


def _kind(
    asked: Offsets | None,
    description: str,
    azimuth: FloatArray,
    elevation: FloatArray,
    off: FloatArray,
) -> tuple[Offsets, str]:
    """Plain or on the sky, and why."""
    fitting = _fitting_kind(azimuth, elevation, off)
    if asked is not None:
        doubt = f"; but {fitting[1]}" if fitting is not None and fitting[0] != asked else ""
        return asked, f"as asked{doubt}"
    if "cos" in description.lower():
        return "on-sky", "as its metadata say"
    if fitting is not None:
        return fitting
    return "plain", "because neither metadata nor data say otherwise (--offsets on-sky changes it)"


def _fitting_kind(
    azimuth: FloatArray, elevation: FloatArray, off: FloatArray
) -> tuple[Offsets, str] | None:
    """Which of the two a rigid mount's five cross terms fit clearly better; None for neither."""
    if len(off) < _FEWEST_TO_JUDGE:
        return None
    a, e = azimuth * RAD_PER_DEG, elevation * RAD_PER_DEG
    # On the sky: azimuth zero, collimation, axes not square, lean north, lean east.
    terms = np.column_stack(
        (np.cos(e), np.ones_like(e), np.sin(e), np.sin(a) * np.sin(e), np.cos(a) * np.sin(e))
    )
    spread = {}
    for kind, cross in (("plain", off * np.cos(e)), ("on-sky", off)):
        left = cross - terms @ np.linalg.lstsq(terms, cross, rcond=None)[0]
        spread[kind] = rms(left)
    better: Offsets = "plain" if spread["plain"] < spread["on-sky"] else "on-sky"
    worse = "on-sky" if better == "plain" else "plain"
    if spread[worse] < _CLEARLY * spread[better] or spread[worse] < 1e-6:
        return None
    return better, (
        f"which fits a mount to {spread[better]:.4f} deg, the other reading to {spread[worse]:.4f}"
    )
