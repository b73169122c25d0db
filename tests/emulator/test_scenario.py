"""Scenarios: found, read, set, and refused in one line."""

import pytest

from solarcal.emulator.scenario import DEFAULT_SCENARIO, load_scenario, scenario_names
from solarcal.emulator.settings import settings_of
from solarcal.errors import ConfigurationError

PROMISED = {
    "tijeras-azel", "tilted-tower", "backlash", "missed-counts", "wrong-clock", "southern",
    "ew-tiltroll", "ew-tiltroll-equinox", "ns-tiltroll", "polar", "screwjack", "tropical",
    "heliostat",
}  # fmt: skip


def test_all_promised_scenarios_are_there_the_default_first():
    names = scenario_names()
    assert set(names) == PROMISED
    assert names[0] == DEFAULT_SCENARIO == "tijeras-azel"


@pytest.mark.parametrize(
    ("name", "key", "value"),
    [
        ("tijeras-azel", "site.latitude_deg", 35.05),
        ("tilted-tower", "truth.lean_deg", 2.5),
        ("backlash", "truth.backlash1_deg", 0.15),
        ("wrong-clock", "truth.unit_drift_s_per_day", 40.0),
        ("wrong-clock", "truth.laptop_offset_s", 24.0),
        ("southern", "unit.ax1_centre_deg", 180.0),
        ("polar", "unit.geometry", "polar"),
        ("ew-tiltroll-equinox", "site.elevation_m", 1830.0),
    ],
)
def test_scenarios_are_what_they_are_called(name, key, value):
    assert settings_of(load_scenario(name))[key] == value


def test_every_key_can_be_set_to_what_it_is():
    for name in scenario_names():
        scenario = load_scenario(name)
        for key, value in settings_of(scenario).items():
            if value is None or isinstance(value, (dict, tuple, list)):
                continue
            text = f'"{value}"' if isinstance(value, str) else repr(value)
            assert scenario.with_settings([f"{key}={text}"]) == scenario or "lean" in key


def test_values_are_toml_literals_and_texts_need_no_quotes():
    scenario = load_scenario(
        DEFAULT_SCENARIO,
        [
            "truth.lean_deg=1", "truth.refraction=none", 'truth.sun="solartrak"',
            "unit.limits1_deg=[-90, 90.5]", "start=2026-12-21", "unit.drive1=rotary:-500",
            "truth.missed_counts=[{at='+90min', axis=2, counts=-7}]",
        ],
    )  # fmt: skip
    assert scenario.truth.lean_deg == 1.0
    assert (scenario.truth.refraction, scenario.truth.sun) == ("none", "solartrak")
    assert scenario.unit.limits1_deg == (-90.0, 90.5)
    assert scenario.start == "2026-12-21"
    assert scenario.truth.missed_counts[0].counts == -7
    assert scenario.start_utc_s() > load_scenario(DEFAULT_SCENARIO).start_utc_s()


def test_a_lean_is_p1_and_p3_and_either_can_be_given():
    lean = load_scenario("tijeras-azel", ["truth.lean_deg=2", "truth.lean_bearing_deg=90"])
    assert pytest.approx(0.0, abs=1e-12) == lean.truth.mechanism().P1
    assert pytest.approx(2.0) == lean.truth.mechanism().P3
    north = load_scenario("tijeras-azel", ["truth.lean_deg=2", "truth.lean_bearing_deg=0"])
    assert north.truth.mechanism().P1 == 2.0
    own = lean.with_settings(["truth.P1=0.3"])
    assert pytest.approx((0.3, 2.0)) == (own.truth.mechanism().P1, own.truth.mechanism().P3)
    again = own.with_settings(["truth.lean_deg=1"])
    assert pytest.approx(0.0, abs=1e-12) == again.truth.mechanism().P1


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("truth.lean_dge=1", "did you mean truth.lean_deg?"),
        ("noise=1", "did you mean truth.noise_deg?"),
        ("truth.lean_deg=steep", "truth.lean_deg: expected `float`"),
        ("truth.lean_deg=nan", "lean_deg: nan"),
        ("truth.noise_deg=-1", "truth.noise_deg"),
        ("truth.sun=moon", "solartrak"),
        ("truth.missed_counts=[{at='+4h', axis=3, counts=1}]", "axis 3"),
        ("truth.missed_counts=[{at='4 o clock', axis=1, counts=1}]", "write +4h"),
        ("site.latitude_deg=95", "latitude 95"),
        ("unit.drive1=rotary:0", "not 0"),
        ("unit.limits1_deg=[5,1]", "unit.limits1_deg"),
        ("unit.geometry=equatorial", "unknown geometry"),
        ("truth.pressure_hpa=20", "pressure"),
        ("truth.drive2=screwjack:20:20:50:35:4000:-", "cannot close"),
        ("unit.drive1=screwjack:20:20:0:90:4000:-", "dead point"),
        ("truth", "write KEY=VALUE"),
    ],
)
def test_a_wrong_setting_is_refused_in_one_line_that_names_it(setting, words):
    with pytest.raises(ConfigurationError) as refused:
        load_scenario(DEFAULT_SCENARIO, [setting])
    message = str(refused.value)
    assert words in message
    assert setting.partition("=")[0] in message
    assert "\n" not in message


def test_an_unknown_scenario_names_the_known_ones():
    with pytest.raises(ConfigurationError, match=r"no scenario 'tijeras'.*tijeras-azel"):
        load_scenario("tijeras")


def test_a_file_may_extend_a_scenario(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('extends = "backlash"\nstart = 2026-09-01\n[truth]\nlean_deg = 1\n')
    scenario = load_scenario(path)
    assert (scenario.name, scenario.start) == ("mine", "2026-09-01")
    assert (scenario.truth.lean_deg, scenario.truth.backlash1_deg) == (1.0, 0.15)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[truth\n", "line 1"),
        ("[truth]\nleen_deg = 1\n", "did you mean truth.lean_deg?"),
        ("truth = 3\n", "must be a table"),
        ('extends = "nobody"\n', "no scenario 'nobody'"),
        ("[unit]\n", "site"),
        ("start = 5\n[site]\nlatitude_deg = 1\nlongitude_deg = 1\n", "start"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(ConfigurationError) as refused:
        load_scenario(path)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_file_that_extends_itself_is_refused(tmp_path):
    path = tmp_path / "loop.toml"
    path.write_text(f'extends = "{path}"\n')
    with pytest.raises(ConfigurationError, match="extends itself"):
        load_scenario(path)


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="is missing: no such file"):
        load_scenario(tmp_path / "none.toml")


def test_a_date_without_a_morning_is_refused():
    scenario = load_scenario(
        DEFAULT_SCENARIO, ["site.latitude_deg=80", "start=2026-12-21", "unit.latitude_deg=80"]
    )
    with pytest.raises(ConfigurationError, match="does not rise"):
        scenario.start_utc_s()
