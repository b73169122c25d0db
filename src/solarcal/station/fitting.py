"""From a session's points to a solution, the same way live, in replay and from files."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.model.fit import Solution, fit_linear
from solarcal.model.points import PointSet
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.limits import Limits
from solarcal.session.interchange import FillIn, read_table
from solarcal.session.points import (
    PointTable,
    ephemeris_warnings,
    merge_tables,
    table_from_session,
)
from solarcal.session.reader import Session, read_session
from solarcal.station.evidence import evidence
from solarcal.station.state import SessionView, view_session

MIN_POINTS = 3


def point_set(table: PointTable) -> PointSet:
    """The accepted points of a table, as the fitter takes them."""
    if table.latitude_deg is None:
        raise ConfigurationError("the points have no latitude; give it with --lat")
    geometry = MountGeometry(table.geometry, table.latitude_deg, table.ax1_centre_deg)
    used = table.accepted()
    return PointSet(
        geometry=geometry,
        ax1_deg=used.ax1_deg,
        ax2_deg=used.ax2_deg,
        err1_deg=used.err1_deg,
        err2_deg=used.err2_deg,
        sigma_deg=used.sigma_deg,
        labels=used.labels,
        utc_s=used.utc_s,
    )


def session_table(session: SessionView) -> PointTable:
    """The live points of a session, with their statuses."""
    return table_from_session(Session("", session.header, session.records))


def solve_table(
    table: PointTable, terms: Sequence[str] = COEFFICIENT_NAMES, limits: Limits | None = None
) -> Solution:
    return fit_linear(point_set(table), tuple(terms), limits=limits)


def solve(session: SessionView, terms: Sequence[str] = COEFFICIENT_NAMES) -> Solution | None:
    """The fit of the session so far; ``None`` while there are too few points to say anything."""
    if len(session.accepted) < MIN_POINTS:
        return None
    return solve_table(session_table(session), terms, session.header.unit.limits)


def load_points(path: Path, fill_in: FillIn) -> tuple[PointTable, Session | None]:
    """Read a session, points CSV or TPOINT file, and the session itself where it is one."""
    if path.suffix.lower() == ".jsonl":
        session = read_session(path)
        return table_from_session(session), session
    table = read_table(path, **fill_in)
    return replace(table, warnings=table.warnings + ephemeris_warnings(table)), None


@dataclass(frozen=True, slots=True)
class FittedFiles:
    """A fit of one or several files of one unit, and what was noticed while reading them."""

    table: PointTable
    solution: Solution
    sessions: tuple[Session, ...]
    evidence: tuple[str, ...]
    warnings: tuple[str, ...]


def fit_files(
    paths: Sequence[Path], fill_in: FillIn, terms: Sequence[str] | None = None
) -> FittedFiles:
    """Read, merge and fit.

    Raises
    ------
    InputFileError, ConfigurationError, FitError
        A file that cannot be read, files of different units, or points that allow no fit.
    """
    loaded = [load_points(Path(path), fill_in) for path in paths]
    tables = [table for table, _ in loaded]
    table = tables[0] if len(tables) == 1 else merge_tables(tables)
    sessions = tuple(session for _, session in loaded if session is not None)
    limits = sessions[0].header.unit.limits if sessions else None
    solution = solve_table(table, terms or COEFFICIENT_NAMES, limits)
    said = [
        sentence
        for session in sessions
        for sentence in evidence(view_session(session.header, session.records))
    ]
    return FittedFiles(
        table=table,
        solution=solution,
        sessions=sessions,
        evidence=tuple(dict.fromkeys(said)),
        warnings=table.warnings,
    )
