"""``solarcal emulate``: the emulator as a separate process, on a pseudo-terminal or on TCP.

The first line on stdout says where to connect to; then it serves until it is interrupted (Ctrl-C)
or terminated, and removes the link it made.
"""

import argparse

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
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import serve_pty, serve_tcp, tcp_address

    address = tcp_address(args.tcp) if args.tcp else None
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
    serving = serve_tcp(emulator, *address) if address else serve_pty(emulator, args.pty)
    with serving as port:
        print(f"connect to {port}", flush=True)
        print(f"  solarcal calibrate --port {port}", flush=True)
        # In steps: a signal that another thread took wakes this one only when it looks itself.
        while not ended.wait(LOOK_S):
            pass
    return 0
