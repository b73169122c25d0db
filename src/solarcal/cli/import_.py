"""``solarcal import``: points of a CSV or TPOINT file into a session file of their own."""

import argparse
from pathlib import Path

from solarcal.cli.fit import add_point_options, fill_in
from solarcal.cli.output import print_json, say
from solarcal.errors import ConfigurationError
from solarcal.timescale import SystemClock

HELP = "make a session file from a points .csv or TPOINT .dat file"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="IN", help="points .csv, TPOINT .dat or session .jsonl")
    parser.add_argument("target", metavar="OUT.jsonl", help="the new session file")
    add_point_options(parser)
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:

    from solarcal.session.interchange import read_table
    from solarcal.session.interchange.sessions import session_from_table
    from solarcal.session.points import STATUSES
    from solarcal.station.analysing import stamp_findings

    if Path(args.target).suffix.lower() != ".jsonl":
        raise ConfigurationError(f"{args.target}: a session file ends in .jsonl")
    table = read_table(args.source, **fill_in(args))
    session = session_from_table(table, args.target, utc_s=SystemClock().utc_s())
    warnings = [*table.warnings, *(finding.sentence for finding in stamp_findings(table))]
    counts = {"total": len(table), **{status: table.count(status) for status in STATUSES}}
    if args.json:
        document = {
            "source": args.source,
            "session": args.target,
            "geometry": table.geometry,
            "points": counts,
            "unknown": list(session.header.unknown),
            "warnings": warnings,
        }
        print_json(document)
        return 0
    for warning in warnings:
        say(f"warning: {warning}")
    if session.header.unknown:
        missing = " and ".join(session.header.unknown)
        say(f"warning: the {missing} is not known (--lat, --lon)")
    print(f"{counts['total']} points ({counts['accepted']} accepted) in {args.target}")
    return 0
