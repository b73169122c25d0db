"""Keys and values of a scenario: typed, checked, the nearest key named when one is wrong."""

import datetime
import difflib
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeVar

import msgspec

from solarcal.decimals import Six
from solarcal.errors import ConfigurationError
from solarcal.input_files import parse_toml
from solarcal.mount.drive import Drive, parse_drive
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.optics.offset_mirror import Heliostat, MirrorOffset
from solarcal.optics.reflection import Target
from solarcal.site import Site
from solarcal.unit.fields import RANGES

S = TypeVar("S", bound=msgspec.Struct)

_LEAN = ("lean_deg", "lean_bearing_deg")


def keys_of(struct: type[msgspec.Struct], prefix: str = "") -> Iterator[str]:
    """All dotted keys of a table and of the tables in it."""
    for field in msgspec.structs.fields(struct):
        if isinstance(field.type, type) and issubclass(field.type, msgspec.Struct):
            yield from keys_of(field.type, f"{prefix}{field.encode_name}.")
        else:
            yield prefix + field.encode_name


def settings_of(scenario: msgspec.Struct) -> dict[str, Any]:
    """Every dotted key with its value, as plain numbers, texts and lists."""
    document = msgspec.to_builtins(scenario)
    found = {}
    for key in keys_of(type(scenario)):
        table, _, name = key.rpartition(".")
        found[key] = (document[table] if table else document)[name]
    return found


def refuse_unknown(document: dict[str, Any], struct: type[msgspec.Struct], source: str) -> None:
    """Refuse a document with a key the scenario does not know."""
    known = set(keys_of(struct))
    tables = {key.partition(".")[0] for key in known if "." in key}
    for name, value in document.items():
        if name in tables and not isinstance(value, dict):
            raise ConfigurationError(f"scenario {source}: {name} must be a table [{name}]")
        found = [f"{name}.{key}" for key in value] if name in tables else [name]
        for key in found:
            _require_known(key, known, f"scenario {source}")


def with_setting(
    document: dict[str, Any], setting: str, struct: type[msgspec.Struct]
) -> dict[str, Any]:
    """The document with one ``key=value`` applied; the value as a TOML literal or a bare text."""
    key, equals, text = setting.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ConfigurationError(f"--set {setting}: write KEY=VALUE, like truth.lean_deg=0.1")
    _require_known(key, set(keys_of(struct)), f"--set {setting}")
    table, _, name = key.rpartition(".")
    changed = dict(document)
    if not table:
        changed[name] = _value(text)
        return changed
    inner = dict(changed.get(table, {}))
    inner[name] = _value(text)
    if table == "truth" and name in _LEAN:
        # A lean asked for last takes the place of the components a scenario gave instead.
        inner["P1"] = inner["P3"] = None
    changed[table] = inner
    return changed


def checked(document: dict[str, Any], struct: type[S], source: str) -> S:
    """The document as its struct, types and ranges checked."""
    written = _written_out(document, source)
    try:
        return msgspec.convert(written, struct)
    except (msgspec.ValidationError, ConfigurationError) as error:
        raise ConfigurationError(f"{source}: {_plain(str(error))}") from None


def require_ranges(
    settings: msgspec.Struct, table: str, ranges: Mapping[str, tuple[float, float]]
) -> None:
    """Refuse a number outside its range; the ends are allowed."""
    for name, (low, high) in ranges.items():
        if not low <= getattr(settings, name) <= high:
            raise ConfigurationError(f"{table}.{name} must lie between {low:g} and {high:g}")


def _require_known(key: str, known: set[str], where: str) -> None:
    if key in known:
        return
    name = key.rpartition(".")[2]
    names = sorted(known, key=lambda full: (len(full), full))
    nearest = difflib.get_close_matches(key, names, n=1, cutoff=0.6)
    nearest += [full for full in names if name in full.rpartition(".")[2]]
    hint = f"did you mean {nearest[0]}?" if nearest else "`solarcal scenarios NAME` shows them all"
    raise ConfigurationError(f"{where}: there is no key {key!r}; {hint}")


def _value(text: str) -> Any:
    """A TOML literal; what is none is a text. Numbers may be written without a decimal point."""
    try:
        return parse_toml(f"value = {text.strip()}")["value"]
    except ValueError:
        return text.strip()


