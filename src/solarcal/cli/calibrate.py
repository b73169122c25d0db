"""``solarcal calibrate``: the manual procedure by the automatic technician, or by a field book."""

import argparse
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import msgspec

from solarcal.cli.fit import (
    add_last_option,
    add_method_option,
    add_rule_options,
    last_coefficients,
    rule_changes,
)
from solarcal.cli.process import add_json_option, print_json, say
from solarcal.cli.unit_options import (
    PORT_HELP,
    add_driver_options,
    add_force_option,
    add_output_option,
    asked_driver,
    asked_tracker,
    asks_for_unit,
    book_lines,
    forced_reason,
    journal_creator,
    named_profile,
    port,
    refuse_options,
)
from solarcal.config import file_stem
from solarcal.decimals import number_option, whole_option
from solarcal.errors import ConfigurationError
from solarcal.profiles import Profile
from solarcal.unit.drivers import DEFAULT_DRIVER

if TYPE_CHECKING:
    from solarcal.station.headless import Calibration
    from solarcal.station.typed.field_book_calibration import HandCalibration
    from solarcal.unit.tracker import Tracker

DEFAULT_SCENARIO = "tijeras-azel"
MOST_POINTS = 500
FOR_EMULATED = ("--set", "--start", "--seed")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        help=f"an emulated tracker, in process (default, without --port: {DEFAULT_SCENARIO})",
    )
    where.add_argument("--port", type=port, metavar="URL", help=PORT_HELP)
    add_driver_options(parser)
    add_emulator_arguments(parser)
    add_schedule_arguments(parser)
    add_output_option(parser)
    parser.add_argument(
        "--resume", type=Path, metavar="FILE",
        help="continue an interrupted session on its own unit",
    )  # fmt: skip
    add_json_option(parser)


def add_emulator_arguments(parser: argparse.ArgumentParser) -> None:
    """Options that shape an emulated tracker; the same for every command that makes one."""
    emulator = parser.add_argument_group("emulator")
    add_set_option(emulator, "truth.lean_deg=0.1")
    emulator.add_argument(
        "--start",
        metavar="ISO",
        help="first instant, or a date: that morning there; default: the scenario's",
    )
    add_seed_option(emulator)
    emulator.add_argument(
        "--noise-deg",
        type=number_option(),
        metavar="X",
        help="noise of the eye, one sigma per axis on the sky",
    )


class Options(Protocol):
    """A parser or a group of its options."""

    def add_argument(self, *flags: str, **how: Any) -> argparse.Action: ...


def add_set_option(options: Options, example: str) -> None:
    options.add_argument(
        "--set",
        dest="settings",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help=f"change a key of the scenario, e.g. {example} (repeatable)",
    )


def add_seed_option(options: Options) -> None:
    options.add_argument(
        "--seed",
        type=whole_option(0, 2**63 - 1),
        help="seed of all random numbers (default 0)",
    )


def add_schedule_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--points", type=whole_option(), default=None, help="data points to take (default 12)"
    )
    parser.add_argument(
        "--every",
        type=number_option(5.0, 600.0),
        metavar="MINUTES",
        help="minutes between points; default: spread over the day",
    )
    add_method_option(parser)
    add_last_option(parser)
    add_rule_options(parser)
    add_force_option(parser)


def scenario_settings(args: argparse.Namespace) -> tuple[str, ...]:
    """The keys of the scenario that are changed; ``--start`` is one of them."""
    start = [f"start={args.start}"] if args.start else []
    return (*args.settings, *start)


def run_calibration(
    args: argparse.Namespace,
    tracker: "Tracker",
    name: str,
    noise_deg: float | None,
    profile: Profile | None = None,
) -> "Calibration":
    """The calibration itself; its steps are reported on stderr."""
    from solarcal.model.methods import DEFAULT_METHOD
    from solarcal.station.headless import calibrate
    from solarcal.station.technician import Schedule

    # Until it is completed.
    args.exit_code = 1
    points = 12 if args.points is None else args.points
    if points < 3:
        raise ConfigurationError(f"--points {points}: a fit needs at least three points")
    if points > MOST_POINTS:
        raise ConfigurationError(
            f"--points {points}: more than {MOST_POINTS} are not one calibration"
        )
    return calibrate(
        tracker,
        journal_creator(args.output, name),
        Schedule(points=points, every_min=args.every),
        profile=_as_asked(profile or Profile(), args),
        method=args.method or DEFAULT_METHOD,
        eye_sigma_deg=0.02 if noise_deg is None else noise_deg,
        force=forced_reason(args),
        say=say,
        resume=getattr(args, "resume", None),
    )


def _as_asked(profile: Profile, args: argparse.Namespace) -> Profile:
    """The profile with what the options say instead."""
    changes: dict[str, Any] = {**rule_changes(args), "last_coefficients": last_coefficients(args)}
    changes["unmodelled"] = {**profile.unmodelled, **changes["unmodelled"]}
    given = {name: value for name, value in changes.items() if value is not None}
    return msgspec.structs.replace(profile, **given)


