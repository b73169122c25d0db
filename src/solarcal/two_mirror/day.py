"""A day of a two-mirror tracker: world and controller joined, what came of it, its log as points.

The document and the lines are those of `solarcal two-mirror simulate`.
"""

import math
from dataclasses import asdict, dataclass
from typing import Any

import msgspec
import numpy as np

from solarcal.decimals import counted
from solarcal.session.points import PointTable
from solarcal.timescale import format_utc, second_of_day
from solarcal.two_mirror.base import BaseModel, BaseSolution, LoggedPoint
from solarcal.two_mirror.control import PidGains
from solarcal.two_mirror.controller import LoopMode, MirrorController
from solarcal.two_mirror.diode import QuadrantDiode
from solarcal.two_mirror.mirrors import EulerBase
from solarcal.two_mirror.scenario import MirrorScenario
from solarcal.two_mirror.tuning import LoopTuning, tune
from solarcal.two_mirror.world import MirrorWorld
from solarcal.units import FloatArray, wrap_deg

FIRST_ELEVATION_DEG = 0.5
LEAST_ELEVATION_DEG = 5.0
CENTRED_MRAD = 2.0
STOPPED_AFTER_S = 60.0
CALCULATED_STEP_S = 60.0


@dataclass(frozen=True, slots=True, eq=False)
class MirrorTrack:
    """What happened at every update, (n,) arrays. ``spot_mrad``: true, from the set point."""

    utc_s: FloatArray
    zenith_deg: FloatArray
    from_axis_deg: FloatArray
    axis1_deg: FloatArray
    spot_mrad: FloatArray
    modes: tuple[LoopMode, ...]

    def outside(self, near_deg: float, since_utc_s: float = -math.inf) -> FloatArray:
        """``spot_mrad`` between that distance from the zenith and elevation 5 deg."""
        chosen = (self.zenith_deg > near_deg) & (self.zenith_deg < 90.0 - LEAST_ELEVATION_DEG)
        return self.spot_mrad[chosen & (self.utc_s >= since_utc_s)]


@dataclass(frozen=True, slots=True)
class ZenithReport:
    """A passage near the zenith. ``dead_time_s``: how long the spot was beyond 2 mrad for it."""

    enters_utc_s: float
    leaves_utc_s: float
    nearest_zenith_deg: float
    nearest_axis_deg: float
    largest_mrad: float
    dead_time_s: float
    back_after_s: float
    largest_reversal_deg: float


@dataclass(frozen=True, slots=True, eq=False)
class MirrorDay:
    """The result. ``solution``: the Euler angles fitted to the whole log, ``None`` if too short.

    ``calculated_mrad``: the spot's distance through the day if the axes stood where those angles
    say, (m,).
    """

    scenario: MirrorScenario
    track: MirrorTrack
    log: tuple[LoggedPoint, ...]
    solution: BaseSolution | None
    calculated_mrad: FloatArray
    tuning: LoopTuning | None
    zenith: ZenithReport | None
    stopped: str
    found_utc_s: float | None

    @property
    def largest_mrad(self) -> float | None:
        """Largest spot error between the near-zenith zone and elevation 5 deg, once found."""
        loop = self.scenario.loop
        # The calculated mode looks for nothing: all of its day counts.
        since_utc_s = -math.inf if loop.control == "calculated" else self.found_utc_s
        if since_utc_s is None:
            return None
        outside = self.track.outside(loop.near_zenith_deg, since_utc_s)
        return float(outside.max()) if outside.size else None


def simulate_day(scenario: MirrorScenario, *, seed: int = 0) -> MirrorDay:
    """Track a whole day from sunrise to sunset, fit the log, and try the calculated mode.

    The same seed gives the same day.

    Raises
    ------
    ConfigurationError
        The Sun does not rise that day, or no gains could be found for the loop.
    """
    site, loop, truth = scenario.site.place(), scenario.loop, scenario.truth
    useful, up = (scenario.above(at) for at in (LEAST_ELEVATION_DEG, FIRST_ELEVATION_DEG))
    first_utc_s, updates = up[0], int((up[1] - up[0]) / loop.period_s)
    # The gains were found while sky and wiring were right.
    faultless = msgspec.structs.replace(truth, flip1=False, flip2=False, clouds=[])
    bench = msgspec.structs.replace(scenario, truth=faultless)
    tuning = tune(bench, seed=seed) if loop.control == "pid" else None
    diode = QuadrantDiode.with_fixed_mirrors(truth.fixed_mirrors)
    sky = scenario.sky(first_utc_s - 60.0, up[1] + 60.0)
    controller = MirrorController(
        loop,
        site,
        diode,
        tuning.gains if tuning else PidGains(0.5 / loop.period_s),
        (truth.axis1_deg_s, truth.axis2_deg_s),
        truth.field_mrad,
        (useful[1] - useful[0]) / (loop.points + 1),
        sky if scenario.target == "moon" else None,
    )
    stands = controller.base_model.calculated_deg(first_utc_s)
    world = MirrorWorld(truth, site, sky, first_utc_s - 1.0, *stands, seed)
    track, found_utc_s = _run(world, controller, first_utc_s, updates, loop.period_s)
    solution = controller.base_model.solution
    return MirrorDay(
        scenario=scenario,
        track=track,
        log=tuple(controller.base_model.log),
        solution=solution,
        calculated_mrad=(
            calculated_mode_mrad(world, controller.base_model, solution.base, useful)
            if solution is not None
            else np.empty(0)
        ),
        tuning=tuning,
        zenith=_zenith_report(track, loop.near_zenith_deg),
        stopped=controller.message,
        found_utc_s=found_utc_s,
    )


