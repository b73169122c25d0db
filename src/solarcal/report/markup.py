"""A certificate as a self-contained HTML page, as Markdown, as one tall SVG.

The page has no script and no link and prints on white; Markdown has GitHub's tables and the plots
in fences; the SVG is text in a fixed pitch with the plots as drawings.
"""

import re
from html import escape

from solarcal.report.blocks import (
    FIGURE_SIZE,
    Block,
    Certificate,
    Facts,
    Figure,
    Prose,
    Sentences,
    Signatures,
    Table,
    lines_of,
    printable,
    wrapped,
)

_STYLE = """
body{font:15px/1.45 sans-serif;color:#000;background:#fff;max-width:52rem;margin:2rem auto;
padding:0 1rem}
h1{margin:0}h2{border-bottom:1px solid #000;margin:1.8rem 0 .6rem;font-size:1.15rem}
.status{font-weight:bold;border:2px solid #000;padding:.4rem .7rem}
table{border-collapse:collapse;margin:.6rem 0;font-variant-numeric:tabular-nums}
th,td{padding:.12rem .6rem .12rem 0;text-align:left;vertical-align:top}
thead th{border-bottom:1px solid #000}.n{text-align:right}tbody th{font-weight:normal}
.hash td{overflow-wrap:anywhere}.group td{font-weight:bold}.remark td{padding-left:2rem}
figure{margin:1rem 0;break-inside:avoid}figcaption{font-style:italic}
svg{max-width:100%;height:auto;font:12px sans-serif}
.sign{margin:2.2rem 0 0;border-top:1px solid #000;padding-top:.2rem;display:flex;gap:2rem}
.sign span{flex:1}
@media print{body{margin:0;max-width:none}tr{break-inside:avoid}}
"""

_SPECIAL = re.compile(r"([\\`*_\[\]<>#|&~])")
_FIRST = re.compile(r"^(\d*)([-+=.)])")
"""What would begin a list or a heading at the start of a line."""
_LINKED = re.compile(r"(://|www\.)", re.IGNORECASE)
"""What GitHub turns into a link unasked."""

_SIDES = {"<": "", ">": ' class="n"'}
PITCH, LINE, MARGIN = 7.3, 17, 28
LEAST_COLUMNS = 84


def html_text(certificate: Certificate) -> str:
    """The page; every text of the files is escaped."""
    body = [
        f"<h1>{shown(certificate.title)}</h1>",
        f"<p>{shown(certificate.subject)}</p>",
        f'<p class="status">{shown(certificate.status)}</p>',
    ]
    for section in certificate.sections:
        body.append(f"<section>\n<h2>{shown(section.title)}</h2>")
        body += map(_html_block, section.blocks)
        body.append("</section>")
    title = f"{shown(certificate.title)}: {shown(certificate.subject)}"
    return "\n".join(
        [
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>{title}</title>",
            f"<style>{_STYLE}</style>",
            "</head>",
            "<body>",
            *body,
            "</body>",
            "</html>",
            "",
        ]
    )


def shown(text: str) -> str:
    """A text that HTML and SVG show as it is."""
    return escape(printable(text))


def _html_block(block: Block) -> str:
    match block:
        case Prose():
            return "\n".join(f"<p>{shown(text)}</p>" for text in block.paragraphs if text)
        case Facts():
            rows = "\n".join(
                f'<tr><th scope="row">{shown(name)}</th><td>{shown(value)}</td></tr>'
                for name, value in block.rows
            )
            return f"<table>\n<tbody>\n{rows}\n</tbody>\n</table>"
        case Table():
            return _html_table(block)
        case Sentences():
            items = "\n".join(f"<li>{shown(sentence)}</li>" for sentence in block.sentences)
            return f"<ul>\n{items}\n</ul>"
        case Figure():
            caption, (wide, high) = shown(block.caption), FIGURE_SIZE
            return (
                f'<figure>\n<svg xmlns="http://www.w3.org/2000/svg" role="img" '
                f'aria-label="{caption}" viewBox="0 0 {wide} {high}" '
                f'width="{wide}" height="{high}">{block.svg}</svg>\n'
                f"<figcaption>{caption}</figcaption>\n</figure>"
            )
        case Signatures():
            return "\n".join(
                f'<div class="sign"><span>{shown(role)}, name</span><span>Date</span>'
                "<span>Signature</span></div>"
                for role in block.roles
            )


def _html_table(table: Table) -> str:
    def line(cells: tuple[str, ...], tag: str) -> str:
        scope = ' scope="col"' if tag == "th" else ""
        told = "".join(
            f"<{tag}{_SIDES[side]}{scope}>{shown(cell)}</{tag}>"
            for cell, side in zip(cells, table.align, strict=True)
        )
        return f"<tr>{told}</tr>"

    def across(text: str, kind: str) -> str:
        return f'<tr class="{kind}"><td colspan="{len(table.headings)}">{shown(text)}</td></tr>'

    rows: list[str] = []
    for above, row, remark in table.parts():
        rows += [across(name, "group") for name in above]
        rows.append(line(row, "td"))
        if remark:
            rows.append(across(remark, "remark"))
    kind = ' class="hash"' if "sha256" in table.headings else ""
    head, body = line(table.headings, "th"), "\n".join(rows)
    return f"<table{kind}>\n<thead>\n{head}\n</thead>\n<tbody>\n{body}\n</tbody>\n</table>"


