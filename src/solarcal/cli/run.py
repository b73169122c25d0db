"""The workstation: ``solarcal run`` and ``solarcal`` alone, ``demo`` on the built-in emulator, to
see how it is done, and ``replay``, a saved session as it happened.
"""

import argparse
import os
import sys
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from solarcal.cli.calibrate import (
    DEFAULT_SCENARIO,
    add_emulator_arguments,
    add_schedule_arguments,
    emulated_tracker,
    print_calibration,
    run_calibration,
    scenario_settings,
)
from solarcal.cli.fit import add_last_option, last_coefficients
from solarcal.cli.process import (
    add_json_option,
    end_with_terminal,
    leave_by_signals,
    print_json,
    say,
)
from solarcal.cli.unit_options import (
    PORT_HELP,
    add_driver_options,
    add_output_option,
    port,
    refuse_options,
)
from solarcal.config import Choice, file_stem, load_keymap, load_settings
from solarcal.decimals import speed_option
from solarcal.errors import ConfigurationError, FitError
from solarcal.profiles import load_profile, load_site_file
from solarcal.timescale import SystemClock
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS, ON_A_LINE, demand_driver, has_line

if TYPE_CHECKING:
    from solarcal.profiles import Profile
    from solarcal.station.saved_sessions import Replay


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command; without one the start screen asks."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--port", type=port, metavar="URL", help=PORT_HELP)
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated tracker")
    where.add_argument(
        "--offline", action="store_true",
        help="open no unit and no emulator: replay, recompute, reports and calculators only",
    )  # fmt: skip
    parser.add_argument(
        "--continue", dest="session", type=Path, metavar="FILE",
        help="continue a session, on its own line or on that of --port",
    )  # fmt: skip
    add_driver_options(parser)
    add_last_option(parser)
    add_output_option(parser)


def run(args: argparse.Namespace) -> int:
    _refuse_what_is_passed_over(args)
    demand_terminal()
    # A new profile's name is allowed here: the form fills it.
    profile = (
        load_site_file(Path(args.site))
        if args.site
        else load_profile(args.profile or load_settings().profile)
    )
    last = last_coefficients(args)
    if last is not None:
        if args.session:
            raise ConfigurationError("--last-coefficients: a session goes on by its own")
        profile = msgspec.structs.replace(profile, last_coefficients=last)
    driver = args.driver or profile.driver
    demand_driver(driver)
    choice: Choice | None = None
    on_line = Choice(
        port=args.port or profile.port,
        driver=driver,
        baudrate=args.baudrate or profile.baudrate,
    )
    if args.session:
        choice = _continued(args.session, profile, on_line if args.port else None)
    elif args.port or (args.driver and not args.scenario):
        choice = msgspec.structs.replace(on_line, offers_unfinished=True, last_coefficients=last)
    elif args.scenario:
        choice = Choice(
            scenario=args.scenario, driver=args.driver or DEFAULT_DRIVER, last_coefficients=last
        )
    return run_workstation(
        choice, profile=profile, output=args.output, trace=args.trace, offline=args.offline
    )


def _refuse_what_is_passed_over(args: argparse.Namespace) -> None:
    refuse_options(args, ["--input"], "calibrate, upload and rollback; here a form asks")
    if args.session:
        if args.scenario or args.offline:
            other = "--scenario" if args.scenario else "--offline"
            raise ConfigurationError(
                f"{other} and --continue do not go together: a session goes on with its own unit"
            )
        refuse_options(args, ["--output"], "a new session; this one has its own")
        if not args.port:
            flags = ["--driver", "--baudrate"]
            refuse_options(args, flags, "a new session, or for --port; this one has its own")
    elif args.scenario:
        refuse_options(args, ["--baudrate"], "a unit on a line: give --port")
        driver = demand_driver(args.driver or DEFAULT_DRIVER)
        if not driver.has_line:
            raise ConfigurationError(f"there is no emulated unit for driver {args.driver}")
        if driver.rotator is not None:
            where = "a unit on a line: give --port, of solarcal emulate for an emulated rotator"
            refuse_options(args, ["--trace"], where)
    elif args.offline:
        flags = ["--driver", "--baudrate", "--trace", "--output"]
        refuse_options(args, flags, "a unit; --offline opens none")


def _continued(path: Path, profile: "Profile", on_line: "Choice | None") -> "Choice":
    from solarcal.station.saved_sessions import continuing, look_into

    saved = look_into(path)
    if saved.damage:
        raise ConfigurationError(saved.damage)
    if saved.finished:
        raise ConfigurationError(f"{path} is finished; begin a new session")
    choice = continuing(saved, on_line or load_settings().line_of(path))
    if choice is None:
        raise ConfigurationError(
            f"it is not known on which line {path} was taken; say --port: "
            f"solarcal run --continue {path} --port URL"
        )
    if not has_line(choice.driver) and profile.site is None:
        raise ConfigurationError(
            f"driver {choice.driver} needs the site and the mount, as this session was begun: "
            f"solarcal run --continue {path} --site FILE"
        )
    return choice


