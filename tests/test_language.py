"""Words that must not come back into what a person reads: messages, help, screens, documents.

The program's prose is plain technical English: a unit reports, answers and refuses; it does not
"tell", "hear" or "believe". Names of identifiers are not looked at, only sentences.
"""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

RETIRED = (
    "told", "nobody", "somebody", "anybody", "everybody", "hears", "stands on", "wish", "wishes",
    "is said", "are said", "even-handed", "hurried", "by itself", "by themselves", "the matter",
    "the house", "front door", "turned right about", "believes?", "promises",
)  # fmt: skip
WORDS = re.compile(r"\b(" + "|".join(RETIRED) + r")\b", re.IGNORECASE)


def _sentences_of(source: Path) -> Iterator[tuple[int, str]]:
    """Every text of a module that has a space in it: messages, help, docstrings."""
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and " " in node.value:
            # An inline style sheet names widgets, not words.
            if "{" in node.value and "height:" in node.value:
                continue
            text = re.sub(r"``[^`]*``|^ *[a-z_, ]+ : ", "", node.value, flags=re.MULTILINE)
            yield node.lineno, text


def _sentences_in(document: Path) -> Iterator[tuple[int, str]]:
    """The lines of a document outside its code blocks."""
    code = False
    for number, line in enumerate(document.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            code = not code
        elif not code:
            yield number, re.sub(r"`[^`]*`", "", line)


def _retired_in(sentences: Iterator[tuple[int, str]], where: Path) -> list[str]:
    return [
        f"{where.relative_to(ROOT)}:{line}: {found.group(0)}"
        for line, text in sentences
        for found in WORDS.finditer(text)
    ]


@pytest.mark.parametrize("room", sorted(p.name for p in (ROOT / "src" / "solarcal").iterdir()))
def test_no_retired_word_is_in_a_message_or_a_docstring(room):
    folder = ROOT / "src" / "solarcal" / room
    sources = [folder] if folder.suffix == ".py" else sorted(folder.rglob("*.py"))
    assert [found for s in sources for found in _retired_in(_sentences_of(s), s)] == []


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "sessions/README.md", "docs"])
def test_no_retired_word_is_in_a_document(name):
    place = ROOT / name
    documents = [place] if place.is_file() else sorted(place.glob("*.md"))
    assert documents
    assert [found for d in documents for found in _retired_in(_sentences_in(d), d)] == []


def test_no_retired_word_is_in_the_summary_of_a_scenario():
    files = sorted((ROOT / "src" / "solarcal").rglob("scenarios/*.toml"))
    assert files
    assert [found for file in files for found in _retired_in(_sentences_in(file), file)] == []


def test_the_words_are_found_where_they_stand():
    assert _retired_in(iter([(3, "Nobody hears this unit")]), ROOT / "x") == [
        "x:3: Nobody", "x:3: hears",
    ]  # fmt: skip
