"""The lines that tell of the station: unit, mode and link; what to do next; P1..P6 with sigma,
change since the last point and their history; why the verdict is so; what proves the points.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

from textual.content import Content

from solarcal.decimals import counted
from solarcal.model.analysis import Analysis
from solarcal.model.evidence.direct import evidence_sentences
from solarcal.model.prior import Prior
from solarcal.model.solution import Solution
from solarcal.model.verdict import sure_sentence
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.report.blocks import Sentences, lines_of
from solarcal.report.judgement import formula_residuals_deg, shim_sentence
from solarcal.report.tables import checks_table, clocks_table, ref_checks_table, upload_table
from solarcal.session.view import SessionView
from solarcal.station.next_step import NextStep, countdown_text
from solarcal.station.sign_off import sign_off
from solarcal.station.state import LinkState, StationState, uploads_as_replaced
from solarcal.tui.widgets.lines import HeadLine, Part, Words
from solarcal.tui.widgets.text_lines import ENDLESS, TextLines
from solarcal.units import rms


class TitleLine(HeadLine):
    """The program, the unit, its mode, and the link."""

    DEFAULT_CSS = """
    TitleLine#title.-lost { background: $error; color: $background; }
    """

    def show_state(self, state: StationState, *, replay: bool = False, silent_s: int = 0) -> None:
        live = state.live
        lost = live.link is LinkState.LOST
        self.set_class(lost, "-lost")
        unit = ""
        if live.identity is not None:
            unit = f"{live.identity.model} {live.identity.serial}"
        elif state.session is not None:
            unit = f"{state.session.header.unit.model} {state.session.header.unit.serial}"
        geometry = state.session.header.geometry if state.session is not None else ""
        mode = str(live.status.mode) if live.status is not None else ""
        link = {
            LinkState.CONNECTED: f"◌ LINK silent {silent_s} s" if silent_s else "● LINK OK",
            LinkState.LOST: "✖ LINK LOST",
            LinkState.CLOSED: "○ no link",
        }[live.link]
        if not live.capabilities.has_link:
            mode, link = "STOP is at the unit", "✎ TYPED BY HAND"
        name = "solarcal REPLAY" if replay else "solarcal"
        self.show(
            [f"{name}  {unit} {geometry}"], ["saved session" if replay else f"{mode}   {link}"]
        )


class NextLines(Words):
    """What to do next, with the key for it and the time left; then what the points come to.

    Three rows, whatever they say, so that nothing below them ever jumps: the next step takes what
    it needs of them, the verdict the rest.
    """

    DEFAULT_CSS = """
    NextLines { height: 3; width: 1fr; padding: 0 1; background: $boost; }
    """

    ROWS = 3

    def show_step(
        self, step: NextStep, key: str, utc_s: float | None, verdict: "VerdictWords"
    ) -> None:
        sentence = Content.assemble(("▶ ", "bold $accent"), (step.sentence, "bold"))
        tail: list[tuple[str, str]] = []
        if key:
            tail.append((f"[{key}]", "bold $footer-key-foreground"))
        left = step.countdown_s(utc_s)
        if left:
            tail.append((f"in {countdown_text(left)}", "$accent"))
        elif left is not None:
            tail.append(("due NOW", "bold reverse $accent"))
        # Not the size of this widget: before the first layout it has none.
        width = max(self.app.size.width - 2, 20)
        lines = _with_tail(sentence.wrap(width), tail, width)[: self.ROWS - 1]
        room = self.ROWS - len(lines)
        self.update(Content("\n").join([*lines, *verdict.fitted(width, room)]), layout=False)


def _with_tail(lines: list[Content], tail: list[tuple[str, str]], width: int) -> list[Content]:
    """Keys and times after the sentence, none of them torn apart by the end of a line."""
    for words, style in tail:
        piece = Content.styled(words, style)
        if lines[-1].cell_length + 2 + piece.cell_length <= width:
            lines[-1] = Content.assemble(lines[-1], "  ", piece)
        else:
            lines.append(piece)
    return lines


IN_ITS_PANE = "[3: reasons]"


@dataclass(frozen=True, slots=True)
class VerdictWords:
    """The verdict as it is always on screen: a mark, the word, the year, the first reason."""

    word: str
    summary: str = ""
    tone: str = ""
    reason: str = ""

    def parts(self, reason: str = "") -> list[Part]:
        """Mark, word and summary, with a reason or what stands for it."""
        rest = "  ".join(text for text in (self.summary, reason) if text)
        return [("■ ", f"bold {self.tone}".strip()), (self.word, "bold"), f"  {rest}"]

    def fitted(self, width: int, rows: int) -> list[Content]:
        """In so many rows; a reason that has no room is not cut, but said to be in its pane, and
        the word alone leaves more of it."""
        reasons = (self.reason, IN_ITS_PANE, "[3]", "") if self.reason else ("",)
        word_alone = replace(self, word=f"{self.word.split(':')[0].rstrip('.')}.")
        for words, reason in product((self, word_alone), reasons):
            lines = Content.assemble(*words.parts(reason)).wrap(width)
            if len(lines) <= rows:
                return lines
        last = lines[rows - 1].truncate(width - 1).append("…")
        return [*lines[: rows - 1], last]


TONES = {
    "done": "$success", "continue": "$accent", "not_today": "$warning",
    "does_not_fit": "$error",
}  # fmt: skip


def verdict_words(
    session: SessionView | None, judgement: Analysis | None, reason: str = ""
) -> VerdictWords:
    """What the points come to; after an upload with check points, whether it is signed off."""
    if session is not None and session.uploads and session.checks:
        proof = sign_off([session], judgement)
        if proof.proven:
            word = "SIGNED OFF" if proof.signed_off else "NOT SIGNED OFF"
            return VerdictWords(word, proof.reason, "$success" if proof.signed_off else "$error")
    if session is None or judgement is None:
        waiting = session is not None and session.accepted
        told = reason or ("" if waiting else "it comes with the first point")
        return VerdictWords("judging ..." if waiting and not reason else "No verdict", told)
    verdict = judgement.verdict
    expected = judgement.forecast
    rule, p95 = expected.rule, expected.rule.within_deg(expected.year_p95_deg)
    # The forecast stands first already: where it decides, what follows it is not the reason.
    forecast_reason = sure_sentence(expected)
    others = [reason for reason in verdict.reasons if reason != forecast_reason]
    decides = verdict.state == "continue" and not expected.sure
    first = IN_ITS_PANE if decides and others else next(iter(others), "")
    sure = expected.sure_words
    summary = f"{sure[0].upper()}{sure[1:]} of {rule.tolerance_deg:g} deg. Year 95 %: {p95} deg."
    return VerdictWords(f"{verdict.words}.", summary, TONES[verdict.state], first)


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


HISTORY = 12
DECIMALS = {"P5": 6, "P6": 6}


class CoefficientsPane(TextLines):
    """The fit as it stands; says so when there is none yet."""

    DEFAULT_CSS = """
    CoefficientsPane { padding: 0 1; }
    """

    def show_fit(
        self, session: SessionView, solution: Solution | None, judgement: Analysis | None = None
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
    # The newest recorded fit of another number of points.
    before = next((fit for fit in reversed(session.fits) if fit.points != solution.n_points), None)
    lines: list[list[Part]] = [
        [(f"{'':3}{'value':>10} {'sigma':>9} {'change':>10}  history", "bold")]
    ]
    for index, name in enumerate(COEFFICIENT_NAMES):
        decimals = DECIMALS.get(name, 4)
        sigma = f"{sigmas.as_tuple()[index]:.{decimals}f}" if sigmas is not None else "-"
        change, style = "-", ""
        if before is not None:
            moved = values[index] - before.coefficients.as_tuple()[index]
            change = f"{moved:+z.{decimals}f}"
            if sigmas is not None and abs(moved) > 3.0 * sigmas.as_tuple()[index]:
                change, style = change + "!", "bold $warning"
        history = [fit.coefficients.as_tuple()[index] for fit in session.fits] or [values[index]]
        lines.append(
            [
                (f"{name:3}", "bold"),
                f"{values[index]:>+z10.{decimals}f} {sigma:>9} ",
                (f"{change:>10}", style),
                "  ",
                (sparkline(history, HISTORY), "$secondary"),
            ]
        )
    # As in the rows and plots of the points beside it.
    left_deg = formula_residuals_deg(solution, solution.points)
    lines += [
        [""],
        [
            "residual of formula ",
            (f"rms {rms(left_deg):.4f}", "bold"),
            f"  max {left_deg.max():.4f} deg",
        ],
        [
            f"{counted(solution.n_points, 'point')}, rank {solution.rank} of "
            f"{len(solution.terms)}, condition {_short(solution.condition_number)}"
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
    return [*shims, [""], [("■ ", "bold"), (verdict.words, "bold")], *reasons]


def _short(number: float) -> str:
    return f"{number:.3g}" if number < 1e12 else "beyond 1e12"


def _in_force(session: SessionView) -> list[list[Part]]:
    return [
        [(f"{name:3}", "bold"), f"{value:>+z10.{DECIMALS.get(name, 4)}f}"]
        for name, value in zip(
            COEFFICIENT_NAMES, session.header.coefficients.as_tuple(), strict=True
        )
    ]


def check_lines(session: SessionView) -> list[str]:
    """What proves the points: clocks, reference checks, uploads, check points, evidence."""
    sections = [
        ("Clock", clocks_table(session.clock_sets)),
        ("Reference checks", ref_checks_table(session.ref_checks)),
        *(("Upload", upload_table(upload)) for upload in uploads_as_replaced(session.uploads)),
    ]
    if session.checks:
        sections.append(
            ("Check points", checks_table(session.checks, session.header.tolerance_deg))
        )
    if said := evidence_sentences(session):
        sections.append(("Evidence", (Sentences(tuple(said)),)))
    # The pane folds them to its width.
    lines: list[str] = []
    for title, blocks in sections:
        lines += ["", title, *lines_of(*blocks, width=ENDLESS)]
    return lines[1:]
