"""The options by which every command finds its unit, and the way they lead to a tracker."""

import argparse
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.config import new_session_path
from solarcal.decimals import shortened
from solarcal.errors import ConfigurationError, InputFileError
from solarcal.input_files import read_utf8
from solarcal.profiles import Profile, load_profile, load_site_file, profile_names
from solarcal.unit.drivers import DEFAULT_DRIVER, demand_driver

if TYPE_CHECKING:
    from solarcal.session.journal import Journal
    from solarcal.session.records import Header
    from solarcal.unit.tracker import Tracker

SLOWEST_BAUD, FASTEST_BAUD = 300, 4_000_000
PORT_HELP = "a unit on a line: device, socket://host:port, rfc2217://..."


def port(text: str) -> str:
    """A port for argparse: an unset variable in a script must not mean another unit."""
    if not text.strip():
        raise argparse.ArgumentTypeError("is empty; name the unit's port (is the variable set?)")
    return text


def _baudrate(text: str) -> int:
    rate = int(text) if text.isascii() and text.isdecimal() and len(text) < 9 else 0
    if not SLOWEST_BAUD <= rate <= FASTEST_BAUD:
        raise argparse.ArgumentTypeError(
            f"{shortened(text)} is no rate from {SLOWEST_BAUD} to {FASTEST_BAUD} baud"
        )
    return rate


def add_unit_options(parser: argparse.ArgumentParser) -> None:
    """For commands that always need a unit."""
    parser.add_argument(
        "--port", type=port, metavar="URL", help=f"{PORT_HELP} (default: the profile's)"
    )
    add_driver_options(parser)


def add_driver_options(parser: argparse.ArgumentParser) -> None:
    """Everything but the port itself."""
    parser.add_argument(
        "--driver",
        metavar="NAME",
        help="driver of the unit (default: the profile's, else solartrak)",
    )
    parser.add_argument(
        "--baudrate", type=_baudrate, metavar="N", help="default: the profile's, 9600"
    )
    told = parser.add_mutually_exclusive_group()
    told.add_argument("--profile", metavar="NAME", help="site, unit and operator profile")
    told.add_argument("--site", metavar="FILE", help="a profile from a TOML file")
    parser.add_argument("--trace", metavar="FILE", help="record everything sent and received")
    parser.add_argument(
        "--input", metavar="FILE", help="driver typed: field book with the display's values (-: "
        "standard input)",
    )  # fmt: skip


def session_path(text: str) -> Path:
    """A session file to write: by another ending no command would read it as one."""
    path = Path(text)
    if path.suffix.lower() != ".jsonl":
        raise argparse.ArgumentTypeError(f"{text}: a session file ends in .jsonl")
    return path


def add_output_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o", "--output", type=session_path, metavar="FILE", help="the session file to write"
    )


def add_force_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--force",
        metavar="REASON",
        help="upload although the points do not fit, or are no improvement; the reason is recorded",
    )


def forced_reason(args: argparse.Namespace) -> str | None:
    """The reason of ``--force``, which must not be empty; None without the option."""
    if args.force is None:
        return None
    if not args.force.strip():
        raise ConfigurationError("--force is empty; say why the upload is right all the same")
    return str(args.force.strip())


def asked_driver(args: argparse.Namespace, profile: "Profile | None") -> str:
    """The driver meant; ConfigurationError where a field book is given to one with a line."""
    driver = args.driver or (profile.driver if profile is not None else DEFAULT_DRIVER)
    if args.input and demand_driver(driver).has_line:
        raise ConfigurationError(f"--input is for --driver typed; driver {driver} has a line")
    return str(driver)


def refuse_options(args: argparse.Namespace, flags: Iterable[str], of: str) -> None:
    """Refuse (ConfigurationError) the first of ``flags`` that was given: it would be passed over.

    ``of`` says what it is for.
    """
    for flag in flags:
        name = "settings" if flag == "--set" else flag.removeprefix("--").replace("-", "_")
        if getattr(args, name) not in (None, []):
            raise ConfigurationError(f"{flag} is for {of}")


def port_words(args: argparse.Namespace) -> str:
    """Where the unit is, to go after its name."""
    return f" on {args.port}" if args.port else ""


def asks_for_unit(args: argparse.Namespace) -> bool:
    """Whether a unit is meant, where a command could also make an emulated one."""
    return not args.scenario and any((args.port, args.driver, args.profile, args.site))


def named_profile(args: argparse.Namespace) -> "Profile | None":
    """The profile the command line names, which must be there; ``None`` where it names none."""
    if args.site:
        return load_site_file(Path(args.site))
    if not args.profile:
        return None
    if args.profile not in (known := profile_names()):
        raise ConfigurationError(
            f"no profile {args.profile!r}; "
            + (f"there is: {', '.join(known)}" if known else "none has been saved yet")
        )
    return load_profile(args.profile)


def asked_tracker(args: argparse.Namespace, header: "Header | None" = None) -> "closing[Tracker]":
    """The tracker these options ask for, its line open; closed again whatever happens.

    ``header``: of the session it is for; a rotator stands where that says, unless a profile does.
    Raises as ``station.connect.open_tracker``.
    """
    from solarcal.station.connect import open_tracker

    profile = named_profile(args)
    if header is not None and demand_driver(asked_driver(args, profile)).rotator is not None:
        from solarcal.station.described_unit import described_by_session

        profile = described_by_session(profile or Profile(), header)
    book = None
    if args.input:
        from solarcal.station.typed.field_book import BookClock, FieldBook

        book = FieldBook(*book_lines(args.input), BookClock())
    told_baudrate = profile.baudrate if profile is not None else 9600
    tracker = open_tracker(
        args.port or (profile.port if profile is not None else ""),
        asked_driver(args, profile),
        trace=args.trace,
        baudrate=args.baudrate or told_baudrate,
        profile=profile,
        display=book,
    )
    return closing(tracker)


def book_lines(path: str) -> tuple[Iterable[str], str]:
    """The lines of a field book, ``-`` for standard input, and what messages call it.

    Raises
    ------
    InputFileError
        The file cannot be read; of standard input while its lines are taken.
    """

    if path == "-":
        return _standard_input(), "standard input"
    return read_utf8(path).splitlines(), path


def _standard_input() -> Iterator[str]:
    try:
        yield from sys.stdin
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is no UTF-8 text"
        raise InputFileError(f"standard input cannot be read: {reason}") from None


def journal_creator(output: Path | None, name: str) -> "Callable[[Header], Journal]":
    """Where the session goes: the file asked for, or a new one in the sessions folder."""

    def create(header: "Header") -> "Journal":
        from solarcal.session.journal import Journal

        path = output or new_session_path(name, header.utc)
        return Journal.create(path, header)

    return create
