"""A certificate as one self-contained HTML page: no script, no link, prints on white."""

from html import escape

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

_STYLE = """
body{font:15px/1.45 sans-serif;color:#000;background:#fff;max-width:52rem;margin:2rem auto;
padding:0 1rem}
h1{margin:0}h2{border-bottom:1px solid #000;margin:1.8rem 0 .6rem;font-size:1.15rem}
.status{font-weight:bold;border:2px solid #000;padding:.4rem .7rem}
table{border-collapse:collapse;margin:.6rem 0;font-variant-numeric:tabular-nums}
th,td{padding:.12rem .6rem .12rem 0;text-align:left;vertical-align:top}
thead th{border-bottom:1px solid #000}.n{text-align:right}tbody th{font-weight:normal}
.hash td{overflow-wrap:anywhere}
figure{margin:1rem 0;break-inside:avoid}figcaption{font-style:italic}
svg{max-width:100%;height:auto;font:12px sans-serif}
.sign{margin:2.2rem 0 0;border-top:1px solid #000;padding-top:.2rem;display:flex;gap:2rem}
.sign span{flex:1}
@media print{body{margin:0;max-width:none}tr{break-inside:avoid}}
"""


def html_text(certificate: Certificate) -> str:
    """The page; every text of the files is escaped."""
    body = [
        f"<h1>{shown(certificate.title)}</h1>",
        f"<p>{shown(certificate.subject)}</p>",
        f'<p class="status">{shown(certificate.status)}</p>',
    ]
    for section in certificate.sections:
        body.append(f"<section>\n<h2>{shown(section.title)}</h2>")
        body += map(_block, section.blocks)
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


def _block(block: Block) -> str:
    match block:
        case Facts():
            rows = "\n".join(
                f'<tr><th scope="row">{shown(name)}</th><td>{shown(value)}</td></tr>'
                for name, value in block.rows
            )
            return f"<table>\n<tbody>\n{rows}\n</tbody>\n</table>"
        case Table():
            return _table(block)
        case Sentences():
            items = "\n".join(f"<li>{shown(sentence)}</li>" for sentence in block.sentences)
            return f"<ul>\n{items}\n</ul>"
        case Figure():
            caption = shown(block.caption)
            return (
                f'<figure>\n<svg xmlns="http://www.w3.org/2000/svg" role="img" '
                f'aria-label="{caption}" viewBox="0 0 {block.width} {block.height}" '
                f'width="{block.width}" height="{block.height}">{block.svg}</svg>\n'
                f"<figcaption>{caption}</figcaption>\n</figure>"
            )
        case Signatures():
            return "\n".join(
                f'<div class="sign"><span>{shown(role)}, name</span><span>Date</span>'
                "<span>Signature</span></div>"
                for role in block.roles
            )


def _table(table: Table) -> str:
    def line(cells: tuple[str, ...], tag: str) -> str:
        told = "".join(
            f"<{tag}{_side(side)}{_scope(tag)}>{shown(cell)}</{tag}>"
            for cell, side in zip(cells, table.align, strict=True)
        )
        return f"<tr>{told}</tr>"

    kind = ' class="hash"' if "sha256" in table.headings else ""
    rows = "\n".join(line(row, "td") for row in table.rows)
    head = line(table.headings, "th")
    return f"<table{kind}>\n<thead>\n{head}\n</thead>\n<tbody>\n{rows}\n</tbody>\n</table>"


def _side(side: str) -> str:
    return ' class="n"' if side == ">" else ""


def _scope(tag: str) -> str:
    return ' scope="col"' if tag == "th" else ""
