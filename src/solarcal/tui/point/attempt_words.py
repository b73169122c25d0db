"""What the point dialog shows of an attempt: the question that is open, and the gathering."""

from collections.abc import Sequence

from textual.content import Content

from solarcal.session.records import Answers
from solarcal.station.gathering import GATHERING_S, READING_INTERVAL_S, READINGS
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
