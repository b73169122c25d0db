"""A certificate as plain text."""

from solarcal.report.columns import columns, wrapped
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

RULE = 80


def plain_text(certificate: Certificate) -> str:
    """Lines of at most 80 columns, but for tables whose cells need more."""
    lines = [
        "=" * RULE,
        printable(certificate.title).upper(),
        *wrapped(printable(certificate.subject)),
        *wrapped(printable(certificate.status)),
        "=" * RULE,
    ]
    for section in certificate.sections:
        title = printable(section.title)
        lines += ["", title, "-" * len(title)]
        for index, block in enumerate(section.blocks):
            lines += ["" for _ in range(bool(index))]
            lines += plain_lines(block)
    return "\n".join(lines) + "\n"


def plain_lines(block: Block) -> list[str]:
    """One block, without empty lines around it."""
    match block:
        case Facts():
            names = [printable(name) for name, _ in block.rows]
            width = max(map(len, names), default=0) + 2
            lines = []
            for name, (_, value) in zip(names, block.rows, strict=True):
                lines += wrapped(f"{name:<{width}}{printable(value)}", hang=width)
            return lines
        case Table():
            return table_lines(block)
        case Sentences():
            return [
                line
                for sentence in block.sentences
                for line in wrapped(f"- {printable(sentence)}", hang=2)
            ]
        case Figure():
            return [printable(block.caption), *block.text.split("\n")]
        case Signatures():
            return signature_lines(block)


def table_lines(table: Table) -> list[str]:
    """Headings, a rule, rows; a last column of remarks only goes below its row."""
    headings = [printable(heading) for heading in table.headings]
    rows = [[printable(cell) for cell in row] for row in table.rows]
    if headings[-1] != "remark":
        return columns(headings, rows, table.align)
    head, rule, *body = columns(headings[:-1], [row[:-1] for row in rows], table.align[:-1])
    lines = [head, rule]
    for row, line in zip(rows, body, strict=True):
        lines.append(line)
        if row[-1]:
            lines += wrapped(row[-1], indent=6)
    return lines


def signature_lines(block: Signatures) -> list[str]:
    lines: list[str] = []
    for role in block.roles:
        lines += [
            "",
            f"{printable(role)}",
            "Name ____________________  Date ______________  Signature ____________________",
        ]
    return lines[1:]
