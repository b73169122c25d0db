"""What a SolarTrak computes for itself, computed by the station: clock, ideal angles, E + O.

A unit served this way has exactly the station's model, so it has the Sun model, the
formula and the offsets of the controller it lacks: ``reading = ideal + E(ideal; P) + O``.
"""

import msgspec

from solarcal.decimals import Pair
from solarcal.errors import ConfigurationError, UnitRefused
from solarcal.mount.controller import ControllerModel, ideal_and_elevation_deg, ideal_axes_deg
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.profiles import MountDescription
from solarcal.site import Site
from solarcal.station.described_unit import unit_parameters, unit_site
from solarcal.station.software_controller.coefficient_store import (
    CoefficientStore,
    MemoryStore,
    StoredCorrection,
)
from solarcal.timescale import Clock, format_utc
from solarcal.unit.frames import Code
from solarcal.unit.rotator import Direction
from solarcal.unit.tracker import Stored, UnitParameters, UnitSite
from solarcal.units import wrap_deg

TURNS = (0, 1, -1, 2, -2)
"""In the order they are tried: azimuths of the plain turn first."""

_TOUCHING_DEG = 1e-6


class AzElAxes:
    """The axes of one rotator.

    Parameters
    ----------
    geometry : the mount's; only ``azel`` is one.
    ax1_centre_deg : centre of the branch of axis 1.
    azimuth, elevation : how far the rotator turns, as it reads.

    Raises
    ------
    ConfigurationError
        Another geometry, or a rotator that reaches no part of the branch.
    """

    def __init__(
        self, geometry: str, ax1_centre_deg: float, azimuth: AxisLimits, elevation: AxisLimits
    ) -> None:
        if geometry != "azel":
            raise ConfigurationError(
                f"a rotator turns in azimuth and elevation: a {geometry} mount cannot be driven by "
                "it; describe the mount as azel"
            )
        self._centre_deg = ax1_centre_deg
        self._azimuth = azimuth
        self._elevation = elevation
        self.limits = Limits(self._reach1(), self._reach2())
        """Read-outs the rotator can be sent to."""

    def reading_deg(self, direction: Direction) -> Pair:
        """AX1 on the branch and AX2 of where the rotator says it stands."""
        azimuth, elevation = direction
        return float(wrap_deg(180.0 - azimuth, self._centre_deg)), 90.0 - elevation

    def direction_deg(self, ax1_deg: float, ax2_deg: float) -> Direction:
        """Azimuth and elevation that belong to read-outs within ``limits``; always the same turn
        for the same AX1."""
        low, high = self._azimuth.low_deg, self._azimuth.high_deg
        azimuth = 180.0 - ax1_deg
        for turn in TURNS:
            on_turn = azimuth + 360.0 * turn
            if low - _TOUCHING_DEG <= on_turn <= high + _TOUCHING_DEG:
                azimuth = on_turn
                break
        elevation = 90.0 - ax2_deg
        return (
            min(max(azimuth, low), high),
            min(max(elevation, self._elevation.low_deg), self._elevation.high_deg),
        )

    def _reach1(self) -> AxisLimits:
        """The longest stretch of the branch that has no gap."""
        low, high = self._centre_deg - 180.0, self._centre_deg + 180.0
        pieces: list[Pair] = []
        for turn in TURNS:
            begins = max(low, 180.0 - self._azimuth.high_deg + 360.0 * turn)
            ends = min(high, 180.0 - self._azimuth.low_deg + 360.0 * turn)
            if begins < ends:
                pieces.append((begins, ends))
        if not pieces:
            raise ConfigurationError(
                f"the rotator's azimuths {self._azimuth.low_deg:g} to {self._azimuth.high_deg:g} "
                "deg are not a valid range"
            )
        if self._azimuth.high_deg - self._azimuth.low_deg >= 360.0 - _TOUCHING_DEG:
            # Each turn touches the next.
            return AxisLimits(min(pieces)[0], max(pieces)[1])
        return AxisLimits(*max(pieces, key=lambda piece: piece[1] - piece[0]))

    def _reach2(self) -> AxisLimits:
        """Not past the zenith: there AX1 would turn over."""
        low = max(0.0, 90.0 - self._elevation.high_deg)
        high = min(180.0, 90.0 - self._elevation.low_deg)
        if not low < high:
            raise ConfigurationError(
                f"the rotator's elevations {self._elevation.low_deg:g} to "
                f"{self._elevation.high_deg:g} deg give axis 2 no range"
            )
        return AxisLimits(low, high)


TILT_DECIMALS, SCALE_DECIMALS = 6, 9
"""Stored at least. No display limits them: six decimals of a degree are what a session records."""


