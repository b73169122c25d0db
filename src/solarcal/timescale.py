"""Instants as UTC in POSIX seconds (float64), their ISO 8601 form in files and on screens; clocks.

POSIX seconds count every day as 86400 s. A leap second therefore has no name of its own, which
costs nothing here: none has been inserted since 2016 and a second is 0.004 deg of Sun.

Time is injected: whoever needs it is handed a ``Clock``. This module and the link are the only
places that ask the operating system for the time or wait.
"""

import math
import threading
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Protocol

from solarcal.errors import ConfigurationError

SECONDS_PER_DAY = 86400.0
SECONDS_PER_SUN_DEG = SECONDS_PER_DAY / 360.0
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


def parse_utc(text: str) -> float:
    """POSIX seconds of an ISO 8601 instant; without an offset the text is taken as UTC.

    Raises
    ------
    ConfigurationError
        The text is not an instant.
    """
    try:
        instant = datetime.fromisoformat(text.strip())
    except ValueError:
        raise ConfigurationError(
            f"{text!r} is not a date and time; write it like 2026-06-21T15:30:00Z"
        ) from None
    if instant.tzinfo is None:
        instant = instant.replace(tzinfo=UTC)
    return instant.timestamp()


def parse_many_utc(texts: Sequence[str | None]) -> list[float]:
    """``parse_utc`` of each, fast where all are written alike; NaN for None.

    Raises
    ------
    ConfigurationError
        The first text that is not an instant.
    """
    try:
        instants = list(map(datetime.fromisoformat, texts))  # type: ignore[arg-type]
        # Instants with and without an offset cannot be subtracted from one another.
        epoch = _EPOCH if instants and instants[0].tzinfo else _EPOCH.replace(tzinfo=None)
        return [(instant - epoch).total_seconds() for instant in instants]
    except (ValueError, TypeError):
        return [math.nan if text is None else parse_utc(text) for text in texts]


def format_utc(utc_s: float, decimals: int = 3) -> str:
    """ISO 8601 with ``Z``, rounded to the given decimals of a second (0, 3 or 6)."""
    rounded = round(utc_s, decimals)
    instant = datetime.fromtimestamp(rounded, UTC).replace(tzinfo=None)
    spec = {0: "seconds", 3: "milliseconds", 6: "microseconds"}[decimals]
    if decimals == 3:
        # fromtimestamp rounds to the microsecond, isoformat truncates to the millisecond.
        millis = round(rounded * 1000.0)
        instant = datetime.fromtimestamp(millis // 1000, UTC).replace(
            tzinfo=None, microsecond=(millis % 1000) * 1000
        )
    return instant.isoformat(timespec=spec) + "Z"


def time_of_day(utc_s: float) -> str:
    """The time of day: ``15:30``."""
    return format_utc(utc_s, 0)[11:16]


def second_of_day(utc: float | str) -> str:
    """The time of day of POSIX seconds or an ISO 8601 text, to the nearest second: ``15:30:07``."""
    return format_utc(parse_utc(utc) if isinstance(utc, str) else utc, 0)[11:19]


def clock_face(seconds: float) -> str:
    """HH:MM:SS of seconds of a day, to the nearest."""
    whole = round(seconds) % 86400
    return f"{whole // 3600:02d}:{whole // 60 % 60:02d}:{whole % 60:02d}"


def clock_utc(utc_s: float) -> str:
    """The time of day: ``15:30 UTC``."""
    return f"{time_of_day(utc_s)} UTC"


class Clock(Protocol):
    """The laptop's clock: the time it shows, and a way to wait."""

    def utc_s(self) -> float:
        """The laptop's UTC, POSIX seconds."""
        ...

    def wait(self, seconds: float) -> None:
        """Return when that much of this clock's time has passed."""
        ...


class SystemClock:
    """The operating system's clock. ``wake`` ends a wait early."""

    def __init__(self) -> None:
        self._woken = threading.Event()

    def utc_s(self) -> float:
        return time.time()

    def wait(self, seconds: float) -> None:
        self._woken.wait(seconds)

    def wake(self) -> None:
        self._woken.set()
