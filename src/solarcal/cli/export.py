"""``solarcal export``: the points of a session as CSV or TPOINT file."""

import argparse

from solarcal.cli.output import print_json, say

HELP = "write a session's points as .csv or TPOINT .dat"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="IN.jsonl", help="session file (.csv and .dat work too)")
    parser.add_argument("target", metavar="OUT", help="points .csv, or TPOINT .dat (azel only)")
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    from solarcal.session.interchange import read_table, write_table
    from solarcal.session.points import STATUSES

    table = read_table(args.source)
    write_table(table, args.target)
    counts = {"total": len(table), **{status: table.count(status) for status in STATUSES}}
    if args.json:
        document = {
            "source": args.source,
            "target": args.target,
            "geometry": table.geometry,
            "points": counts,
            "warnings": list(table.warnings),
        }
        print_json(document)
        return 0
    for warning in table.warnings:
        say(f"warning: {warning}")
    print(f"{counts['total']} points ({counts['accepted']} accepted) in {args.target}")
    return 0
