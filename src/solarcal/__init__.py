"""solarcal: calibrate a sun tracker from the terminal, or from Python (docs/library.md)."""

import importlib
from typing import Any

__version__ = "0.1.0"

_OFFERED = (
    "Analysis", "Forecast", "Mechanism", "MountGeometry", "Points", "Site", "Solution",
    "SunPosition", "Weather", "analyse", "fit", "forecast", "read", "sun_position",
)  # fmt: skip


def __getattr__(name: str) -> Any:
    """The library's names, imported when first used: every command imports this module."""
    if name not in _OFFERED:
        raise AttributeError(f"module 'solarcal' has no attribute {name!r}")
    return getattr(importlib.import_module("solarcal.library"), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_OFFERED])
