"""The command line: one module per command, imported only when it is the one asked for.

A command module has ``add_arguments(parser)`` and ``run(args) -> exit code``, with the command's
name in them where two share a module. A command that may fail without an error keeps its code in
``args.exit_code``, so that it holds where its output is not read to the end. It imports what is
heavy inside ``run``, so that every ``--help`` is there at once.
"""

import argparse
import errno
import importlib
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from solarcal import __version__
from solarcal.cli.process import (
    interrupts_prevail,
    let_go,
    let_go_of_terminal,
    never_fail,
    say,
)
from solarcal.errors import SolarcalError

COMMANDS: dict[str, str] = {
    "run": "open the workstation (also without a command)",
    "demo": "watch a demonstration on an emulated tracker",
    "calibrate": "run the whole procedure with the automatic technician",
    "fit": "fit coefficients to session, CSV or TPOINT files",
    "fleet": "fit thousands of sessions, list the worst trackers",
    "forecast": "forecast the pointing error over the year from saved points",
    "plan": "plan the next points, and find the end of the calibration",
    "report": "write the certificate of a calibration, and a zip archive",
    "upload": "write the fit of one or more sessions into their unit and read it back",
    "rollback": "restore the coefficients before the newest upload",
    "track": "follow the Sun with a rotator and its coefficients",
    "replay": "replay a saved session",
    "void": "strike a record of a session, or restore it",
    "note": "add a remark to a session",
    "import": "convert a points CSV or TPOINT file into a session file",
    "export": "write a session's points as CSV or TPOINT file",
    "emulate": "run the emulator as a separate process",
    "scenarios": "list the scenarios of the emulator",
    "sun": "position of the Sun",
    "day": "sunrise, noon, sunset, solar time, hours within limits",
    "year": "the Sun month by month, hours within limits, collector energy",
    "energy": "energy of a collector at a moment, over a day, over a year",
    "sunspot": "sunspot device: tracking error, misalignment, design",
    "screwjack": "screwjack parameters SJP#1-3 from measured lengths",
    "heliostat": "aim, target and mirror offset of a heliostat",
    "two-mirror": "two-mirror altazimuth trackers: axes, diode, base, a simulated day",
    "ports": "list the serial ports",
    "keys": "test the keys of this terminal",
    "doctor": "check this laptop",
    "serve": "the workstation in a browser: replay, recompute, reports and calculators",
    "completion": "print the script for completion with Tab in a shell",
}
AddArguments = Callable[[argparse.ArgumentParser], None]
Run = Callable[[argparse.Namespace], int]
_CALCULATORS = ("sun", "day", "year", "energy", "sunspot", "screwjack", "heliostat")
_SHARED = {
    "demo": "run",
    "doctor": "readiness",
    "emulate": "emulate",
    "export": "session_files",
    "forecast": "plan",
    "import": "session_files",
    "note": "session_files",
    "plan": "plan",
    "report": "plan",
    "replay": "run",
    "ports": "readiness",
    "rollback": "upload",
    "scenarios": "emulate",
    "track": "upload",
    "upload": "upload",
    "void": "session_files",
}
_NOT_WRITTEN = (errno.ENOSPC, errno.EDQUOT, errno.EIO, errno.EFBIG, errno.EBADF)


class OneLineParser(argparse.ArgumentParser):
    """argparse, but a usage error is one line like every other error of solarcal."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"{self.prog}: {message}; `{self.prog} --help` lists the options\n")

    def _print_message(self, message: str, file: Any = None) -> None:
        # argparse keeps it to itself when this fails.
        if file is None or file is sys.stderr:
            say(message.rstrip("\n"))
        else:
            print(message, end="", file=file, flush=True)


def command_functions(name: str) -> tuple[AddArguments, Run]:
    """What adds a command's arguments, and what runs it. A module's name has no hyphen."""
    if name in _SHARED:
        module = importlib.import_module(f"solarcal.cli.{_SHARED[name]}")
        return getattr(module, f"add_{name}_arguments"), getattr(module, f"run_{name}")
    module_name = "instrument" if name in _CALCULATORS else name.replace("-", "_")
    module = importlib.import_module(f"solarcal.cli.{module_name}")
    return module.add_arguments, module.run


def build_parser(asked: str | None = None) -> argparse.ArgumentParser:
    """The parser; only the command ``asked`` for is imported and given its arguments."""
    parser = OneLineParser(
        prog="solarcal",
        description="Calibrate a sun tracker from the terminal.",
        epilog="`solarcal COMMAND --help` lists a command's options.",
    )
    parser.add_argument("--version", action="version", version=f"solarcal {__version__}")
    parser.add_argument("--debug", action="store_true", help="show the traceback of an error")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, help_line in COMMANDS.items():
        command = commands.add_parser(name, help=help_line, description=help_line)
        command.add_argument(
            "--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS
        )
        if name == asked:
            add_arguments, run = command_functions(name)
            add_arguments(command)
            command.set_defaults(run=run)
    return parser


def run_command(argv: Sequence[str]) -> int:
    """Run one command line; the exit code. Errors meant for the user go to stderr in one line."""
    never_fail(sys.stdout)
    args = argparse.Namespace(debug=False, exit_code=0)
    try:
        with interrupts_prevail():
            code = let_go_of_terminal(_run(argv, args))
        # Here a full disk or a closed pipe still has an answer; at the interpreter's end none.
        sys.stdout.flush()
        return code
    except SolarcalError as error:
        if args.debug:
            traceback.print_exc()
        say(f"solarcal: {error}")
        return error.exit_code
    except KeyboardInterrupt as interrupt:
        say(f"solarcal: {str(interrupt) or 'interrupted'}")
        return let_go_of_terminal(int(getattr(interrupt, "exit_code", 130)))
    except BrokenPipeError:
        # The reader of our output went away (`| head`): nothing is wrong but what a command found.
        let_go(sys.stdout, sys.stderr)
        return int(args.exit_code)
    except OSError as error:
        if args.debug or error.errno not in (*_NOT_WRITTEN, errno.ENAMETOOLONG):
            raise
        if error.errno == errno.ENAMETOOLONG:
            name = str(error.filename)
            say(
                f"solarcal: the file name {name[:30]}... has {len(name)} characters; this system "
                "allows fewer"
            )
            return 2
        say(f"solarcal: the output cannot be written: {error.strerror}")
        let_go(sys.stdout)
        return 2


def _run(argv: Sequence[str], args: argparse.Namespace) -> int:
    asked = next((word for word in argv if not word.startswith("-")), None)
    if asked is None and not {"-h", "--help", "--version"}.intersection(argv):
        asked, argv = "run", [*argv, "run"]
    parser = build_parser(asked)
    _, unknown = parser.parse_known_args(argv, args)
    if unknown:
        parser.prog = f"solarcal {args.command}"
        parser.error(f"unrecognized arguments: {' '.join(unknown)}")
    return int(args.run(args))
