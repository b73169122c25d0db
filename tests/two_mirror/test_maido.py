"""Scenario maido: a clear day of a two-mirror tracker in closed loop, and what it learns."""

import ast
import contextlib
import functools
import io
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import solarcal.two_mirror
from solarcal.cli import run_command
from solarcal.errors import ConfigurationError
from solarcal.session.interchange.csv_points import read_points_csv, write_points_csv
from solarcal.station.analysing import stamp_findings
from solarcal.sun.energy import disc_share
from solarcal.two_mirror.controller import LoopMode
from solarcal.two_mirror.day import MirrorDay, day_lines, day_table, simulate_day
from solarcal.two_mirror.scenario import load_mirror_scenario, mirror_scenario_names
from solarcal.two_mirror.tuning import tune
from solarcal.two_mirror.world import quadrant_parts

UPRIGHT = ("truth.beta_deg=0", "truth.gamma_deg=0")
LATE_NOVEMBER = "day=2024-11-28"
"""The Sun culminates 0.31 deg from the zenith of 21.1 S 55.4 E."""
ACROSS = (LATE_NOVEMBER, *UPRIGHT, "loop.period_s=2", "loop.believed_alpha_deg=9.5")
"""The base is turned but does not lean: 0.31 deg from the tracker's own axis too."""
KNOWN = (
    "loop.believed_alpha_deg=9.96", "loop.believed_beta_deg=0.888", "loop.believed_gamma_deg=0.174",
)  # fmt: skip
"""The base as it is: the day begins centred."""
LEANING = ("day=2026-11-25", "loop.period_s=2", "loop.believed_alpha_deg=9.5")


@functools.cache
def day(*settings: str) -> MirrorDay:
    return simulate_day(load_mirror_scenario("maido", list(settings)))


# -- the whole day ---------------------------------------------------------------------------


def test_the_scenario_is_maido_with_the_published_base() -> None:
    scenario = load_mirror_scenario("maido")
    assert (scenario.site.latitude_deg, scenario.site.longitude_deg) == (-21.1, 55.4)
    truth = scenario.truth
    assert (truth.alpha_deg, truth.beta_deg, truth.gamma_deg) == (9.96, 0.888, 0.174)
    assert scenario.loop.believed().alpha_deg == 0.0
    assert mirror_scenario_names() == ["maido"]


def test_about_100_points_are_logged_on_a_clear_day() -> None:
    assert day().stopped == ""
    assert 95 <= len(day().log) <= 105


def test_the_euler_angles_are_fitted_back_within_a_twentieth_of_a_degree() -> None:
    """9.96, 0.888, 0.174 deg; and not by chance: within 0.01 deg here."""
    solution = day().solution
    assert solution is not None
    found = (solution.base.alpha_deg, solution.base.beta_deg, solution.base.gamma_deg)
    assert found == pytest.approx((9.96, 0.888, 0.174), abs=0.01)
    assert solution.sky_max_deg < 0.02


def test_the_calculated_mode_then_stays_within_the_diodes_20_mrad() -> None:
    """20 mrad across: 10 to either side, and even the whole Sun is in (5.35)."""
    calculated = day().calculated_mrad
    assert len(calculated) > 600
    assert calculated.max() < 5.35


def test_a_september_day_has_no_near_zenith_passage() -> None:
    assert day().zenith is None


def test_a_day_in_calculated_mode_with_the_fitted_angles() -> None:
    """The loop itself, with its motors, never looking at the diode."""
    solution = day().solution
    assert solution is not None
    base = solution.base
    calculated = day(
        "loop.control=calculated",
        "loop.period_s=4",
        f"loop.believed_alpha_deg={base.alpha_deg!r}",
        f"loop.believed_beta_deg={base.beta_deg!r}",
        f"loop.believed_gamma_deg={base.gamma_deg!r}",
    )
    assert set(calculated.track.modes) == {LoopMode.CALCULATED}
    assert calculated.largest_mrad is not None
    assert calculated.largest_mrad < 2.0


