"""What any controller computes: where the Sun is for its axes, and where it drives them.

    reading = ideal + E(ideal; P in force) + O

An emulated unit, a rotator that the station drives, a display that a person reads and the checks of
the procedure use this one model. Angles are axis degrees, AX1 on its branch.

References
----------
SolarTrak controller manual, appendix A: the Sun (``sun.appendix_a``); its correction is
``mount.formula``.
"""

from typing import Protocol

import msgspec

from solarcal.decimals import Pair
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import Limits, MountGeometry
from solarcal.site import Site
from solarcal.sun.appendix_a import horizontal_deg
from solarcal.units import Angles


class Aim(Protocol):
    """What a heliostat turns to instead of the Sun: the normal that reflects it to a target."""

    def controller_normal_deg(
        self, sun_azimuth_deg: Angles, sun_zenith_deg: Angles, /
    ) -> tuple[Angles, Angles]:
        """(azimuth, zenith angle) of the normal as the controller computes it."""
        ...


def ideal_and_elevation_deg(
    geometry: MountGeometry, site: Site, utc_s: Angles, aim: Aim | None = None
) -> tuple[Angles, Angles, Angles]:
    """AX1, AX2 of the Sun a controller at ``site`` computes for ``utc_s``, and its elevation.

    ``utc_s`` is a float or an array (n,); so is each result. With ``aim``: AX1, AX2 of the normal
    that reflects this Sun to the target; the elevation is the Sun's.
    """
    sun = horizontal_deg(utc_s, site.latitude_deg, site.longitude_deg)
    ax1, ax2 = geometry.axes_from_horizontal(
        *(sun if aim is None else aim.controller_normal_deg(*sun))
    )
    return ax1, ax2, 90.0 - sun[1]


def ideal_axes_deg(
    geometry: MountGeometry, site: Site, utc_s: float, aim: Aim | None = None
) -> Pair:
    """AX1 on the branch and AX2 of ``ideal_and_elevation_deg`` at one instant."""
    ax1, ax2, _ = ideal_and_elevation_deg(geometry, site, utc_s, aim)
    return float(ax1), float(ax2)


class ControllerModel(msgspec.Struct, frozen=True):
    """P and O in force, the limits, and how many decimals are stored of P1..P4 and O, and P5, P6.

    Methods take floats, or arrays (n,) that broadcast together, and give the same.
    """

    limits: Limits
    tilt_decimals: int = 4
    scale_decimals: int = 6
    coefficients: Coefficients = Coefficients()
    offsets: Offsets = Offsets()

    def corrected_deg(self, ideal1_deg: Angles, ideal2_deg: Angles) -> tuple[Angles, Angles]:
        """ideal + E: read-outs before the reference offsets."""
        e1, e2 = correction_deg(self.coefficients, ideal1_deg, ideal2_deg)
        return ideal1_deg + e1, ideal2_deg + e2

    def target_deg(self, ideal1_deg: Angles, ideal2_deg: Angles) -> tuple[Angles, Angles]:
        """ideal + E + O: the read-outs the axes are driven to."""
        corrected1, corrected2 = self.corrected_deg(ideal1_deg, ideal2_deg)
        return corrected1 + self.offsets.O1, corrected2 + self.offsets.O2

    def offsets_at(
        self, ideal1_deg: float, ideal2_deg: float, reading1_deg: float, reading2_deg: float
    ) -> Offsets:
        """O, before it is rounded, with which these read-outs are the target."""
        corrected1, corrected2 = self.corrected_deg(ideal1_deg, ideal2_deg)
        return Offsets(reading1_deg - float(corrected1), reading2_deg - float(corrected2))

    def holding(
        self, coefficients: Coefficients | None = None, offsets: Offsets | None = None
    ) -> "ControllerModel":
        """The model with P, O or both as this controller stores them: rounded, without -0."""
        new_p = self.coefficients if coefficients is None else coefficients
        new_o = self.offsets if offsets is None else offsets
        return msgspec.structs.replace(
            self,
            coefficients=new_p.rounded(self.tilt_decimals, self.scale_decimals),
            offsets=new_o.rounded(self.tilt_decimals),
        )


def commanded_error_deg(
    coefficients: Coefficients, offsets: Offsets, ideal1_deg: float, ideal2_deg: float
) -> Pair:
    """E + O at these ideal angles: the total correction a controller applies."""
    e1, e2 = correction_deg(coefficients, ideal1_deg, ideal2_deg)
    return float(e1) + offsets.O1, float(e2) + offsets.O2
