"""``solarcal demo``: calibrate the built-in emulator, to see how it is done."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.cli.calibrate import (
    DEFAULT_SCENARIO,
    add_emulator_arguments,
    add_schedule_arguments,
    emulated_tracker,
    print_calibration,
    run_calibration,
    start_utc_s,
)
from solarcal.cli.fit import last_coefficients
from solarcal.cli.output import add_json_option, say
from solarcal.cli.run import has_terminal, run_workstation
from solarcal.config import Choice, file_stem
from solarcal.decimals import speed_option
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS

if TYPE_CHECKING:
    pass


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--scenario", metavar="NAME|FILE", default=DEFAULT_SCENARIO)
    parser.add_argument(
        "--driver", choices=tuple(name for name, one in DRIVERS.items() if one.has_line),
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
    parser.add_argument(
        "-o", "--output", type=Path, metavar="FILE", help="the session file to write"
    )
    parser.add_argument("--headless", action="store_true", help="no screen, even in a terminal")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """In a terminal the workstation, for a newcomer to calibrate; else a whole day headless."""
    if has_terminal() and not (args.headless or args.json):
        return run_workstation(
            Choice(
                scenario=args.scenario,
                driver=args.driver,
                settings=tuple(args.settings),
                start_utc=args.start or "",
                seed=args.seed,
                noise_deg=args.noise_deg,
                speed=args.speed,
                last_coefficients=last_coefficients(args),
            ),
            output=args.output,
        )
    return run_headless(args)


def run_headless(args: argparse.Namespace) -> int:
    """A full day's calibration over a real pseudo-terminal, with tables and plot."""
    from solarcal.emulator.emulation import Emulator
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import serve_here
    from solarcal.station.connect import open_tracker

    if DRIVERS[args.driver].rotator is not None:
        # An emulated rotator is spoken to within this process.
        with emulated_tracker(args) as (tracker, name, noise_deg):
            say(f"emulated rotator in the world of '{args.scenario}'; a day passes in seconds")
            return print_calibration(args, run_calibration(args, tracker, name, noise_deg))
    scenario = load_scenario(args.scenario, args.settings)
    emulator = Emulator(
        scenario,
        start_utc_s=start_utc_s(args),
        seed=args.seed,
        noise_deg=args.noise_deg,
        speed=args.speed or 0.0,
    )
    with serve_here(emulator) as url:
        kind = "TCP" if url.startswith("socket://") else "a serial line"
        say(f"emulated tracker '{args.scenario}' on {kind}; a day passes in seconds")
        tracker = open_tracker(url)
        try:
            calibration = run_calibration(
                args, tracker, file_stem(args.scenario), emulator.noise_deg
            )
        finally:
            tracker.close()
    return print_calibration(args, calibration)
