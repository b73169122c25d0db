"""The answer of a field calculator, whoever asked: a command prints it, a screen shows it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from solarcal.report.scales import Theme

Draw = Callable[[int, int, bool, Theme], str]
"""Width, height, colour wanted, theme -> the drawing as text with ANSI colours."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """A drawing not yet drawn. ``height`` is what it takes when printed; None: a whole screen."""

    name: str
    draw: Draw
    height: int | None = 14


@dataclass(frozen=True, slots=True)
class Answer:
    """The JSON document, what is printed in its order, and a sketch only a screen has room for."""

    document: dict[str, Any]
    blocks: tuple[str | Drawing, ...]
    sketch: Drawing | None = None

    @property
    def lines(self) -> list[str]:
        """All the text."""
        text = [block.split("\n") for block in self.blocks if isinstance(block, str)]
        return [line for block in text for line in block]

    @property
    def drawings(self) -> tuple[Drawing, ...]:
        """The sketch and whatever is drawn between the text."""
        drawn = tuple(block for block in self.blocks if isinstance(block, Drawing))
        return drawn if self.sketch is None else (self.sketch, *drawn)


def paragraph(*lines: str) -> str:
    """Lines as one block."""
    return "\n".join(lines)
