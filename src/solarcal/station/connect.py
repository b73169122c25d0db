"""From a port and a driver's name to a ``Tracker``: the one way every command takes.

A driver for a controller that knows the Sun lives in ``unit``. One for a controller that does not
gets it from the station, so the choice is made here.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from solarcal.errors import ConfigurationError
from solarcal.model.evidence.unit_state import check_unit_settings, check_unit_sun
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.profiles import MountDescription, Profile
from solarcal.site import Site
from solarcal.station.core import StationCore
from solarcal.station.software_controller.coefficient_store import FileStore
from solarcal.station.software_controller.rotator_tracker import RotatorTracker
from solarcal.station.typed.forms import Display
from solarcal.station.typed.unit import TypedUnit
from solarcal.timescale import Clock, SystemClock
from solarcal.unit.drivers import DEFAULT_DRIVER, Driver, demand_driver
from solarcal.unit.link import LINES_KEPT, Link, SerialLink
from solarcal.unit.tracker import Tracker


@dataclass(frozen=True, slots=True)
class Connection:
    """How to reach a unit: what the command line or the start screen said of it.

    ``profile`` holds what a controller that does not report its site or its mount needs them given;
    ``display`` answers for one that has no line, by ``clock``, the laptop's (the system's without).
    """

    port: str = ""
    driver: str = DEFAULT_DRIVER
    baudrate: int = 9600
    trace: str | Path | None = None
    profile: Profile | None = None
    display: Display | None = None
    clock: Clock | None = None

    def link(self, url: str = "", lines_kept: int | None = None) -> Callable[[], Link]:
        """What opens the line, to this port or to the URL a driver makes of it."""
        return lambda: SerialLink(
            url or self.port,
            baudrate=self.baudrate,
            trace=self.trace,
            lines_kept=lines_kept or LINES_KEPT,
        )

    def demand_port(self, example: str) -> None:
        """Refuse (ConfigurationError) to go on without a port."""
        if not self.port:
            raise ConfigurationError(
                f"driver {self.driver} needs a port: give --port, e.g. {example}"
            )

    def demand_site(self) -> Site:
        """The site of the profile; ConfigurationError where it was not given."""
        if self.profile is None or self.profile.site is None:
            raise ConfigurationError(
                f"driver {self.driver} needs the site, which its controller does not report: give "
                "--site FILE or --profile NAME, or fill in the profile form"
            )
        return self.profile.site

    def demand_display(self) -> Display:
        """Who reads the display; ConfigurationError where no such person was given."""
        if self.display is None:
            raise ConfigurationError(
                f"driver {self.driver} needs a person who reads the display: use the workstation, "
                "or give what was read with --input FILE"
            )
        return self.display

    def mount(self) -> MountDescription:
        """How the mount is described; by default the default description."""
        described = self.profile.mount if self.profile is not None else None
        return described if described is not None else MountDescription()


def open_tracker(
    port: str,
    driver: str = DEFAULT_DRIVER,
    trace: str | Path | None = None,
    baudrate: int = 9600,
    profile: Profile | None = None,
    *,
    display: Display | None = None,
    clock: Clock | None = None,
) -> Tracker:
    """The tracker at ``port``, its line open and the unit's identity known.

    Raises
    ------
    ConfigurationError
        No such driver, something it needs is missing, or the trace file cannot be written.
    LinkError
        The port cannot be opened, or there is no answer in the driver's protocol.
    """
    connection = Connection(port, driver, baudrate, trace, profile, display, clock)
    tracker = _tracker(connection, demand_driver(driver))
    try:
        tracker.open()
    except BaseException:
        tracker.close()
        raise
    return tracker


def _tracker(connection: Connection, driver: Driver) -> Tracker:
    if driver.has_line:
        connection.demand_port(driver.example)
    if driver.tracker is not None:
        return driver.tracker(connection)
    # Neither a rotator nor a display knows the Sun: the station computes it for the site.
    clock = connection.clock or SystemClock()
    if driver.rotator is None:
        display, site = connection.demand_display(), connection.demand_site()
        return TypedUnit(site, connection.mount(), display, clock)

    rotator = driver.rotator(connection)
    site, mount = connection.demand_site(), connection.mount()
    serial = mount.unit_name or rotator.where
    return RotatorTracker(rotator, serial, mount, site, clock, FileStore.of_unit)


def disagreements(station: StationCore) -> Iterator[str]:
    """Sentences, each with its number; none where unit and laptop agree. Reads one status."""
    status = station.poll()
    laptop_utc_s = station.clock.utc_s()
    if station.unit_site is None:
        return
    site = station.session.header.site
    yield from check_unit_settings(station.unit_site, site, status.unit_utc_s - laptop_utc_s)
    sun = check_unit_sun(station.unit_site, site, status.unit_utc_s, status.ideal_deg, laptop_utc_s)
    if not station.tracker.capabilities.has_link:
        yield from _typed_otherwise(station)
    if not sun.agrees:
        yield f"the unit's Sun is {sun.difference_deg:.3f} deg from ours: {sun.explanation}"


def other_site(station: StationCore, site: Site | None) -> Iterator[str]:
    """One sentence where an emulated unit, which keeps its own site, is not at this one."""
    if site is None or station.unit_site is None:
        return
    if apart := check_unit_settings(station.unit_site, site, 0.0):
        yield f"the profile's site is not used: {'; '.join(apart)}"


def _typed_otherwise(station: StationCore) -> Iterator[str]:
    """P1..P6 of a unit without a connection, typed again in a session that is gone on with."""
    session, in_force = station.session, station.coefficients_in_force
    uploads = session.uploads
    known = uploads[-1].new_coefficients if uploads else session.header.coefficients
    for name, typed, before in zip(
        COEFFICIENT_NAMES, in_force.as_tuple(), known.as_tuple(), strict=True
    ):
        if typed != before:
            yield (
                f"{name} was typed {typed:g}, but the last value in this session is {before:g}: "
                "check the display; if it was a typing error, leave and open the session again"
            )
