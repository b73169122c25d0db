"""How commands print: one JSON document, or text."""

import argparse
import json
import shutil
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from solarcal.instruments.form import Answer

TALLEST_CHART = 30
"""Rows of a drawing that takes a whole screen."""


def add_json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def plain(value: Any) -> Any:
    """Numpy scalars and arrays as Python numbers, not-a-number as null, recursively."""
    import numpy as np

    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def print_json(document: Any) -> None:
    """Exactly one JSON document on stdout."""
    json.dump(plain(document), sys.stdout, indent=2, allow_nan=False)
    sys.stdout.write("\n")


def print_answer(answer: "Answer", as_json: bool) -> int:
    """The answer of a field calculator as a document or as text with its drawings; 0."""

    if as_json:
        print_json(answer.document)
        return 0
    from solarcal.report.scales import Sheet

    width, colour = terminal_size()
    screen = min(max(shutil.get_terminal_size((80, 24)).lines - 2, 20), TALLEST_CHART)
    for block in answer.blocks:
        if isinstance(block, str):
            print(block)
        else:
            print(block.draw(Sheet(width, block.height or screen, colour)))
    return 0


def say(sentence: str) -> None:
    """Progress for a person; stderr, so that stdout stays the result."""
    print(sentence, file=sys.stderr, flush=True)


def terminal_size() -> tuple[int, bool]:
    """Columns for a drawing, and whether it may have colours."""

    columns = min(100, max(40, shutil.get_terminal_size((80, 24)).columns))
    return columns, sys.stdout.isatty()
