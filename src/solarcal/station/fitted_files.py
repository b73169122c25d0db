"""Files of one unit, read, merged and fitted, with what was noticed on the way."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from solarcal.model.evidence.direct import direct_findings
from solarcal.model.finding import Finding
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.solution import Solution
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.session.interchange import FillIn, read_table
from solarcal.session.points import (
    PointTable,
    ephemeris_warnings,
    merge_tables,
    table_from_session,
)
from solarcal.session.reader import Session, read_session
from solarcal.station.diagnosing import (
    diagnose_session,
    diagnose_table,
    session_evidence,
    solve_merged,
)
from solarcal.station.fitting import solve_table
from solarcal.station.state import view_session


def load_points(path: Path, fill_in: FillIn) -> tuple[PointTable, Session | None]:
    """Read a session, points CSV or TPOINT file, and the session itself where it is one."""
    if path.suffix.lower() == ".jsonl":
        session = read_session(path)
        return table_from_session(session), session
    table = read_table(path, **fill_in)
    return replace(table, warnings=table.warnings + ephemeris_warnings(table)), None


@dataclass(frozen=True, slots=True)
class FittedFiles:
    """A fit of one or several files of one unit, and what was noticed while reading them.

    ``evidence``: what clocks, checks, settings and read-outs of each session say by themselves.
    ``findings``: the same, whether the tower moved between several, and what the residuals ask for.
    """

    table: PointTable
    solution: Solution
    sessions: tuple[Session, ...]
    evidence: tuple[Finding, ...]
    findings: tuple[Finding, ...]
    warnings: tuple[str, ...]


def fit_files(
    paths: Sequence[Path],
    fill_in: FillIn,
    *,
    method: str | None = None,
    terms: Sequence[str] | None = None,
) -> FittedFiles:
    """Read, merge and fit. Terms of one's own choice mean the ``linear`` method.

    Several files fitted by ``robust`` may each have zeros and a lean of their own where their
    points say that something moved between them; the solution is then of the last one.

    Raises
    ------
    InputFileError, ConfigurationError, FitError
        A file that cannot be read, files of different units, or points that allow no fit.
    """
    loaded = [load_points(Path(path), fill_in) for path in paths]
    tables = [table for table, _ in loaded]
    table = tables[0] if len(tables) == 1 else merge_tables(tables)
    sessions = tuple(session for _, session in loaded if session is not None)
    header = sessions[0].header if sessions else None
    chosen = method or (DEFAULT_METHOD if terms is None else "linear")
    moved: tuple[Finding, ...] = ()
    # A session broken off before its first point has nothing to compare; what it saw still counts.
    with_points = [table for table in tables if table.count("accepted")]
    if len(with_points) > 1 and chosen == "robust":
        merged = solve_merged(with_points, header)
        solution: Solution = merged.solution
        moved = merged.findings
    else:
        solution = solve_table(table, chosen, terms or COEFFICIENT_NAMES, header)
    views = [view_session(session.header, session.records) for session in sessions]
    if len(views) == len(tables) == 1:
        evidence = session_evidence(views[0], solution)
        findings = diagnose_session(views[0], solution)
    else:
        evidence = tuple(dict.fromkeys(f for view in views for f in direct_findings(view)))
        findings = (*evidence, *moved, *diagnose_table(table, solution, header))
    return FittedFiles(table, solution, sessions, evidence, findings, table.warnings)
