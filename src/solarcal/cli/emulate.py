"""``solarcal emulate``: the emulator as a separate process, on a pseudo-terminal or on TCP.

The first line on stdout says where to connect to; then it serves until it is interrupted (Ctrl-C)
or terminated, and removes the link it made.
"""

import argparse
import sys

HELP = "the emulator as a separate process"

LOOK_S = 0.2
"""How often the waiting thread looks whether it shall end."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    from solarcal.cli.calibrate import add_emulator_arguments

    line = parser.add_mutually_exclusive_group()
    line.add_argument(
        "--pty",
        metavar="LINK",
        help="serve on a pseudo-terminal and make LINK point to it (default: one without a link)",
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
    add_emulator_arguments(parser)
    parser.add_argument(
        "--faults",
        metavar="NAME=P,...",
        help="a bad line: how often what goes wrong, e.g. flipped=0.01,silent=0.002 "
        "(docs/emulator.md names them)",
    )
    parser.add_argument(
        "--speed",
        type=float,
        default=0.0,
        metavar="N",
        help="virtual seconds a real second, 1 for a live unit; 0 (default): time moves only when "
        "the station lets it (X ADVANCE)",
    )


def run(args: argparse.Namespace) -> int:
    """Serve until interrupted or terminated."""
    import signal
    import threading

    from solarcal.cli.calibrate import start_utc_s
    from solarcal.emulator.emulation import Emulator
    from solarcal.emulator.line_faults import FaultyLine, line_faults
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import exposure, serve_pty, serve_tcp, tcp_address
    from solarcal.errors import ConfigurationError

    address = tcp_address(args.tcp) if args.tcp else None
    faults = line_faults(args.faults) if args.faults is not None else None
    if faults is not None and faults.hung_up and address is None:
        raise ConfigurationError(
            "a pseudo-terminal cannot hang up and come back; give --tcp with hung_up"
        )
    emulator = Emulator(
        load_scenario(args.scenario, args.settings),
        start_utc_s=start_utc_s(args),
        seed=args.seed,
        noise_deg=args.noise_deg,
        speed=args.speed,
    )
    ended = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ended.set())
    line = FaultyLine(emulator, faults, seed=args.seed) if faults is not None else emulator
    if address and (warning := exposure(address[0])):
        print(f"solarcal: {warning}", file=sys.stderr)
    serving = serve_tcp(line, *address) if address else serve_pty(line, args.pty)
    with serving as port:
        print(f"connect to {port}", flush=True)
        print(f"  solarcal calibrate --port {port}", flush=True)
        # In steps: a signal that another thread took wakes this one only when it looks itself.
        while not ended.wait(LOOK_S):
            pass
    if isinstance(line, FaultyLine):
        print(f"line faults: {line.damages} in {line.frames} pieces of the stream", file=sys.stderr)
    return 0
