"""``solarcal forecast``: how wrong the tracker will be over the year."""

import argparse
import shutil
import sys

from solarcal.cli.fit import add_judging_arguments, fill_in, judging
from solarcal.cli.output import print_json, say
from solarcal.report.blocks import text_of


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_judging_arguments(parser)


def run(args: argparse.Namespace) -> int:
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

    for warning in judged.warnings:
        say(f"warning: {warning}")
    width, height = shutil.get_terminal_size((80, 24))
    drawn = forecast_map(
        judgement.forecast,
        max(40, min(width, 120)),
        max(16, min(height - 2, 40)),
        sys.stdout.isatty(),
        tolerance_deg=judged.tolerance_deg,
    )
    parts = (
        f"Expected error on the sky over the year, deg ({judged.solution.n_points} points, "
        f"{judged.solution.method})",
        text_of(forecast_facts(judgement.forecast, judged.tolerance_deg)),
        drawn,
        text_of(*verdict_blocks(judgement.verdict)),
    )
    print("\n\n".join(parts))
    return 0
