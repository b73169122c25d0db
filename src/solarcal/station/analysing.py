"""Sessions and files brought to ``analyse``: the one way of live, replay, files and certificates.

Records are folded once into a ``SessionView``, its table is made once, and the points once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Unpack

import msgspec

from solarcal.errors import ConfigurationError
from solarcal.model.analysis import Analysis, analyse, findings_of
from solarcal.model.earlier_sessions import Merged, merge_sessions
from solarcal.model.evidence.direct import Evidence
from solarcal.model.evidence.sun_path import stamp_evidence
from solarcal.model.finding import Finding, listed
from solarcal.model.methods import DEFAULT_METHOD, fit
from solarcal.model.overlapping_sessions import contradictions, groups_in_time
from solarcal.model.points import Points
from solarcal.model.prior import Prior
from solarcal.model.sky_context import SkyContext
from solarcal.model.solution import Solution
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients
from solarcal.session.interchange import (
    SESSION,
    FillIn,
    is_paint,
    point_format,
    read_paint,
    read_table,
)
from solarcal.session.interchange.paint import paint_table
from solarcal.session.points import (
    PointTable,
    labelled_by_file,
    merge_tables,
    require_one_unit,
)
from solarcal.session.records import Header
from solarcal.session.view import SessionView, read_session
from solarcal.site import BoltCircle
from solarcal.station.copies import counted_once
from solarcal.station.fitting import (
    chosen_prior,
    fewest_points,
    newest_point_utc_s,
    point_set,
    sky_context,
)
from solarcal.station.judging import (
    RuleChanges,
    asked_for,
    differences,
    own_sessions,
    read_last,
    stopping_rule,
)
from solarcal.stopping_rule import TOLERANCE_DEG, StoppingRule


def analyse_session(
    session: SessionView,
    method: str = DEFAULT_METHOD,
    *,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> Analysis | None:
    """What a session's points come to; ``None`` while there are too few for ``method``.

    ``at_utc_s`` is the moment to plan from; the newest point's when ``None``.
    """
    if len(session.accepted) < fewest_points(method):
        return None
    table, header = session.table, session.header
    points = point_set(table)
    context = sky_context(table, header, points)
    prior, contradictions = chosen_prior(points, context, header, method)
    return analyse(
        points,
        context,
        Evidence(table, (session,), contradictions),
        newest_point_utc_s(table) if at_utc_s is None else at_utc_s,
        method=method,
        prior=prior,
        bolt_circle=header.bolt_circle,
        rule=stopping_rule((session,)),
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
    )


@dataclass(frozen=True, slots=True)
class UnitFiles:
    """Files of one unit as they were read: each one's table, all of them, and the sessions.

    ``contradictions``: on readings of one instant that differ from file to file.
    """

    paths: tuple[Path, ...]
    tables: tuple[PointTable, ...]
    table: PointTable
    sessions: tuple[SessionView, ...]
    contradictions: tuple[Finding, ...] = ()

    @property
    def header(self) -> Header | None:
        """Of the first session of a unit, else of the first; None for points files alone."""
        return own_sessions(self.sessions)[0].header if self.sessions else None

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the readers found to report."""
        return self.table.warnings


@dataclass(frozen=True, slots=True)
class FileAnalysis:
    """A fit of files and its analysis.

    ``analysis`` is None where other terms than P1..P6 were fitted: what a controller cannot be
    given has no forecast.
    """

    files: UnitFiles
    solution: Solution
    findings: tuple[Finding, ...]
    analysis: Analysis | None
    rule: StoppingRule
    asked_for: tuple[str, ...]
    """What it is judged by that is not as in the files."""
    warnings: tuple[str, ...]

    @property
    def tolerance_deg(self) -> float:
        return self.rule.tolerance_deg

    @property
    def table(self) -> PointTable:
        return self.files.table

    @property
    def sessions(self) -> tuple[SessionView, ...]:
        return self.files.sessions

    @property
    def header(self) -> Header | None:
        return self.files.header

    def of_the_controller(self) -> Analysis:
        """The analysis; ConfigurationError where there is none."""
        if self.analysis is None:
            raise ConfigurationError(
                "a forecast needs the controller's six terms; leave --terms out"
            )
        return self.analysis


def load_points(path: Path, fill_in: FillIn) -> tuple[PointTable, SessionView | None]:
    """Read a session, points CSV or TPOINT file, and the session itself where it is one."""
    if point_format(path) == SESSION:
        session = read_session(path)
        return session.table, session
    return read_table(path, **fill_in), None


def load_all(paths: Sequence[Path], fill_in: FillIn) -> list[tuple[PointTable, SessionView | None]]:
    """Every file; PAINT records, which hold one point each, are one table together."""
    paint = [path for path in paths if is_paint(path)]
    loaded = [load_points(path, fill_in) for path in paths if path not in paint]
    if paint:
        table = paint_table(read_paint(paint, fill_in), unit=fill_in.get("unit"))
        loaded.append((table, None))
    return loaded


def read_files(paths: Sequence[str | Path], fill_in: FillIn) -> UnitFiles:
    """Read files of one unit.

    Raises
    ------
    InputFileError, ConfigurationError
        A file that cannot be read, or files of different units.
    """
    files = tuple(Path(path) for path in paths)
    loaded = load_all(files, fill_in)
    require_one_unit([table for table, _ in loaded])
    once, contradictions = counted_once(loaded) if len(loaded) > 1 else (loaded, ())
    tables = labelled_by_file([table for table, _ in once])
    return UnitFiles(
        files,
        tables,
        merge_tables(tables),
        tuple(session for _, session in once if session is not None),
        contradictions,
    )


