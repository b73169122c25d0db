"""``solarcal export``: the points of a session as CSV or TPOINT file."""

import argparse
from pathlib import Path

from solarcal.cli.output import print_json, say
from solarcal.errors import ConfigurationError

HELP = "write a session's points as .csv or TPOINT .dat"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="IN.jsonl", help="session file (.csv and .dat work too)")
    parser.add_argument("target", metavar="OUT", help="points .csv, or TPOINT .dat (azel only)")
    parser.add_argument("--replace", action="store_true", help="write over a file that is there")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.session.interchange import read_table, write_table
    from solarcal.session.points import STATUSES

    target = Path(args.target)
    if target.exists() and not args.replace:
        raise ConfigurationError(f"{target} exists already; give another name, or --replace")
    table = read_table(args.source)
    write_table(table, target)
    warnings = list(table.warnings)
    if target.suffix.lower() == ".dat" and table.ideal != "apparent":
        warnings.append(
            f"TPOINT cannot say that the angles are {table.ideal}: a fit of {target} takes them "
            "for the Sun's true place; a .csv keeps it"
        )
    counts = {"total": len(table), **{status: table.count(status) for status in STATUSES}}
    if args.json:
        document = {
            "source": args.source,
            "target": args.target,
            "geometry": table.geometry,
            "points": counts,
            "warnings": warnings,
        }
        print_json(document)
        return 0
    for warning in warnings:
        say(f"warning: {warning}")
    print(f"{counts['total']} points ({counts['accepted']} accepted) in {args.target}")
    return 0
