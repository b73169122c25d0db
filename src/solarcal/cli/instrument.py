"""The field calculators as commands: options from their fields, texts read by their forms."""

import argparse
from collections.abc import Iterable
from typing import Any

from solarcal.cli.process import add_json_option, print_answer, print_json, say
from solarcal.errors import ConfigurationError
from solarcal.instruments.catalogue import INSTRUMENTS
from solarcal.instruments.form import Field, Flag, Instrument
from solarcal.timescale import Clock, SystemClock

LOOK_EVERY_S = 0.5
"""At a folder for its next image."""

_KINDS = {
    "heliostat": ("aim", "target", "drift", "circle", "shift"),
    "sun": ("position", "compare"),
}
"""Commands whose first word says what to compute; the first one where it is left out."""
_KIND_HELP = {
    "heliostat": "aim: the normal for a Sun and a target (default); target: direction of the "
    "target, from normals with the beam on it; drift: of an uncorrected mirror offset over a day; "
    "circle: both roots of AzimPivot_R = PivotRefl_R = 0; shift: change of the target's direction "
    "by a translation",
    "sun": "position: angles now (default); compare: two models over years",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The options of every instrument of the command that is the parser's last word."""
    command = parser.prog.split()[-1]
    served = [one for one in INSTRUMENTS if one.command.split()[0] == command]
    if command in _KINDS:
        parser.add_argument(
            "what",
            nargs="?",
            choices=_KINDS[command],
            default=_KINDS[command][0],
            help=_KIND_HELP[command],
        )  # fmt: skip
    elif len(served) > 1:
        parser.add_argument(
            "--design", action="store_true", help="resolution and range of a device, or its design"
        )
    add_options(parser, served)
    add_json_option(parser)
    parser.set_defaults(instruments=served)


def add_options(parser: argparse.ArgumentParser, instruments: Iterable[Instrument]) -> None:
    """The options of these instruments, each once."""
    added: set[str] = set()
    groups: dict[str, Any] = {}
    keys = []
    for one in instruments:
        for flags, fields in _options(one.fields):
            if not added.issuperset(flags):
                _add_fields(parser, flags, fields)
            added.update(flags)
        for flag in one.flags:
            if flag.flag not in added:
                _add_flag(parser, groups, flag)
            added.add(flag.flag)
        if one.json_keys:
            keys.append(f"JSON keys ({one.command}): {one.json_keys}.")
    page = "two-mirror" if "two-mirror" in parser.prog.split() else "instruments"
    parser.epilog = " ".join(keys) or f"The JSON keys are in docs/{page}.md."


def run(args: argparse.Namespace) -> int:
    """Compute and print."""
    words = [args.command]
    if args.command in _KINDS:
        words += [args.what] if args.what != "position" else []
    else:
        words += [f"--{one}" for one in ("design", "picture") if getattr(args, one, None)]
    wanted = " ".join(words)
    return answer(next(one for one in args.instruments if one.command == wanted), args)


def answer(instrument: Instrument, args: argparse.Namespace) -> int:
    """Read the options as the instrument's fields, and print what it answers."""
    values, labels = texts_of(instrument, args)
    form = instrument.form(values, SystemClock().utc_s(), labels)
    return print_answer(instrument.answer(form), args.json)


def watch_folder(instrument: Instrument, args: argparse.Namespace, clock: Clock) -> int:
    """The corrections of every image that comes into the folder, until there are ``--images``."""
    from solarcal.optics.disc_image import newest_image

    folder = args.image
    seen: set[str] = set()
    found: list[dict[str, Any]] = []
    while len(found) < args.images:
        newest = newest_image(folder, seen)
        if newest is None:
            clock.wait(LOOK_EVERY_S)
            continue
        args.image = newest[0]
        seen.add(args.image)
        try:
            values, labels = texts_of(instrument, args)
            one = instrument.answer(instrument.form(values, clock.utc_s(), labels)).document
        except ConfigurationError as error:
            say(f"warning: {error}")
            continue
        found.append(one)
        if not args.json:
            print(
                f"{args.image}: axis 1 {one['correction1_deg']:+z.5f} +- "
                f"{one['correction1_sigma_deg']:.5f}, axis 2 {one['correction2_deg']:+z.5f} +- "
                f"{one['correction2_sigma_deg']:.5f} deg",
                flush=True,
            )
    if args.json:
        print_json({"images": found})
    return 0


def texts_of(
    instrument: Instrument, args: argparse.Namespace
) -> tuple[dict[str, str], dict[str, str]]:
    """The texts of the fields as the options give them, and what errors call each field."""
    fields = {one.name: one for one in instrument.fields}
    values = {one.name: one.default for one in instrument.fields if not one.repeat}
    labels: dict[str, str] = {}

    def put(name: str, row: Any) -> None:
        text = row if isinstance(row, str) else " ".join(row)
        if fields[name].repeat:
            name = f"{name}{1 + sum(one.startswith(name) for one in values)}"
        values[name] = text

    for flags, filled in _options(instrument.fields):
        names = _metavars(filled) if len(filled) > 1 else ()
        labels |= {one.name: " ".join((*flags, *names)) for one in filled}
        words = _given(args, flags)
        if len(filled) > 1:
            for one, word in zip(filled, words, strict=False):
                put(one.name, word)
        elif filled[0].repeat:
            for row in words:
                put(filled[0].name, row)
        elif words:
            put(filled[0].name, words)
    for flag in instrument.flags:
        given = getattr(args, _dest(flag.flag))
        if flag.to and (given or flag.to not in labels):
            labels[flag.to] = flag.flag
        if not given:
            continue
        if flag.to:
            for row in given if flag.repeat else [given]:
                put(flag.to, row.replace(",", " ") if flag.repeat and isinstance(row, str) else row)
        values |= {
            name: text for name, text in flag.sets.items() if values[name] == fields[name].default
        }
    return values, labels


def _options(fields: Iterable[Field]) -> list[tuple[tuple[str, ...], list[Field]]]:
    """Flags and the fields they fill, for every option."""
    found: dict[tuple[str, ...], list[Field]] = {}
    for one in fields:
        if one.help:
            found.setdefault(tuple(one.option.split()), []).append(one)
    return list(found.items())


def _given(args: argparse.Namespace, flags: tuple[str, ...]) -> list[Any]:
    """The words given for an option, none where it was not."""
    words = [getattr(args, _dest(flag)) for flag in flags]
    if words.count(None) == len(words):
        return []
    if None in words:
        raise ConfigurationError(f"give {' and '.join(flags)}, both or neither")
    return list(words[0]) if isinstance(words[0], list) else words


def _dest(flag: str) -> str:
    return flag.lstrip("-").replace("-", "_")


def _metavars(fields: list[Field]) -> tuple[str, ...]:
    return tuple(word for one in fields for word in one.metavar.split())


def _add_fields(
    parser: argparse.ArgumentParser, flags: tuple[str, ...], fields: list[Field]
) -> None:
    first, names = fields[0], _metavars(fields)
    options: dict[str, Any] = {"help": first.help}
    if first.required:
        options["required"] = True
    if first.choices and not first.metavar:
        options["choices"] = first.choices
    if len(flags) == 1 and len(names) > 1:
        options |= {"nargs": len(names), "metavar": names}
        if first.repeat:
            options |= {"action": "append", "default": []}
    elif names:
        options["metavar"] = names[0]
    for flag in flags:
        parser.add_argument(flag, **options)


def _add_flag(parser: argparse.ArgumentParser, groups: dict[str, Any], flag: Flag) -> None:
    where: Any = parser
    if flag.exclusive:
        if flag.exclusive not in groups:
            groups[flag.exclusive] = parser.add_mutually_exclusive_group()
        where = groups[flag.exclusive]
    if not flag.to:
        where.add_argument(flag.flag, action="store_true", help=flag.help)
        return
    names = tuple(flag.metavar.split())
    options: dict[str, Any] = {"help": flag.help, "metavar": names[0]}
    if len(names) > 1:
        options |= {"nargs": len(names), "metavar": names}
    if flag.repeat:
        options |= {"action": "append", "default": []}
    where.add_argument(flag.flag, **options)
