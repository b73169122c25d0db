"""Keys and values of a scenario: typed, checked, the nearest key named when one is wrong."""

import datetime
import difflib
import math
import re
from collections.abc import Iterator
from typing import Any, TypeVar

import msgspec

from solarcal.errors import ConfigurationError
from solarcal.input_files import parse_toml

S = TypeVar("S", bound=msgspec.Struct)

_LEAN = ("lean_deg", "lean_bearing_deg")


def keys_of(struct: type[msgspec.Struct], prefix: str = "") -> Iterator[str]:
    """All dotted keys of a table and of the tables in it."""
    for field in msgspec.structs.fields(struct):
        if isinstance(field.type, type) and issubclass(field.type, msgspec.Struct):
            yield from keys_of(field.type, f"{prefix}{field.encode_name}.")
        else:
            yield prefix + field.encode_name


def settings_of(scenario: msgspec.Struct) -> dict[str, Any]:
    """Every dotted key with its value, as plain numbers, texts and lists."""
    document = msgspec.to_builtins(scenario)
    found = {}
    for key in keys_of(type(scenario)):
        table, _, name = key.rpartition(".")
        found[key] = (document[table] if table else document)[name]
    return found


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
    written = _written_out(document, source)
    try:
        return msgspec.convert(written, struct)
    except (msgspec.ValidationError, ConfigurationError) as error:
        raise ConfigurationError(f"{source}: {_plain(str(error))}") from None


def _require_known(key: str, known: set[str], where: str) -> None:
    if key in known:
        return
    name = key.rpartition(".")[2]
    names = sorted(known, key=lambda full: (len(full), full))
    nearest = difflib.get_close_matches(key, names, n=1, cutoff=0.6)
    nearest += [full for full in names if name in full.rpartition(".")[2]]
    hint = f"did you mean {nearest[0]}?" if nearest else "`solarcal scenarios NAME` shows them all"
    raise ConfigurationError(f"{where}: there is no key {key!r}; {hint}")


def _value(text: str) -> Any:
    """A TOML literal; what is none is a text. Numbers may be written without a decimal point."""
    try:
        return parse_toml(f"value = {text.strip()}")["value"]
    except ValueError:
        return text.strip()


def _written_out(value: Any, where: str) -> Any:
    """Dates as the texts they are in TOML; numbers that are none refused."""
    if isinstance(value, dict):
        return {key: _written_out(item, f"{where}: {key}") for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_written_out(item, where) for item in value]
    if isinstance(value, (datetime.date, datetime.time)):
        return value.isoformat()
    if isinstance(value, float) and not math.isfinite(value):
        raise ConfigurationError(f"{where}: {value} is not a number one can use")
    return value


def _plain(message: str) -> str:
    """msgspec's message with the place first: ``truth.lean_deg: expected a number``."""
    match = re.fullmatch(r"(.*) - at `\$\.?(.*)`", message, re.DOTALL)
    if match is None:
        return message
    what = match[1][0].lower() + match[1][1:] if match[1].startswith("Expected") else match[1]
    return f"{match[2]}: {what}"
