"""One straight line: a fit of a session folds its records once and builds its point set once."""

from pathlib import Path

import pytest

from solarcal.cli import run_command
from solarcal.session import view
from solarcal.station import analysing, fitting

SESSION = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"


@pytest.mark.parametrize("command", [["fit"], ["fit", "--method", "linear"], ["forecast"]])
def test_records_are_folded_and_points_built_once(command, monkeypatch, capsys):
    calls = {"fold": 0, "points": 0}

    def counted(name, honest):
        def spy(*given, **more):
            calls[name] += 1
            return honest(*given, **more)

        return spy

    monkeypatch.setattr(view, "live_records", counted("fold", view.live_records))
    points = counted("points", fitting.point_set)
    monkeypatch.setattr(fitting, "point_set", points)
    monkeypatch.setattr(analysing, "point_set", points)
    assert run_command([*command, str(SESSION), "--json"]) == 0
    assert calls == {"fold": 1, "points": 1}
    capsys.readouterr()
