"""A camera in place of the diode or the eye: pictures of a known truth, asked of the program."""

import json
import math
import os
from pathlib import Path

import numpy as np
import pytest

from solarcal.cli import build_parser, run_command
from solarcal.cli.instrument import watch_folder
from solarcal.instruments.catalogue import BY_ID
from solarcal.two_mirror.mirrors import direction, tracker_matrix

T1, T2 = 20.0, 40.0
SIZE = (240, 320)
MRAD_A_PIXEL = 0.1


def disc(x: float, y: float, radius: float, noise: float = 0.0) -> np.ndarray:
    rows, columns = np.mgrid[: SIZE[0], : SIZE[1]]
    part = np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0.0, 1.0)
    return 0.05 + 0.85 * part + noise * np.random.default_rng(5).standard_normal(SIZE)


def stored(path: Path, image: np.ndarray, age_s: int = 0) -> Path:
    values = np.round(np.clip(image, 0.0, 1.0) * 65535.0).astype(">u2")
    path.write_bytes(f"P5 {SIZE[1]} {SIZE[0]} 65535\n".encode() + values.tobytes())
    os.utime(path, (10**9 - age_s,) * 2)
    return path


def sun_beside_axes(folder: Path, off1: float, off2: float, noise: float = 0.0) -> Path:
    """What a camera along the tracker's axis sees of a Sun the axes still have to turn to."""
    sun = direction(np.array([T1 + off1]), np.array([T2 + off2]))[0]
    ray = np.asarray(tracker_matrix(T1, T2)).T @ sun
    right, up = 1e3 * ray[:2] / ray[2] / MRAD_A_PIXEL
    middle = (0.5 * (SIZE[1] - 1), 0.5 * (SIZE[0] - 1))
    return stored(folder / "sun.pgm", disc(middle[0] + right, middle[1] - up, 46.5, noise))


