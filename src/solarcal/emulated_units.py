"""An emulated unit in this process, for commands and screens: whatever the driver.

The station never knows the emulator: what puts both together is here.
"""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from solarcal.config import Choice
from solarcal.emulator.emulation import Emulator
from solarcal.emulator.rotator import EmulatedRotator, RotatorWorld
from solarcal.emulator.rotator_protocols import ROTATOR_PROTOCOLS
from solarcal.emulator.scenario import load_scenario
from solarcal.emulator.server import InProcessLink, UnitOnALine, serve_here
from solarcal.errors import ConfigurationError
from solarcal.profiles import MountDescription, Profile
from solarcal.session.view import read_session
from solarcal.station.clocks import EmulatedClock
from solarcal.station.connect import open_tracker
from solarcal.station.described_unit import described_by_session
from solarcal.station.opening import OpenLine, open_line
from solarcal.station.saved_sessions import emulated_again
from solarcal.station.software_controller.coefficient_store import MemoryStore, StoredCorrection
from solarcal.station.software_controller.motion import ThreadPace
from solarcal.station.software_controller.rotator_tracker import RotatorTracker
from solarcal.station.typed.forms import Display
from solarcal.unit.drivers import DEFAULT_DRIVER, DRIVERS, demand_driver
from solarcal.unit.drivers.solartrak import SolarTrakUnit
from solarcal.unit.link import Link
from solarcal.unit.rotator import Rotator
from solarcal.unit.tracker import Tracker


@dataclass(frozen=True, slots=True)
class EmulatedUnit:
    """Its tracker, not opened yet, and how well its eye sees (1 sigma per axis on sky)."""

    tracker: Tracker
    noise_deg: float


def emulated_unit(
    scenario: str,
    driver: str = DEFAULT_DRIVER,
    *,
    settings: tuple[str, ...] = (),
    seed: int = 0,
    noise_deg: float | None = None,
    speed: float = 0.0,
) -> EmulatedUnit:
    """A scenario's unit on a line within the process.

    Raises
    ------
    ConfigurationError
        No such scenario or setting, or a driver that has no emulated unit.
    """

    loaded = load_scenario(scenario, settings)
    kind = demand_driver(driver)
    if not kind.has_line:
        raise ConfigurationError(
            f"there is no emulated unit for driver {driver}; leave --driver away, or name "
            f"{' or '.join(name for name, one in DRIVERS.items() if one.rotator)}"
        )
    if kind.rotator is not None:
        rotator = EmulatedRotator(loaded, seed=seed, noise_deg=noise_deg, speed=speed)
        rotator.protocol = ROTATOR_PROTOCOLS[driver]()
        on_line = kind.rotator(_InProcess(rotator, "emulated"))
        return EmulatedUnit(_rotator_tracker(rotator, on_line), rotator.noise_deg)
    emulator = Emulator(loaded, seed=seed, noise_deg=noise_deg, speed=speed)
    return EmulatedUnit(SolarTrakUnit(lambda: InProcessLink(emulator)), emulator.noise_deg)


@dataclass(frozen=True, slots=True)
class _InProcess:
    """A line within this process; a ``Line``."""

    unit: UnitOnALine
    port: str

    def link(self, url: str = "", lines_kept: int | None = None) -> Callable[[], Link]:
        del url, lines_kept
        return lambda: InProcessLink(self.unit)


def _rotator_tracker(rotator: EmulatedRotator, on_line: Rotator) -> RotatorTracker:
    """The station in the place of a rotator's controller; P and O are kept in memory."""
    unit, site = rotator.scenario.unit, rotator.scenario.site
    world = RotatorWorld(rotator)
    coefficients, offsets = unit.memory()
    store = MemoryStore(StoredCorrection(coefficients=coefficients, offsets=offsets))
    tracker = RotatorTracker(
        on_line,
        unit.serial,
        MountDescription(
            zone_west_h=rotator.scenario.unit_zone_west_h,
            ax1_centre_deg=unit.ax1_centre_deg,
            update_range_deg=unit.update_range_deg,
            reference1_deg=unit.reference1_deg,
            reference2_deg=unit.reference2_deg,
            tilt_decimals=unit.tilt_decimals,
            scale_decimals=unit.scale_decimals,
        ),
        site.place(),
        EmulatedClock(world),
        lambda model, serial: store,
        emulation=world,
        pace=ThreadPace(world.speed),
    )
    world.stand_in = tracker
    return tracker


def open_choice(
    choice: Choice,
    profile: Profile,
    *,
    output: Path | None = None,
    trace: str | None = None,
    display: Display | None = None,
) -> OpenLine:
    """The line of a choice of the start screen, real or emulated, with its session open.

    ``display``: who reads the display of a unit without a line. Nothing stays open after an error.
    """
    with contextlib.ExitStack() as resources:
        settings = choice.settings
        if choice.scenario and choice.session:
            settings = (*settings, *emulated_again(read_session(choice.session)))
        speed = 1.0 if choice.speed is None else choice.speed
        if choice.scenario and demand_driver(choice.driver).rotator is not None:
            if trace is not None:
                raise ConfigurationError(
                    "--trace records a line, and an emulated rotator in this process has none: "
                    f"start solarcal emulate --driver {choice.driver}, and choose its port"
                )
            tracker = emulated_unit(
                choice.scenario,
                choice.driver,
                settings=settings,
                seed=choice.seed,
                noise_deg=choice.noise_deg,
                speed=speed,
            ).tracker
        else:
            if choice.session and demand_driver(choice.driver).rotator is not None:
                profile = described_by_session(profile, read_session(choice.session).header)
            url = choice.port
            if choice.scenario:
                # In a thread of this process, on a line like any other.
                emulator = Emulator(
                    load_scenario(choice.scenario, settings),
                    seed=choice.seed,
                    noise_deg=choice.noise_deg,
                    speed=speed,
                )
                url = resources.enter_context(serve_here(emulator))
            tracker = open_tracker(
                url,
                choice.driver,
                trace=trace,
                baudrate=choice.baudrate,
                profile=profile,
                display=display,
            )
        line = open_line(tracker, choice, profile, output=output)
        # The tracker is closed before the line that it is on.
        resources.push(line.resources)
        line.resources = resources.pop_all()
        return line
