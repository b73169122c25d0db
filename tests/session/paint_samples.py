"""A made-up field in PAINT's format, whose mechanisms are known."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from solarcal.mount.geometry import MountGeometry
from solarcal.mount.mechanism import Mechanism
from solarcal.optics.reflection import bisector, direction_enu, horizontal_deg, unit
from solarcal.session.interchange.paint_records import enu_m, read_heliostat, read_tower

PLANT = (50.9, 6.4, 88.0)
TARGETS = {"upper": (50.9, 6.4, 130.0), "lower": (50.9, 6.4, 122.0), "side": (50.9, 6.3998, 138.0)}
GEOMETRY = MountGeometry("tiltroll-ew", PLANT[0], 0.0)


def write_tower(folder: Path) -> Path:
    path = folder / "made-up-tower-measurements.json"
    tower: dict[str, Any] = {"power_plant_properties": {"ID": "X", "coordinates": PLANT}}
    for name, centre in TARGETS.items():
        tower[name] = {"type": "planar", "coordinates": {"center": centre}}
    path.write_text(json.dumps(tower))
    return path


def properties(north_m: float = 80.0, east_m: float = 15.0) -> dict[str, Any]:
    def jack(cw: bool, offset: float, radius: float, angle: float) -> dict[str, Any]:
        return {
            "type_axis": "linear",
            "clockwise_axis_movement": cw,
            "increment": 154166.666,
            "initial_stroke_length": 0.075,
            "offset": offset,
            "pivot_radius": radius,
            "initial_angle": angle,
        }

    return {
        "heliostat_position": [PLANT[0] + north_m / 111_200.0, PLANT[1] + east_m / 70_300.0, 89.0],
        "width": 3.2,
        "height": 2.6,
        "kinematic_properties": {
            "actuators": [
                jack(False, 0.34061, 0.3204, -1.570796),
                jack(True, 0.3479, 0.309, 0.959931),
            ],
            "second_joint_translation_u": 0.315,
            "concentrator_translation_n": -0.1776,
            "concentrator_translation_u": -0.4045,
        },
    }


def write_heliostat(
    folder: Path,
    tower_path: Path,
    mechanism: Mechanism,
    *,
    records: int = 12,
    seed: int = 1,
    noise_deg: float = 0.0,
    name: str = "AA23",
    north_m: float = 80.0,
) -> list[Path]:
    """Properties and calibration records of one heliostat; the records' files."""
    (folder / name / "Properties").mkdir(parents=True)
    (folder / name / "Calibration").mkdir()
    place = folder / name / "Properties" / f"{name}-heliostat-properties.json"
    place.write_text(json.dumps(properties(north_m)))
    tower = read_tower(tower_path)
    heliostat = read_heliostat(place, tower)
    generator = np.random.default_rng(seed)
    # South in the middle of the day, positive East.
    sun_azimuth = generator.uniform(-70.0, 70.0, records)
    sun_elevation = generator.uniform(15.0, 60.0, records)
    names = [list(TARGETS)[at % len(TARGETS)] for at in range(records)]
    spot = np.array([TARGETS[target] for target in names])
    spot[:, 2] += generator.uniform(-1.0, 1.0, records)
    aims = np.array([enu_m(PLANT, tuple(row)) for row in spot.tolist()])
    sun = direction_enu(180.0 - sun_azimuth, 90.0 - sun_elevation)
    centre = np.broadcast_to(np.array(heliostat.position_enu), aims.shape)
    for _ in range(30):
        ideal = GEOMETRY.axes_from_horizontal(*horizontal_deg(bisector(sun, unit(aims - centre))))
        ax1, ax2 = mechanism.readings_deg(GEOMETRY, *ideal)
        centre = heliostat.centre_enu(ax1, ax2)
    ax1 = ax1 + generator.normal(0.0, 1.0, records) * noise_deg
    ax2 = ax2 + generator.normal(0.0, 1.0, records) * noise_deg
    steps = heliostat.steps_at(ax1, ax2)
    paths = []
    for at in range(records):
        path = folder / name / "Calibration" / f"{100000 + at}-calibration-properties.json"
        found = [*spot[at, :2].tolist(), float(spot[at, 2])]
        record = {
            "motor_position": {
                "Axis1MotorPosition": float(steps[at, 0]),
                "Axis2MotorPosition": float(steps[at, 1]),
            },
            "target_name": names[at],
            "Sun_elevation": float(sun_elevation[at]),
            "Sun_azimuth": float(sun_azimuth[at]),
            "focal_spot": {"HeliOS": [*found[:2], found[2] + 0.5], "UTIS": found},
        }
        path.write_text(json.dumps(record))
        paths.append(path)
    return paths
