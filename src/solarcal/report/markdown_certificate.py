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

_SPECIAL = re.compile(r"([\\`*_{}\[\]<>()#+!|&~-])")
_AS_IT_IS = re.compile(r"[A-Za-z0-9 .,:;/%='\"?]*")


def markdown_text(certificate: Certificate) -> str:
    """The certificate; nothing a file contains can become markup."""
    parts = [
        f"# {escaped(certificate.title)}",
        escaped(certificate.subject),
        f"**{escaped(certificate.status)}**",
    ]
    for section in certificate.sections:
        parts.append(f"## {escaped(section.title)}")
        parts += map(_block, section.blocks)
    return "\n\n".join(parts) + "\n"


def escaped(text: str) -> str:
    """A text that Markdown shows as it is."""
    shown = printable(text)
    return shown if _AS_IT_IS.fullmatch(shown) else _SPECIAL.sub(r"\\\1", shown)


def _block(block: Block) -> str:
    match block:
        case Facts():
            return _table(("", ""), block.rows, "<<")
        case Table():
            return _table(block.headings, block.rows, block.align)
        case Sentences():
            return "\n".join(f"- {escaped(sentence)}" for sentence in block.sentences)
        case Figure():
            return f"{escaped(block.caption)}\n\n```text\n{block.text}\n```"
        case Signatures():
            rows = tuple((role, "", "", "") for role in block.roles)
            return _table(("", "Name", "Date", "Signature"), rows, "<<<<")


def _table(headings: tuple[str, ...], rows: tuple[tuple[str, ...], ...], align: str) -> str:
    lines = [headings, *rows]
    told = [f"| {' | '.join(map(escaped, line))} |" for line in lines]
    rule = "|" + "|".join("---:" if side == ">" else ":---" for side in align) + "|"
    return "\n".join([told[0], rule, *told[1:]])
