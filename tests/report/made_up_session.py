"""Made-up sessions: known coefficients, the controller's own Sun, seeded noise."""

import numpy as np

from solarcal.model.fit import fit_linear
from solarcal.model.points import Points
from solarcal.model.solution import Solution
from solarcal.mount.drive import RotaryDrive
from solarcal.mount.formula import Coefficients, Offsets, correction_deg
from solarcal.mount.geometry import AxisLimits, Limits, MountGeometry
from solarcal.session.records import Answers, Header, PointRecord, UnitRecord
from solarcal.site import Site
from solarcal.sun import sun_position
from solarcal.timescale import format_utc, parse_utc

TIJERAS = Site(35.05, -106.48, 1830.0, "Tijeras")
TRUTH = Coefficients(P1=0.4, P2=-0.25, P3=0.3, P4=0.15, P5=0.001, P6=-0.0008)
YES = Answers(ref_check=True, sun_offset=True, tracking=True)


def header_of(
    site: Site = TIJERAS,
    geometry: str = "azel",
    centre_deg: float = 0.0,
    limits: Limits | None = None,
    utc: str = "2026-06-21T13:00:00.000Z",
) -> Header:
    limits = limits or Limits(
        AxisLimits(centre_deg - 110.0, centre_deg + 110.0), AxisLimits(5.0, 85.0)
    )
    unit = UnitRecord(
        model="SolarTrak",
        serial="1",
        firmware="1.0",
        zone_west_h=7.0,
        drive1=RotaryDrive(counts_per_deg=200.0),
        drive2=RotaryDrive(counts_per_deg=200.0),
        limits=limits,
        update_range_deg=0.05,
        reference1_deg=0.0,
        reference2_deg=45.0,
        tilt_decimals=3,
        scale_decimals=5,
        site=site,
    )
    return Header(
        utc=utc,
        software="solarcal",
        unit=unit,
        site=site,
        geometry=geometry,
        ax1_centre_deg=centre_deg,
    )


def points_at(
    header: Header,
    instants: list[str],
    *,
    noise_deg: float = 0.02,
    first_seq: int = 10,
    status: str = "accepted",
) -> list[PointRecord]:
    geometry = MountGeometry(header.geometry, header.site.latitude_deg, header.ax1_centre_deg)
    random = np.random.default_rng(7)
    points = []
    for index, instant in enumerate(instants):
        sun = sun_position("solartrak", parse_utc(instant), header.site)
        ax1, ax2 = geometry.axes_from_horizontal(sun.azimuth_deg, sun.zenith_deg)
        e1, e2 = correction_deg(TRUTH, ax1, ax2)
        noise1, noise2 = random.normal(0.0, noise_deg, 2)
        error = (float(e1 + noise1 / np.sin(np.radians(ax2))), float(e2 + noise2))
        reading = (float(ax1) + error[0], float(ax2) + error[1])
        points.append(
            PointRecord(
                seq=first_seq + 3 * index,
                utc=format_utc(parse_utc(instant) + 20.0),
                read_utc=format_utc(parse_utc(instant)),
                status=status,  # type: ignore[arg-type]
                answers=YES,
                ideal_deg=(float(ax1), float(ax2)),
                reading_deg=reading,
                error_deg=error,
                counts=(round(200.0 * reading[0]), round(200.0 * (reading[1] - 45.0))),
                offsets=Offsets(*error),
            )
        )
    return points


def fit_points(header: Header, points: list[PointRecord]) -> Solution:
    used = [p for p in points if p.status == "accepted"]
    ideal = np.array([p.ideal_deg for p in used])
    error = np.array([p.error_deg for p in used])
    return fit_linear(
        Points(
            geometry=MountGeometry(
                header.geometry, header.site.latitude_deg, header.ax1_centre_deg
            ),
            ax1_deg=ideal[:, 0],
            ax2_deg=ideal[:, 1],
            err1_deg=error[:, 0],
            err2_deg=error[:, 1],
            labels=tuple(p.seq for p in used),
        ),
        limits=header.unit.limits,
    )


def hourly(day: str, first_h: int, last_h: int) -> list[str]:
    """Instants of one UTC day every hour; hours beyond 24 fall on the next day."""
    midnight = parse_utc(f"{day}T00:00:00Z")
    return [format_utc(midnight + 3600.0 * h) for h in range(first_h, last_h + 1)]
