"""Coefficients into a unit: ``solarcal upload``, read back; ``solarcal rollback``, out again.

``solarcal track``: follow the Sun with a rotator, coefficients applied.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from solarcal.cli.calibrate import add_emulator_arguments, tracker_for
from solarcal.cli.fit import add_method_option
from solarcal.cli.plan import next_time
from solarcal.cli.process import add_json_option, interrupts_obeyed, print_json, say
from solarcal.cli.unit_options import (
    PORT_HELP,
    add_driver_options,
    add_force_option,
    add_unit_options,
    asked_tracker,
    forced_reason,
    port,
    port_words,
    refuse_options,
)
from solarcal.config import sessions_dir
from solarcal.decimals import number_option
from solarcal.errors import ConfigurationError, ProcedureRefused, one_line
from solarcal.report.blocks import text_of

if TYPE_CHECKING:
    from solarcal.timescale import Clock
    from solarcal.unit.tracker import Tracker


def add_upload_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="session file (.jsonl); several of one unit are fitted together, and the upload is "
        "recorded in the newest",
    )
    add_unit_options(parser)
    add_method_option(parser)
    add_force_option(parser)
    add_json_option(parser)


def run_upload(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.station.analysing import analyse_files, read_files
    from solarcal.station.clocks import clock_beside
    from solarcal.station.procedure import Station
    from solarcal.station.uploading import (
        losses_recorded,
        newest_session,
        offer_upload,
        refuse_doubtful,
    )

    args.exit_code = 1
    force = forced_reason(args)
    for path in args.files:
        demand_session(path)
    several, newest = len(args.files) > 1, newest_session(args.files)
    with Journal.resume(newest) as journal:
        judged = analyse_files(read_files(args.files, {}), method=args.method)
        for sentence in judged.warnings if several else ():
            say(sentence)
        analysis = judged.of_the_controller()
        # Before the line is opened: what does not fit needs no unit to be refused.
        refuse_doubtful(offer_upload(analysis, journal.header.unit), force)
        with asked_tracker(args, journal.header) as tracker:
            station = Station(tracker, clock_beside(tracker.emulation))
            station.connect()
            station.resume_session(journal)
            stored = tracker.stored()
            offer = offer_upload(
                analysis, journal.header.unit, (stored.coefficients, stored.offsets)
            )
            forced = refuse_doubtful(offer, force)
            with losses_recorded(station):
                if several:
                    names = ", ".join(path.name for path in args.files)
                    station.note(f"uploaded next: the fit of {names} together")
                record = station.upload(offer.rounded, method=judged.solution.method, forced=forced)
    args.exit_code = 0 if record.verified else 1
    if args.json:
        from solarcal.station.documents import offer_document, upload_document

        print_json(
            {
                **upload_document(newest, journal.header.unit, record),
                **offer_document(offer),
                "files": [path.name for path in args.files],
            }
        )
    else:
        from solarcal.report.judgement import rounding_blocks, verdict_blocks
        from solarcal.report.tables import upload_table

        print(f"Unit {journal.header.unit.model} {journal.header.unit.serial}{port_words(args)}\n")
        print(text_of(*verdict_blocks(offer.judgement.verdict)), end="\n\n")
        print(text_of(*rounding_blocks(offer)), end="\n\n")
        print(text_of(*upload_table(record)))
        print(
            f"\nRecorded in {one_line(str(newest))} as {record.seq}; `solarcal rollback` "
            "restores the previous ones."
        )
    return int(args.exit_code)


def demand_session(path: Path) -> None:
    """An upload belongs to a session: only there can it be recorded."""
    if path.suffix.lower() != ".jsonl":
        raise ConfigurationError(
            f"{path}: uploads are recorded in the session file they come from; name a .jsonl"
        )


def add_rollback_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="session file with the upload; default: the newest one in the sessions folder",
    )
    add_unit_options(parser)
    add_json_option(parser)


def run_rollback(args: argparse.Namespace) -> int:
    from solarcal.session.journal import Journal
    from solarcal.session.view import read_session, view_session
    from solarcal.station.clocks import clock_beside
    from solarcal.station.procedure import Station
    from solarcal.station.state import newest_upload
    from solarcal.station.uploading import find_upload, losses_recorded

    args.exit_code = 1
    header = None
    if args.file is not None:
        demand_session(args.file)
        header = read_session(args.file).header
    with asked_tracker(args, header) as tracker:
        station = Station(tracker, clock_beside(tracker.emulation))
        identity = station.connect()
        path = args.file
        if path is None:
            path, unreadable = find_upload(sessions_dir(), identity)
            for sentence in unreadable:
                say(f"passed over: {sentence}")
        with Journal.resume(path) as journal:
            uploads = view_session(journal.header, tuple(journal.records)).uploads
            replaced = newest_upload(uploads)
            if replaced is None:
                raise ProcedureRefused(f"there is no upload in {path} to roll back")
            station.resume_session(journal)
            last = uploads[-1]
            if tracker.stored().coefficients != last.new_coefficients:
                say(
                    f"the unit holds other coefficients than record {last.seq} of {path} wrote; "
                    "they are in the record of this rollback"
                )
            with losses_recorded(station):
                record = station.rollback()
            header = journal.header
    args.exit_code = 0 if record.verified else 1
    if args.json:
        from solarcal.station.documents import upload_document

        print_json({**upload_document(path, header.unit, record), "restores": replaced.seq})
    else:
        from solarcal.report.tables import upload_table

        print(f"Unit {header.unit.model} {header.unit.serial}{port_words(args)}\n")
        print(text_of(*upload_table(record)))
        print(f"\nRecorded in {one_line(str(path))} as {record.seq}.")
    return int(args.exit_code)


def add_track_arguments(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--port", type=port, metavar="URL", help=f"{PORT_HELP} (default: the profile's)"
    )
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated rotator, in process")
    add_driver_options(parser)
    add_emulator_arguments(parser)
    parser.add_argument(
        "--coefficients", type=Path, metavar="FILE",
        help="output of `solarcal fit --json`, or a session file, for this run; default: the last "
        "uploaded ones",
    )  # fmt: skip
    add_method_option(parser)
    parser.add_argument("--until", metavar="HH:MM", help="UTC; default: sunset")
    parser.add_argument(
        "--every",
        type=number_option(1.0, 3600.0),
        default=10.0,
        metavar="S",
        help="seconds between printed lines (default 10)",
    )
    parser.add_argument("--json", action="store_true", help="a summary on stdout at the end")


def run_track(args: argparse.Namespace) -> int:
    """Track until the end, then stop the rotator."""
    from solarcal.station.clocks import clock_beside

    if args.scenario and not args.driver:
        args.driver = "rotctld"
    if not any((args.scenario, args.port, args.driver, args.profile, args.site)):
        raise ConfigurationError("which rotator? give --port and --site, or --site alone")
    if not args.scenario:
        refuse_options(args, ["--noise-deg"], "an emulated tracker, not a unit")
    with tracker_for(args) as (tracker, _, _):
        identity = tracker.open()
        clock = clock_beside(tracker.emulation)
        document = _tracked(args, tracker, f"{identity.model} {identity.serial}", clock)
    if args.json:
        print_json(document)
    return 0


def _tracked(
    args: argparse.Namespace, tracker: "Tracker", unit: str, clock: "Clock"
) -> dict[str, Any]:
    from solarcal.mount.formula import Coefficients, Offsets
    from solarcal.station.software_controller.rotator_tracker import RotatorTracker
    from solarcal.station.sun_tracking import SunTracking, TrackingRun, read_coefficients

    if not isinstance(tracker, RotatorTracker):
        raise ConfigurationError(
            f"{unit} has its own tracking: put it into mode TRACK with `solarcal run`, and load "
            "coefficients with `solarcal upload`; this command is for --driver rotctld"
        )
    source = ""
    if args.coefficients is not None:
        found = read_coefficients(args.coefficients, args.method)
        if found.geometry != tracker.site().geometry:
            raise ConfigurationError(
                f"{args.coefficients} is of a {found.geometry} mount, this is "
                f"{tracker.site().geometry}: its coefficients do not apply here"
            )
        tracker.use_for_now(found.coefficients)
        source = found.source
    coefficients, offsets = tracker.in_force()
    uploaded = coefficients != Coefficients()
    source = source or ("what was uploaded last" if uploaded else "nothing is uploaded: all zero")
    now_s = clock.utc_s()
    until_s = next_time(args.until, now_s, "--until") if args.until else None
    say(f"{unit}: tracking with P1..P6 {_numbers(coefficients.as_tuple())} ({source})")
    if offsets != Offsets():
        say(f"and with the reference offsets O {offsets.O1:+z.4f} {offsets.O2:+z.4f} deg")
    run = TrackingRun(unit, coefficients, source, now_s, offsets)
    summary = SunTracking(tracker, clock, run, say)
    done = summary.until(until_s, args.every).document()
    interrupts_obeyed()
    looks, worst = done["looks"], done["off_max_deg"]
    far = "" if worst is None else f", at most {worst:.3f} deg from their targets"
    say(f"stopped ({done['ended_by']}) after {looks} looks{far}")
    return done


def _numbers(values: tuple[float, ...]) -> str:
    return (
        " ".join(f"{value:+z.4f}" for value in values[:4])
        + " "
        + " ".join(f"{value:+z.6f}" for value in values[4:])
    )
