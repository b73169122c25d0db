"""One driver per kind of controller, chosen by name."""

from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.unit.link import Link, SerialLink
from solarcal.unit.tracker import Tracker

DRIVERS = ("solartrak",)


def open_tracker(
    url: str, driver: str = "solartrak", trace: str | Path | None = None, baudrate: int = 9600
) -> Tracker:
    """The tracker at ``url``, its line open and the unit's identity known.

    Raises
    ------
    ConfigurationError
        No such driver, or the trace file cannot be written.
    LinkError
        The port cannot be opened, or nobody answers in the driver's protocol.
    """
    from solarcal.unit.drivers.solartrak import SolarTrakUnit

    if driver not in DRIVERS:
        raise ConfigurationError(f"no driver {driver!r}; there is: {', '.join(DRIVERS)}")

    def link() -> Link:
        return SerialLink(url, baudrate=baudrate, trace=trace)

    unit = SolarTrakUnit(link, port=url)
    try:
        unit.open()
    except BaseException:
        unit.close()
        raise
    return unit
