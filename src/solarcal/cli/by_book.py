"""``solarcal calibrate --driver typed --input FILE``: by hand, from a field book."""

import argparse
from typing import TYPE_CHECKING, Any

from solarcal.cli.fit import rule_changes
from solarcal.cli.output import print_json, say
from solarcal.cli.unit_options import asked_driver, book_lines, journal_creator, named_profile
from solarcal.config import file_stem
from solarcal.errors import ConfigurationError
from solarcal.profiles import Profile

if TYPE_CHECKING:
    from solarcal.station.typed.field_book_calibration import HandCalibration


def run_book(args: argparse.Namespace) -> int:
    """Do what the book says; print the session and what to key in."""
    from solarcal.model.methods import DEFAULT_METHOD
    from solarcal.report.session_report import record_line
    from solarcal.station.typed.field_book_calibration import calibrate_by_book

    if args.scenario or args.port:
        raise ConfigurationError("--input is for a unit without a line; leave --port, --scenario")
    if args.force is not None:
        raise ConfigurationError("--force: give the reason on the book's own upload line")
    if any(rule_changes(args).values()):
        raise ConfigurationError(
            "--tolerance, --done-probability and --unmodelled: with --input they are the profile's"
        )
    profile = named_profile(args) or Profile()
    asked_driver(args, profile)
    name = profile.mount.unit_name if profile.mount is not None else ""
    calibration = calibrate_by_book(
        *book_lines(args.input),
        profile,
        journal_creator(args.output, file_stem(name or "by-hand")),
        method=args.method or DEFAULT_METHOD,
        tell=lambda record: say(record_line(record)),
    )
    if args.json:
        print_json(hand_document(calibration))
    else:
        from solarcal.report.session_report import hand_calibration_text

        print(hand_calibration_text(calibration))
    return 0 if calibration.completed else 1


def hand_document(calibration: "HandCalibration") -> dict[str, Any]:
    """The fit document where there is a fit, the session, and what to key in."""
    from solarcal.station.analysing import analyse_session
    from solarcal.station.documents import fit_document

    session = calibration.session
    judgement = analyse_session(session, calibration.method)
    fitted: dict[str, Any] = {}
    if judgement is not None:
        fitted = fit_document(
            [calibration.path],
            session.table,
            judgement.solution,
            judgement,
        )
    return {
        **fitted,
        "session": str(calibration.path),
        "completed": calibration.completed,
        "key_in": dict(calibration.key_in),
        "truth": None,
    }
