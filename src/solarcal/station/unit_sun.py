"""Does the unit believe in the same Sun as we do?

The unit's own algorithm is known, so its ``ideal`` angles can be computed here from the clock, site
and zone it reports. Agreement proves that hour, zone, hemisphere and site are what they say;
disagreement is a wrong setting, and the one that explains it is searched for and named.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from solarcal.mount.controller import ideal_axes_deg
from solarcal.mount.geometry import MountGeometry
from solarcal.site import Site
from solarcal.unit.tracker import Status, UnitSite

AGREEMENT_DEG = 0.002
"""The wire carries milliseconds and 1e-5 deg; anything above this is another Sun."""

MATCH_DEG = 0.02
"""A hypothesis that brings the difference below this explains it."""


@dataclass(frozen=True, slots=True)
class UnitSunCheck:
    """Largest difference of the unit's ideal angles from ours on sky, and what explains it."""

    difference_deg: float
    explanation: str

    @property
    def agrees(self) -> bool:
        return self.difference_deg <= AGREEMENT_DEG


def _geometry(unit_site: UnitSite, latitude_deg: float) -> MountGeometry:
    return MountGeometry(unit_site.geometry, latitude_deg, unit_site.ax1_centre_deg)


def _difference_deg(unit_site: UnitSite, site: Site, utc_s: float, status: Status) -> float:
    geometry = _geometry(unit_site, site.latitude_deg)
    ax1, ax2 = ideal_axes_deg(geometry, site, utc_s, unit_site.heliostat)
    return float(geometry.sky_separation_deg(status.ideal1_deg, status.ideal2_deg, ax1, ax2))


def _hypotheses(
    told: Site, ours: Site, utc_s: float, laptop_utc_s: float
) -> Iterator[tuple[str, Site, float]]:
    def moved(latitude_deg: float, longitude_deg: float) -> Site:
        return Site(latitude_deg, longitude_deg, told.elevation_m)

    for hours in (1, -1, *(sign * h for h in range(2, 13) for sign in (1, -1))):
        yield (
            f"its clock or zone is off by {hours:+d} h (daylight-saving time, or the zone)",
            told,
            utc_s + 3600.0 * hours,
        )
    yield (
        "it uses the other hemisphere (sign of the latitude)",
        moved(-told.latitude_deg, told.longitude_deg),
        utc_s,
    )
    yield (
        "it takes the longitude with the wrong sign (east for west)",
        moved(told.latitude_deg, -told.longitude_deg),
        utc_s,
    )
    yield "it uses our site, not the one it reports", ours, utc_s
    yield "it uses another date or time than it reports (the laptop's fits)", told, laptop_utc_s
    for days in (1, -1):
        yield f"its date is off by {days:+d} day", told, utc_s + 86400.0 * days


def check_unit_sun(
    unit_site: UnitSite, ours: Site, status: Status, laptop_utc_s: float
) -> UnitSunCheck:
    """Compare the unit's ideal angles with ours for the clock, site and zone it reports."""
    told = unit_site.site
    difference = _difference_deg(unit_site, told, status.unit_utc_s, status)
    if difference <= AGREEMENT_DEG:
        return UnitSunCheck(difference, "the unit's Sun is ours")
    for words, site, utc_s in _hypotheses(told, ours, status.unit_utc_s, laptop_utc_s):
        if _difference_deg(unit_site, site, utc_s, status) <= MATCH_DEG:
            return UnitSunCheck(difference, f"the unit computes as if {words}")
    return UnitSunCheck(
        difference,
        "no single wrong hour, zone, hemisphere or site explains it; compare the unit's site, "
        "date and time with the truth one by one",
    )


def check_unit_settings(
    unit_site: UnitSite, ours: Site, unit_minus_laptop_s: float
) -> tuple[str, ...]:
    """Sentences about a unit whose site or clock is not ours; empty when they agree.

    A site wrong by 0.01 deg moves the Sun by as much; a clock by 24 s moves it 0.1 deg.
    """
    told = unit_site.site
    said: list[str] = []
    if abs(told.latitude_deg - ours.latitude_deg) > 0.005:
        word = (
            "the other hemisphere"
            if abs(told.latitude_deg + ours.latitude_deg) < 0.01
            else f"{abs(told.latitude_deg - ours.latitude_deg):.3f} deg away"
        )
        said.append(
            f"the unit's latitude is {told.latitude_deg:.4f}, ours {ours.latitude_deg:.4f}: {word}"
        )
    if abs(told.longitude_deg - ours.longitude_deg) > 0.005:
        said.append(
            f"the unit's longitude is {told.longitude_deg:.4f}, ours {ours.longitude_deg:.4f} "
            "(positive east)"
        )
    hours = round(unit_minus_laptop_s / 3600.0)
    if hours and abs(unit_minus_laptop_s - 3600.0 * hours) < 120.0:
        said.append(
            f"the unit's UTC differs from the laptop's by {hours:+d} h: its hour or its zone "
            f"({unit_site.zone_west_h:g} h west) is wrong, or the laptop's is"
        )
    elif abs(unit_minus_laptop_s) > 1.0:
        said.append(
            f"the unit's clock differs from the laptop's by {unit_minus_laptop_s:+.1f} s, "
            f"{abs(unit_minus_laptop_s) / 240.0:.3f} deg of Sun"
        )
    return tuple(said)
