"""What the points come to: ``solarcal forecast``, how wrong the tracker will be over the year;
``solarcal plan``, when to take the next points, and when today is worth stopping; ``solarcal
report``, a calibration on paper, and the zip for the office.
"""

import argparse
import re
import shutil
import sys
from pathlib import Path

from solarcal.cli.fit import add_bolt_option, add_judging_arguments, fill_in, judging
from solarcal.cli.process import print_json, say, warn
from solarcal.decimals import counted, whole_option
from solarcal.errors import ConfigurationError, one_line
from solarcal.report.blocks import text_of
from solarcal.timescale import SECONDS_PER_DAY, SystemClock, parse_utc

_CLOCK = re.compile(r"([01]?[0-9]|2[0-3]):([0-5][0-9])")


add_forecast_arguments = add_judging_arguments


def run_forecast(args: argparse.Namespace) -> int:
    from solarcal.station.analysing import analyse_files, read_files

    files = read_files(args.files, fill_in(args))
    judged = analyse_files(files, **judging(args, files))
    judgement = judged.of_the_controller()
    if args.json:
        from solarcal.station.documents import forecast_document

        print_json(forecast_document(args.files, judgement, judged.tolerance_deg))
        return 0
    from solarcal.report.forecast_map import forecast_map
    from solarcal.report.judgement import forecast_facts, verdict_blocks
    from solarcal.report.scales import Sheet

    warn(judged.warnings)
    width, height = shutil.get_terminal_size((80, 24))
    drawn = forecast_map(
        judgement.forecast,
        Sheet(max(40, min(width, 120)), max(16, min(height - 2, 40)), sys.stdout.isatty()),
        tolerance_deg=judged.tolerance_deg,
    )
    parts = (
        f"Expected error on the sky over the year, deg "
        f"({counted(judged.solution.n_points, 'point')}, {judged.solution.method})",
        text_of(forecast_facts(judgement.forecast, judged.tolerance_deg)),
        drawn,
        text_of(*verdict_blocks(judgement.verdict)),
    )
    print("\n\n".join(parts))
    return 0


def add_plan_arguments(parser: argparse.ArgumentParser) -> None:
    add_judging_arguments(parser)
    parser.add_argument(
        "--at",
        metavar="ISO",
        help="plan from this instant, or `now`; default: the time of the newest point",
    )
    parser.add_argument(
        "--until", metavar="HH:MM", help="end of the plan (UTC, the next such time)"
    )
    parser.add_argument(
        "--points", type=whole_option(), metavar="N", help="exact number of further points"
    )
    parser.add_argument(
        "--strike",
        action="append",
        default=[],
        metavar="HH:MM-HH:MM",
        help="plan no point in this time, UTC: cloud, lunch (repeatable)",
    )


def run_plan(args: argparse.Namespace) -> int:
    import numpy as np

    from solarcal.station.analysing import analyse_files, read_files
    from solarcal.station.fitting import newest_point_utc_s
    from solarcal.sun.position import SUN_YEARS, sun_known

    if args.points is not None and args.points < 1:
        raise ConfigurationError(f"--points {args.points}: at least one more point")
    files = read_files(args.files, fill_in(args))
    if args.at == "now":
        at_utc_s: float | None = SystemClock().utc_s()
    else:
        at_utc_s = parse_utc(args.at) if args.at else newest_point_utc_s(files.table)
    if at_utc_s is None:
        raise ConfigurationError(
            "the points carry no times, or none with a year to come that the Sun models cover "
            f"({SUN_YEARS}); give --at, the instant to plan from"
            if files.table.accepted()
            else "no points to plan from; take at least one"
        )
    if not sun_known(np.array([at_utc_s]), year_ahead=True).all():
        raise ConfigurationError(
            f"--at {args.at}: a plan looks a year ahead, and the Sun models hold from {SUN_YEARS}; "
            "give an instant within these years"
        )
    judged = analyse_files(
        files,
        **judging(args, files),
        at_utc_s=at_utc_s,
        until_utc_s=next_time(args.until, at_utc_s, "--until") if args.until else None,
        points_left=args.points,
        struck=[_interval(text, at_utc_s) for text in args.strike],
    )
    judgement = judged.of_the_controller()
    planned = judgement.plan
    assert planned is not None  # an instant to plan from was given
    room = max((stop.points for stop in planned.stops), default=0)
    if args.points is not None and room < args.points and not planned.done:
        say(f"warning: --points {args.points}: the day has room for {counted(room, 'point')}")
    if args.json:
        from solarcal.station.documents import plan_document

        print_json(plan_document(args.files, judgement))
        return 0
    from solarcal.report.judgement import plan_blocks

    warn(judged.warnings)
    print(text_of(*plan_blocks(judgement)))
    return 0


def next_time(text: str, after_utc_s: float, option: str) -> float:
    """The first instant after another at which the clock shows HH:MM UTC."""
    found = _CLOCK.fullmatch(text)
    if found is None:
        raise ConfigurationError(f"{option} {text}: give a time of day as HH:MM, UTC")
    of_day_s = 3600.0 * int(found[1]) + 60.0 * int(found[2])
    return after_utc_s + ((of_day_s - after_utc_s) % SECONDS_PER_DAY or SECONDS_PER_DAY)


def _interval(text: str, at_utc_s: float) -> tuple[float, float]:
    """An interval of the day that is running or comes next."""
    begin, _, end = text.partition("-")
    if not (_CLOCK.fullmatch(begin) and _CLOCK.fullmatch(end)):
        raise ConfigurationError(f"--strike {text}: give two times of day as HH:MM-HH:MM, UTC")
    end_utc_s = next_time(end, at_utc_s, "--strike")
    begin_utc_s = next_time(begin, end_utc_s - SECONDS_PER_DAY, "--strike")
    return begin_utc_s, end_utc_s


def add_report_arguments(parser: argparse.ArgumentParser) -> None:
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


def run_report(args: argparse.Namespace) -> int:
    from solarcal.report.certificate import issue

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
    warn(judged.warnings)
    state = "signed off" if after.signed_off else "not signed off"
    lines = [*(f"wrote {path}" for path in issued.paths), f"{state}: {after.reason}"]
    print("\n".join(map(one_line, lines)))
    return 0
