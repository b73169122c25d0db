"""Numbers as a person writes them: ASCII decimals only, finite, within a range.

One reader for command options, forms, profiles and typed displays. Python's own ``float`` also
takes ``1_000``, ``nan``, ``inf`` and the digits of every script: none of them is a reading.
"""

import argparse
import math
import re
from collections.abc import Callable
from typing import TypeVar

from solarcal.errors import ConfigurationError

Value = TypeVar("Value")

Pair = tuple[float, float]
"""Of axis 1 and axis 2."""

Six = tuple[float, float, float, float, float, float]
"""Of P1..P6."""

_DECIMAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_WHOLE = re.compile(r"[+-]?[0-9]+")
_LONGEST = 64
"""Characters of the longest number; a longer text is none."""


def decimal(
    text: str,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    comma: bool = False,
    exponent: bool = True,
) -> float:
    """The number a text is.

    Parameters
    ----------
    text : spaces around it do not count.
    low, high : both allowed.
    comma : a decimal comma is taken for the point.
    exponent : ``1e3`` is a number too; no display shows one.

    Raises
    ------
    ConfigurationError
        It is not a number, or not between the two; without the name of what was asked for.
    """
    written = text.strip()
    if comma:
        written = written.replace(",", ".")
    plain = exponent or "e" not in written.lower()
    if len(written) > _LONGEST or not plain or _DECIMAL.fullmatch(written) is None:
        raise ConfigurationError(f"{shortened(text)} is not a number")
    value = float(written)
    if not math.isfinite(value):
        raise ConfigurationError(f"{shortened(text)} is too large for a number")
    if not low <= value <= high:
        raise ConfigurationError(f"{value:g} is not {between(low, high)}")
    return value


def whole(text: str, low: float = -math.inf, high: float = math.inf) -> int:
    """The same for a whole number."""
    written = text.strip()
    if len(written) > _LONGEST or _WHOLE.fullmatch(written) is None:
        raise ConfigurationError(f"{shortened(text)} is not a whole number")
    value = int(written)
    if not low <= value <= high:
        raise ConfigurationError(f"{value} is not {between(low, high)}")
    return value


def between(low: float, high: float) -> str:
    """A range in words."""
    if math.isinf(high):
        return f"{low:g} or more"
    if math.isinf(low):
        return f"{high:g} or less"
    return f"between {low:g} and {high:g}"


def require_between(what: str, value: float, low: float, high: float, unit: str = "") -> None:
    """Refuse (ConfigurationError) a number outside its range; both ends are allowed, NaN is not."""
    if not low <= value <= high:
        raise ConfigurationError(f"{what} {value:g}{unit} is not {between(low, high)}")


def require_positive(what: str, value: float) -> None:
    """Refuse (ConfigurationError) what is not finite and greater than zero."""
    if not 0.0 < value < math.inf:
        raise ConfigurationError(f"{what} must be greater than zero, not {value:g}")


def shortest(value: float) -> str:
    """Digits that read back as the same number, without ``.0``."""
    plain = f"{value:g}"
    return plain if float(plain) == value else repr(value)


def shortened(text: str) -> str:
    """A text quoted in an error, not longer than a line has room for."""
    return repr(text if len(text) <= 30 else text[:27] + "...")


def option_of(read: Callable[[str], Value]) -> Callable[[str], Value]:
    """The ``type`` of an argparse option whose text is read like this; its error as argparse's."""

    def value(text: str) -> Value:
        try:
            return read(text)
        except ConfigurationError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return value


def number_option(low: float = -math.inf, high: float = math.inf) -> Callable[[str], float]:
    """The ``type`` of an argparse option that takes a decimal within a range."""
    return option_of(lambda text: decimal(text, low, high))


SLOWEST, FASTEST = 0.001, 1e6
"""How fast emulated or recorded time may run, seconds a second."""


def speed_option(stopped: float | None = None) -> Callable[[str], float]:
    """The ``type`` of an option for the speed of time: 0 where ``stopped`` allows, or in range."""

    def speed(text: str) -> float:
        value = decimal(text, 0.0, FASTEST)
        if value < SLOWEST and value != stopped:
            zero = "0, or " if stopped == 0.0 else ""
            raise ConfigurationError(f"{value:g} is not {zero}{between(SLOWEST, FASTEST)}")
        return value

    return option_of(speed)


def whole_option(low: float = -math.inf, high: float = math.inf) -> Callable[[str], int]:
    """The ``type`` of an argparse option that takes a whole number within a range."""
    return option_of(lambda text: whole(text, low, high))


def counted(number: int, noun: str) -> str:
    """A number of things: ``1 point``, ``2 points``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
