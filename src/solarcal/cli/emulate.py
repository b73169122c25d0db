"""``solarcal emulate``: an emulated unit as a separate process, on a pseudo-terminal or on TCP.

The first line on stdout says where to connect to; then it serves until it is interrupted (Ctrl-C)
or terminated, and removes the link it made.

``solarcal scenarios``: what the emulator can play. The JSON document: ``scenarios`` (``name``,
``summary``, ``start_utc``, ``settings``: every key of ``--set`` with its value) and ``default`` (a
name).
"""

import argparse
import signal
import threading
from typing import TYPE_CHECKING, Any

from solarcal.cli.process import add_json_option, print_json, say
from solarcal.decimals import number_option, speed_option
from solarcal.errors import ConfigurationError
from solarcal.timescale import SystemClock, format_utc
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS, ON_A_LINE

if TYPE_CHECKING:
    from solarcal.emulator.emulation import Emulator
    from solarcal.emulator.rotator import EmulatedRotator
    from solarcal.emulator.scenario import Scenario
    from solarcal.emulator.server import UnitOnALine

LOOK_S = 0.2
"""How often the waiting thread looks whether it shall end."""


def add_emulate_arguments(parser: argparse.ArgumentParser) -> None:
    from solarcal.cli.calibrate import add_emulator_arguments

    line = parser.add_mutually_exclusive_group()
    line.add_argument(
        "--pty",
        metavar="LINK",
        help="serve on a pseudo-terminal with a link LINK to it (default: without a link)",
    )
    line.add_argument(
        "--tcp", metavar="HOST:PORT", help="serve on TCP; :PORT for this machine only, port 0: any"
    )
    parser.add_argument(
        "--scenario",
        metavar="NAME|FILE",
        default="tijeras-azel",
        help="one of `solarcal scenarios`, or a TOML file (default tijeras-azel)",
    )
    parser.add_argument(
        "--driver",
        choices=ON_A_LINE,
        default=DEFAULT_DRIVER,
        help="protocol; a rotator does not compute the Sun: the client is its controller",
    )
    add_emulator_arguments(parser)
    parser.add_argument(
        "--target",
        choices=("sun", "moon"),
        help="light on the sunspot device (default: the scenario's truth.light, sun)",
    )
    parser.add_argument(
        "--watch",
        type=number_option(0.1, 3600.0),
        metavar="S",
        help="rotators: print the read-outs and the true pointing error every S seconds",
    )
    parser.add_argument(
        "--faults",
        metavar="NAME=P,...",
        help="emulate a bad line: probability of each fault, e.g. flipped=0.01,silent=0.002 "
        "(docs/emulator.md names them)",
    )
    parser.add_argument(
        "--speed",
        type=speed_option(stopped=0.0),
        metavar="N",
        help="virtual seconds per real second; 1: real time, the default for rotators; 0, the "
        "default for a controller: time moves only by X ADVANCE",
    )


def run_emulate(args: argparse.Namespace) -> int:
    """Serve until interrupted or terminated."""
    from solarcal.cli.calibrate import scenario_settings
    from solarcal.emulator.line_faults import FaultyLine, line_faults
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import exposure, serve_pty, serve_tcp, tcp_address

    address = tcp_address(args.tcp) if args.tcp else None
    faults = line_faults(args.faults) if args.faults is not None else None
    if faults is not None and faults.hung_up and address is None:
        raise ConfigurationError(
            "a pseudo-terminal cannot hang up and come back; give --tcp with hung_up"
        )
    lights = [f"truth.light={args.target}"] if args.target else []
    scenario = load_scenario(args.scenario, [*scenario_settings(args), *lights])
    rotator = None
    line: UnitOnALine
    if DRIVERS[args.driver].rotator is not None:
        if faults is not None:
            raise ConfigurationError("--faults is for the controller's protocol, not for rotators")
        line = rotator = _rotator(args, scenario)
    else:
        if args.watch is not None:
            raise ConfigurationError("--watch is for rotators; a controller is asked by X SPOT")
        emulator = emulator_of(args, scenario)
        line = FaultyLine(emulator, faults, seed=args.seed or 0) if faults is not None else emulator
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    if address and (warning := exposure(address[0])):
        say(f"solarcal: {warning}")
    serving = serve_tcp(line, *address) if address else serve_pty(line, args.pty)
    with serving as port:
        print(f"connect to {port}", flush=True)
        print(f"  {_client(args.driver, port)}", flush=True)
        # In steps: a signal that another thread took wakes this one only when it looks itself.
        left_s = 0.0
        while not ended.wait(LOOK_S):
            left_s -= LOOK_S
            if rotator is not None and args.watch is not None and left_s <= 0.0:
                left_s = args.watch
                print(_seen(rotator), flush=True)
    if isinstance(line, FaultyLine):
        say(f"line faults: {line.damages} in {line.frames} pieces of the stream")
    return 0


