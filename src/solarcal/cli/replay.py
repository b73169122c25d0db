"""``solarcal replay``: a saved session as it happened."""

import argparse
from pathlib import Path

from solarcal.cli.output import print_json

HELP = "a saved session as it happened"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", type=Path, metavar="FILE")
    parser.add_argument(
        "--headless", action="store_true", help="print what happened and the fit, no screen"
    )
    parser.add_argument("--json", action="store_true", help="the final fit as one JSON document")


def run(args: argparse.Namespace) -> int:
    """In a terminal on the workstation's screen; without one told record by record."""
    from solarcal.cli.run import has_terminal, run_workstation
    from solarcal.station.replay import Replay

    replay = Replay.open(args.file)
    if has_terminal() and not (args.headless or args.json):
        from solarcal.config import Choice

        return run_workstation(Choice(replay=str(args.file)))
    replay.jump(len(replay))
    if args.json:
        from solarcal.errors import FitError
        from solarcal.station.diagnosing import diagnose_session
        from solarcal.station.documents import fit_document
        from solarcal.station.fitting import session_table
        from solarcal.station.judging import judge_session

        session = replay.view
        judgement = judge_session(session)
        if judgement is None:
            raise FitError(f"{args.file}: no accepted point; a fit needs one")
        print_json(
            fit_document(
                [args.file],
                session_table(session),
                judgement.solution,
                judgement,
                findings=diagnose_session(session, judgement.solution),
                warnings=replay.warnings,
            )
        )
        return 0
    from solarcal.report.session_report import replay_text

    print(replay_text(replay))
    return 0
