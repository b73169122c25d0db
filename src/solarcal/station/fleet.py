"""Thousands of sessions at once: which trackers are worst, and how well that is known.

Every session and every PAINT heliostat is fitted on its own by ``robust``; nothing is merged. Plain
ones go through the fast reader and the batched fit; whatever is out of the ordinary (a heliostat
in a session, a torn file, points no fit takes) goes the way of ``solarcal fit``, one by one, and
fails with the words it has there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from solarcal.errors import FitError, InputFileError, SolarcalError
from solarcal.model.fleet_fit import ManyMechanisms, at_once, fit_many
from solarcal.model.mechanism_solution import OUTLIER_PROBABILITY, MechanismSolution
from solarcal.model.mixture_climb import ENOUGH_FOR_SCALE
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.session.interchange import imported_header
from solarcal.session.interchange.paint import paint_files, paint_table
from solarcal.session.interchange.paint_records import Tower
from solarcal.session.parsing import NeedsWholeReader, read_points_only
from solarcal.session.points import PointTable
from solarcal.session.records import Header
from solarcal.station.analysing import load_points
from solarcal.station.fitting import solve_table
from solarcal.station.fleet_points import PlainSession, plain_session, seen_points
from solarcal.units import FloatArray

WorstBy = Literal["rms", "lean", "sigma", "noise"]

Progress = Callable[[str, int, int], None]
"""Called with the current work, how many are done, of how many."""

_READ_BETWEEN_REPORTS = 200


@dataclass(frozen=True, slots=True)
class FleetMember:
    """What ``robust`` says of one session. Degrees; P5, P6 in deg/deg.

    ``values``, ``sigmas`` are P1..P6 of the exact mechanism, not yet what one uploads;
    ``sky_rms_deg``, ``sky_max_deg`` of the residuals; ``outliers`` the records that are more
    likely blunders than not.
    """

    path: str
    unit: str
    geometry: str
    points: int
    values: tuple[float, ...]
    sigmas: tuple[float, ...]
    lean_deg: float
    lean_sigma_deg: float
    noise_deg: float
    sky_rms_deg: float
    sky_max_deg: float
    outliers: tuple[int, ...]

    def ranked_by(self, worst_by: WorstBy) -> float:
        return {
            "rms": self.sky_rms_deg,
            "lean": self.lean_deg,
            "sigma": self.lean_sigma_deg,
            "noise": self.noise_deg,
        }[worst_by]

    def as_json(self) -> dict[str, Any]:
        return {
            "file": self.path,
            "unit": self.unit,
            "geometry": self.geometry,
            "points": self.points,
            "mechanism": dict(zip(COEFFICIENT_NAMES, self.values, strict=True)),
            "sigmas": dict(zip(COEFFICIENT_NAMES, self.sigmas, strict=True)),
            "lean_deg": self.lean_deg,
            "lean_sigma_deg": self.lean_sigma_deg,
            "noise_deg": self.noise_deg,
            "sky_rms_deg": self.sky_rms_deg,
            "sky_max_deg": self.sky_max_deg,
            "outliers": list(self.outliers),
        }


@dataclass(frozen=True, slots=True)
class Fleet:
    """The sessions that could be fitted, and (file, reason) of those that could not."""

    members: tuple[FleetMember, ...]
    unreadable: tuple[tuple[str, str], ...]

    def worst(self, worst_by: WorstBy, top: int) -> tuple[FleetMember, ...]:
        """The worst first; ``top`` 0 for all of them."""
        ranked = sorted(self.members, key=lambda m: (-m.ranked_by(worst_by), m.path))
        return tuple(ranked[:top] if top else ranked)


def session_files(folder: Path) -> tuple[Path, ...]:
    """The session files of a folder and the folders in it, by name, and PAINT heliostats.

    A PAINT heliostat stands there by its properties file; its calibration records belong to it.

    Raises
    ------
    InputFileError
        No folder, or no session file or heliostat in it.
    """
    if not folder.is_dir():
        raise InputFileError(f"{folder} is not a folder; give the one the session files are in")
    files = sorted(path for path in folder.rglob("*.jsonl") if path.is_file())
    files += sorted(folder.rglob("Properties/*heliostat*properties.json"))
    if not files:
        raise InputFileError(
            f"there is no session file (.jsonl) and no PAINT heliostat in {folder}"
        )
    return tuple(files)


def paint_points(properties: Path, towers: dict[Path, Tower]) -> tuple[Header, PointTable]:
    """The calibration records of a PAINT heliostat; ``towers`` holds what was read before.

    Raises
    ------
    InputFileError
        No record, or a file that is none of its kind.
    """
    records = sorted(
        (properties.parent.parent / "Calibration").glob("*calibration-properties.json")
    )
    if not records:
        raise InputFileError(f"{properties}: no calibration records are in ../Calibration")
    table = paint_table(paint_files(records, heliostat=properties, towers=towers))
    used = replace(table, heliostat=None, sources=(str(properties),) * len(table)).accepted()
    return imported_header(used, 0.0), used


def fit_fleet(paths: Sequence[Path], progress: Progress = lambda what, done, total: None) -> Fleet:
    """Fit every session on its own; a file that cannot be read or fitted is named, not fatal."""
    plain: list[PlainSession] = []
    unusual: list[Path] = []
    unreadable: list[tuple[str, str]] = []
    towers: dict[Path, Tower] = {}
    for done, path in enumerate(paths):
        if done % _READ_BETWEEN_REPORTS == 0:
            progress("reading", done, len(paths))
        try:
            paint = path.suffix == ".json"
            header, read = paint_points(path, towers) if paint else read_points_only(path)
            session = plain_session(header, read)
        except NeedsWholeReader:
            unusual.append(path)
        except SolarcalError as error:
            unreadable.append((str(path), str(error)))
        else:
            # A large session is fitted alone: nothing is gained side by side.
            if session is None or len(read) > ENOUGH_FOR_SCALE:
                unusual.append(path)
            else:
                plain.append(session)
    progress("reading", len(paths), len(paths))
    members: list[FleetMember] = []
    seen, refused = seen_points(plain)
    unusual += [Path(session.points.sources[0]) for session in refused]
    fitted = 0
    for sessions, points, sine2, labels in seen:
        together = at_once(points.ax1_deg.shape[1])
        for low in range(0, len(sessions), together):
            progress("fitting", fitted, len(paths))
            part = slice(low, low + together)
            found = fit_many(points.take(part))
            members += _members(sessions[part], labels[part], sine2[part], found)
            fitted += len(sessions[part])
    for path in sorted(unusual):
        progress("fitting", fitted, len(paths))
        try:
            members.append(_fitted_alone(path))
        except SolarcalError as error:
            unreadable.append((str(path), str(error)))
        fitted += 1
    progress("fitting", len(paths), len(paths))
    return Fleet(tuple(sorted(members, key=lambda member: member.path)), tuple(sorted(unreadable)))


def _members(
    sessions: Sequence[PlainSession],
    labels: Sequence[tuple[int, ...]],
    sine2: FloatArray,
    found: ManyMechanisms,
) -> list[FleetMember]:
    sky = np.hypot(found.residual1_deg * sine2, found.residual2_deg)
    rms = np.sqrt(np.mean(sky**2, axis=1)).tolist()
    largest = sky.max(axis=1).tolist()
    sigmas = np.sqrt(np.einsum("sii->si", found.covariance)).tolist()
    P1, P3 = found.mean[:, 0], found.mean[:, 2]
    lean = np.hypot(P1, P3)
    # Along the lean itself; without one, along P1 (as summarise has it).
    along = np.stack((np.where(lean > 0.0, P1, 1.0), P3), axis=1)
    along /= np.where(lean > 0.0, lean, 1.0)[:, np.newaxis]
    block = found.covariance[:, [[0], [2]], [[0, 2]]]
    lean_sigma = np.sqrt(np.einsum("si,sij,sj->s", along, block, along)).tolist()
    doubted = found.blunder > OUTLIER_PROBABILITY
    values, noise = found.mean.tolist(), found.noise_deg.tolist()
    return [
        FleetMember(
            path=session.points.sources[0],
            unit=session.points.unit,
            geometry=session.points.geometry,
            points=len(labels[i]),
            values=tuple(values[i]),
            sigmas=tuple(sigmas[i]),
            lean_deg=float(lean[i]),
            lean_sigma_deg=lean_sigma[i],
            noise_deg=noise[i],
            sky_rms_deg=rms[i],
            sky_max_deg=largest[i],
            outliers=tuple(labels[i][k] for k in np.flatnonzero(doubted[i])),
        )
        for i, session in enumerate(sessions)
    ]


def _fitted_alone(path: Path) -> FleetMember:
    """The way of ``solarcal fit``; FitError where the points allow no fit of the mechanism."""
    if path.suffix == ".json":
        raise FitError(f"{path}: its records cannot be fitted together; `solarcal fit` says why")
    table, session = load_points(path, {})
    solution = solve_table(table, "robust", header=None if session is None else session.header)
    if not isinstance(solution, MechanismSolution):
        raise FitError(f"{path}: no mechanism was fitted")
    mechanism = solution.mechanism
    posterior = solution.posterior
    return FleetMember(
        path=str(path),
        unit=table.unit,
        geometry=table.geometry,
        points=solution.n_points,
        values=tuple(posterior.mean.tolist()),
        sigmas=tuple(np.sqrt(np.diag(posterior.covariance)).tolist()),
        lean_deg=mechanism.lean_deg,
        lean_sigma_deg=mechanism.lean_sigma_deg,
        noise_deg=mechanism.noise_deg,
        sky_rms_deg=solution.sky_rms_deg,
        sky_max_deg=solution.sky_max_deg,
        outliers=solution.outliers,
    )
