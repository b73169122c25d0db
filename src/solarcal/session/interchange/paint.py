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
from typing import Literal

import numpy as np

from solarcal.errors import ConfigurationError, InputFileError, one_line
from solarcal.mount.drive import JackHeliostat
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
from solarcal.session.interchange.paint_records import (
    Record,
    Tower,
    enu_m,
    read_heliostat,
    read_record,
    read_tower,
)
from solarcal.session.points import PointTable
from solarcal.units import FloatArray, wrap_deg

Spot = Literal["UTIS", "HeliOS"]
SPOTS: tuple[Spot, ...] = ("UTIS", "HeliOS")

GEOMETRY = "tiltroll-ew"
_FARTHEST_M = 20_000.0


@dataclass(frozen=True, slots=True)
class Shots:
    """Records of one heliostat as arrays, n rows: normals, Sun and spot as unit vectors (n, 3)."""

    readings_deg: tuple[FloatArray, FloatArray]
    ideal_deg: tuple[FloatArray, FloatArray]
    sun_enu: FloatArray
    spot_enu: FloatArray
    geometry: MountGeometry


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
        """Where the jacks say that the normal stood, and where the spot says that it must have.

        Raises
        ------
        InputFileError
            A record without this spot, with a Sun below the horizon, or motors beyond the jacks'
            reach.
        """
        places = []
        for path, record in self.records:
            place = record.focal_spot.get(self.spot)
            if place is None:
                others = [name for name, value in record.focal_spot.items() if value is not None]
                raise InputFileError(
                    f"{path}: no focal spot by {self.spot}"
                    + (f"; --spot {one_line(others[0])} is there" if others else "")
                )
            if not 0.0 < record.Sun_elevation <= 90.0:
                raise InputFileError(
                    f"{path}: the Sun's elevation {record.Sun_elevation:g} is not above 0"
                )
            places.append(enu_m(self.tower.plant, place))
        found = [record for _, record in self.records]
        motors = [record.motor_position for record in found]
        steps = np.array([(m.Axis1MotorPosition, m.Axis2MotorPosition) for m in motors])
        try:
            ax1, ax2 = self.heliostat.readings_deg(steps)
        except ConfigurationError as error:
            raise InputFileError(f"{self.records[0][0]} and its like: {error}") from None
        # Counted from South, positive East.
        sun = direction_enu(
            np.array([180.0 - r.Sun_azimuth for r in found]),
            np.array([90.0 - r.Sun_elevation for r in found]),
        )
        line = np.array(places) - self.heliostat.centre_enu(ax1, ax2)
        distance = np.linalg.norm(line, axis=1)
        for row in np.flatnonzero(~((distance > 1.0) & (distance < _FARTHEST_M)))[:1]:
            raise InputFileError(
                f"{self.records[row][0]}: the spot is {distance[row]:.0f} m from the heliostat; "
                "heliostat and tower files must be of one plant"
            )
        aim = unit(line)
        geometry = MountGeometry(GEOMETRY, self.tower.plant[0], 0.0)
        ideal1, ideal2 = geometry.axes_from_horizontal(*horizontal_deg(bisector(sun, aim)))
        return Shots((ax1, ax2), (np.asarray(ideal1), np.asarray(ideal2)), sun, aim, geometry)


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
    return PaintFiles(
        records=tuple((path, read_record(path)) for path in files),
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
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=tuple(one_line(record.target_name) for _, record in files.records),
        labels=tuple(_number(path, at) for at, (path, _) in enumerate(files.records, start=1)),
        sources=tuple(str(path) for path, _ in files.records),
        warnings=tuple(warnings),
        heliostat=Heliostat(Target(float(azimuth), float(zenith), float(np.linalg.norm(line)))),
    )


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
