"""``solarcal doctor``: is this laptop ready?

The JSON document: ``ready`` and ``checks`` (``name``, ``verdict`` ok, warning or failed, ``found``,
``remedy``).
"""

import argparse
from dataclasses import asdict

from solarcal.cli.output import print_json
from solarcal.cli.readiness import check_all

HELP = "is this laptop ready"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument("--json", action="store_true", help="one JSON document on stdout")


def run(args: argparse.Namespace) -> int:
    """0 when no check failed; warnings do not count."""

    checks = check_all()
    failed = [check.name for check in checks if check.verdict == "failed"]
    if args.json:
        print_json({"ready": not failed, "checks": [asdict(check) for check in checks]})
    else:
        for check in checks:
            print(f"{check.verdict:8} {check.name:12} {check.found}")
            if check.remedy:
                print(f"{'':21} -> {check.remedy}")
        print(f"not ready: {', '.join(failed)}" if failed else "ready")
    return 1 if failed else 0
