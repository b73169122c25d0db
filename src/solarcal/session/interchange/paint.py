"""PAINT calibration records (``.json``): a heliostat on two screwjacks and its spot on a target.

A record holds the motor positions, the target's name, the focal spot (latitude, longitude, height)
as two methods found it, and the Sun's elevation and azimuth, counted from South, positive East.
The heliostat's properties file has its place, jacks and mirror offset, the tower's measurements
the plant's place and the targets. From them: the ideal normal halves the angle between Sun and
spot as seen from the mirror; the reading is what the jacks say; the mount is a `tiltroll-ew`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError, InputFileError, one_line
from solarcal.input_files import read_bytes
from solarcal.mount.drive import Jack, JackHeliostat
from solarcal.mount.geometry import MountGeometry
from solarcal.optics.offset_mirror import Heliostat
from solarcal.optics.reflection import (
    Target,
    bisector,
    direction_enu,
    horizontal_deg,
    reflected,
    unit,
)
from solarcal.session.points import PointTable
from solarcal.units import RAD_PER_DEG, FloatArray, wrap_deg

Spot = Literal["UTIS", "HeliOS"]
SPOTS: tuple[Spot, ...] = ("UTIS", "HeliOS")

GEOMETRY = "tiltroll-ew"
_WGS84_A_M, _WGS84_E2 = 6378137.0, 6.69437999014e-3
_FARTHEST_M = 20_000.0
Place = tuple[
    Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)],
    Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)],
    Annotated[float, msgspec.Meta(ge=-500.0, le=9000.0)],
]
"""Latitude, longitude, height; degrees and metres."""
_Steps = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
_Metres = Annotated[float, msgspec.Meta(ge=-1e3, le=1e3)]
_Angle = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]


class _Motors(msgspec.Struct, frozen=True):
    Axis1MotorPosition: _Steps
    Axis2MotorPosition: _Steps


class Record(msgspec.Struct, frozen=True):
    """A calibration record as its file has it."""

    motor_position: _Motors
    target_name: str
    focal_spot: dict[str, Place | None]
    Sun_elevation: _Angle
    Sun_azimuth: _Angle


class _Actuator(msgspec.Struct, frozen=True):
    increment: Annotated[float, msgspec.Meta(ge=1.0, le=1e9)]
    initial_stroke_length: _Metres
    offset: _Metres
    pivot_radius: _Metres
    initial_angle: _Angle
    clockwise_axis_movement: bool | int
    type_axis: str = "linear"


class _Kinematics(msgspec.Struct, frozen=True):
    actuators: list[_Actuator]
    first_joint_translation_e: _Metres = 0.0
    first_joint_translation_n: _Metres = 0.0
    first_joint_translation_u: _Metres = 0.0
    second_joint_translation_e: _Metres = 0.0
    second_joint_translation_n: _Metres = 0.0
    second_joint_translation_u: _Metres = 0.0
    concentrator_translation_e: _Metres = 0.0
    concentrator_translation_n: _Metres = 0.0
    concentrator_translation_u: _Metres = 0.0


class _Properties(msgspec.Struct, frozen=True):
    heliostat_position: Place
    kinematic_properties: _Kinematics


class _Plant(msgspec.Struct, frozen=True):
    coordinates: Place


@dataclass(frozen=True, slots=True)
class Tower:
    """The plant's place (latitude, longitude, height) and the centres of its targets, (3,) ENU."""

    plant: Place
    targets: dict[str, FloatArray]


_record = msgspec.json.Decoder(Record)
_properties = msgspec.json.Decoder(_Properties)
_tower = msgspec.json.Decoder(dict[str, dict[str, object]])
# Bytes that are no UTF-8 come as a ValueError of their own.
_UNREADABLE = (msgspec.MsgspecError, UnicodeDecodeError, RecursionError)


def read_tower(path: str | Path) -> Tower:
    """The tower's measurements file.

    Raises
    ------
    InputFileError
        It is missing, or no such file.
    """
    content = read_bytes(path)
    try:
        raw = _tower.decode(content)
        plant = msgspec.convert(raw["power_plant_properties"], _Plant).coordinates
        targets = {
            name: enu_m(plant, msgspec.convert(_centre(entry), Place))
            for name, entry in raw.items()
            if name != "power_plant_properties"
        }
    except (*_UNREADABLE, KeyError, TypeError) as error:
        raise InputFileError(f"{path}: no PAINT tower measurements: {_said(error)}") from None
    if not targets:
        raise InputFileError(f"{path}: no PAINT tower measurements: no target is in it")
    return Tower(plant, targets)


