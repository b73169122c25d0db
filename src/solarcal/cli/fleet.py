"""``solarcal fleet``: fit thousands of session files, list the worst trackers."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.cli.process import add_json_option, print_json, say
from solarcal.decimals import counted, whole_option
from solarcal.errors import one_line
from solarcal.report.blocks import columns, number

if TYPE_CHECKING:
    from collections.abc import Callable

    from solarcal.station.fleet import Fleet, FleetMember, WorstBy

_NAMED = 10
"""Unreadable files named on a screen; the JSON document names all."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder, with its subfolders")
    parser.add_argument(
        "--worst-by",
        choices=("rms", "lean", "sigma", "noise"),
        default="rms",
        help="order by rms of the residuals on sky (default), lean, sigma of the lean, or noise of "
        "one point",
    )
    parser.add_argument(
        "--top",
        type=whole_option(0),
        default=20,
        metavar="N",
        help="number of lines; 0: all; default 20",
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    from solarcal.station.fleet import fit_fleet, session_files

    args.exit_code = 1
    files = session_files(args.folder)
    fleet = fit_fleet(files, _progress_on(sys.stderr.isatty()))
    args.exit_code = 0 if fleet.members else 1
    worst = fleet.worst(args.worst_by, args.top)
    if args.json:
        print_json(
            {
                "folder": str(args.folder),
                "files": len(files),
                "fitted": len(fleet.members),
                "unreadable": [
                    {"file": path, "reason": reason} for path, reason in fleet.unreadable
                ],
                "worst_by": args.worst_by,
                "sessions": [member.as_json() for member in worst],
            }
        )
    else:
        print("\n".join(_table(fleet, worst, args.worst_by, args.folder)))
    return int(args.exit_code)


def _progress_on(terminal: bool) -> "Callable[[str, int, int], None]":
    """One line rewritten in place on a terminal; elsewhere a line for each quarter."""
    told: dict[str, int] = {}

    def progress(what: str, done: int, total: int) -> None:
        if terminal:
            end = "\n" if done == total else ""
            print(f"\r{what} {done:6d} of {total}", end=end, file=sys.stderr, flush=True)
        elif (quarter := 4 * done // max(total, 1)) > told.get(what, -1):
            told[what] = quarter
            say(f"{what} {done} of {total}")

    return progress


def _table(
    fleet: "Fleet", worst: "tuple[FleetMember, ...]", worst_by: "WorstBy", folder: Path
) -> list[str]:
    what = {"rms": "rms", "lean": "lean", "sigma": "lean's sigma", "noise": "noise"}[worst_by]
    lines = [
        f"{counted(len(fleet.members), 'session')} fitted by robust; the {len(worst)} worst by "
        f"{what}, deg:",
        "",
        *columns(
            ("file", "pts", "out", "rms", "max", "noise", "lean", "sigma"),
            [
                (
                    _shortened(m.path, folder),
                    str(m.points),
                    str(len(m.outliers)),
                    number(m.sky_rms_deg, 3),
                    number(m.sky_max_deg, 3),
                    number(m.noise_deg, 3),
                    number(m.lean_deg, 3),
                    number(m.lean_sigma_deg, 3),
                )
                for m in worst
            ],
            "<>>>>>>>",
        ),
        "",
        "out: points that are more likely blunders than not",
        "`solarcal fit FILE` reports the rest of a session",
    ]
    if fleet.unreadable:
        lines += ["", f"{counted(len(fleet.unreadable), 'file')} could not be read or fitted:"]
        lines += [f"  {reason}" for reason in _named(fleet)]
    return lines


def _named(fleet: "Fleet") -> list[str]:
    found = [(one_line(path), one_line(reason)) for path, reason in fleet.unreadable[:_NAMED]]
    named = [reason if path in reason else f"{path}: {reason}" for path, reason in found]
    left = len(fleet.unreadable) - len(named)
    return [*named, *([f"and {left} more; --json names them all"] if left else [])]


_LONGEST_NAME = 31


def _shortened(path: str, folder: Path) -> str:
    """The file within its folder, or a heliostat's own folder; its end, where that is too long."""
    within = Path(path).relative_to(folder)
    name = one_line(str(within.parents[1] if within.match("*/Properties/*.json") else within))
    return name if len(name) <= _LONGEST_NAME else "..." + name[3 - _LONGEST_NAME :]