def test_before_the_fit_it_would_not() -> None:
    """With the base as believed in the morning the spot is ten degrees off: it was searched."""
    modes = day().track.modes
    assert modes.index(LoopMode.SEARCH) < modes.index(LoopMode.PID)
    assert modes.count(LoopMode.SEARCH) > 300


@pytest.mark.parametrize("settings", [(), ACROSS, LEANING], ids=str)
def test_the_spot_stays_within_2_mrad(settings: tuple[str, ...]) -> None:
    """Between 3 deg from the zenith and elevation 5 deg, by the world's own count."""
    track = day(*settings).track
    outside = track.outside(3.0)
    assert len(outside) * (track.utc_s[1] - track.utc_s[0]) > 35_000.0
    assert outside.max() < 2.0
    assert day(*settings).largest_mrad == outside.max()


# -- near the zenith -------------------------------------------------------------------------


def test_late_november_passes_three_tenths_of_a_degree_from_the_zenith() -> None:
    zenith = day(*ACROSS).zenith
    assert zenith is not None
    assert zenith.nearest_zenith_deg == pytest.approx(0.3, abs=0.02)
    assert zenith.nearest_axis_deg == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize("settings", [ACROSS, LEANING], ids=str)
def test_inside_3_deg_azimuth_is_calculated_and_never_turns_back(
    settings: tuple[str, ...],
) -> None:
    track = day(*settings).track
    inside = np.flatnonzero(np.minimum(track.zenith_deg, track.from_axis_deg) < 3.0)
    assert len(inside) > 500
    assert {track.modes[n] for n in inside} == {LoopMode.ZENITH}
    turned = np.diff(track.axis1_deg[inside])
    assert (turned >= 0.0).all() or (turned <= 0.0).all()
    assert abs(turned.sum()) > 100.0
    zenith = day(*settings).zenith
    assert zenith is not None
    assert zenith.largest_reversal_deg == 0.0


@pytest.mark.parametrize("settings", [ACROSS, LEANING], ids=str)
def test_within_5_min_of_leaving_the_spot_is_back_within_2_mrad(settings: tuple[str, ...]) -> None:
    result = day(*settings)
    zenith, track = result.zenith, result.track
    assert zenith is not None
    assert zenith.back_after_s < 300.0
    after = (track.utc_s > zenith.leaves_utc_s + 300.0) & (track.zenith_deg < 85.0)
    assert track.spot_mrad[after].max() < 2.0


def test_the_dead_time_is_what_the_slow_axis_costs() -> None:
    """0.3 deg/s cannot follow the azimuth at 0.3 deg from the zenith (0.75 deg/s): minutes."""
    result = day(*ACROSS)
    zenith, track = result.zenith, result.track
    assert zenith is not None
    near = (track.utc_s >= zenith.enters_utc_s) & (track.utc_s < zenith.leaves_utc_s)
    assert zenith.dead_time_s == 2.0 * (track.spot_mrad[near] > 2.0).sum()
    assert 60.0 < zenith.dead_time_s < 600.0


# -- what can be wrong -----------------------------------------------------------------------


@pytest.mark.parametrize("flip", ["truth.flip1=true", "truth.flip2=true"])
@pytest.mark.parametrize("control", ["pid", "step"])
@pytest.mark.parametrize("start", ["from the edge", "from the centre"])
def test_a_flipped_quadrant_sign_is_noticed_stopped_and_said(
    flip: str, control: str, start: str
) -> None:
    """Whether the search finds the spot or the base was known and it begins centred."""
    settings = [flip, f"loop.control={control}", *(KNOWN if start == "from the centre" else ())]
    result = simulate_day(load_mirror_scenario("maido", settings))
    assert "sign" in result.stopped
    assert result.track.modes[-1] is LoopMode.STOPPED
    assert len(result.track.modes) < 3600
    stands = result.track.axis1_deg[-30:]
    assert np.ptp(stands) < 1e-6


