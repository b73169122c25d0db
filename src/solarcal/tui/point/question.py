"""A question with its evidence, the answers so far, and the result of a gathering."""

from collections.abc import Sequence

from textual.content import Content

from solarcal.report.blocks import columns, number
from solarcal.session.records import Answers, CheckRecord, PointRecord
from solarcal.station.gathering import GATHERING_S, READING_INTERVAL_S, READINGS
from solarcal.station.point_judgement import PointJudgement
from solarcal.station.question_evidence import Fact
from solarcal.station.state import QUESTIONS
from solarcal.tui.dialogs.paced import progress_bar
from solarcal.tui.widgets.lines import Words


class Question(Words):
    """One of the three, with what speaks for and against it."""

    DEFAULT_CSS = """
    Question { height: auto; }
    """

    def ask(self, number: int, facts: Sequence[Fact], answers: Answers) -> None:
        given = (answers.ref_check, answers.sun_offset, answers.tracking)
        lines: list[str | tuple[str, str]] = []
        for index, question in enumerate(QUESTIONS):
            answer = given[index]
            if index < number:
                lines.append(f"   {question}  {'YES' if answer else 'NO'}\n")
            elif index == number:
                lines.append((f"{index + 1}. {question}\n", "bold $accent"))
                for fact in facts:
                    style = "bold $warning" if fact.against else ""
                    lines.append(
                        (f"      {'! ' if fact.against else '- '}{fact.sentence}\n", style)
                    )
        self.update(Content.assemble(*lines))


class Gathering(Words):
    """Progress of a gathering. The words say that keys are held."""

    DEFAULT_CSS = """
    Gathering { height: auto; }
    """

    def at(self, fraction: float) -> None:
        left_s = min(GATHERING_S, (1.0 - fraction) * READINGS * READING_INTERVAL_S)
        self.update(
            Content.assemble(
                ("GATHERING  ", "bold $accent"),
                f"{progress_bar(fraction)}, about {left_s:.0f} s to go\n\n",
                "Keys are ignored for a few seconds. Touch nothing. STOP works.",
            )
        )

    def typing(self) -> None:
        """Nothing is gathered: what the display shows is typed."""
        self.update(Content.assemble(("Type what the display shows.", "bold $accent")))


def point_result(candidate: PointRecord, judgement: PointJudgement) -> str:
    """Counts expected and found since the last point, and the error against the prediction."""
    rows = []
    for axis, judged in enumerate(judgement.axes, start=1):
        missing = None
        if judged.expected_counts is not None and judged.found_counts is not None:
            missing = judged.found_counts - judged.expected_counts
        rows.append(
            [
                str(axis),
                number(judged.expected_counts, 0, True),
                number(judged.found_counts, 0, True),
                number(missing, 0, True),
                number(judged.error_deg, 4, True),
                number(judged.off_deg, 4, True),
                number(judged.sigmas, 1, True),
                "LOOK" if judged.suspicious else "",
            ]
        )
    headings = (
        "axis", "expected", "found", "difference", "error, deg", "off fit", "in sigmas", "",
    )  # fmt: skip
    source = "Set Sun Offset" if candidate.basis == "sun_offset" else "the gathering"
    lines = ["Counts moved since the last point:", *columns(headings, rows, "<>>>>>><")]
    lines.append(f"Error taken from {source}" + (f": {candidate.reason}" * bool(candidate.reason)))
    return "\n".join(lines)


def check_result(candidate: CheckRecord) -> str:
    """What is left of the error after the upload."""
    e1, e2 = candidate.error_deg or (None, None)
    row = [number(e1, 4, True), number(e2, 4, True), number(candidate.sky_error_deg, 4)]
    headings = ("left, axis 1", "left, axis 2", "on the sky, deg")
    return "\n".join(["Check point, never fitted:", *columns(headings, [row], ">>>")])
