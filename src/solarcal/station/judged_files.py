"""Files of one unit, fitted and judged: what every command that reads saved points starts from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.model.forecast import StoppingRule
from solarcal.model.judgement import Judgement
from solarcal.model.solution import Solution
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.session.interchange import FillIn
from solarcal.session.points import PointTable
from solarcal.session.reader import Session
from solarcal.session.records import Header
from solarcal.station.fitted_files import FittedFiles, fit_files
from solarcal.station.judging import judge_fit, stopping_rule


@dataclass(frozen=True, slots=True)
class JudgedFiles:
    """A fit of files and its judgement.

    ``judgement`` is None where other terms than P1..P6 were fitted: what a controller cannot be
    given has no forecast.
    """

    paths: tuple[Path, ...]
    fitted: FittedFiles
    judgement: Judgement | None
    rule: StoppingRule

    @property
    def tolerance_deg(self) -> float:
        return self.rule.tolerance_deg

    @property
    def table(self) -> PointTable:
        return self.fitted.table

    @property
    def solution(self) -> Solution:
        return self.fitted.solution

    @property
    def sessions(self) -> tuple[Session, ...]:
        return self.fitted.sessions

    @property
    def header(self) -> Header | None:
        """Of the first session; None where there are only points files."""
        return self.sessions[0].header if self.sessions else None

    def of_the_controller(self) -> Judgement:
        """The judgement.

        Raises
        ------
        ConfigurationError
            There is none.
        """
        if self.judgement is None:
            raise ConfigurationError(
                "a forecast needs the controller's six terms; leave --terms out"
            )
        return self.judgement


def judge_files(
    paths: Sequence[str | Path],
    fill_in: FillIn,
    *,
    method: str | None = None,
    terms: Sequence[str] | None = None,
    tolerance_deg: float | None = None,
    done_probability: float | None = None,
) -> JudgedFiles:
    """Read, merge, fit and judge, planning from the newest point.

    Raises as ``fit_files`` and ``judge_fit``.
    """
    files = [Path(path) for path in paths]
    fitted = fit_files(files, fill_in, method=method, terms=terms)
    return judge_fitted(
        files, fitted, tolerance_deg=tolerance_deg, done_probability=done_probability
    )


def judge_fitted(
    paths: Sequence[str | Path],
    fitted: FittedFiles,
    *,
    tolerance_deg: float | None = None,
    done_probability: float | None = None,
    at_utc_s: float | None = None,
    until_utc_s: float | None = None,
    points_left: int | None = None,
    struck: Sequence[tuple[float, float]] = (),
) -> JudgedFiles:
    """The judgement of files already fitted; the plan begins at the newest point unless told."""
    files = tuple(Path(path) for path in paths)
    header = fitted.sessions[0].header if fitted.sessions else None
    rule = stopping_rule(header, tolerance_deg, done_probability)
    if fitted.solution.terms != COEFFICIENT_NAMES:
        return JudgedFiles(files, fitted, None, rule)
    judgement = judge_fit(
        fitted.table,
        fitted.solution,
        header,
        tolerance_deg=rule.tolerance_deg,
        done_probability=rule.probability,
        at_utc_s=at_utc_s,
        until_utc_s=until_utc_s,
        points_left=points_left,
        struck=struck,
        evidence=fitted.evidence,
    )
    return JudgedFiles(files, fitted, judgement, rule)
