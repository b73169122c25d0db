"""Text of others made harmless: what a terminal would obey is written out instead.

A session file, a profile, a points file or a file's name may hold escape sequences that clear the
screen, change its title or turn words around. Every reader of such text, and
every error message, passes it through here.
"""

import re
from typing import Any

# C0 but tab and line feed, delete, C1, marks and overrides of the writing direction, lone
# surrogates (a file name that is no UTF-8), a byte order mark.
_OBEYED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufeff]"
)


def harmless(text: str) -> str:
    """The text with every character a terminal would obey written out, like ``\\x1b``.

    Tabs and line feeds stay.
    """
    return _OBEYED.sub(_written_out, text)


def one_line(text: str) -> str:
    """The same with every run of white space a single space."""
    return harmless(" ".join(text.split()))


def harmless_tree(value: Any) -> Any:
    """A document of mappings, lists and plain values with all its texts harmless, keys too."""
    if isinstance(value, str):
        return harmless(value)
    if isinstance(value, dict):
        return {harmless_tree(key): harmless_tree(item) for key, item in value.items()}
    if isinstance(value, list):
        return [harmless_tree(item) for item in value]
    return value


def is_harmless(text: str) -> bool:
    return _OBEYED.search(text) is None


def _written_out(found: "re.Match[str]") -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}"
