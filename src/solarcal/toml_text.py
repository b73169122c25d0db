"""TOML of others: whatever is wrong with it is a ``ValueError``, and its texts are harmless."""

import tomllib
from typing import Any

from solarcal.plain_text import harmless_tree


def parse_toml(text: str) -> dict[str, Any]:
    """A TOML document.

    Raises
    ------
    ValueError
        Not TOML, a number too long to read, or nested too deeply; says where it can.
    """
    try:
        document: dict[str, Any] = harmless_tree(tomllib.loads(text))
    except RecursionError:
        raise ValueError("nested too deeply") from None
    return document
