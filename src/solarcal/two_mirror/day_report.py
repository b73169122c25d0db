"""What `solarcal two-mirror simulate` prints of a day, and its log as points."""

from dataclasses import asdict
from typing import Any

import numpy as np

from solarcal.session.points import PointTable
from solarcal.timescale import format_utc
from solarcal.two_mirror.day import MirrorDay, ZenithReport
from solarcal.units import wrap_deg


def day_document(day: MirrorDay) -> dict[str, Any]:
    """The JSON document of a simulated day."""
    solution, tuning, truth = day.solution, day.tuning, day.scenario.truth
    return {
        "scenario": day.scenario.name,
        "day": day.scenario.day,
        "target": day.scenario.target,
        "found_utc": None if day.found_utc_s is None else format_utc(day.found_utc_s, 0),
        "points": len(day.log),
        "largest_mrad": day.largest_mrad,
        "near_zenith_deg": day.scenario.loop.near_zenith_deg,
        "stopped": day.stopped or None,
        "gains": None if tuning is None else tuning.gains_document(),
        "zenith": None if day.zenith is None else _zenith_document(day.zenith),
        "base": None
        if solution is None
        else {
            **asdict(solution.base),
            "sigma_deg": solution.sigma_deg,
            "sky_max_deg": solution.sky_max_deg,
        },
        "calculated_mode": None
        if solution is None
        else {
            "largest_mrad": float(day.calculated_mrad.max()),
            "field_mrad": truth.field_mrad,
            "within_field": bool(day.calculated_mrad.max() < 0.5 * truth.field_mrad),
        },
        "truth": asdict(truth.base()),
    }


def _zenith_document(zenith: ZenithReport) -> dict[str, Any]:
    found = asdict(zenith)
    instants = {
        name: format_utc(found.pop(f"{name}_s"), 0) for name in ("enters_utc", "leaves_utc")
    }
    return instants | found


def day_lines(day: MirrorDay) -> list[str]:
    """The same for a reader, 80 columns wide."""
    truth, solution, tuning, zenith = (
        day.scenario.truth,
        day.solution,
        day.tuning,
        day.zenith,
    )
    moon = ", the Moon" if day.scenario.target == "moon" else ""
    lines = [f"{day.scenario.name}, {day.scenario.day}{moon}"]
    if day.scenario.summary:
        lines.append(day.scenario.summary)
    if tuning is not None:
        lines.append(
            f"Loop: Kc {tuning.critical_gain:.3f} 1/s, Tc {tuning.critical_period_s:.2f} s -> Kp "
            f"{tuning.gains.kp:.3f}, Ki {tuning.gains.ki:.3f}, Kd {tuning.gains.kd:.3f}"
        )
    if day.found_utc_s is not None:
        lines.append(f"Spot centred first at {format_utc(day.found_utc_s, 0)}")
    if day.stopped:
        lines.append(f"STOPPED: {day.stopped}")
    if day.largest_mrad is not None:
        lines.append(
            f"Spot, from {day.scenario.loop.near_zenith_deg:g} deg off the zenith down to "
            f"elevation 5 deg: at most {day.largest_mrad:.2f} mrad"
        )
    if zenith is not None:
        lines += _zenith_lines(zenith)
    if solution is None:
        lines.append(f"Log: {len(day.log)} points, too few for the Euler angles")
        return lines
    lines.append(f"Log: {len(day.log)} points; Euler angles fitted back (truth):")
    base = solution.base
    for name, value, true in (
        ("alpha", base.alpha_deg, truth.alpha_deg),
        ("beta ", base.beta_deg, truth.beta_deg),
        ("gamma", base.gamma_deg, truth.gamma_deg),
    ):
        lines.append(f"  {name} {value:+9.4f} deg  ({true:+9.4f})")
    lines.append(
        f"Calculated mode with them: spot at most {day.calculated_mrad.max():.2f} mrad off, "
        f"field {truth.field_mrad:g} mrad"
    )
    return lines


def _zenith_lines(zenith: ZenithReport) -> list[str]:
    minutes = (zenith.leaves_utc_s - zenith.enters_utc_s) / 60.0
    back = (
        f"{zenith.back_after_s:.0f} s after leaving it"
        if np.isfinite(zenith.back_after_s)
        else "NOT before the end of the day"
    )
    return [
        f"Near the zenith {format_utc(zenith.enters_utc_s, 0)[11:19]} to "
        f"{format_utc(zenith.leaves_utc_s, 0)[11:19]} UTC ({minutes:.1f} min), azimuth calculated:",
        f"  nearest {zenith.nearest_zenith_deg:.2f} deg to the zenith, "
        f"{zenith.nearest_axis_deg:.2f} deg to its own axis",
        f"  dead time {zenith.dead_time_s:.0f} s with the spot beyond 2 mrad (at most "
        f"{zenith.largest_mrad:.1f} mrad)",
        f"  back within 2 mrad {back}; azimuth turned back by "
        f"{zenith.largest_reversal_deg:.3f} deg",
    ]


def day_table(day: MirrorDay) -> PointTable:
    """The log as a table of points: ideal axes of the Sun, and read-out minus ideal."""
    n = len(day.log)
    rows = np.array([[p.utc_s, p.sun1_deg, p.sun2_deg, p.axis1_deg, p.axis2_deg] for p in day.log])
    utc_s, sun1, sun2, axis1, axis2 = rows.reshape(-1, 5).T
    # The Sun passes the North in the South: the branch about 180 is the unbroken one there.
    centre_deg = 180.0 if day.scenario.site.latitude_deg < 0.0 else 0.0
    site = day.scenario.site
    return PointTable(
        geometry="azel",
        latitude_deg=site.latitude_deg,
        longitude_deg=site.longitude_deg,
        elevation_m=site.elevation_m,
        unit=day.scenario.name,
        ax1_centre_deg=centre_deg,
        ideal="apparent",
        utc_s=utc_s,
        ax1_deg=wrap_deg(sun1, centre_deg),
        ax2_deg=sun2,
        err1_deg=wrap_deg(axis1 - sun1),
        err2_deg=axis2 - sun2,
        sigma_deg=None,
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=("",) * n,
        labels=tuple(range(1, n + 1)),
        sources=(day.scenario.name,) * n,
    )