def _run(
    world: MirrorWorld,
    controller: MirrorController,
    first_utc_s: float,
    updates: int,
    period_s: float,
) -> tuple[MirrorTrack, float | None]:
    """The loop itself, until sunset or a minute after it was stopped."""
    rows = np.empty((updates, 5))
    modes: list[LoopMode] = []
    found_utc_s: float | None = None
    stopped_s = 0.0
    for number in range(updates):
        utc_s = first_utc_s + number * period_s
        sun = world.sun_deg(utc_s)
        rates = controller.update(utc_s, world.signals(utc_s), *world.readings_deg())
        if found_utc_s is None and controller.base_model.log:
            found_utc_s = utc_s
        rows[number] = (
            utc_s,
            sun[1],
            world.base.axes_deg(*sun)[1],
            world.motors[0].angle_deg,
            math.hypot(*world.spot(utc_s)),
        )
        modes.append(controller.mode)
        world.run(*rates, period_s)
        if controller.mode is LoopMode.STOPPED:
            stopped_s += period_s
            if stopped_s > STOPPED_AFTER_S:
                break
    times, zenith, from_axis, axis1, spot = rows[: len(modes)].T
    return MirrorTrack(times, zenith, from_axis, axis1, spot, tuple(modes)), found_utc_s


def calculated_mode_mrad(
    world: MirrorWorld, base_model: BaseModel, base: EulerBase, between_utc_s: tuple[float, float]
) -> FloatArray:
    """The spot's distance, mrad, every minute, with both axes where the controller's Sun and a base
    put them: no diode, no lag."""
    times = np.arange(between_utc_s[0], between_utc_s[1], CALCULATED_STEP_S)
    spots = [
        world.spot_from(utc_s, *base.axes_deg(*base_model.sun_deg(utc_s)))
        for utc_s in times.tolist()
    ]
    return np.array([math.hypot(*spot) for spot in spots])


def _zenith_report(track: MirrorTrack, near_deg: float) -> ZenithReport | None:
    """The passage in near-zenith mode, or ``None`` when there was none."""
    inside = np.flatnonzero([mode is LoopMode.ZENITH for mode in track.modes])
    if not inside.size:
        return None
    first, last = int(inside[0]), int(inside[-1])
    period_s = float(track.utc_s[1] - track.utc_s[0])
    beyond = track.spot_mrad > CENTRED_MRAD
    after = np.flatnonzero(~beyond[last + 1 :])
    back_after_s = float(after[0] + 1) * period_s if after.size else math.inf
    end = last + 1 + (int(after[0]) if after.size else len(beyond) - last - 1)
    nearest_deg = np.minimum(track.zenith_deg, track.from_axis_deg)
    axis1 = track.axis1_deg[first : last + 1][nearest_deg[first : last + 1] < near_deg]
    forward = axis1 * (1.0 if axis1[-1:].sum() >= axis1[:1].sum() else -1.0)
    return ZenithReport(
        enters_utc_s=float(track.utc_s[first]),
        leaves_utc_s=float(track.utc_s[last]) + period_s,
        nearest_zenith_deg=float(track.zenith_deg[first : last + 1].min()),
        nearest_axis_deg=float(track.from_axis_deg[first : last + 1].min()),
        largest_mrad=float(track.spot_mrad[first:end].max()),
        dead_time_s=float(beyond[first:end].sum()) * period_s,
        back_after_s=back_after_s,
        largest_reversal_deg=float((np.maximum.accumulate(forward) - forward).max(initial=0.0)),
    )


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
    truth, solution = day.scenario.truth, day.solution
    tuning, zenith = day.tuning, day.zenith
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
        lines.append(f"Log: {counted(len(day.log), 'point')}, too few for the Euler angles")
        return lines
    lines.append(f"Log: {len(day.log)} points; Euler angles fitted back (truth):")
    true = asdict(truth.base())
    for name, value in asdict(solution.base).items():
        lines.append(f"  {name.removesuffix('_deg'):5} {value:+z9.4f} deg  ({true[name]:+z9.4f})")
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
        f"Near the zenith {second_of_day(zenith.enters_utc_s)} to "
        f"{second_of_day(zenith.leaves_utc_s)} UTC ({minutes:.1f} min), azimuth calculated:",
        f"  nearest {zenith.nearest_zenith_deg:.2f} deg to the zenith, "
        f"{zenith.nearest_axis_deg:.2f} deg to its own axis",
        f"  dead time {zenith.dead_time_s:.0f} s with the spot beyond 2 mrad (at most "
        f"{zenith.largest_mrad:.1f} mrad)",
        f"  back within 2 mrad {back}; azimuth turned back by "
        f"{zenith.largest_reversal_deg:.3f} deg",
    ]


def day_table(day: MirrorDay) -> PointTable:
    """The log as a table of points: ideal axes of the target, and read-out minus ideal.

    On the Moon without ``utc_s``: what compares instants and angles compares them with the Sun.
    """
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
        utc_s=np.full(n, np.nan) if day.scenario.target == "moon" else utc_s,
        stamp_utc_s=utc_s,
        ax1_deg=wrap_deg(sun1, centre_deg),
        ax2_deg=sun2,
        err1_deg=wrap_deg(axis1 - sun1),
        err2_deg=axis2 - sun2,
        status=("accepted",) * n,
        approach=((0, 0),) * n,
        note=("",) * n,
        labels=tuple(range(1, n + 1)),
        sources=(day.scenario.name,) * n,
    )