def test_a_cloud_is_waited_for_and_the_spot_found_again() -> None:
    """Twenty minutes without Sun, with steps and behind three fixed mirrors."""
    scenario = load_mirror_scenario(
        "maido",
        [
            "loop.control=step",
            "loop.period_s=2",
            "truth.clouds=[[150, 170]]",
            "truth.fixed_mirrors=[[0, 1, -1], [1, -1, 0], [1, 0, -1]]",
        ],
    )
    result = simulate_day(scenario)
    track = result.track
    minutes = (track.utc_s - track.utc_s[0]) / 60.0
    assert result.stopped == ""
    cloud = {mode for mode, m in zip(track.modes, minutes, strict=True) if 152.0 < m < 170.0}
    assert cloud <= {LoopMode.WAIT, LoopMode.SEARCH}
    later = (minutes > 180.0) & (track.zenith_deg < 85.0)
    assert track.spot_mrad[later].max() < 2.0


# -- tuning ----------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [1, 2])
def test_the_critical_gain_is_that_of_the_motor_and_the_sampling(axis: int) -> None:
    """First-order lag 0.6 s sampled every second. With a = exp(-1/0.6), g = 1 - 0.6(1 - a) and
    h = 0.6(1 - a) the loop is [[1 - K g, h], [-K(1 - a), a]]; its determinant is 1 at
    K = (1 - a)/(h (1 - a) - g a), where it swings with the period 2 pi/acos(trace/2)."""
    a = math.exp(-1.0 / 0.6)
    h = 0.6 * (1.0 - a)
    g = 1.0 - h
    critical = (1.0 - a) / (h * (1.0 - a) - g * a)
    period = 2.0 * math.pi / math.acos(0.5 * (1.0 - critical * g + a))
    found = tune(load_mirror_scenario("maido"), axis=axis)
    assert found.critical_gain == pytest.approx(critical, rel=0.05)
    assert found.critical_period_s == pytest.approx(period, rel=0.03)


def test_the_gains_are_ziegler_and_nichols() -> None:
    found = tune(load_mirror_scenario("maido"))
    gains = found.gains
    assert gains.kp == pytest.approx(0.6 * found.critical_gain)
    assert gains.ki == pytest.approx(2.0 * gains.kp / found.critical_period_s)
    assert gains.kd == pytest.approx(gains.kp * found.critical_period_s / 8.0)


def test_gains_that_make_a_slowly_sampled_loop_swing_are_reduced() -> None:
    """At 2 s the motor's lag hides behind the sampling, and the rules give too much."""
    found = tune(load_mirror_scenario("maido", ["loop.period_s=2"]))
    assert found.reduced < 1.0
    assert found.gains.kp == pytest.approx(found.reduced * 0.6 * found.critical_gain)
    assert tune(load_mirror_scenario("maido")).reduced == 1.0


def test_a_reversed_diode_cannot_be_tuned() -> None:
    with pytest.raises(ConfigurationError, match="reversed"):
        tune(load_mirror_scenario("maido", ["truth.flip2=true"]))


# -- the world -------------------------------------------------------------------------------


def test_the_light_of_a_disc_on_four_quadrants() -> None:
    """Against counting a fine grid."""
    x, y = np.meshgrid(*(2 * [(np.arange(1200) + 0.5) / 600.0 - 1.0]))
    inside = x**2 + y**2 < 1.0
    for u1, u2 in ((0.0, 0.0), (0.3, -0.5), (-0.7, -0.6), (0.9, 0.8), (-0.8, 0.9), (1.2, 0.1)):
        right, top = (x + u1)[inside] > 0.0, (y + u2)[inside] > 0.0
        counted = ((~right & top).mean(), (right & top).mean(), (right & ~top).mean(),
                   (~right & ~top).mean())  # fmt: skip
        assert quadrant_parts(u1, u2) == pytest.approx(counted, abs=1e-3)


def test_the_field_lets_the_sun_through_until_it_passes_its_edge() -> None:
    assert disc_share(0.0, 4.65, 10.0) == 1.0
    assert disc_share(5.35, 4.65, 10.0) == pytest.approx(1.0)
    assert 0.4 < disc_share(10.0, 4.65, 10.0) < 0.5
    assert disc_share(14.65, 4.65, 10.0) == 0.0


