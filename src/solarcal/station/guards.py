"""What the procedure does not allow, and why: pure rules, asked before anything is done."""

from solarcal.decimals import Pair
from solarcal.errors import ProcedureRefused
from solarcal.mount.geometry import from_limit
from solarcal.session.records import Header, UnitRecord
from solarcal.station import sun_path
from solarcal.timescale import clock_utc, format_utc
from solarcal.unit.tracker import Mode, Status


class GuardRefused(ProcedureRefused):
    """A guard the technician may overrule, with a reason that is recorded."""


class AxisStands(ProcedureRefused):
    """An axis is driven and does not move: first its motor and encoder are to be looked at."""


MIN_ELEVATION_DEG = 5.0
"""Below this the refraction of a real sky is too uncertain to fit (10 arcsec and more)."""

NEAR_LIMIT_DEG = 1.0
SOON_S = 6.0 * 3600.0


def near_limit_threshold_deg(update_range_deg: float) -> float:
    """Within one degree or two update ranges of a limit, the larger, nothing is initialised."""
    return max(NEAR_LIMIT_DEG, 2.0 * update_range_deg)


def distance_to_limits_deg(unit: UnitRecord, status: Status) -> float:
    """Distance of the read-outs to the nearest software limit of either axis."""
    limits = unit.limits
    if unit.typed:
        # What was typed may be old; the unit stands where it drives its axes.
        return float(limits.distance_deg(status.target1_deg, status.target2_deg))
    return float(limits.distance_deg(status.reading1_deg, status.reading2_deg))


def demand_clear_of_limits(header: Header, status: Status, step: str) -> float:
    """Distance to the nearest limit; ``ProcedureRefused`` when it is too near for ``step``."""
    distance = distance_to_limits_deg(header.unit, status)
    needed = near_limit_threshold_deg(header.unit.update_range_deg)
    if distance < needed:
        axes = "for this Sun the axes lie" if header.unit.typed else "the axes stand"
        raise GuardRefused(
            f"{step} refused: {axes} {from_limit(distance, 2)}, and {needed:.2f} deg inside it are "
            f"needed; wait until {back_words(header, status)}, or override with a reason"
        )
    return distance


def back_in_reach_s(header: Header, status: Status) -> float | None:
    """When the Sun is clear of the limits again and high enough for a point; ``None`` where it is
    now, or is not within a day."""
    needed = near_limit_threshold_deg(header.unit.update_range_deg)
    return sun_path.back_in_reach_s(header, status.unit_utc_s, needed, MIN_ELEVATION_DEG)


def back_words(header: Header, status: Status) -> str:
    """``the Sun is clear of it``, with the time, and the date where it is not within hours."""
    back_s = back_in_reach_s(header, status)
    if back_s is None:
        return "the Sun is clear of it"
    date = f"{format_utc(back_s)[:10]} " if back_s - status.unit_utc_s > SOON_S else ""
    return f"the Sun is clear of it, about {date}{clock_utc(back_s)}"


def demand_sun_high_enough(elevation_deg: float, step: str) -> None:
    if elevation_deg < MIN_ELEVATION_DEG:
        raise GuardRefused(
            f"{step} refused: the Sun is at {elevation_deg:z.1f} deg elevation, where "
            f"refraction is uncertain; wait until it is above {MIN_ELEVATION_DEG:.0f} deg"
        )


AT_LIMIT = "the unit waits at an axis limit, the Sun is beyond it; go on when it tracks again"


def demand_free_of_limits(status: Status) -> None:
    """What stands at a limit does not stand on the Sun."""
    if status.mode is Mode.LIMIT:
        raise ProcedureRefused(AT_LIMIT)


def demand_tracking(header: Header, status: Status) -> None:
    """A point needs a unit that tracks and has reached its target."""
    demand_free_of_limits(status)
    if status.mode is not Mode.TRACK:
        raise ProcedureRefused(
            f"the unit is in mode {status.mode}, not tracking; set it to TRACK and watch it "
            "for a minute first"
        )
    off = max(map(abs, status.off_target_deg))
    if off > 2.0 * header.unit.update_range_deg:
        raise ProcedureRefused(
            f"the axes stand {off:.3f} deg from where the unit drives them, more than two update "
            "ranges; let it settle, or look for a motor that does not run"
        )


def standing_axis(
    unit: UnitRecord, before: Status, status: Status, targets_deg: Pair | None = None
) -> str:
    """Which axis has not moved since ``before``, more than two update ranges from its target.

    ``targets_deg``: where the axes are driven; by default as the unit tells. Empty: neither stands.
    """
    targets_deg = targets_deg or (status.target1_deg, status.target2_deg)
    stands = zip(before.reading_deg, status.reading_deg, targets_deg, strict=True)
    for axis, (was_deg, now_deg, target_deg) in enumerate(stands, 1):
        off_deg = abs(now_deg - target_deg)
        if now_deg == was_deg and off_deg > 2.0 * unit.update_range_deg:
            return (
                f"axis {axis} does not move: it stands {off_deg:.1f} deg from where the unit "
                "drives it; look at its motor and encoder"
            )
    return ""