def document(capsys: pytest.CaptureFixture[str], *words: str) -> dict:
    assert run_command([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def camera(path: Path, *words: str) -> tuple[str, ...]:
    return ("two-mirror", "camera", "--image", str(path), "--t1", f"{T1}", "--t2", f"{T2}", *words)


def test_the_disc_turns_the_axes_onto_the_sun(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = document(capsys, *camera(sun_beside_axes(tmp_path, 0.2, -0.15)))
    assert found["correction1_deg"] == pytest.approx(0.2, abs=1e-3)
    assert found["correction2_deg"] == pytest.approx(-0.15, abs=1e-3)
    assert found["pixel_mrad"] == pytest.approx(MRAD_A_PIXEL, rel=2e-3)


def test_the_corrections_are_those_of_the_diode(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = document(capsys, *camera(sun_beside_axes(tmp_path, 0.02, 0.01), "--mirror=0,1,0"))
    # A diode of gain 10 per radian with the same ray behind the same fixed mirror.
    e1, e2 = 1e-2 * seen["d1_mrad"], 1e-2 * seen["d2_mrad"]
    signals = [1 - e1 + e2, 1 + e1 + e2, 1 + e1 - e2, 1 - e1 - e2]
    words = ["--signals", *(f"{one:.9f}" for one in signals), "--gain", "10", "--mirror=0,1,0"]
    traced = document(capsys, "two-mirror", "trace", *words, "--t1", f"{T1}", "--t2", f"{T2}")
    for name in ("correction1_deg", "correction2_deg"):
        assert seen[name] == pytest.approx(traced[name], abs=1e-7)


def test_the_sigma_covers_the_noise(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = document(capsys, *camera(sun_beside_axes(tmp_path, 0.2, -0.15, noise=0.05)))
    assert 0.0 < found["correction2_sigma_deg"] < 1e-3
    # A cross error counts on axis 1 by 1/sin t2.
    ratio = found["correction1_sigma_deg"] / found["correction2_sigma_deg"]
    assert ratio == pytest.approx(1.0 / math.sin(math.radians(T2)), rel=0.02)
    assert abs(found["correction2_deg"] + 0.15) < 5.0 * found["correction2_sigma_deg"] + 1e-4


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), (1.0, 2.0)),
        (("--rotated", "90"), (-2.0, 1.0)),
        (("--mirrored",), (-1.0, 2.0)),
        (("--mirrored", "--rotated", "90"), (-2.0, -1.0)),
        (("--aim", "159.5", "109.5"), (1.0, 1.0)),
        (("--pixel", "0.2"), (2.0, 4.0)),
    ],
)
def test_the_picture_may_lie_otherwise(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    expected: tuple[float, float],
) -> None:
    """Ten pixels to the right and twenty up, 0.1 mrad each."""
    path = stored(tmp_path / "a.pgm", disc(169.5, 99.5, 46.5))
    found = document(capsys, *camera(path, *words))
    assert (found["d1_mrad"], found["d2_mrad"]) == pytest.approx(expected, abs=0.01)


def test_of_a_folder_the_newest_whole_image(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    stored(tmp_path / "older.pgm", disc(120.0, 110.0, 40.0), age_s=60)
    stored(tmp_path / "newer.pgm", disc(180.0, 110.0, 40.0), age_s=30)
    (tmp_path / "being-written.pgm").write_bytes(b"P5 320 240 255\n")
    found = document(capsys, *camera(tmp_path))
    assert found["image"].endswith("newer.pgm")
    assert found["disc"]["x"] == pytest.approx(180.0, abs=0.05)


def test_an_empty_folder_and_a_missing_image_are_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path, complaint in ((tmp_path, "no whole image"), (tmp_path / "none.pgm", "no such file")):
        assert run_command(list(camera(path))) == 2
        assert complaint in capsys.readouterr().err


class Shutter:
    """A clock with whose waits a camera takes its pictures."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.taken = folder, 0

    def utc_s(self) -> float:
        return 1.8e9

    def wait(self, seconds: float) -> None:
        self.taken += 1
        bright = disc(159.5 + self.taken, 119.5, 40.0) if self.taken != 2 else np.zeros(SIZE)
        stored(self.folder / f"{self.taken}.pgm", bright, age_s=100 - self.taken)


def test_a_folder_being_filled_gives_a_line_for_each_image(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second picture shows a cloud: a warning, and the next one counts."""
    words = camera(tmp_path, "--images", "3", "--pixel", "0.1")
    args = build_parser("two-mirror").parse_args(words)
    assert watch_folder(BY_ID["mirrors-camera"], args, Shutter(tmp_path)) == 0
    printed = capsys.readouterr()
    assert len(printed.out.splitlines()) == 3
    assert [Path(line.split(":")[0]).stem for line in printed.out.splitlines()] == ["1", "3", "4"]
    assert "no bright disc stands out" in printed.err


def plate_picture(folder: Path, right: float, up: float, pixels: float = 8.0) -> Path:
    """A plate whose hole of 4 stands at pixel (150, 120), its spot of 13 moved by (right, up)."""
    image = disc(150.0 + pixels * right, 120.0 - pixels * up, 6.5 * pixels)
    hole = disc(150.0, 120.0, 2.0 * pixels)
    return stored(folder / "plate.pgm", np.minimum(image, 0.95 - hole))


DEVICE = ("--height", "500", "--hole", "4")


def test_a_picture_of_the_plate_reads_e_on_both_axes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = plate_picture(tmp_path, 1.5, -0.75)
    found = document(capsys, "sunspot", "--picture", str(path), *DEVICE)
    # E = (Rs - Ro) + shift = 4.5 + shift, error = atan(shift / 2H).
    assert found["edge"] == pytest.approx(6.0, abs=0.03)
    assert found["edge_up"] == pytest.approx(3.75, abs=0.03)
    assert found["error_deg"] == pytest.approx(math.degrees(math.atan(1.5e-3)), abs=2e-3)
    assert found["error_up_deg"] == pytest.approx(math.degrees(math.atan(-0.75e-3)), abs=2e-3)
    assert 0.0 < found["error_sigma_deg"] < 2e-3
    # The same as the edges read by eye.
    edges = ("--edge", f"{found['edge']}", "--edge-up", f"{found['edge_up']}")
    by_eye = document(capsys, "sunspot", *DEVICE, "--spot", f"{found['spot_diameter']}", *edges)
    assert by_eye["error_deg"] == pytest.approx(found["error_deg"], abs=1e-9)
    assert by_eye["error_up_deg"] == pytest.approx(found["error_up_deg"], abs=1e-9)


def test_a_hole_half_outside_the_spot_is_given_by_its_place(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = plate_picture(tmp_path, 6.0, 0.0)
    assert run_command(["sunspot", "--picture", str(path), *DEVICE]) == 2
    assert "--hole-at X Y" in capsys.readouterr().err
    words = ("--hole-at", "150", "120", "--spot", "13")
    found = document(capsys, "sunspot", "--picture", str(path), *DEVICE, *words)
    assert found["edge"] == pytest.approx(4.5 + 6.0, abs=0.1)
    assert found["edge_up"] == pytest.approx(4.5, abs=0.1)
