"""The files of a PAINT heliostat: calibration records, properties, the tower's measurements.

Read as they are written; ``paint`` makes points of them.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, TypeVar

import msgspec
import numpy as np

from solarcal.errors import InputFileError, one_line
from solarcal.input_files import read_bytes
from solarcal.mount.drive import Jack, JackHeliostat
from solarcal.units import RAD_PER_DEG, FloatArray

_WGS84_A_M, _WGS84_E2 = 6378137.0, 6.69437999014e-3
Place = tuple[
    Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)],
    Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)],
    Annotated[float, msgspec.Meta(ge=-500.0, le=9000.0)],
]
"""Latitude, longitude, height; degrees and metres."""
_Steps = Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)]
_Metres = Annotated[float, msgspec.Meta(ge=-1e3, le=1e3)]
_Angle = Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]

T = TypeVar("T")


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


def read_record(path: Path) -> Record:
    """A calibration record; InputFileError where the file is missing or none."""
    return _decoded(_record, path, "calibration record")


def read_tower(path: str | Path) -> Tower:
    """The tower's measurements; InputFileError where the file is missing or holds none."""
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
    found = _decoded(_properties, path, "heliostat properties")
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


def _decoded(decoder: msgspec.json.Decoder[T], path: str | Path, what: str) -> T:
    content = read_bytes(path)
    try:
        return decoder.decode(content)
    except _UNREADABLE as error:
        raise InputFileError(f"{path}: no PAINT {what}: {_said(error)}") from None


def _centre(entry: dict[str, object]) -> object:
    coordinates = entry.get("coordinates", entry)
    return coordinates["center"] if isinstance(coordinates, dict) else None


def _said(error: Exception) -> str:
    return one_line(" ".join(str(error).split()))[:200]