def emulator_of(args: argparse.Namespace, scenario: "Scenario") -> "Emulator":
    """The emulated controller that these options ask for."""
    from solarcal.emulator.emulation import Emulator

    return Emulator(
        scenario,
        seed=args.seed or 0,
        noise_deg=args.noise_deg,
        speed=args.speed or 0.0,
    )


def _rotator(args: argparse.Namespace, scenario: "Scenario") -> "EmulatedRotator":
    """It begins now: its client goes by the real clock and the real Sun."""
    from solarcal.emulator.rotator import EmulatedRotator
    from solarcal.emulator.rotator_protocols import ROTATOR_PROTOCOLS

    rotator = EmulatedRotator(
        scenario,
        start_utc_s=scenario.start_utc_s() if args.start else SystemClock().utc_s(),
        seed=args.seed or 0,
        noise_deg=args.noise_deg,
        speed=1.0 if args.speed is None else args.speed,
    )
    rotator.protocol = ROTATOR_PROTOCOLS[args.driver]()
    return rotator


def _client(driver: str, port: str) -> str:
    """What to say to reach it."""
    if driver == DEFAULT_DRIVER:
        return f"solarcal calibrate --port {port}"
    return f"solarcal run --driver {driver} --port {port} --site FILE"


def _seen(rotator: "EmulatedRotator") -> str:
    """One line of ``--watch``: where it reads, and where the light is on its sunspot device."""
    with rotator.turn:
        rotator.catch_up()
        utc_s = rotator.world.true_utc_s(rotator.now_s())
        azimuth, elevation = rotator.stands_deg()
    spot, light = rotator.spot(), rotator.scenario.truth.light.capitalize()
    # Axis 1 counts from South towards East, axis 2 from the zenith down.
    seen = (
        f"{light} at az {-spot.error1_deg:+z.3f}, el {-spot.error2_deg:+z.3f} deg from there"
        if spot.visible
        else f"no {light} on the sunspot device"
    )
    return f"{format_utc(utc_s, 0)}  reads az {azimuth:z.2f} el {elevation:z.2f} deg; {seen}"


def add_scenarios_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "scenario", nargs="?", metavar="NAME|FILE", help="show this one with all its keys"
    )
    add_json_option(parser)


def run_scenarios(args: argparse.Namespace) -> int:
    """List all, or one with its keys."""
    from solarcal.emulator.scenario import DEFAULT_SCENARIO, load_scenario, scenario_names
    from solarcal.emulator.settings import settings_of

    names = [args.scenario] if args.scenario else scenario_names()
    scenarios = [load_scenario(name) for name in names]
    if args.json:
        found: list[dict[str, Any]] = [
            {
                "name": scenario.name,
                "summary": scenario.summary,
                "start_utc": format_utc(scenario.start_utc_s(), 0),
                "settings": settings_of(scenario),
            }
            for scenario in scenarios
        ]
        print_json({"scenarios": found, "default": DEFAULT_SCENARIO})
        return 0
    if args.scenario:
        (scenario,) = scenarios
        print(f"{scenario.name}: {scenario.summary}\n")
        settings = settings_of(scenario)
        width = max(map(len, settings))
        for key, value in settings.items():
            print(f"  {key:{width}}  {value_text(value)}")
        return 0
    width = max(len(scenario.name) for scenario in scenarios)
    for scenario in scenarios:
        mark = "  (default)" if scenario.name == DEFAULT_SCENARIO else ""
        print(f"{scenario.name:{width}}  {scenario.summary}{mark}")
    return 0


def value_text(value: Any) -> str:
    """A value as it would be written after ``KEY=``."""
    if value is None:
        return "(as built)"
    if isinstance(value, dict):
        inner = ", ".join(f"{key} = {value_text(item)}" for key, item in value.items())
        return "{ " + inner + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(value_text, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else f"{value}"
