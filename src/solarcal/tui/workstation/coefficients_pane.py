"""P1..P6 with sigma, change since the last point and their history; why the verdict is so."""

from collections.abc import Sequence

from textual.content import Content

from solarcal.model.analysis import Analysis
from solarcal.model.fit import Solution
from solarcal.model.prior import Prior
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.report.judgement import STATE_WORDS, shim_sentence
from solarcal.session.records import FitRecord
from solarcal.station.state import SessionView
from solarcal.tui.widgets.text_lines import TextLines

BARS = "▁▂▃▄▅▆▇█"


def sparkline(values: Sequence[float], width: int) -> str:
    """The newest ``width`` values as bars between their smallest and largest."""
    shown = list(values)[-width:]
    if not shown:
        return ""
    low, high = min(shown), max(shown)
    if high <= low:
        return BARS[len(BARS) // 2] * len(shown)
    top = len(BARS) - 1
    return "".join(BARS[round((value - low) / (high - low) * top)] for value in shown)


Part = str | tuple[str, str]
HISTORY = 12
DECIMALS = {"P5": 6, "P6": 6}


class CoefficientsPane(TextLines):
    """The fit as it stands; says so when there is none yet."""

    DEFAULT_CSS = """
    CoefficientsPane { padding: 0 1; }
    """

    def __init__(self, id: str | None = None, classes: str | None = None) -> None:
        super().__init__(id=id, wrap=True, classes=classes)

    def show_fit(
        self,
        session: SessionView,
        solution: Solution | None,
        judgement: Analysis | None = None,
    ) -> None:
        lines = coefficient_lines(session, solution) + reason_lines(judgement)
        self.show([Content.assemble(*line) for line in lines])


def coefficient_lines(session: SessionView, solution: Solution | None) -> list[list[Part]]:
    """The pane's lines as parts with styles."""
    if solution is None:
        last = session.header.last_coefficients
        prior = "" if last is None else f"prior: {Prior.of_last_coefficients(last).words()}"
        return [
            [("P1..P6", "bold"), "  as soon as a point is accepted"],
            ["In force in the unit at the start:"],
            *_in_force(session),
            [prior],
        ]
    values = solution.coefficients().as_tuple()
    sigmas = solution.sigma_coefficients()
    before = _before(session.fits, solution.n_points)
    lines: list[list[Part]] = [
        [(f"{'':3}{'value':>10} {'sigma':>9} {'change':>10}  history", "bold")]
    ]
    for index, name in enumerate(COEFFICIENT_NAMES):
        decimals = DECIMALS.get(name, 4)
        sigma = f"{sigmas.as_tuple()[index]:.{decimals}f}" if sigmas is not None else "-"
        change, style = "-", ""
        if before is not None:
            moved = values[index] - before.coefficients.as_tuple()[index]
            change = f"{moved:+.{decimals}f}"
            if sigmas is not None and abs(moved) > 3.0 * sigmas.as_tuple()[index]:
                change, style = change + "!", "bold $warning"
        history = [fit.coefficients.as_tuple()[index] for fit in session.fits] or [values[index]]
        lines.append(
            [
                (f"{name:3}", "bold"),
                f"{values[index]:>+10.{decimals}f} {sigma:>9} ",
                (f"{change:>10}", style),
                "  ",
                (sparkline(history, HISTORY), "$secondary"),
            ]
        )
    lines += [
        [""],
        [
            "residual on sky ",
            (f"rms {solution.sky_rms_deg:.4f}", "bold"),
            f"  max {solution.sky_max_deg:.4f} deg",
        ],
        [
            f"{solution.n_points} point{'s' if solution.n_points > 1 else ''}, "
            f"rank {solution.rank} of {len(solution.terms)}, "
            f"condition {_short(solution.condition_number)}"
        ],
    ]
    if solution.message is not None:
        lines.append([(f" {solution.message} ", "bold reverse $warning")])
    return lines + [[sentence] for sentence in (*solution.inseparable, *solution.notes)]


def reason_lines(judgement: Analysis | None) -> list[list[Part]]:
    """The verdict with all its reasons; above the panes there is room for the first only."""
    if judgement is None:
        return []
    verdict = judgement.verdict
    reasons: list[list[Part]] = [[f"- {reason}"] for reason in verdict.reasons]
    shims: list[list[Part]] = []
    if verdict.base is not None and verdict.shims:
        shims = [[shim_sentence(verdict.base, verdict.shims)]]
    return [*shims, [""], [("■ ", "bold"), (STATE_WORDS[verdict.state], "bold")], *reasons]


def _short(number: float) -> str:
    return f"{number:.3g}" if number < 1e12 else "beyond 1e12"


def _before(fits: Sequence[FitRecord], points: int) -> FitRecord | None:
    """The newest recorded fit of another number of points."""
    return next((fit for fit in reversed(fits) if fit.points != points), None)


def _in_force(session: SessionView) -> list[list[Part]]:
    return [
        [(f"{name:3}", "bold"), f"{value:>+10.{DECIMALS.get(name, 4)}f}"]
        for name, value in zip(
            COEFFICIENT_NAMES, session.header.coefficients.as_tuple(), strict=True
        )
    ]
