"""What is noticed when a unit has just been connected: site, clock or Sun that are not ours."""

from collections.abc import Iterator

from solarcal.station.core import StationCore
from solarcal.station.unit_sun import check_unit_settings, check_unit_sun


def disagreements(station: StationCore) -> Iterator[str]:
    """Sentences, each with its number; none where unit and laptop agree. Reads one status."""
    status = station.poll()
    laptop_utc_s = station.clock.utc_s()
    if station.unit_site is None:
        return
    site = station.session.header.site
    yield from check_unit_settings(station.unit_site, site, status.unit_utc_s - laptop_utc_s)
    sun = check_unit_sun(station.unit_site, site, status, laptop_utc_s)
    if not sun.agrees:
        yield f"the unit's Sun is {sun.difference_deg:.3f} deg from ours: {sun.explanation}"