def _written_out(value: Any, where: str) -> Any:
    """Dates as the texts they are in TOML; numbers that are none refused."""
    if isinstance(value, dict):
        return {key: _written_out(item, f"{where}: {key}") for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_written_out(item, where) for item in value]
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    if isinstance(value, float) and not math.isfinite(value):
        raise ConfigurationError(f"{where}: {value} is not a number one can use")
    return value


def _plain(message: str) -> str:
    """msgspec's message with the place first: ``truth.lean_deg: expected a number``."""
    match = re.fullmatch(r"(.*) - at `\$\.?(.*)`", message, re.DOTALL)
    if match is None:
        return message
    what = match[1][0].lower() + match[1][1:] if match[1].startswith("Expected") else match[1]
    return f"{match[2]}: {what}"


class UnitSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Factory and installation settings. Readings in degrees; drives as in ``docs/protocol.md``.

    ``latitude_deg``, ``longitude_deg``, ``zone_west_h`` are the unit's own settings; left out, it
    has the true ones of ``[site]``.

    With a ``target`` (azimuth, zenith angle, distance) it is a heliostat: AX1, AX2 are the angles
    of the mirror's normal. ``mirror_offset``: AzimPivot_R, PivotRefl_R, PivotRefl_Z, in the unit of
    the distance.
    """

    geometry: str = "azel"
    ax1_centre_deg: float = 0.0
    drive1: str = "rotary:1000"
    drive2: str = "rotary:1000"
    limits1_deg: tuple[float, float] = (-130.0, 130.0)
    limits2_deg: tuple[float, float] = (3.0, 88.0)
    reference1_deg: float = 120.0
    reference2_deg: float = 80.0
    stow1_deg: float = 0.0
    stow2_deg: float = 5.0
    update_range_deg: float = 0.1
    tilt_decimals: int = 4
    scale_decimals: int = 6
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    zone_west_h: float | None = None
    coefficients: Six = (0.0,) * 6
    offsets: tuple[float, float] = (0.0, 0.0)
    serial: str = "0001"
    target: tuple[float, float, float] | None = None
    mirror_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("limits1_deg", "limits2_deg"):
            low, high = getattr(self, name)
            if not low < high:
                raise ConfigurationError(f"unit.{name}: {low:g} is not below {high:g}")
            least, most = RANGES[f"axis{name[6]}.limits"]
            if low < least or high > most:
                raise ConfigurationError(f"unit.{name} must lie between {least:g} and {most:g}")
        own_ranges = {
            "update_range_deg": RANGES["update_range"],
            "tilt_decimals": RANGES["tilt_decimals"],
            "scale_decimals": RANGES["scale_decimals"],
            "reference1_deg": RANGES["axis1.reference"],
            "reference2_deg": RANGES["axis2.reference"],
        }
        require_ranges(self, "unit", own_ranges)
        if any(self.mirror_offset) and (self.target is None or self.geometry != "azel"):
            raise ConfigurationError(
                "unit.mirror_offset belongs to a heliostat with a target on an azel mount"
            )
        self.heliostat()

    def believed_site(self, true_site: Site) -> Site:
        latitude, longitude = self.latitude_deg, self.longitude_deg
        return Site(
            true_site.latitude_deg if latitude is None else latitude,
            true_site.longitude_deg if longitude is None else longitude,
            true_site.elevation_m,
        )

    def mount(self, site: Site) -> MountGeometry:
        return MountGeometry(self.geometry, site.latitude_deg, self.ax1_centre_deg)

    def drives(self) -> tuple[Drive, Drive]:
        return parse_drive(self.drive1), parse_drive(self.drive2)

    def limits(self) -> Limits:
        return Limits(AxisLimits(*self.limits1_deg), AxisLimits(*self.limits2_deg))

    def heliostat(self) -> Heliostat | None:
        """The configured target and mirror; ``None`` for a tracker."""
        if self.target is None:
            return None
        return Heliostat(Target(*self.target), MirrorOffset(*self.mirror_offset))

    def memory(self) -> tuple[Coefficients, Offsets]:
        """P and O as they are when the emulation begins, in both memories."""
        return Coefficients(*self.coefficients), Offsets(*self.offsets)
