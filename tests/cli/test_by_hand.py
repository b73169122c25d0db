"""A field book at the command line: the saved one, and what is refused."""

import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from solarcal.cli import run, run_command
from solarcal.mount.formula import Coefficients, correction_deg
from solarcal.session.records import UploadRecord
from solarcal.session.view import read_session

SESSIONS = Path(__file__).parents[2] / "sessions"
SITE, BOOK = str(SESSIONS / "by-hand.toml"), SESSIONS / "by-hand.book"
BY_HAND = ["calibrate", "--driver", "typed", "--site", SITE]
TRUTH = Coefficients(0.2817, -0.35, 0.5298, 0.22, 0.0008, -0.0006)


@pytest.fixture
def before_upload(tmp_path: Path) -> Path:
    path = tmp_path / "morning.book"
    text = BOOK.read_text(encoding="utf-8")
    path.write_text(text[: text.index("# Keyed in")], encoding="utf-8")
    return path


def test_the_saved_book_is_a_completed_calibration(tmp_path: Path, capsys) -> None:
    path = tmp_path / "s.jsonl"
    assert run_command([*BY_HAND, "--input", str(BOOK), "-o", str(path)]) == 0
    out, err = capsys.readouterr()
    assert "Coefficients to key in" in out
    assert "keyed in and typed back equal" in out
    assert "typed for offset: ax1 98.92" in err
    assert read_session(path).warnings == ()


def test_a_check_point_that_was_not_stored_leaves_its_offset_in_the_unit(tmp_path, capsys) -> None:
    lines = BOOK.read_text().splitlines()
    last = max(i for i, line in enumerate(lines) if " check " in line)
    rejected = [*lines[:last], f"{lines[last].rsplit(' ', 1)[0]} reject a reflection"]
    book = tmp_path / "rejected.book"
    book.write_text("\n".join(rejected))
    path = tmp_path / "s.jsonl"
    assert run_command([*BY_HAND, "--input", str(book), "-o", str(path)]) == 1
    assert (
        "NOT completed: the newest Set Sun Offset is still in the unit" in capsys.readouterr().out
    )


def test_before_the_upload_it_says_what_to_key_in_and_finds_the_truth(
    before_upload: Path, tmp_path: Path, capsys
) -> None:
    path = tmp_path / "s.jsonl"
    words = [*BY_HAND, "--input", str(before_upload), "-o", str(path), "--json"]
    assert run_command(words) == 1
    document = json.loads(capsys.readouterr().out)
    assert (document["completed"], document["truth"]) == (False, None)
    assert document["session"] == str(path)
    assert document["points"] == {
        "total": 9, "used": 8, "aborted": 1, "rejected": 0, "outliers": []
    }  # fmt: skip
    key_in = document["key_in"]
    assert (key_in["O1"], key_in["O2"]) == ("0.0000", "0.0000")
    found = Coefficients(*(float(key_in[f"P{i}"]) for i in range(1, 7)))
    ax1, ax2 = np.linspace(-90.0, 100.0, 20), np.linspace(20.0, 75.0, 20)
    off1, off2 = np.array(correction_deg(found, ax1, ax2)) - correction_deg(TRUTH, ax1, ax2)
    # On the sky; what the refracted Sun and the controller's own Sun differ by is in it.
    assert np.hypot(off1 * np.sin(np.radians(ax2)), off2).max() < 0.09


def test_standard_input_is_a_book_too(before_upload: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "solarcal", *BY_HAND, "--input", "-"]
    done = subprocess.run(
        [*words, "-o", str(tmp_path / "s.jsonl")],
        input=before_upload.read_text(encoding="utf-8").split("17:51")[0] + "17:51 jump\n",
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "standard input:" in done.stderr
    assert "'jump' is not a step" in done.stderr


def test_the_session_is_keyed_in_later_and_rolled_back(
    before_upload: Path, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "s.jsonl"
    run_command([*BY_HAND, "--input", str(before_upload), "-o", str(path), "--json"])
    key_in = json.loads(capsys.readouterr().out)["key_in"]
    typed = " ".join(f"{name} {value}" for name, value in key_in.items())
    opened = "2026-06-03T23:00:00Z open o1 -0.046 o2 0.817 clock 16:00:00\n"
    book = tmp_path / "evening.book"
    book.write_text(f"{opened}2026-06-03T23:05:00Z upload {typed}\n", encoding="utf-8")
    unit = ["--driver", "typed", "--site", SITE]
    assert run_command(["upload", str(path), *unit, "--input", str(book)]) == 0
    back = f"2026-06-03T23:00:00Z open {typed} clock 16:00:00\n"
    zeros = " ".join(f"p{i} 0" for i in range(1, 7))
    back += f"2026-06-03T23:10:00Z rollback {zeros} o1 -0.046 o2 0.817\n"
    monkeypatch.setattr(sys, "stdin", io.StringIO(back))
    assert run_command(["rollback", str(path), *unit, "--input", "-"]) == 0
    uploads = [r for r in read_session(path).records if isinstance(r, UploadRecord)]
    assert [(u.verified, u.rollback) for u in uploads] == [(True, False), (True, True)]
    assert uploads[1].new_offsets == uploads[0].old_offsets


def test_going_on_without_the_site_file_is_refused_at_once_with_the_command(
    before_upload: Path, tmp_path: Path, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "s.jsonl"
    run_command([*BY_HAND, "--input", str(before_upload), "-o", str(path)])
    monkeypatch.setattr(run, "has_terminal", lambda: True)
    monkeypatch.setattr(run, "run_workstation", lambda choice, **_: 0 if choice.session else 1)
    capsys.readouterr()
    assert run_command(["run", "--continue", str(path)]) == 2
    assert f"solarcal run --continue {path} --site FILE" in capsys.readouterr().err
    assert run_command(["run", "--continue", str(path), "--site", SITE]) == 0


@pytest.mark.parametrize(
    ("words", "wrong"),
    [
        (["calibrate", "--driver", "typed", "--site", SITE], "or give what was read with --input"),
        (["calibrate", "--input", "x.book"], "--input is for --driver typed"),
        (["calibrate", "--driver", "typed", "--input", str(BOOK)], "driver typed needs the site"),
        ([*BY_HAND, "--input", "none.book"], "none.book is missing: no such file"),
        ([*BY_HAND, "--port", "/dev/null", "--input", "x"], "--input is for a unit without a line"),
    ],
)
def test_what_is_missing_or_does_not_belong_together(words, wrong, capsys) -> None:
    assert run_command(words) == 2
    assert wrong in capsys.readouterr().err