class SoftwareControllerModel:
    """Clock, Sun, P and O of one unit. Angles are axis degrees, AX1 on the branch.

    Parameters
    ----------
    description, site : how the mount is built and where it stands.
    clock : the laptop's.
    store : where P and O are kept.
    unit_limits : limits the unit itself tells; ``None`` where it tells none.

    Raises
    ------
    ConfigurationError
        What was stored cannot be read, or the limits leave no room.
    """

    def __init__(
        self,
        description: MountDescription,
        site: Site,
        clock: Clock,
        store: CoefficientStore,
        unit_limits: Limits | None = None,
    ) -> None:
        self.unit_site: UnitSite = unit_site(description, site)
        self.parameters: UnitParameters = unit_parameters(description, site, unit_limits)
        self.geometry = MountGeometry(
            description.geometry, site.latitude_deg, self.unit_site.ax1_centre_deg
        )
        self._clock = clock
        self._unit_minus_laptop_s = 0.0
        self._store = store
        self._formula = ControllerModel(
            self.parameters.limits,
            max(description.tilt_decimals, TILT_DECIMALS),
            max(description.scale_decimals, SCALE_DECIMALS),
        )
        self._recall()

    # -- clock and Sun -------------------------------------------------------------------------

    def utc_s(self) -> float:
        """The stand-in's clock: the laptop's, corrected by ``set_clock``."""
        return self._clock.utc_s() + self._unit_minus_laptop_s

    def set_clock(self, utc_s: float) -> None:
        """It is ``utc_s`` now. Not kept beyond this program: a laptop set right later would else be
        corrected twice."""
        self._unit_minus_laptop_s = utc_s - self._clock.utc_s()

    def set_clock_as(self, before: "SoftwareControllerModel") -> None:
        """Go on with the clock of before a lost line, as a controller's own would have."""
        self._unit_minus_laptop_s = before._unit_minus_laptop_s

    def ideal_deg(self, utc_s: float) -> tuple[float, float]:
        """The Sun's axis angles as a SolarTrak computes them."""
        return ideal_axes_deg(self.geometry, self.unit_site.site, utc_s)

    def sun_elevation_deg(self, utc_s: float) -> float:
        """Elevation of that Sun."""
        return float(ideal_and_elevation_deg(self.geometry, self.unit_site.site, utc_s)[2])

    def demand_sun(self, utc_s: float, request: str) -> None:
        """Refuse (UnitRefused) what needs a Sun above the horizon."""
        if self.sun_elevation_deg(utc_s) < 0.0:
            raise UnitRefused(Code.SUN_DOWN, "the Sun is below the horizon", request)

    # -- P and O -------------------------------------------------------------------------------

    @property
    def coefficients(self) -> Coefficients:
        return self._formula.coefficients

    @property
    def offsets(self) -> Offsets:
        return self._formula.offsets

    def target_deg(self, utc_s: float) -> tuple[float, float]:
        """The read-outs that belong to the Sun at an instant: ideal + E + O."""
        target1, target2 = self._formula.target_deg(*self.ideal_deg(utc_s))
        return float(target1), float(target2)

    def set_sun_offset(self, utc_s: float, reading1_deg: float, reading2_deg: float) -> Offsets:
        """O such that the read-outs are the Sun's at that instant; stored at once."""
        self.demand_sun(utc_s, "Set Sun Offset")
        offsets = self._formula.offsets_at(*self.ideal_deg(utc_s), reading1_deg, reading2_deg)
        self._hold(self._formula.holding(offsets=offsets))
        return self.offsets

    def write(self, coefficients: Coefficients, offsets: Offsets) -> Stored:
        """Store P and O, and what is stored now, read back from where it is stored."""
        self._hold(self._formula.holding(coefficients, offsets))
        self._recall()
        return self.stored()

    def use_for_now(self, coefficients: Coefficients) -> None:
        """These, and no O, until the line is closed; what is kept stays as it is."""
        self._store = MemoryStore()
        self._hold(self._formula.holding(coefficients, Offsets()))

    def stored(self) -> Stored:
        """P and O in force. There is one memory, and it survives: both of ``Stored`` are it."""
        return Stored(self.coefficients, self.offsets, self.coefficients, self.offsets)

    def _hold(self, formula: ControllerModel) -> None:
        # First stored, then in force: what the axes are driven by is never only in memory.
        self._store.keep(
            StoredCorrection(
                coefficients=formula.coefficients,
                offsets=formula.offsets,
                utc=format_utc(self._clock.utc_s()),
            )
        )
        self._formula = formula

    def _recall(self) -> None:
        stored = self._store.load()
        self._formula = msgspec.structs.replace(
            self._formula, coefficients=stored.coefficients, offsets=stored.offsets
        )
