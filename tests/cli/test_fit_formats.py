"""`solarcal fit` on files of other programs, and published models beside the fit."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solarcal.cli import run_command


def telescope(folder: Path, name: str, *, pmfit: bool = False) -> Path:
    """Thirty observations with IA -100, IE -200, CA 40, TX 60 arcsec."""
    generator = np.random.default_rng(3)
    azimuth, elevation = generator.uniform(0, 360, 30), generator.uniform(20, 80, 30)
    e = np.radians(elevation)
    encoder_azimuth = azimuth - (100 - 40 / np.cos(e)) / 3600
    encoder_elevation = elevation - (-200 - 60 / np.tan(e)) / 3600
    rows = [
        " ".join(f"{value:.9f}" for value in row)
        for row in zip(azimuth, elevation, encoder_azimuth, encoder_elevation, strict=True)
    ]
    head = ["Made up", "A", "35.0"] if pmfit else ["Made up", ": ALTAZ", "+35 00 00"]
    path = folder / name
    path.write_text("\n".join([*head, *rows, *([] if pmfit else ["END"]), ""]))
    return path


def fitted(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert run_command(["fit", "--json", *map(str, arguments)]) == 0
    document: dict[str, Any] = json.loads(capsys.readouterr().out)
    return document


@pytest.mark.parametrize("pmfit", [False, True])
def test_terms_in_arcsec(tmp_path: Path, capsys: pytest.CaptureFixture[str], pmfit: bool) -> None:
    path = telescope(tmp_path, "a.dat", pmfit=pmfit)
    document = fitted(capsys, path, "--terms", "IA,IE,CA,TX")
    found = {name: c["value"] for name, c in document["coefficients"].items()}
    assert found == pytest.approx({"IA": -100, "IE": -200, "CA": 40, "TX": 60}, abs=1e-3)
    assert document["residuals"]["sky_rms_deg"] * 3600 < 1e-3
    assert {c["unit"] for c in document["coefficients"].values()} == {"arcsec"}


def test_iterated_fits_pmfits_terms_unless_others_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = telescope(tmp_path, "a.dat", pmfit=True)
    document = fitted(capsys, path, "--method", "iterated")
    assert list(document["coefficients"]) == ["IA", "IE", "CA", "AN", "AW", "TF"]
    assert document["method"] == "iterated"
    document = fitted(capsys, path, "--method", "iterated", "--terms", "IA,IE,CA,TX")
    assert document["coefficients"]["TX"]["value"] == pytest.approx(60.0, abs=1.0)


def test_a_written_model_leaves_nothing_when_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, model = telescope(tmp_path, "a.dat"), tmp_path / "a.mod"
    fitted(capsys, path, "--terms", "IA,IE,CA,TX", "--write-model", model)
    document = fitted(capsys, path, "--compare", model)
    assert document["comparison"]["sky_rms_arcsec"] < 1e-3
    assert document["comparison"]["terms"]["TX"]["published"] == pytest.approx(60.0, abs=1e-3)
    assert run_command(["fit", str(path), "--compare", str(model), "--terms", "IA,IE"]) == 0
    text = capsys.readouterr().out
    assert "Published model" in text
    assert "these points from the published model: sky rms 0.00 arcsec" in text


def test_a_model_replaces_a_file_only_when_told_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = telescope(tmp_path, "a.dat")
    points = path.read_bytes()
    call = ["fit", str(path), "--terms", "IA,IE,CA,TX", "--write-model", str(path)]
    assert run_command(call) == 2
    assert "a.dat exists already; give another name, or --replace" in capsys.readouterr().err
    assert path.read_bytes() == points
    model = tmp_path / "a.mod"
    model.write_text("another")
    assert run_command([*call[:-1], str(model), "--replace"]) == 0
    assert "TX" in model.read_text()


def test_a_model_holds_tpoint_terms_only(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, model = telescope(tmp_path, "a.dat"), tmp_path / "a.mod"
    assert run_command(["fit", str(path), "--method", "linear", "--write-model", str(model)]) == 2
    assert "a TPOINT model cannot hold P1" in capsys.readouterr().err
    assert not model.exists()


def test_of_a_large_file_a_part_is_tested_and_that_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    generator = np.random.default_rng(8)
    rows = "".join(
        f",{ax1:.3f},{ax2:.3f},{0.3 + noise / np.sin(np.radians(ax2)):.5f},{0.1 - noise:.5f}\n"
        for ax1, ax2, noise in zip(
            generator.uniform(-90, 90, 700),
            generator.uniform(20, 70, 700),
            generator.normal(0.0, 0.02, 700),
            strict=True,
        )
    )
    path = tmp_path / "many.csv"
    head = "# geometry=azel\n# lat_deg=35\n# lon_deg=-106\n"
    path.write_text(head + "utc,ax1_deg,ax2_deg,err1_deg,err2_deg\n" + rows)
    document = fitted(capsys, path, "--terms", "P2,P4")
    assert document["coefficients"]["P2"]["value"] == pytest.approx(0.3, abs=0.01)
    sentences = [finding["sentence"] for finding in document["findings"]]
    assert any("looked at 500 of 700 points" in sentence for sentence in sentences)


def test_the_text_prints_what_pmfit_prints(capsys: pytest.CaptureFixture[str]) -> None:
    """Of 105 observations whose solution the documentation of PMFIT prints."""
    published = Path(__file__).parents[1] / "model" / "published_pmfit_105.dat"
    assert run_command(["fit", str(published), "--method", "iterated"]) == 0
    text = capsys.readouterr().out
    rows = [line.split()[:3] for line in text.splitlines() if " arcsec " in line]
    assert [row for row in rows if row[0] in ("IA", "CA", "TF")] == [
        ["IA", "-142.148", "4.378"],
        ["CA", "+19.843", "3.022"],
        ["TF", "+279.752", "4.361"],
    ]
    assert "population SD 8.349" in text


def test_one_point_is_one_point_and_two_are_points(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    day = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"
    lines = day.read_text().splitlines(keepends=True)
    points = [at for at, line in enumerate(lines) if '"type":"point"' in line]
    for count, words in ((1, "1 point, method"), (2, "2 points, method")):
        cut = tmp_path / f"{count}.jsonl"
        cut.write_text("".join(lines[: points[count - 1] + 1]))
        assert run_command(["fit", str(cut)]) == 0
        assert words in capsys.readouterr().out
        run_command(["forecast", str(cut)])
        assert f"({words.removesuffix(', method')}, robust)" in capsys.readouterr().out
