"""Where the program keeps what is the user's: sessions, profiles, settings, keymap.

``settings.toml`` is the program's own memory and is rewritten by it; profiles are written by the
profile form; ``keymap.toml`` is the user's alone and only read.
"""

import json
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import platformdirs

from solarcal.decimals import Six
from solarcal.errors import ConfigurationError
from solarcal.input_files import parse_toml, read_utf8, write_whole
from solarcal.timescale import parse_utc
from solarcal.unit.drivers import DEFAULT_DRIVER, has_line

APP = "solarcal"
REMEMBERED_LINES = 200
"""Of how many sessions the line they were taken on is remembered."""

Kind = TypeVar("Kind")


def sessions_dir() -> Path:
    """Folder of saved sessions; ``SOLARCAL_SESSIONS`` names another."""
    named = os.environ.get("SOLARCAL_SESSIONS")
    return Path(named or os.path.join(platformdirs.user_data_dir(APP, False), "sessions"))


def units_dir() -> Path:
    """Folder of what is kept for units that cannot keep it; ``SOLARCAL_UNITS`` names another."""
    named = os.environ.get("SOLARCAL_UNITS")
    return Path(named or os.path.join(platformdirs.user_data_dir(APP, False), "units"))


def config_dir() -> Path:
    """Folder of profiles, settings and keymap; ``SOLARCAL_CONFIG`` names another."""
    return Path(os.environ.get("SOLARCAL_CONFIG") or platformdirs.user_config_dir(APP, False))


def file_stem(text: str) -> str:
    """A scenario's name or a serial number as the beginning of a file name."""
    return re.sub(r"[^A-Za-z0-9-]+", "-", Path(text).stem).strip("-") or "session"


def new_session_path(name: str, utc: str) -> Path:
    """A path in the sessions folder that no file has yet: ``name-YYYY-MM-DD.jsonl``, ``-2`` ...

    Raises
    ------
    ConfigurationError
        The folder cannot be made, or is full of sessions of this name.
    """
    folder = sessions_dir()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ConfigurationError(
            f"the sessions folder {folder} cannot be made: {error.strerror}; name another one with "
            "SOLARCAL_SESSIONS, or the file itself"
        ) from None
    parse_utc(utc)
    stem = f"{name}-{utc[:10]}"
    for number in range(1, 100_000):
        path = folder / (f"{stem}.jsonl" if number == 1 else f"{stem}-{number}.jsonl")
        if not path.exists():
            return path
    raise ConfigurationError(f"{folder} is full of sessions named {stem}; move some elsewhere")