def markdown_text(certificate: Certificate) -> str:
    """The certificate; nothing a file contains can become markup."""
    parts = [
        f"# {escaped(certificate.title)}",
        paragraph(certificate.subject),
        f"**{escaped(certificate.status)}**",
    ]
    for section in certificate.sections:
        parts.append(f"## {escaped(section.title)}")
        parts += map(_markdown_block, section.blocks)
    return "\n\n".join(parts) + "\n"


def escaped(text: str) -> str:
    """A text that Markdown shows as it is, within a line."""
    shown = _SPECIAL.sub(r"\\\1", printable(text))
    return _LINKED.sub(lambda found: f"{found[0][:-1]}\\{found[0][-1]}", shown)


def paragraph(text: str) -> str:
    """The same at the start of a line, where more means something."""
    return _FIRST.sub(r"\1\\\2", escaped(text))


def _markdown_block(block: Block) -> str:
    match block:
        case Prose():
            return "\n\n".join(paragraph(text) for text in block.paragraphs if text)
        case Facts():
            return _markdown_table(Table(("", ""), block.rows, "<<"))
        case Table():
            return _markdown_table(block)
        case Sentences():
            return "\n".join(f"- {paragraph(sentence)}" for sentence in block.sentences)
        case Figure():
            return f"{paragraph(block.caption)}\n\n```text\n{block.text}\n```"
        case Signatures():
            rows = tuple((role, "", "", "") for role in block.roles)
            return _markdown_table(Table(("", "Name", "Date", "Signature"), rows, "<<<<"))


def _markdown_table(table: Table) -> str:
    """No cell goes across a row here: a group is in the first column, a remark in the last."""

    def line(cells: tuple[str, ...]) -> str:
        return f"| {' | '.join(map(escaped, cells))} |"

    rule = "|" + "|".join("---:" if side == ">" else ":---" for side in table.align) + "|"
    aside = ("",) * (len(table.headings) - 1)
    lines = [line(table.headings), rule]
    for above, row, remark in table.parts():
        lines += [line((name, *aside)) for name in above]
        lines.append(line(row))
        if remark:
            lines.append(line((*aside, remark)))
    return "\n".join(lines)


def svg_text(certificate: Certificate) -> str:
    """The drawing; every text of the files is escaped."""
    sheet = _Sheet()
    sheet.say(certificate.title, size=22, bold=True)
    for line in wrapped(printable(certificate.subject)):
        sheet.say(line)
    for line in wrapped(printable(certificate.status)):
        sheet.say(line, bold=True)
    for section in certificate.sections:
        sheet.heading(section.title)
        for block in section.blocks:
            if isinstance(block, Figure):
                sheet.say(block.caption, bold=True)
                sheet.figure(block)
            else:
                for line in lines_of(block):
                    sheet.say(line)
            sheet.skip(0.5)
    return sheet.text(f"{certificate.title}: {certificate.subject}")


class _Sheet:
    """Lines put below one another."""

    def __init__(self) -> None:
        self._parts: list[str] = []
        self._y = float(MARGIN)
        self._columns = LEAST_COLUMNS

    def skip(self, lines: float) -> None:
        self._y += lines * LINE

    def say(self, line: str, *, size: int = 12, bold: bool = False) -> None:
        self._y += max(LINE, size + 6)
        if not line:
            return
        self._columns = max(self._columns, len(line))
        style = (f' font-size="{size}"' if size != 12 else "") + (
            ' font-weight="bold"' if bold else ""
        )
        self._parts.append(
            f'<text x="{MARGIN}" y="{self._y:g}" xml:space="preserve"{style}>{shown(line)}</text>'
        )

    def heading(self, title: str) -> None:
        self.skip(1.0)
        self.say(title, size=15, bold=True)
        self._y += 5
        self._parts.append(f'<path d="M{MARGIN} {self._y:g}h600" stroke="#000"/>')

    def figure(self, figure: Figure) -> None:
        self._y += 6
        wide, high = FIGURE_SIZE
        self._parts.append(
            f'<svg x="{MARGIN}" y="{self._y:g}" width="{wide}" height="{high}" '
            f'font-family="sans-serif">{figure.svg}</svg>'
        )
        self._y += high

    def text(self, title: str) -> str:
        width, height = 2 * MARGIN + self._columns * PITCH, self._y + MARGIN
        return "\n".join(
            [
                f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" '
                f'height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}" '
                'font-family="monospace" font-size="12">',
                f"<title>{shown(title)}</title>",
                f'<rect width="{width:.0f}" height="{height:.0f}" fill="#fff"/>',
                *self._parts,
                "</svg>",
                "",
            ]
        )
