"""A certificate as Markdown (GitHub's tables; plots in fences)."""

import re

from solarcal.report.renderables import (
    Block,
    Certificate,
    Facts,
    Figure,
    Sentences,
    Signatures,
    Table,
    printable,
)

_SPECIAL = re.compile(r"([\\`*_\[\]<>#|&~])")
_FIRST = re.compile(r"^(\d*)([-+=.)])")
"""What would begin a list or a heading at the start of a line."""
_LINKED = re.compile(r"(://|www\.)", re.IGNORECASE)
"""What GitHub makes a link of by itself."""


def markdown_text(certificate: Certificate) -> str:
    """The certificate; nothing a file contains can become markup."""
    parts = [
        f"# {escaped(certificate.title)}",
        paragraph(certificate.subject),
        f"**{escaped(certificate.status)}**",
    ]
    for section in certificate.sections:
        parts.append(f"## {escaped(section.title)}")
        parts += map(_block, section.blocks)
    return "\n\n".join(parts) + "\n"


def escaped(text: str) -> str:
    """A text that Markdown shows as it is, within a line."""
    shown = _SPECIAL.sub(r"\\\1", printable(text))
    return _LINKED.sub(lambda found: f"{found[0][:-1]}\\{found[0][-1]}", shown)


def paragraph(text: str) -> str:
    """The same at the start of a line, where more means something."""
    return _FIRST.sub(r"\1\\\2", escaped(text))


def _block(block: Block) -> str:
    match block:
        case Facts():
            return _table(("", ""), block.rows, "<<")
        case Table():
            return _table(block.headings, block.rows, block.align)
        case Sentences():
            return "\n".join(f"- {paragraph(sentence)}" for sentence in block.sentences)
        case Figure():
            return f"{paragraph(block.caption)}\n\n```text\n{block.text}\n```"
        case Signatures():
            rows = tuple((role, "", "", "") for role in block.roles)
            return _table(("", "Name", "Date", "Signature"), rows, "<<<<")


def _table(headings: tuple[str, ...], rows: tuple[tuple[str, ...], ...], align: str) -> str:
    lines = [headings, *rows]
    told = [f"| {' | '.join(map(escaped, line))} |" for line in lines]
    rule = "|" + "|".join("---:" if side == ">" else ":---" for side in align) + "|"
    return "\n".join([told[0], rule, *told[1:]])