def analyse_files(
    files: UnitFiles,
    *,
    method: str | None = None,
    terms: Sequence[str] | None = None,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
    last_coefficients: Coefficients | None = None,
    bolt_circle: BoltCircle | None = None,
    **changes: Unpack[RuleChanges],
) -> FileAnalysis:
    """Fit and analyse files; the plan begins at the newest point unless ``at_utc_s`` is given.

    Terms of one's own choice mean the ``linear`` method. Several files fitted by ``robust`` may
    each have zeros and a lean of their own where their points say that something moved between
    them; the solution is then of the last one. ``last_coefficients`` and ``bolt_circle`` are those
    of the first session's header where they are None.

    Raises
    ------
    ConfigurationError, FitError
        Points that allow no fit.
    """
    table, header = files.table, files.header
    chosen = method or (DEFAULT_METHOD if terms is None else "linear")
    rule = stopping_rule(files.sessions, **changes)
    if header is not None:
        lean = read_last(files.sessions).header.inclinometer
        header = msgspec.structs.replace(header, inclinometer=lean)
    # A session broken off before its first point has nothing to compare; its records still count.
    with_points = [one for one in files.tables if one.count("accepted")]
    solution: Solution | None = None
    moved: tuple[Finding, ...] = ()
    if len(with_points) > 1 and chosen == "robust":
        merged = solve_merged(with_points, header, last_coefficients)
        solution, moved = merged.solution, merged.findings
        prior = merged.solution.prior
        context = sky_context(table, header)
    else:
        points = point_set(table)
        context = sky_context(table, header, points)
        prior, moved = chosen_prior(points, context, header, chosen, last_coefficients)
        if terms is not None and tuple(terms) != COEFFICIENT_NAMES:
            solution = fit(points, context, method=chosen, prior=prior, terms=terms)
    against = (*files.contradictions, *_overlapping(with_points, context, prior, rule), *moved)
    evidence = Evidence(table, files.sessions, against)
    asked = asked_for(files.sessions, rule, chosen, last_coefficients, bolt_circle)
    differing = tuple(differences(files.sessions, changes))

    def judged(
        solution: Solution, findings: tuple[Finding, ...], analysis: Analysis | None
    ) -> FileAnalysis:
        warnings = (*files.warnings, *differing)
        return FileAnalysis(files, solution, findings, analysis, rule, asked, warnings)

    if solution is not None and solution.terms != COEFFICIENT_NAMES:
        findings = findings_of(
            solution, context, evidence, prior=prior, tolerance_deg=rule.tolerance_deg
        )
        return judged(solution, findings, None)
    analysis = analyse(
        points if solution is None else solution.points,
        context,
        evidence,
        newest_point_utc_s(table) if at_utc_s is None else at_utc_s,
        method=chosen,
        prior=prior,
        solution=solution,
        rule=rule,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
        bolt_circle=bolt_circle or (None if header is None else header.bolt_circle),
    )
    return judged(analysis.solution, analysis.findings, analysis)


def _overlapping(
    tables: Sequence[PointTable], context: SkyContext, prior: Prior, rule: StoppingRule
) -> tuple[Finding, ...]:
    """Findings on sessions that overlap in time and contradict each other."""
    if len(tables) < 2:
        return ()
    parts = [point_set(table).distinct() for table in tables]
    names = [table.sources[0] for table in tables]
    return contradictions(parts, names, context, prior, rule.tolerance_deg / 2.0)


def stamp_findings(table: PointTable) -> tuple[Finding, ...]:
    """Whether stamps and ideal angles of a table agree, before anything is fitted."""
    if table.site is None or not table.count("accepted"):
        return ()
    return stamp_evidence(table, sky_context(table), TOLERANCE_DEG)


def solve_merged(
    tables: Sequence[PointTable],
    header: Header | None = None,
    last_coefficients: Coefficients | None = None,
) -> Merged:
    """Several sessions of one unit in order of time, with the test whether the tower moved.

    ``tables`` must be of one unit (``session.points.merge_tables`` refuses others); the context is
    the first one's. The last coefficients are the header's where none are given.
    """
    # Sigmas count only where every table gives them.
    weighted = all(table.sigma_deg is not None for table in tables)
    parts = [point_set(t if weighted else replace(t, sigma_deg=None)).distinct() for t in tables]
    names = [t.sources[0] if t.sources else f"session {k + 1}" for k, t in enumerate(tables)]
    in_time = groups_in_time(parts)
    groups = in_time or [[at] for at in range(len(parts))]
    context = sky_context(tables[groups[0][0]], header)
    called = [listed([names[at] for at in group]) for group in groups]
    joined = [Points.joined([parts[at] for at in group]) for group in groups]

    def merged(prior: Prior) -> Merged:
        return merge_sessions(joined, context, prior=prior, names=called)

    prior, against = chosen_prior(
        joined[0], context, header, DEFAULT_METHOD, last_coefficients,
        lambda one: merged(one).solution,
    )  # fmt: skip
    found = merged(prior)
    moved = found.findings
    if in_time is None and found.change != "same":
        order = f"; not every file has time stamps: {names[-1]}, given last, is taken as the last"
        moved = tuple(replace(one, sentence=one.sentence + order) for one in moved)
    of_groups = found.solution.session_shifts
    shifts = {
        names[at]: of_groups[name]
        for name, group in zip(called, groups, strict=True)
        if name in of_groups
        for at in group
    }
    return replace(
        found,
        solution=replace(found.solution, session_shifts=shifts),
        findings=(*against, *moved),
    )
