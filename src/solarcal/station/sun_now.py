"""The Sun as the unit computes it and the true Sun, at the instant of a status."""

from dataclasses import dataclass

from solarcal.station.state import LiveView, SessionView
from solarcal.sun import sun_position


@dataclass(frozen=True, slots=True)
class SunNow:
    """Azimuth from north through east; degrees; ``precise`` apparent, for the laptop's UTC.

    ``unit_*`` is where the unit's ideal angles point, ``None`` without a status.
    """

    azimuth_deg: float
    elevation_deg: float
    solar_time_h: float
    unit_azimuth_deg: float | None = None
    unit_elevation_deg: float | None = None
    apart_deg: float | None = None


def sun_now(session: SessionView, live: LiveView) -> SunNow | None:
    """Both Suns; ``None`` while the laptop's clock at a status is not known."""
    if live.laptop_utc_s is None:
        return None
    header = session.header
    sun = sun_position(
        "precise", live.laptop_utc_s, header.site, refraction="hughes", weather=header.weather
    )
    azimuth, elevation = float(sun.azimuth_deg), 90.0 - float(sun.zenith_deg)
    status = live.status
    if status is None:
        return SunNow(azimuth, elevation, float(sun.solar_time_h))
    geometry = session.geometry
    unit_azimuth, unit_zenith = geometry.horizontal_from_axes(status.ideal1_deg, status.ideal2_deg)
    aim = (azimuth, float(sun.zenith_deg))
    if header.unit.heliostat is not None:
        aim = header.unit.heliostat.true_normal_deg(*aim)
        unit_azimuth, unit_zenith = (
            float(angle) for angle in header.unit.heliostat.sun_deg(unit_azimuth, unit_zenith)
        )
    ax1, ax2 = geometry.axes_from_horizontal(*aim)
    apart = geometry.sky_separation_deg(status.ideal1_deg, status.ideal2_deg, ax1, ax2)
    return SunNow(
        azimuth,
        elevation,
        float(sun.solar_time_h),
        float(unit_azimuth),
        90.0 - float(unit_zenith),
        float(apart),
    )