def read_heliostat(path: str | Path, tower: Tower) -> JackHeliostat:
    """The heliostat's properties file; metres from the plant's place.

    Raises
    ------
    InputFileError
        It is missing, no such file, or not of two linear actuators.
    """
    content = read_bytes(path)
    try:
        found = _properties.decode(content)
    except _UNREADABLE as error:
        raise InputFileError(f"{path}: no PAINT heliostat properties: {_said(error)}") from None
    kinematics = found.kinematic_properties
    if len(kinematics.actuators) != 2 or any(a.type_axis != "linear" for a in kinematics.actuators):
        raise InputFileError(f"{path}: only heliostats with two linear actuators are read")
    first, second = (
        Jack(
            increment=a.increment,
            initial_stroke=a.initial_stroke_length,
            offset=a.offset,
            pivot_radius=a.pivot_radius,
            initial_angle_deg=a.initial_angle / RAD_PER_DEG,
            clockwise=bool(a.clockwise_axis_movement),
        )
        for a in kinematics.actuators
    )

    def moved(joint: str) -> tuple[float, float, float]:
        east, north, up = (getattr(kinematics, f"{joint}_translation_{axis}") for axis in "enu")
        return east, north, up

    east, north, up = enu_m(tower.plant, found.heliostat_position).tolist()
    return JackHeliostat(
        jacks=(first, second),
        position_enu=(east, north, up),
        first_joint=moved("first_joint"),
        second_joint=moved("second_joint"),
        concentrator=moved("concentrator"),
    )


def enu_m(plant: Place, place: Place) -> FloatArray:
    """(east, north, up) in metres of a place (latitude, longitude, height) near the plant."""
    latitude = plant[0] * RAD_PER_DEG
    root = np.sqrt(1.0 - _WGS84_E2 * np.sin(latitude) ** 2)
    across = _WGS84_A_M / root
    along = _WGS84_A_M * (1.0 - _WGS84_E2) / root**3
    return np.array(
        (
            (place[1] - plant[1]) * RAD_PER_DEG * across * np.cos(latitude),
            (place[0] - plant[0]) * RAD_PER_DEG * along,
            place[2] - plant[2],
        )
    )


@dataclass(frozen=True, slots=True)
class Shots:
    """Records of one heliostat as arrays, n rows: normals, Sun and spot as unit vectors (n, 3)."""

    readings_deg: tuple[FloatArray, FloatArray]
    ideal_deg: tuple[FloatArray, FloatArray]
    sun_enu: FloatArray
    spot_enu: FloatArray
    geometry: MountGeometry


def shots_of(
    records: Sequence[tuple[Path, Record]], heliostat: JackHeliostat, tower: Tower, spot: str
) -> Shots:
    """Where the jacks say that the normal stood, and where the spot says that it must have stood.

    Raises
    ------
    InputFileError
        A record without this spot, with a Sun below the horizon, or motors beyond the jacks' reach.
    """
    places = []
    for path, record in records:
        place = record.focal_spot.get(spot)
        if place is None:
            others = [name for name, value in record.focal_spot.items() if value is not None]
            raise InputFileError(
                f"{path}: no focal spot by {spot}"
                + (f"; --spot {one_line(others[0])} is there" if others else "")
            )
        if not 0.0 < record.Sun_elevation <= 90.0:
            raise InputFileError(
                f"{path}: the Sun's elevation {record.Sun_elevation:g} is not above 0"
            )
        places.append(enu_m(tower.plant, place))
    found = [record for _, record in records]
    steps = np.array(
        [(r.motor_position.Axis1MotorPosition, r.motor_position.Axis2MotorPosition) for r in found]
    )
    try:
        ax1, ax2 = heliostat.readings_deg(steps)
    except ConfigurationError as error:
        raise InputFileError(f"{records[0][0]} and its like: {error}") from None
    # Counted from South, positive East.
    sun = direction_enu(
        np.array([180.0 - r.Sun_azimuth for r in found]),
        np.array([90.0 - r.Sun_elevation for r in found]),
    )
    line = np.array(places) - heliostat.centre_enu(ax1, ax2)
    distance = np.linalg.norm(line, axis=1)
    for row in np.flatnonzero(~((distance > 1.0) & (distance < _FARTHEST_M)))[:1]:
        raise InputFileError(
            f"{records[row][0]}: the spot is {distance[row]:.0f} m from the heliostat; heliostat "
            "and tower files must be of one plant"
        )
    aim = unit(line)
    geometry = MountGeometry(GEOMETRY, tower.plant[0], 0.0)
    ideal1, ideal2 = geometry.axes_from_horizontal(*horizontal_deg(bisector(sun, aim)))
    return Shots((ax1, ax2), (np.asarray(ideal1), np.asarray(ideal2)), sun, aim, geometry)


