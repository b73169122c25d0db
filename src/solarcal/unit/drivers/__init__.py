"""One driver per kind of controller: this table is all that commands and screens know of them.

A driver for a controller that follows the Sun gives a ``Tracker``; one for a machine that only
turns gives a ``Rotator``, which the station makes a tracker of; one with neither has no line, and
a person types. ``station.connect`` opens them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from solarcal.errors import ConfigurationError

if TYPE_CHECKING:
    from solarcal.unit.link import Link
    from solarcal.unit.rotator import Rotator
    from solarcal.unit.tracker import Tracker

DEFAULT_DRIVER = "solartrak"


class Line(Protocol):
    """What a driver is opened on."""

    @property
    def port(self) -> str:
        """As given; not empty."""
        ...

    def link(self, url: str = "", lines_kept: int | None = None) -> "Callable[[], Link]":
        """What opens the line to the port, or to the URL the driver makes of it."""
        ...


@dataclass(frozen=True, slots=True)
class Driver:
    """One kind of controller.

    Attributes
    ----------
    summary : what it is for.
    address : what its port looks like; empty where there is no line.
    example : a port, for messages.
    tracker, rotator : opens it; at most one of them.
    """

    summary: str
    address: str = ""
    example: str = ""
    tracker: "Callable[[Line], Tracker] | None" = None
    rotator: "Callable[[Line], Rotator] | None" = None

    @property
    def has_line(self) -> bool:
        """Else a person reads its display and types."""
        return bool(self.address)


# Each opener imports its own module: the start screen needs the names alone.


def _solartrak(line: Line) -> "Tracker":
    from solarcal.unit.drivers.solartrak import SolarTrakUnit

    return SolarTrakUnit(line.link(), port=line.port)


def _rotctld(line: Line) -> "Rotator":
    from solarcal.unit.drivers.rotctld import LINES_KEPT, RotctldRotator, rotctld_address

    address = rotctld_address(line.port)
    return RotctldRotator(line.link(f"socket://{address}", LINES_KEPT), address)


def _easycomm(line: Line) -> "Rotator":
    from solarcal.unit.drivers.easycomm import EasyCommRotator

    return EasyCommRotator(line.link(), line.port)


DRIVERS: dict[str, Driver] = {
    "solartrak": Driver(
        "a unit that speaks the documented protocol",
        "device, socket:// or rfc2217://host:port",
        "/dev/ttyUSB0",
        tracker=_solartrak,
    ),
    "typed": Driver("no line at all: a person types what the controller's display shows"),
    "rotctld": Driver(
        "any azimuth-elevation rotator of Hamlib, over its rotctld",
        "host or host:port of Hamlib's rotctld",
        "localhost:4533",
        rotator=_rotctld,
    ),
    "easycomm": Driver(
        "a rotator whose firmware speaks EasyComm II, on its serial line",
        "device, socket:// or rfc2217://host:port",
        "/dev/ttyUSB0",
        rotator=_easycomm,
    ),
}
"""By name, in the order a technician would look for it."""

ON_A_LINE = tuple(name for name, driver in DRIVERS.items() if driver.has_line)
"""The drivers of what has an address."""


def demand_driver(name: str) -> Driver:
    """The driver of that name; ConfigurationError names those there are."""
    if name not in DRIVERS:
        raise ConfigurationError(f"no driver {name!r}; there is: {', '.join(DRIVERS)}")
    return DRIVERS[name]


def has_line(name: str) -> bool:
    """Whether a driver has a line; taken for granted of a name that is no driver's."""
    return name not in DRIVERS or DRIVERS[name].has_line
