"""What a SolarTrak computes for itself, computed by the station: clock, ideal angles, E + O.

A unit served this way has exactly the station's model, so it has the Sun model, the
formula and the offsets of the controller it lacks: ``reading = ideal + E(ideal; P) + O``.
"""

import msgspec

from solarcal.errors import UnitRefused
from solarcal.mount.controller import ControllerModel, ideal_and_elevation_deg, ideal_axes_deg
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import MountGeometry
from solarcal.mount.limits import Limits
from solarcal.mount_description import MountDescription
from solarcal.site import Site
from solarcal.station.described_unit import unit_parameters, unit_site
from solarcal.station.software_controller.coefficient_store import (
    CoefficientStore,
    MemoryStore,
    StoredCorrection,
)
from solarcal.timescale import Clock, format_utc
from solarcal.unit.tracker import Code, Stored, UnitParameters, UnitSite

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
        """Refuse what needs a Sun above the horizon.

        Raises
        ------
        UnitRefused
        """
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
