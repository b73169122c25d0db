"""Tab in a shell: what is offered is what the program takes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from solarcal.cli import COMMANDS
from solarcal.cli.completion import SHELLS


def offered(line: str, tmp_path: Path) -> set[str]:
    """What a Tab at the end of ``line`` offers."""
    answer = tmp_path / "offered"
    subprocess.run(
        [sys.executable, "-m", "solarcal"],
        env={
            **os.environ,
            "_ARGCOMPLETE": "1",
            "_ARGCOMPLETE_SHELL": "fish",
            "_ARGCOMPLETE_STDOUT_FILENAME": str(answer),
            "_ARGCOMPLETE_IFS": "\n",
            "COMP_LINE": line,
            "COMP_POINT": str(len(line)),
        },
        cwd=tmp_path,
        check=True,
        timeout=60,
    )
    return {row.split("\t")[0].strip() for row in answer.read_text().split("\n")}


def test_every_command_is_offered(tmp_path):
    assert set(COMMANDS) <= offered("solarcal ", tmp_path)
    assert offered("solarcal roll", tmp_path) == {"rollback"}


def test_options_and_their_values_are_offered(tmp_path):
    assert {"--method", "--terms", "--json"} <= offered("solarcal fit --", tmp_path)
    assert offered("solarcal fit --method ", tmp_path) == {
        "linear",
        "robust",
        "exact",
        "iterated",
    }


def test_scenarios_and_scenario_files_are_offered(tmp_path):
    (tmp_path / "tijeras-mine.toml").write_text("")
    assert {"tijeras-azel", "tijeras-mine.toml"} <= offered(
        "solarcal calibrate --scenario tij", tmp_path
    )


def test_files_are_offered_where_a_file_is_wanted(tmp_path):
    (tmp_path / "day.jsonl").write_text("")
    assert "day.jsonl" in offered("solarcal fit da", tmp_path)


@pytest.mark.parametrize("shell", SHELLS)
def test_the_shell_takes_its_script(shell, capsys, tmp_path):
    from solarcal.cli import run_command

    assert run_command(["completion", shell]) == 0
    script = tmp_path / "script"
    script.write_text(capsys.readouterr().out)
    assert "solarcal" in script.read_text()
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    subprocess.run([shell, "-n", str(script)], check=True, timeout=60)
