"""Keys and values of a scenario: typed, checked, the nearest key named when one is wrong."""

import difflib
import re
import tomllib
from collections.abc import Iterator
from typing import Any, TypeVar

import msgspec

from solarcal.errors import ConfigurationError

S = TypeVar("S", bound=msgspec.Struct)

_LEAN = ("lean_deg", "lean_bearing_deg")


def keys_of(struct: type[msgspec.Struct], prefix: str = "") -> Iterator[str]:
    """All dotted keys of a table and of the tables in it."""
    for field in msgspec.structs.fields(struct):
        if isinstance(field.type, type) and issubclass(field.type, msgspec.Struct):
            yield from keys_of(field.type, f"{prefix}{field.encode_name}.")
        else:
            yield prefix + field.encode_name


def refuse_unknown(document: dict[str, Any], struct: type[msgspec.Struct], source: str) -> None:
    """Refuse a document with a key the scenario does not know."""
    known = set(keys_of(struct))
    tables = {key.partition(".")[0] for key in known if "." in key}
    for name, value in document.items():
        if name in tables and not isinstance(value, dict):
            raise ConfigurationError(f"scenario {source}: {name} must be a table [{name}]")
        found = [f"{name}.{key}" for key in value] if name in tables else [name]
        for key in found:
            _require_known(key, known, f"scenario {source}")


def with_setting(
    document: dict[str, Any], setting: str, struct: type[msgspec.Struct]
) -> dict[str, Any]:
    """The document with one ``key=value`` applied; the value as a TOML literal or a bare text."""
    key, equals, text = setting.partition("=")
    key = key.strip()
    if not equals or not key:
        raise ConfigurationError(f"--set {setting}: write KEY=VALUE, like truth.lean_deg=0.1")
    _require_known(key, set(keys_of(struct)), f"--set {setting}")
    table, _, name = key.rpartition(".")
    changed = dict(document)
    if not table:
        changed[name] = _value(text)
        return changed
    inner = dict(changed.get(table, {}))
    inner[name] = _value(text)
    if table == "truth" and name in _LEAN:
        # A lean asked for last takes the place of the components a scenario gave instead.
        inner["P1"] = inner["P3"] = None
    changed[table] = inner
    return changed


def checked(document: dict[str, Any], struct: type[S], source: str) -> S:
    """The document as its struct, types and ranges checked."""
    try:
        return msgspec.convert(document, struct)
    except msgspec.ValidationError as error:
        raise ConfigurationError(f"scenario {source}: {_plain(str(error))}") from None


def _require_known(key: str, known: set[str], where: str) -> None:
    if key in known:
        return
    nearest = difflib.get_close_matches(key, known, n=1, cutoff=0.5) or difflib.get_close_matches(
        key.rpartition(".")[2], {name.rpartition(".")[2]: name for name in known}, n=1, cutoff=0.5
    )
    hint = "see `solarcal scenarios --json` for all keys"
    if nearest:
        full = next(name for name in sorted(known) if name.endswith(nearest[0]))
        hint = f"did you mean {full}?"
    raise ConfigurationError(f"{where}: there is no key {key!r}; {hint}")


def _value(text: str) -> Any:
    """A TOML literal; what is none is a text. Numbers may be written without a decimal point."""
    try:
        return tomllib.loads(f"value = {text.strip()}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()


def _plain(message: str) -> str:
    """msgspec's message with the place first: ``truth.lean_deg: expected a number``."""
    match = re.fullmatch(r"(.*) - at `\$\.?(.*)`", message, re.DOTALL)
    if match is None:
        return message
    what = match[1][0].lower() + match[1][1:] if match[1].startswith("Expected") else match[1]
    return f"{match[2]}: {what}"
