"""A day of a two-mirror tracker: world and controller joined, and what came of it."""

import math
from dataclasses import dataclass

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError
from solarcal.two_mirror.base import BaseModel, BaseSolution, LoggedPoint
from solarcal.two_mirror.control import PidGains
from solarcal.two_mirror.controller import LoopMode, MirrorController
from solarcal.two_mirror.diode import QuadrantDiode
from solarcal.two_mirror.mirrors import EulerBase
from solarcal.two_mirror.scenario import MirrorScenario
from solarcal.two_mirror.tuning import LoopTuning, tune
from solarcal.two_mirror.world import MirrorWorld
from solarcal.units import FloatArray

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
    if seed < 0:
        raise ConfigurationError(f"seed {seed} must not be negative")
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
    world: MirrorWorld,
    base_model: BaseModel,
    base: EulerBase,
    between_utc_s: tuple[float, float],
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