def has_terminal() -> bool:
    """Whether there is a screen to draw on and a keyboard to read, or a browser for both."""
    if in_browser():
        return True
    return sys.stdin.isatty() and sys.stdout.isatty()


def in_browser() -> bool:
    """Whether this process draws a page of ``solarcal serve``, which sets Textual's driver."""
    return "web_driver" in os.environ.get("TEXTUAL_DRIVER", "")


def demand_terminal() -> None:
    """Refuse in one line where there is no terminal; Textual itself would not fail."""
    if not has_terminal():
        raise ConfigurationError(
            "the workstation needs a terminal; without one use solarcal demo --headless, "
            "solarcal calibrate or solarcal replay --headless"
        )


def run_workstation(
    start: "Choice | None",
    *,
    profile: "Profile | None" = None,
    output: Path | None = None,
    trace: str | None = None,
    offline: bool = False,
) -> int:
    """The Textual program, until it is left; its exit code."""
    from solarcal.tui.app import SolarcalApp
    from solarcal.tui.keys import checked_keymap

    settings = load_settings()
    app = SolarcalApp(
        settings=settings,
        profile=profile or load_profile(settings.profile),
        keymap=checked_keymap(load_keymap()),
        start=start,
        output=output,
        trace=trace,
        remember=True,
        offline=offline,
    )
    leave_by_signals(lambda code: app.call_from_thread(app.exit, return_code=code))
    if not in_browser():
        end_with_terminal(sys.stdin.fileno())
    try:
        result = app.run()
    finally:
        app.release()
    return app.return_code or 0 if result is None else result


def add_demo_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scenario", metavar="NAME|FILE", default=DEFAULT_SCENARIO)
    parser.add_argument(
        "--driver", choices=ON_A_LINE,
        default=DEFAULT_DRIVER,
        help="emulate a controller, or a rotator that does not compute the Sun",
    )  # fmt: skip
    add_emulator_arguments(parser)
    parser.add_argument(
        "--speed",
        type=speed_option(stopped=0.0),
        metavar="N",
        help="virtual seconds per real second; default: 1 on the screen (+ and - change it), as "
        "fast as possible without a screen",
    )
    add_schedule_arguments(parser)
    add_output_option(parser)
    parser.add_argument("--headless", action="store_true", help="no screen, even in a terminal")
    add_json_option(parser)


def run_demo(args: argparse.Namespace) -> int:
    """In a terminal the workstation, for a newcomer to calibrate; else a whole day headless."""
    if has_terminal() and not (args.headless or args.json):
        flags = ["--points", "--every", "--method", "--tolerance", "--done-probability"]
        flags += ["--unmodelled", "--force"]
        refuse_options(args, flags, "a demonstration without a screen: give --headless")
        return run_workstation(
            Choice(
                scenario=args.scenario,
                driver=args.driver,
                settings=scenario_settings(args),
                seed=args.seed or 0,
                noise_deg=args.noise_deg,
                speed=args.speed,
                last_coefficients=last_coefficients(args),
            ),
            output=args.output,
        )
    return demo_headless(args)


def demo_headless(args: argparse.Namespace) -> int:
    """A full day's calibration over a real pseudo-terminal, with tables and plot."""
    from solarcal.cli.emulate import emulator_of
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import serve_here
    from solarcal.station.connect import open_tracker

    if DRIVERS[args.driver].rotator is not None:
        # An emulated rotator is spoken to within this process.
        with emulated_tracker(args) as (tracker, name, noise_deg):
            say(f"emulated rotator in the world of '{args.scenario}'; a day passes in seconds")
            return print_calibration(args, run_calibration(args, tracker, name, noise_deg))
    emulator = emulator_of(args, load_scenario(args.scenario, scenario_settings(args)))
    with serve_here(emulator) as url:
        kind = "TCP" if url.startswith("socket://") else "a serial line"
        say(f"emulated tracker '{args.scenario}' on {kind}; a day passes in seconds")
        with closing(open_tracker(url)) as tracker:
            name = file_stem(args.scenario)
            calibration = run_calibration(args, tracker, name, emulator.noise_deg)
    return print_calibration(args, calibration)


def add_replay_arguments(parser: argparse.ArgumentParser) -> None:
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


def run_replay(args: argparse.Namespace) -> int:
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
        solution, table = judgement.solution, session.table
        print_json(fit_document([args.file], table, solution, judgement, warnings=replay.warnings))
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