@pytest.mark.parametrize(
    ("module", "stranger"),
    [
        ("controller", "world"),
        ("base", "world"),
        ("world", "controller"),
    ],
)
def test_hidden_truth_and_controller_do_not_know_each_other(module: str, stranger: str) -> None:
    source = Path(solarcal.two_mirror.__path__[0]) / f"{module}.py"
    names = {
        name
        for node in ast.walk(ast.parse(source.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        for name in (node.module, *(alias.name for alias in node.names))
    }
    assert not {n for n in names if n and (stranger in n or n == "MirrorTruth")} or (
        module == "world" and not any(n and stranger in n for n in names)
    )


def test_the_same_seed_is_the_same_day_and_another_is_not() -> None:
    def spots(seed: int) -> list[float]:
        scenario = load_mirror_scenario("maido", ["truth.flip1=true", *KNOWN])
        return simulate_day(scenario, seed=seed).track.spot_mrad.tolist()

    assert spots(3) == spots(3)
    assert spots(3) != spots(4)


# -- the command -----------------------------------------------------------------------------


def test_the_dead_time_is_printed() -> None:
    result = day(*ACROSS)
    assert result.zenith is not None
    lines = day_lines(result)
    assert "  nearest 0.31 deg to the zenith, 0.31 deg to its own axis" in lines
    assert any(f"dead time {result.zenith.dead_time_s:.0f} s" in line for line in lines)
    assert max(map(len, lines)) <= 80


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The log of 12 September 2011, and what its simulation says of it."""
    log = tmp_path_factory.mktemp("maido") / "maido.csv"
    words = ["--day", "2011-09-12", "--set", "loop.period_s=3", "--set", "loop.control=step"]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        assert run_command(["two-mirror", "simulate", *words, "--log", str(log), "--json"]) == 0
    return log, json.loads(printed.getvalue())


def test_the_log_goes_back_through_fit(
    logged: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    log, simulated = logged
    assert run_command(["two-mirror", "fit", str(log), "--json"]) == 0
    fitted = json.loads(capsys.readouterr().out)
    assert fitted["points"] == simulated["points"]
    for angle in ("alpha_deg", "beta_deg", "gamma_deg"):
        assert fitted["base"][angle] == pytest.approx(simulated["base"][angle], abs=1e-6)
    assert fitted["warnings"] == []


def test_time_stamps_that_disagree_with_the_angles_are_a_warning_of_the_fit(
    logged: tuple[Path, dict[str, Any]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, late = read_points_csv(logged[0]), tmp_path / "late.csv"
    write_points_csv(replace(table, utc_s=table.utc_s + 3600.0), late)
    assert run_command(["two-mirror", "fit", str(late), "--json"]) == 0
    (warning,) = json.loads(capsys.readouterr().out)["warnings"]
    assert "the time stamps are 3600 s late" in warning


def test_a_log_replaces_no_file(
    logged: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    log, _ = logged
    before = log.read_bytes()
    assert run_command(["two-mirror", "simulate", "--log", str(log)]) == 2
    assert "exists already" in capsys.readouterr().err
    assert log.read_bytes() == before


def test_a_stopped_loop_is_exit_code_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command(["two-mirror", "simulate", "--set", "truth.flip1=true"]) == 1
    assert "STOPPED" in capsys.readouterr().out


def test_point_and_trace_and_fov_as_documents(capsys: pytest.CaptureFixture[str]) -> None:
    def document(*words: str) -> dict[str, float]:
        assert run_command(["two-mirror", *words, "--json"]) == 0
        return dict(json.loads(capsys.readouterr().out))

    point = document("point", "--azimuth", "90", "--zenith", "30")
    assert (point["t1_deg"], point["t2_deg"]) == pytest.approx((90.0, 30.0))
    placed = document("point", "--lat=-21.1", "--lon=55.4", "--at", "2026-09-12T08:00:00Z")
    assert placed["t2_deg"] == pytest.approx(placed["zenith_deg"])
    trace = document("trace", "--signals", "1", "1", "1", "1", "--t1", "10", "--t2", "50")
    assert trace["correction1_deg"] == pytest.approx(0.0)
    fov = document("fov")
    assert fov["field_mrad"] == pytest.approx(20.0, abs=0.01)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["point", "--azimuth", "0", "--zenith", "95"], "below the horizon"),
        (["point", "--azimuth", "0"], "--zenith"),
        (["point", "--lat=0", "--lon=0", "--at", "2026-06-21T00:00:00Z"], "below the horizon"),
        (["trace", "--signals", "0", "0", "0", "0", "--t1", "0", "--t2", "9"], "no light"),
        (["trace", "--signals", "1", "1", "1", "1", "--t1", "0", "--t2", "9", "--mirror",
          "0,0,0"], "zero length"),
        (["trace", "--signals", "1", "1", "1", "1", "--t1", "0", "--t2", "9", "--mirror",
          "up"], "write 3 numbers"),
        (["fov", "--focal-length", "0"], "focal length"),
        (["fit", "nowhere.csv"], "is missing: no such file"),
        (["simulate", "--scenario", "mauna"], "there is: maido"),
        (["simulate", "--set", "truth.alpha=1"], "truth.alpha_deg"),
        (["simulate", "--set", "loop.period_s=0"], "between 0.1 and 10"),
        (["simulate", "--set", "truth.fixed_mirrors=[[0, 1, 0.5]]"], "along the tracker's axis"),
        (["simulate", "--day", "soon"], "soon"),
        (["tune", "--set", "site.latitude_deg=85"], "30 deg high"),
    ],
)  # fmt: skip
def test_bad_input_is_one_clear_line(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command(["two-mirror", *words]) == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert said in told.err
    assert told.err.count("\n") == 1


def test_too_few_positions_are_one_clear_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = tmp_path / "few.csv"
    few.write_text(
        "# geometry=azel\n# lat_deg=-21.1\n# lon_deg=55.4\n"
        "utc,ax1_deg,ax2_deg,err1_deg,err2_deg\n"
        ",100,50,9.9,0.1\n,110,40,9.8,0.1\n"
    )
    assert run_command(["two-mirror", "fit", str(few)]) == 2
    assert "at least 3" in capsys.readouterr().err


# -- the Moon, and the panels of the fit -----------------------------------------------------


def test_the_moon_is_followed_and_gives_the_base_back() -> None:
    moon = day("target=moon", "day=2026-01-03")
    assert not moon.stopped
    assert moon.largest_mrad is not None
    assert moon.largest_mrad < 1.0
    assert moon.solution is not None
    assert moon.solution.base.alpha_deg == pytest.approx(9.96, abs=0.005)
    assert moon.solution.base.beta_deg == pytest.approx(0.888, abs=0.005)
    assert moon.solution.base.gamma_deg == pytest.approx(0.174, abs=0.005)
    assert day_lines(moon)[0] == "maido, 2026-01-03, the Moon"
    # Its angles are not the Sun's at that time.
    assert stamp_findings(day_table(moon)) == ()


def test_a_thin_moon_is_refused_and_an_unknown_target_too() -> None:
    with pytest.raises(ConfigurationError, match="the Moon is 2% lit"):
        day("target=moon", "day=2026-01-17")
    with pytest.raises(ConfigurationError, match="target must be one of sun, moon"):
        load_mirror_scenario("maido", ["target=mars"])


def test_the_fit_shows_calculated_against_actual_before_and_after(
    logged: tuple[Path, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    """The published base of that day: ten degrees before, at most 0.5 after."""
    log, _ = logged
    assert run_command(["two-mirror", "fit", str(log), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert 9.0 < document["before_max_deg"] < 11.5
    assert document["sky_max_deg"] < 0.5
    assert run_command(["two-mirror", "fit", str(log), "--plot"]) == 0
    printed = capsys.readouterr().out
    titles = [line for line in printed.splitlines() if "● calculated" in line]
    assert [title.split(" the fit")[0] for title in titles] == [
        "axis 1 before", "axis 1 after", "axis 2 before", "axis 2 after",
    ]  # fmt: skip
    # After the fit the dots cover the line on which both are equal; before it they lie beside it.
    before, after = printed.split("axis 1 before")[1].split("axis 2")[0].split("axis 1 after")
    assert before.count("·") > 3 * after.count("·")
