"""``solarcal run``, and ``solarcal`` alone: the workstation."""

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from solarcal.cli.fit import add_last_option, last_coefficients
from solarcal.cli.process import end_with_terminal, leave_by_signals
from solarcal.cli.unit_options import PORT_HELP, add_driver_options, port
from solarcal.config import Choice, load_keymap, load_settings
from solarcal.errors import ConfigurationError
from solarcal.profiles import load_profile, load_site_file
from solarcal.unit.drivers import demand_driver

if TYPE_CHECKING:
    from solarcal.profiles import Profile


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command; without one the start screen asks."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--port", type=port, metavar="URL", help=PORT_HELP)
    where.add_argument("--scenario", metavar="NAME|FILE", help="an emulated tracker")
    where.add_argument(
        "--continue", dest="session", type=Path, metavar="FILE",
        help="continue a session, on its own line",
    )  # fmt: skip
    where.add_argument(
        "--offline", action="store_true",
        help="open no unit and no emulator: replay, recompute, reports and calculators only",
    )  # fmt: skip
    add_driver_options(parser)
    add_last_option(parser)
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="the session file to write"
    )


def run(args: argparse.Namespace) -> int:
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
    if args.port or (args.driver and not args.scenario and not args.session):
        choice = Choice(
            port=args.port or profile.port,
            driver=driver,
            baudrate=args.baudrate or profile.baudrate,
            offers_unfinished=True,
            last_coefficients=last,
        )
    elif args.scenario:
        choice = Choice(scenario=args.scenario, last_coefficients=last)
    elif args.session:
        choice = _continued(args.session)
    return run_workstation(
        choice, profile=profile, output=args.output, trace=args.trace, offline=args.offline
    )


def _continued(path: Path) -> "Choice":
    from solarcal.station.saved_sessions import continuing, look_into

    saved = look_into(path)
    if saved.damage:
        raise ConfigurationError(saved.damage)
    choice = continuing(saved, load_settings().lines.get(path.name))
    if choice is None:
        raise ConfigurationError(
            f"it is not known on which line {path} was taken; start solarcal and choose it there"
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
