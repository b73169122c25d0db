"""What is noticed when a unit has just been connected: site, clock or Sun that are not ours."""

from collections.abc import Iterator

from solarcal.model.evidence.unit_state import check_unit_settings, check_unit_sun
from solarcal.mount.formula import COEFFICIENT_NAMES
from solarcal.station.core import StationCore


def disagreements(station: StationCore) -> Iterator[str]:
    """Sentences, each with its number; none where unit and laptop agree. Reads one status."""
    status = station.poll()
    laptop_utc_s = station.clock.utc_s()
    if station.unit_site is None:
        return
    site = station.session.header.site
    yield from check_unit_settings(station.unit_site, site, status.unit_utc_s - laptop_utc_s)
    sun = check_unit_sun(station.unit_site, site, status, laptop_utc_s)
    if not station.tracker.capabilities.has_link:
        yield from _typed_otherwise(station)
    if not sun.agrees:
        yield f"the unit's Sun is {sun.difference_deg:.3f} deg from ours: {sun.explanation}"


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
                f"{name} was typed {typed:g}, but this session knew it last as {before:g}: look at "
                "the display again; if it was a slip, leave and go on with the session anew"
            )
