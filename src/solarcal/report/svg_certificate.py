"""A certificate as one tall SVG: text in a fixed pitch, plots as drawings."""

from solarcal.report.columns import wrapped
from solarcal.report.html_certificate import shown
from solarcal.report.plain_certificate import plain_lines
from solarcal.report.renderables import Certificate, Figure, printable

PITCH, LINE, MARGIN = 7.3, 17, 28
LEAST_COLUMNS = 84


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
                for line in plain_lines(block):
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
        self._parts.append(
            f'<svg x="{MARGIN}" y="{self._y:g}" width="{figure.width}" height="{figure.height}" '
            f'font-family="sans-serif">{figure.svg}</svg>'
        )
        self._y += figure.height

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