def beam_residuals_mrad(
    shots: Shots, residual1_deg: FloatArray, residual2_deg: FloatArray
) -> FloatArray:
    """How far beside the spot the beam of the fitted mechanism falls, mrad as seen from the mirror.

    Residuals are those of the axes; the mirror doubles them in the plane of reflection.
    """
    normal = direction_enu(
        *shots.geometry.horizontal_from_axes(
            shots.ideal_deg[0] + residual1_deg, shots.ideal_deg[1] + residual2_deg
        )
    )
    beam = reflected(shots.sun_enu, normal)
    return np.asarray(1e3 * np.linalg.norm(beam - shots.spot_enu, axis=1))


@dataclass(frozen=True, slots=True)
class PaintFiles:
    """Records of one heliostat, and the two files that they need."""

    records: tuple[tuple[Path, Record], ...]
    heliostat: JackHeliostat
    tower: Tower
    name: str
    spot: str

    def shots(self) -> Shots:
        return shots_of(self.records, self.heliostat, self.tower, self.spot)


def paint_files(
    paths: Sequence[str | Path],
    *,
    heliostat: str | Path | None = None,
    tower: str | Path | None = None,
    spot: str | None = None,
    towers: dict[Path, Tower] | None = None,
) -> PaintFiles:
    """Read the records and what belongs to them.

    Without ``heliostat`` the properties file is looked for beside the records
    (``../Properties/*properties.json``), without ``tower`` the measurements
    (``*tower-measurements.json``) in the folders above. ``towers`` holds what was read before.

    Raises
    ------
    InputFileError
        A file that is missing or none of its kind.
    """
    files = [Path(path) for path in paths]
    properties = Path(heliostat) if heliostat is not None else _properties_beside(files[0])
    measurements = Path(tower) if tower is not None else _tower_above(files[0])
    known = {} if towers is None else towers
    if measurements not in known:
        known[measurements] = read_tower(measurements)
    records = []
    for path in files:
        try:
            records.append((path, _record.decode(read_bytes(path))))
        except _UNREADABLE as error:
            raise InputFileError(f"{path}: no PAINT calibration record: {_said(error)}") from None
    return PaintFiles(
        records=tuple(records),
        heliostat=read_heliostat(properties, known[measurements]),
        tower=known[measurements],
        name=re.sub(r"[-_]heliostat[-_]properties$", "", properties.stem),
        spot=spot or SPOTS[0],
    )


def paint_table(files: PaintFiles, *, unit: str | None = None) -> PointTable:
    """The records as points of a `tiltroll-ew` mount; labels are the records' numbers.

    The heliostat's target for forecasts is the first one of the tower's file.
    """
    shots = files.shots()
    (ax1, ax2), (ideal1, ideal2) = shots.readings_deg, shots.ideal_deg
    n = len(files.records)
    targets = {record.target_name for _, record in files.records}
    unknown = sorted(targets - set(files.tower.targets))
    warnings = [f"the tower's file has no target {one_line(name)}" for name in unknown]
    line = next(iter(files.tower.targets.values())) - np.array(files.heliostat.position_enu)
    azimuth, zenith = horizontal_deg(line)
    latitude, longitude, height = files.tower.plant
    return PointTable(
        geometry=GEOMETRY,
        latitude_deg=latitude,
        longitude_deg=longitude,
        elevation_m=height,
        unit=unit or files.name,
        ax1_centre_deg=0.0,
        ideal="apparent",
        utc_s=np.full(n, np.nan),
        ax1_deg=ideal1,
        ax2_deg=ideal2,
        err1_deg=wrap_deg(ax1 - ideal1),
        err2_deg=ax2 - ideal2,
        sigma_deg=None,
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=tuple(one_line(record.target_name) for _, record in files.records),
        labels=tuple(_number(path, at) for at, (path, _) in enumerate(files.records, start=1)),
        sources=tuple(str(path) for path, _ in files.records),
        warnings=tuple(warnings),
        heliostat=Heliostat(Target(float(azimuth), float(zenith), float(np.linalg.norm(line)))),
    )


def _centre(entry: dict[str, object]) -> object:
    coordinates = entry.get("coordinates", entry)
    return coordinates["center"] if isinstance(coordinates, dict) else None


def _number(path: Path, otherwise: int) -> int:
    digits = re.match(r"[0-9]{1,15}", path.name)
    return int(digits[0]) if digits else otherwise


def _properties_beside(record: Path) -> Path:
    found = sorted(record.resolve().parent.parent.glob("Properties/*properties.json"))
    if not found:
        raise InputFileError(
            f"{record}: the heliostat's properties file is not in ../Properties; give it with "
            "--heliostat"
        )
    return found[0]


def _tower_above(record: Path) -> Path:
    for folder in record.resolve().parents[:4]:
        if found := sorted(folder.glob("*tower-measurements.json")):
            return found[0]
    raise InputFileError(
        f"{record}: no *tower-measurements.json in the folders above; give it with --tower"
    )


def _said(error: Exception) -> str:
    return one_line(" ".join(str(error).split()))[:200]
