"""``solarcal serve``: the workstation in a browser, one process for each page that is opened."""

import argparse
import shlex
import subprocess
import sys
from pathlib import Path

from solarcal.errors import ConfigurationError

LOOPBACK = ("localhost", "127.0.0.1", "::1")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="replay this session; default: choose on the page",
    )
    parser.add_argument(
        "--host", default="localhost", metavar="HOST",
        help="address to listen on (localhost: this machine only)",
    )  # fmt: skip
    parser.add_argument(
        "--tcp-port", type=int, default=8000, metavar="N", help="TCP port to listen on (8000)"
    )
    parser.add_argument(
        "--allow-motion", action="store_true",
        help="also open units: everyone who can open the page can then move the tracker",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl+C.

    Raises
    ------
    ConfigurationError
        A number that is no TCP port, a file that cannot be read, the package missing.
    """

    if not 1 <= args.tcp_port <= 65535:
        raise ConfigurationError(f"--tcp-port {args.tcp_port} is not between 1 and 65535")
    if args.file is not None and args.allow_motion:
        raise ConfigurationError("--allow-motion opens units; FILE is only replayed: give one")
    if args.file is not None:
        from solarcal.session.reader import read_session

        read_session(args.file)
    try:
        from solarcal.cli.web_server import GuardedServer
    except ModuleNotFoundError as error:
        raise ConfigurationError(
            f"serve needs the package textual-serve ({error.name} is missing); install it with: "
            "pip install 'solarcal[serve]'"
        ) from None
    if args.host not in LOOPBACK:
        print(
            f"solarcal: {args.host} may be reached from other machines: whoever opens the page can "
            + ("MOVE THE TRACKER and " if args.allow_motion else "")
            + "read every saved session. There is no password and no encryption.",
            file=sys.stderr,
        )
    GuardedServer(workstation_command(args), args.host, args.tcp_port, "solarcal").serve()
    return 0


def workstation_command(args: argparse.Namespace) -> str:
    """Return the shell command that runs one page's workstation."""
    words = [sys.executable, "-m", "solarcal"]
    if args.file is not None:
        words += ["replay", str(args.file.resolve())]
    else:
        words += ["run"] if args.allow_motion else ["run", "--offline"]
    return subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words)