@contextmanager
def tracker_for(args: argparse.Namespace) -> "Iterator[tuple[Tracker, str, float | None]]":
    """The unit asked for, its name for files, and the eye noise if we made it ourselves.

    Raises
    ------
    ConfigurationError
        An option that the unit meant has no use for.
    """
    if asks_for_unit(args):
        refuse_options(args, FOR_EMULATED, "an emulated tracker, not a unit")
        with asked_tracker(args) as tracker:
            yield tracker, "unit", args.noise_deg
    else:
        instead = "leave --scenario away" if args.scenario else "give --port"
        refuse_options(args, ["--input"], "a unit without a line: leave --scenario away")
        flags = ["--trace", "--baudrate", "--profile", "--site"]
        refuse_options(args, flags, f"a unit on a line: {instead}")
        with emulated_tracker(args) as made:
            yield made


@contextmanager
def emulated_tracker(args: argparse.Namespace) -> "Iterator[tuple[Tracker, str, float | None]]":
    """An emulated unit in this process, its name for files, and its eye noise."""
    from solarcal.emulated_units import emulated_unit

    emulated = emulated_unit(
        args.scenario or DEFAULT_SCENARIO,
        args.driver or DEFAULT_DRIVER,
        settings=scenario_settings(args),
        seed=args.seed or 0,
        speed=getattr(args, "speed", None) or 0.0,
        noise_deg=args.noise_deg,
    )
    with closing(emulated.tracker) as tracker:
        yield tracker, file_stem(args.scenario or DEFAULT_SCENARIO), emulated.noise_deg


def calibration_document(calibration: "Calibration") -> dict[str, Any]:
    """The fit document, plus where the session is and, from an emulator, its truth."""
    from solarcal.station.analysing import analyse_session
    from solarcal.station.documents import fit_document

    session = calibration.session
    solution = calibration.solution
    analysis = analyse_session(session, solution.method)
    return {
        **fit_document([calibration.path], session.table, solution, analysis),
        "session": str(calibration.path),
        "completed": calibration.completed,
        "refused": calibration.refused or None,
        "truth": calibration.truth_document(),
    }


def _start_where_it_broke_off(args: argparse.Namespace) -> None:
    """An emulated unit of another process died with it: one of the same truth takes over then.

    Refuses what would write the file anew, or go on with it by another rule than its own.
    """
    from solarcal.session.view import read_session
    from solarcal.station.saved_sessions import emulated_again

    if args.output:
        raise ConfigurationError("--resume FILE goes on in that file; leave -o away")
    if any(rule_changes(args).values()):
        raise ConfigurationError(
            "--tolerance, --done-probability and --unmodelled: a continued session has its own"
        )
    if args.last_coefficients is not None:
        raise ConfigurationError("--last-coefficients: a continued session has its own")
    session = read_session(args.resume)
    if not asks_for_unit(args):
        args.settings = [*args.settings, *emulated_again(session)]


def run(args: argparse.Namespace) -> int:
    if args.resume:
        _start_where_it_broke_off(args)
    if args.input:
        return run_book(args)
    with tracker_for(args) as (tracker, name, noise_deg):
        profile = named_profile(args)
        return print_calibration(args, run_calibration(args, tracker, name, noise_deg, profile))


def print_calibration(args: argparse.Namespace, calibration: "Calibration") -> int:
    """The document or the tables; the exit code."""
    args.exit_code = 0 if calibration.completed else 1
    if args.json:
        print_json(calibration_document(calibration))
    else:
        from solarcal.report.session_report import calibration_text

        print(calibration_text(calibration))
    return int(args.exit_code)


def run_book(args: argparse.Namespace) -> int:
    """Do what the book says; print the session and what to key in."""
    args.exit_code = 1
    from solarcal.model.methods import DEFAULT_METHOD
    from solarcal.report.session_report import record_line
    from solarcal.station.typed.field_book_calibration import calibrate_by_book

    if args.scenario or args.port:
        raise ConfigurationError("--input is for a unit without a line; leave --port, --scenario")
    refuse_options(args, [*FOR_EMULATED, "--noise-deg"], "an emulated tracker")
    refuse_options(args, ["--trace", "--baudrate"], "a unit on a line")
    refuse_options(args, ["--points", "--every"], "a unit on a line; the book has its points")
    if args.force is not None:
        raise ConfigurationError("--force: give the reason on the book's own upload line")
    if any(rule_changes(args).values()):
        raise ConfigurationError(
            "--tolerance, --done-probability and --unmodelled: with --input they are the profile's"
        )
    profile = _as_asked(named_profile(args) or Profile(), args)
    asked_driver(args, profile)
    name = profile.mount.unit_name if profile.mount is not None else ""
    calibration = calibrate_by_book(
        *book_lines(args.input),
        profile,
        journal_creator(args.output, file_stem(name or "by-hand")),
        method=args.method or DEFAULT_METHOD,
        tell=lambda record: say(record_line(record)),
    )
    args.exit_code = 0 if calibration.completed else 1
    if args.json:
        print_json(hand_document(calibration))
    else:
        from solarcal.report.session_report import hand_calibration_text

        print(hand_calibration_text(calibration))
    return int(args.exit_code)


def hand_document(calibration: "HandCalibration") -> dict[str, Any]:
    """The fit document where there is a fit, the session, and what to key in."""
    from solarcal.station.analysing import analyse_session
    from solarcal.station.documents import fit_document

    session = calibration.session
    analysis = analyse_session(session, calibration.method)
    fitted: dict[str, Any] = {}
    if analysis is not None:
        fitted = fit_document([calibration.path], session.table, analysis.solution, analysis)
    return {
        **fitted,
        "session": str(calibration.path),
        "completed": calibration.completed,
        "key_in": dict(calibration.key_in),
        "truth": None,
    }
