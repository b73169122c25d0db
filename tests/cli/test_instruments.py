"""The field calculators on the command line: numbers of 10-physics sections 5-6, one clear line."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest

from solarcal.cli import run_command


def document(capsys, *words: str) -> dict:
    assert run_command([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def text(capsys, *words: str) -> str:
    assert run_command(list(words)) == 0
    return capsys.readouterr().out


PLACE = ["--lat", "35.05", "--lon", "-106.48", "--at", "2026-06-10T17:00:00Z"]
BOARD = ["--target", "176", "78", "--distance", "120"]
OFFSET = ["--offset", "0.12", "0", "0.35"]


def test_circle_prints_the_published_roots(capsys):
    """Section 6: phi 22.5 deg, d/r 5."""
    found = document(capsys, "heliostat", "circle", "--angle", "22.5", "--distance", "5")
    assert {key: round(value, 6) for key, value in found.items()} == {
        "front_deg": 12.489466,
        "front_from_target_deg": 10.010534,
        "back_deg": 10.232014,
        "back_from_target_deg": 12.267986,
    }
    said = text(
        capsys, "heliostat", "circle", "--angle", "22.5", "--distance", "10", "--radius", "2"
    )
    assert "12.489466" in said
    assert "10.232014" in said


def test_three_feet_at_eight_hundred(capsys):
    """Section 6: 0.215 deg."""
    found = document(capsys, "heliostat", "shift", "--by", "3", "--distance", "800")
    assert round(found["angle_deg"], 3) == 0.215


def test_aim_gives_the_normal_in_any_native_frame(capsys):
    azel = document(capsys, "heliostat", *PLACE, *BOARD, *OFFSET)
    assert azel["ax2_deg"] == pytest.approx(azel["normal_zenith_deg"])
    assert azel["ax1_deg"] == pytest.approx(180.0 - azel["normal_azimuth_deg"])
    assert azel["front"]["miss"] < 120e-9
    assert azel["back"]["azimuth_deg"] == pytest.approx(azel["front"]["azimuth_deg"] + 180.0, abs=1)
    assert 0.0 < azel["controller"]["apart_deg"] < 1e-3
    assert azel["parameters"]["target"] == "176.00000:78.00000:120.00000"
    assert azel["parameters"]["mirror"] == "0.001000000:0.000000000:0.002916667"
    polar = document(capsys, "heliostat", *PLACE, *BOARD, *OFFSET, "--geometry", "polar")
    assert polar["normal_azimuth_deg"] == azel["normal_azimuth_deg"]
    assert abs(polar["ax2_deg"] - azel["ax2_deg"]) > 1.0


def test_aim_without_an_offset_needs_no_distance(capsys):
    found = document(capsys, "heliostat", "aim", "--sun", "180", "40", "--target", "180", "80")
    assert found["normal_zenith_deg"] == pytest.approx(60.0)
    assert found["incidence_deg"] == pytest.approx(20.0)
    assert (found["back"], found["parameters"]) == (None, None)


def test_target_is_found_from_what_aim_said(capsys):
    seen: list[str] = []
    for sun in (("110", "60"), ("180", "20"), ("250", "65")):
        aimed = document(capsys, "heliostat", "--sun", *sun, "--target", "176", "78")
        seen += ["--seen", *sun, str(aimed["ax1_deg"]), str(aimed["ax2_deg"])]
    found = document(capsys, "heliostat", "target", "--axes", *seen)
    assert found["azimuth_deg"] == pytest.approx(176.0, abs=1e-9)
    assert found["zenith_deg"] == pytest.approx(78.0, abs=1e-9)
    assert found["observations"] == 3
    assert found["sigma_deg"] < 1e-9


def test_target_from_times_instead_of_the_sun(capsys):
    aimed = document(capsys, "heliostat", *PLACE, "--target", "176", "78")
    normal = str(aimed["normal_azimuth_deg"]), str(aimed["normal_zenith_deg"])
    found = document(
        capsys, "heliostat", "target", *PLACE[:4], "--seen-at", "2026-06-10T17:00:00Z", *normal
    )
    assert (found["azimuth_deg"], found["zenith_deg"]) == (
        pytest.approx(176.0),
        pytest.approx(78.0),
    )
    assert found["rms_deg"] is None


def test_drift_of_an_uncorrected_offset_is_drawn(capsys):
    found = document(capsys, "heliostat", "drift", *PLACE, *BOARD, *OFFSET)
    assert len(found["right"]) == len(found["utc"]) > 60
    # Between the offset itself and twice what it can reach.
    assert 0.2 < found["drift_max"] < 1.0
    assert found["drift_max_deg"] == pytest.approx(
        math.degrees(math.atan2(found["drift_max"], 120.0))
    )
    assert 0.0 < found["first_order_max_deg"] < 1e-3
    lines = text(capsys, "heliostat", "drift", *PLACE, *BOARD, *OFFSET).splitlines()
    assert max(map(len, lines)) <= 100
    assert sum("●" in line for line in lines) > 8


def test_screwjack_gives_the_parameters_and_draws_the_dead_points(capsys):
    """Section 5: L = sqrt(SJP3 + SJP2 cos(S + beta)); beta comes back from two angles."""
    sjp2, sjp3 = -2.0 * 30.0 * 20.0, 30.0**2 + 20.0**2 - 1.5**2
    lengths = {s: math.sqrt(sjp3 + sjp2 * math.cos(math.radians(s + 90.0))) for s in (-40, 35)}
    measured = [w for s, length in lengths.items() for w in ("--at", str(s), str(length))]
    words = ["screwjack", "--R1", "30", "--R2", "20", "--R3", "1.5", *measured, "--counts", "4000"]
    found = document(capsys, *words)
    assert (found["SJP2"], found["SJP3"]) == (sjp2, sjp3)
    assert found["SJP1"] == pytest.approx(90.0)
    assert found["consistent"] is True
    assert found["dead_points_deg"] == [pytest.approx(-90.0), pytest.approx(90.0)]
    assert found["drive"].startswith("screwjack:30:20:1.5:")
    assert found["wrong_R1"]["change"] == pytest.approx(5.0 / 25.4)
    assert found["wrong_R1"]["error_max_deg"] > found["wrong_R1"]["left_max_deg"] > 0.01
    assert np.diff(found["curve"]["length"]).min() > 0.0
    said = text(capsys, *words)
    assert "░ dead point" in said
    assert "agree within" in said
    pins = [
        w for s, length in lengths.items() for w in ("--at", str(s), str(math.hypot(length, 1.5)))
    ]
    between = document(
        capsys, "screwjack", "--R1", "30", "--R2", "20", "--R3", "1.5", *pins, "--pin-to-pin"
    )
    assert between["SJP1"] == pytest.approx(90.0)


def test_screwjack_names_the_length_that_is_wrong(capsys):
    sjp2, sjp3 = -2.0 * 30.0 * 20.0, 30.0**2 + 20.0**2 - 1.5**2
    measured = [
        w
        for s in (-50, -10, 20, 60)
        for w in (
            "--at",
            str(s),
            str(math.sqrt(sjp3 + sjp2 * math.cos(math.radians(s + 90.0)))),
        )
    ]
    words = ["screwjack", "--R1", "29.5", "--R2", "20", "--R3", "1.5", *measured]
    assert document(capsys, *words)["consistent"] is False
    assert "R1 +0.5000 would leave" in text(capsys, *words)


def test_sunspot_error_and_the_two_position_check(capsys):
    """Section 5: error = atan((E - (Rs - Ro))/F), F = 2H."""
    device = ["sunspot", "--height", "500", "--hole", "4", "--spot", "13"]
    found = document(capsys, *device, "--edge", "6.5", "--edge-up", "4.5")
    assert found["error_deg"] == pytest.approx(math.degrees(math.atan(2.0 / 1000.0)))
    assert found["error_up_deg"] == 0.0
    assert found["even_rim"] == 4.5
    check = document(capsys, *device, "--edge", "6.5", "--turned", "4.5")
    assert check["device_deg"] == pytest.approx(0.5 * found["error_deg"])
    assert check["tracker_deg"] == pytest.approx(0.5 * found["error_deg"])
    said = text(capsys, *device, "--edge", "6.5", "--turned", "4.5")
    assert "the device's own +0.0573 deg" in said
    assert "o spot" in said


def test_sunspot_design(capsys):
    wish = document(
        capsys, "sunspot", "--design", "--hole", "4", "--resolution", "0.02", "--range", "1.5"
    )
    assert wish["range_deg"] == pytest.approx(1.5)
    built = document(
        capsys, "sunspot", "--design", "--hole", "4",
        "--height", str(wish["height"]), "--plate", str(wish["plate"]),
    )  # fmt: skip
    assert built == pytest.approx(wish)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("heliostat --sun 90 95 --target 176 78", "below the horizon"),
        ("heliostat --lat 35 --lon -106 --at 2026-06-10T06:00:00Z --target 176 78", "below the h"),
        ("heliostat --sun 90 45 --target 176 78 --offset 1 0 0 --distance 0.5", "behind the mirr"),
        ("heliostat --sun 90 45 --target 176 78 --offset 1 0 0 --distance 0", "greater than zero"),
        ("heliostat --sun 90 45 --target 176 78 --offset 1 0 0", "--distance is missing"),
        ("heliostat --sun 0 60 --target 180 120", "opposite"),
        ("heliostat --sun 0 60", "--target AZIMUTH ZENITH is missing"),
        ("heliostat", "give the Sun"),
        ("heliostat target", "--seen is missing"),
        ("heliostat target --seen 90 60 270 60", "behind the mirror"),
        (
            "heliostat target --lat 35 --lon -106 --seen-at 2026-06-10T17:00:00Z a 3",
            "--seen-at: 'a' is not a number",
        ),
        ("heliostat drift --lat 35 --lon -106 --target 176 78 --distance 120", "nothing drifts"),
        ("heliostat shift --by 3,5 --distance 8", "--by: '3,5' is not a number"),
        ("heliostat shift --by 1_000 --distance 8", "--by: '1_000' is not a number"),
        ("heliostat shift --by ٣ --distance 8", "--by: '٣' is not a number"),
        ("two-mirror point --azimuth 170", "give --azimuth and --zenith"),
        ("two-mirror point --azimuth 180 --zenith -5", "zenith angle (0 to 180)"),
        ("two-mirror point --azimuth 999 --zenith 5", "give azimuth (-360 to 360)"),
        (
            "two-mirror trace --t1 10 --t2 40 --signals -1 1 1 1",
            "no light gives a signal of -1: measure the dark level",
        ),
        ("heliostat --sun 90 -5 --target 176 78", "--sun: give azimuth (-360 to 360) and"),
        ("heliostat --sun nan 40 --target 0 80", "--sun: 'nan' is not a number"),
        ("heliostat circle --angle 22.5 --distance 0.5", "behind the mirror"),
        ("heliostat circle --distance 5", "--angle is missing"),
        ("heliostat shift --by 3 --distance 0", "greater than zero"),
        ("screwjack --R1 30 --R2 20 --at 0 80", "cannot close"),
        ("screwjack --R1 0 --R2 20 --at 0 30", "positive lengths"),
        ("screwjack --R1 30 --R2 20 --at 0 0", "greater than zero"),
        ("screwjack --R1 30 --R2 20", "at one axis angle at least"),
        ("screwjack --R1 30 --R2 20 --at 0 36 --limits 80 10", "not below"),
        ("screwjack --R1 30 --R2 20 --at 0 36 --limits -170 10", "dead point"),
        ("sunspot --height 0 --hole 4 --spot 13 --edge 5", "height H"),
        ("sunspot --hole 4 --spot 13 --edge 5", "--height is missing"),
        ("sunspot --height 500 --hole 4 --spot 13 --edge nan", "--edge: 'nan' is not a number"),
        ("sunspot --height 500 --hole 13 --spot 4 --edge 4.5", "whether the two are swapped"),
        ("sunspot --height 1 --hole 4 --spot 13 --edge 4.5", "check that all four are in the same"),
        ("sunspot --design --hole 4 --height 500 --plate 5", "too small"),
    ],
)
def test_bad_input_is_answered_in_one_clear_line(capsys, words, said):
    assert run_command(words.split()) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.err.count("\n") == 1
    assert captured.out == ""


@pytest.mark.parametrize("command", ["heliostat", "screwjack", "sunspot"])
def test_help_imports_nothing_heavy(command):
    """The calculators' help is there at once."""
    probe = (
        "import sys\n"
        "from solarcal.cli import run_command\n"
        "try:\n"
        f"    run_command(['{command}', '--help'])\n"
        "except SystemExit:\n"
        "    pass\n"
        "print([m for m in ('numpy', 'scipy', 'plotext', 'textual') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
