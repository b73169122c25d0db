"""``solarcal replay``: a saved session as it happened."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.cli.output import print_json, say
from solarcal.cli.run import has_terminal, run_workstation
from solarcal.config import Choice
from solarcal.decimals import speed_option
from solarcal.errors import FitError
from solarcal.timescale import SystemClock

if TYPE_CHECKING:
    from solarcal.station.saved_sessions import Replay


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE")
    parser.add_argument(
        "--speed",
        type=speed_option(),
        metavar="N",
        help="recorded seconds per real second; default: 600 on the screen (+ and - change it), "
        "everything at once without a screen",
    )
    parser.add_argument(
        "--headless", action="store_true", help="print the events and the fit, without a screen"
    )
    parser.add_argument("--json", action="store_true", help="the final fit as one JSON document")


def run(args: argparse.Namespace) -> int:
    """In a terminal on the workstation's screen; without one printed record by record."""
    from solarcal.station.saved_sessions import Replay

    replay = Replay.open(args.file)
    if has_terminal() and not (args.headless or args.json):
        return run_workstation(Choice(replay=str(args.file), speed=args.speed))
    if args.speed is not None and not args.json:
        _tell_as_it_happened(replay, args.speed)
        return 0
    replay.jump(len(replay))
    if args.json:
        from solarcal.station.analysing import analyse_session
        from solarcal.station.documents import fit_document

        session = replay.view
        judgement = analyse_session(session)
        if judgement is None:
            raise FitError(f"{args.file}: no accepted point; a fit needs one")
        print_json(
            fit_document(
                [args.file],
                session.table,
                judgement.solution,
                judgement,
                warnings=replay.warnings,
            )
        )
        return 0
    from solarcal.report.session_report import replay_text

    print(replay_text(replay))
    return 0


def _tell_as_it_happened(replay: "Replay", speed: float) -> None:
    """Each record when its time has come, then the session as it ended."""
    from solarcal.report.session_report import record_line, session_text
    from solarcal.station.analysing import analyse_session

    for warning in replay.warnings:
        say(warning)
    clock = SystemClock()
    for record in replay.records:
        before_s = replay.utc_s
        replay.step()
        clock.wait(max(0.0, replay.utc_s - before_s) / speed)
        print(record_line(record), flush=True)
    print(f"\n{session_text(replay.view, analyse_session(replay.view))}")