class Choice(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """What was opened on the start screen: a unit on a line, an emulated one, or a saved session.

    Exactly one of ``port``, ``scenario`` and ``replay`` is set, or none for the driver ``typed``;
    ``session`` continues a file. ``speed`` is how many seconds of an emulator or a
    replay pass in a real one at first.
    """

    port: str = ""
    driver: str = DEFAULT_DRIVER
    baudrate: int = 9600
    scenario: str = ""
    settings: tuple[str, ...] = ()
    seed: int = 0
    noise_deg: float | None = None
    speed: float | None = None
    replay: str = ""
    session: str = ""
    last_coefficients: Six | None = None
    """P1..P6 given with the command: they count for a scenario too, a profile's do not."""
    offers_unfinished: bool = False
    """Ask first which of the unit's unfinished sessions to go on with, if there is one."""

    def words(self) -> str:
        """The choice as a line of the start screen."""
        if self.replay:
            return f"replay {Path(self.replay).name}"
        what = f"emulated tracker {self.scenario}" if self.scenario else f"unit on {self.port}"
        if not has_line(self.driver):
            what = "a unit by hand: type what its display shows"
        elif self.driver != DEFAULT_DRIVER:
            what += f", driver {self.driver}"
        return f"continue {Path(self.session).name} ({what})" if self.session else what


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """What the program remembers.

    ``lines``: session file -> the choice it was taken with, a file outside the sessions folder with
    its whole path; ``calculators``: id of a field
    calculator -> what was typed into its fields where it is not the default. ``alerts``: bell and
    terminal notifications.
    """

    theme: str = "phosphor"
    alerts: bool = True
    profile: str = ""
    last: Choice | None = None
    lines: dict[str, Choice] = {}
    calculators: dict[str, dict[str, str]] = {}

    def with_line(self, path: Path, choice: Choice) -> "Settings":
        """These settings, remembering the line of a session; the oldest are forgotten."""
        session = _session_name(path)
        kept = [(name, line) for name, line in self.lines.items() if name != session]
        lines = dict([*kept, (session, choice)][-REMEMBERED_LINES:])
        return msgspec.structs.replace(self, lines=lines)

    def line_of(self, path: Path) -> Choice | None:
        """The line a session was taken on; a file moved since is known by its name."""
        return self.lines.get(_session_name(path)) or self.lines.get(path.name)

    def with_calculator(self, name: str, values: Mapping[str, str]) -> "Settings":
        """These settings, remembering what was typed into a calculator."""
        kept = {one: typed for one, typed in self.calculators.items() if one != name}
        if values:
            kept[name] = dict(values)
        return msgspec.structs.replace(self, calculators=kept)


def in_sessions_dir(path: Path) -> bool:
    """Whether a file is in the sessions folder."""
    return path.resolve().parent == sessions_dir().resolve()


def _session_name(path: Path) -> str:
    return path.name if in_sessions_dir(path) else str(path.resolve())


def load_settings() -> Settings:
    """The remembered settings; the defaults when there are none yet.

    Raises
    ------
    ConfigurationError
        The file is damaged; says which and where.
    """
    path = config_dir() / "settings.toml"
    return read_toml(path, Settings) if path.exists() else Settings()


def save_settings(settings: Settings) -> None:
    """Write them; the lines that another workstation on this laptop has added meanwhile stay."""
    ours = settings.lines
    others = {name: line for name, line in load_settings().lines.items() if name not in ours}
    lines = dict([*others.items(), *ours.items()][-REMEMBERED_LINES:])
    write_toml(config_dir() / "settings.toml", msgspec.structs.replace(settings, lines=lines))


def load_keymap() -> dict[str, str]:
    """Action id -> keys, from ``keymap.toml``; empty without one.

    Raises
    ------
    ConfigurationError
        Not TOML, or a value that is not text.
    """
    path = config_dir() / "keymap.toml"
    return read_toml(path, dict[str, str]) if path.exists() else {}


# -- TOML ------------------------------------------------------------------------------------


def read_toml(path: Path, kind: type[Kind]) -> Kind:
    """A TOML file as ``kind``; errors name the file, and the line or the field."""
    text = read_utf8(path)
    try:
        return msgspec.convert(parse_toml(text), kind)
    except (ValueError, ConfigurationError) as error:
        raise ConfigurationError(f"{path}: {error}; correct it or remove the file") from None


def write_toml(path: Path, value: msgspec.Struct) -> None:
    """Write a struct as TOML, whole or not at all."""
    write_whole(path, toml_text(msgspec.to_builtins(value)), make_folder=True)


def toml_text(document: Mapping[str, Any], prefix: str = "") -> str:
    """A nested mapping as TOML: values first, then tables. ``None`` is left out."""
    lines = [
        f"{_key(name)} = {_value(value)}"
        for name, value in document.items()
        if value is not None and not isinstance(value, Mapping)
    ]
    text = "".join(f"{line}\n" for line in lines)
    for name, value in document.items():
        if isinstance(value, Mapping):
            full = prefix + _key(name)
            text += f"\n[{full}]\n" + toml_text(value, f"{full}.")
    return text


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("-", "").replace("_", "").isalnum()
    return name if bare else _text(name)


def _value(value: object) -> str:
    match value:
        case bool():
            return "true" if value else "false"
        case str():
            return _text(value)
        case int() | float():
            return repr(value)
        case list() | tuple():
            return "[" + ", ".join(_value(item) for item in value) + "]"
        case _:
            raise TypeError(f"{type(value).__name__} has no TOML form here")


def _text(text: str) -> str:
    # JSON's escapes are TOML's, but TOML also wants the delete character escaped.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
