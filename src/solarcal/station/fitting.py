"""From a session's points to a solution, the same way live, in replay and from files."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import cast

import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.model.fit import FEWEST_POINTS, Solution
from solarcal.model.known_physics import Ideal, SkyContext
from solarcal.model.methods import DEFAULT_METHOD, fit
from solarcal.model.points import PointSet
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.mount.geometry import MountGeometry
from solarcal.session.interchange import FillIn, read_table
from solarcal.session.points import (
    IMPORTED_MODEL,
    PointTable,
    ephemeris_warnings,
    merge_tables,
    table_from_session,
)
from solarcal.session.reader import Session, read_session
from solarcal.session.records import Header
from solarcal.station.evidence import evidence
from solarcal.station.state import SessionView, view_session


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


def newest_point_utc_s(table: PointTable) -> float | None:
    """When the newest accepted point was taken; ``None`` where no time is known."""
    times = table.accepted().utc_s
    known = times[np.isfinite(times)]
    return float(known.max()) if known.size else None


def sky_context(table: PointTable, header: Header | None = None) -> SkyContext:
    """Where and under what sky the points were taken: what a fit may take as known physics."""
    points = point_set(table)
    # An import's limits are placeholders.
    from_a_unit = header is not None and header.unit.model != IMPORTED_MODEL
    return SkyContext.for_points(
        points,
        site=table.site,
        limits=header.unit.limits if header is not None and from_a_unit else None,
        ideal=cast(Ideal, table.ideal),
        weather=None if header is None else header.weather,
        heliostat=table.heliostat,
    )


def solve_table(
    table: PointTable,
    method: str = DEFAULT_METHOD,
    terms: Sequence[str] = COEFFICIENT_NAMES,
    header: Header | None = None,
) -> Solution:
    """Fit the accepted points of a table; ``header`` is that of the session they come from."""
    return fit(point_set(table), sky_context(table, header), method=method, terms=terms)


def solve(session: SessionView, method: str = DEFAULT_METHOD) -> Solution | None:
    """The fit of the session so far; ``None`` while there are too few points for ``method``."""
    if len(session.accepted) < fewest_points(method):
        return None
    return solve_table(session_table(session), method, header=session.header)


def fewest_points(method: str) -> int:
    """``manual`` needs three points; with a prior, one says something."""
    return 1 if method == "robust" else FEWEST_POINTS


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
    paths: Sequence[Path],
    fill_in: FillIn,
    *,
    method: str | None = None,
    terms: Sequence[str] | None = None,
) -> FittedFiles:
    """Read, merge and fit. Terms of one's own choice mean the ``manual`` method.

    Raises
    ------
    InputFileError, ConfigurationError, FitError
        A file that cannot be read, files of different units, or points that allow no fit.
    """
    loaded = [load_points(Path(path), fill_in) for path in paths]
    tables = [table for table, _ in loaded]
    table = tables[0] if len(tables) == 1 else merge_tables(tables)
    sessions = tuple(session for _, session in loaded if session is not None)
    solution = solve_table(
        table,
        method or (DEFAULT_METHOD if terms is None else "manual"),
        terms or COEFFICIENT_NAMES,
        sessions[0].header if sessions else None,
    )
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
