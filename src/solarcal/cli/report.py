"""``solarcal report``: a calibration on paper, and the zip for the office."""

import argparse
from pathlib import Path

from solarcal.cli.fit import add_bolt_option, add_judging_arguments, fill_in, judging
from solarcal.cli.output import print_json, say
from solarcal.errors import ConfigurationError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_judging_arguments(parser)
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        action="append",
        required=True,
        metavar="OUT",
        help="certificate to write (repeat for another format)",
    )
    parser.add_argument(
        "--zip",
        action="store_true",
        help="write a zip beside the first: certificate, files, profile, checksums",
    )
    add_bolt_option(parser)


def run(args: argparse.Namespace) -> int:
    from solarcal.report.certificate import WRITERS, issue

    for output in args.output:
        if output.suffix.lower() not in WRITERS:
            raise ConfigurationError(
                f"{output}: a certificate is written as {', '.join(WRITERS)}; choose by the ending"
            )
    issued = issue(
        args.files,
        fill_in(args),
        args.output,
        zip_too=args.zip,
        judging=lambda files: judging(args, files),
    )
    after, judged = issued.after, issued.judged
    judgement = judged.of_the_controller()
    if args.json:
        print_json(
            {
                "files": [path.name for path in args.files],
                "certificate": str(args.output[0]),
                "certificates": [str(output) for output in args.output],
                "sha256": issued.sha256,
                "zip": str(issued.paths[-1]) if args.zip else None,
                "signed_off": after.signed_off,
                "reason": after.reason,
                "prior": judgement.solution.as_json().get("prior"),
                "verdict": judgement.verdict.as_json(),
            }
        )
        return 0
    for warning in judged.warnings:
        say(f"warning: {warning}")
    state = "signed off" if after.signed_off else "not signed off"
    print("\n".join([*(f"wrote {path}" for path in issued.paths), f"{state}: {after.reason}"]))
    return 0
