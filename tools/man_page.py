"""Write the man page from the program's own tree of options: ``python -m tools.man_page``."""

import os
import sys
from pathlib import Path

from argparse_manpage.manpage import Manpage

from solarcal import __version__
from solarcal.cli import COMMANDS, OneLineParser, command_functions

PAGE = Path(__file__).parent.parent / "docs" / "solarcal.1"
DESCRIPTION = (
    "Calibrates sun trackers: takes points on the Sun, estimates the six tilt-error coefficients "
    "of the controller with their uncertainty, forecasts the pointing error over the year, and "
    "loads the coefficients, read back and compared. Without a command it opens the workstation. "
    "The documentation is in the folder docs of the program."
)


def whole_parser() -> OneLineParser:
    """Return the parser with every command and all their options."""
    parser = OneLineParser(prog="solarcal", description=DESCRIPTION)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    for name, help_line in COMMANDS.items():
        command = commands.add_parser(name, help=help_line, description=help_line)
        command_functions(name)[0](command)
    return parser


def man_page() -> str:
    """Return the page as roff."""
    os.environ["COLUMNS"] = "80"
    os.environ["SOURCE_DATE_EPOCH"] = "0"
    parser = whole_parser()
    parser.man_short_description = "calibrate a sun tracker from the terminal"  # type: ignore[attr-defined]
    page = Manpage(
        parser,
        format="pretty",
        _data={
            "prog": "solarcal",
            "version": __version__,
            "project_name": "solarcal",
            "manual_title": "User Commands",
            "manual_section": 1,
        },
    )
    return str(page)


if __name__ == "__main__":
    (Path(sys.argv[1]) if len(sys.argv) > 1 else PAGE).write_text(man_page(), encoding="utf-8")
