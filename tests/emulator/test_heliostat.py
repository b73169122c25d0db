"""The scenario `heliostat`: the axes turn the mirror's normal, the beam on the board is the eye."""

import math

import numpy as np
import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import ConfigurationError
from solarcal.optics.offset_mirror import beam_miss_enu
from solarcal.optics.reflection import direction_enu
from solarcal.sun import sun_position


def emulated(*settings: str) -> Emulator:
    return Emulator(load_scenario("heliostat", list(settings)), seed=1, noise_deg=0.0)


PERFECT = [
    "truth.sun=solartrak", "truth.refraction=none", "truth.lean_deg=0", "truth.P2=0",
    "truth.P4=0", "truth.P5=0", "truth.P6=0",
]  # fmt: skip


def test_the_beam_of_the_worlds_normal_hits_the_board():
    """A ray traced from the true Sun over the mirror's true middle passes through the target."""
    emulator = emulated(*PERFECT)
    heliostat = emulator.world.truth.heliostat(emulator.scenario.unit.heliostat())
    assert heliostat is not None
    utc_s = emulator.world.start_utc_s + 3.0 * 3600.0
    ax1, ax2, elevation = emulator.world.sky.sun_now_deg(utc_s)
    normal = emulator.world.geometry.horizontal_from_axes(ax1, ax2)
    sun = sun_position("solartrak", utc_s, emulator.world.site)
    assert elevation == pytest.approx(sun.elevation_deg)
    miss = beam_miss_enu(
        direction_enu(sun.azimuth_deg, sun.zenith_deg),
        direction_enu(*normal),
        heliostat.offset.centre_enu(*normal),
        heliostat.target,
    )
    assert np.linalg.norm(miss) < 1e-6


def test_a_controller_that_knows_everything_keeps_the_beam_there():
    """What is left is the second order its formula leaves out: 0.001 deg."""
    truth = emulated(*PERFECT).truth()
    assert 0.0 < truth.day_max_deg < 0.001
    assert truth.year_rms_deg < 0.001


def test_a_mirror_that_stands_elsewhere_than_told_shows():
    """0.35 m of PivotRefl_Z forgotten at 120 m: up to half of atan(0.35 / 120) on the normal."""
    truth = emulated(*PERFECT, "unit.mirror_offset=[0.0, 0.0, 0.0]",
                     "truth.mirror_offset=[0.0, 0.0, 0.35]").truth()  # fmt: skip
    assert 0.02 < truth.day_max_deg < 0.5 * math.degrees(0.35 / 120.0) * 1.01


def test_the_spot_says_by_how_much_the_axes_must_move():
    """Axes standing where the true normal is but for a little: the eye sees exactly that little."""
    emulator = emulated(*PERFECT)
    ax1, ax2, _ = emulator.world.sky.sun_now_deg(emulator.world.start_utc_s)
    away = emulated(*PERFECT, f"truth.stands1_deg={ax1 - 0.3}", f"truth.stands2_deg={ax2 + 0.2}")
    seen = away.spot()
    assert seen.visible
    # To the motor's whole counts, 2000 to the degree.
    assert (seen.error1_deg, seen.error2_deg) == pytest.approx((0.3, -0.2), abs=1e-3)
    far = emulated(*PERFECT, f"truth.stands2_deg={ax2 + 3.0}")
    assert not far.spot().visible


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ("unit.target=[176.0, 78.0, 0.0]", "distance of the target"),
        ("unit.target=[176.0, 78.0, 0.2]", "behind the mirror"),
        ("unit.geometry=polar", "azel mount"),
        ("truth.mirror_offset=[500.0, 0.0, 0.0]", "behind the mirror"),
    ],
)
def test_a_heliostat_that_cannot_be_is_refused(setting, said):
    with pytest.raises(ConfigurationError, match=said):
        load_scenario("heliostat", [setting])
