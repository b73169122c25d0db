"""The least squares are scipy's: a spy sees the call; what fits nothing does not import it."""

import subprocess
import sys

import pytest
from made_up_trackers import day_of
from scipy import linalg, optimize

from solarcal.model import least_squares, methods
from solarcal.model.methods import fit


@pytest.mark.parametrize(
    ("method", "module", "name", "solver"),
    [
        ("linear", least_squares.linalg, "svd", linalg.svd),
        ("robust", methods, "least_squares", optimize.least_squares),
        ("exact", methods, "least_squares", optimize.least_squares),
    ],
)
def test_each_method_goes_through_scipy(method, module, name, solver, monkeypatch):
    calls = []

    def spy(*arguments, **options):
        calls.append(name)
        return solver(*arguments, **options)

    monkeypatch.setattr(module, name, spy)
    context, points = day_of("azel", 9)
    fit(points, context, method=method)
    assert calls


def test_the_suns_command_imports_no_scipy():
    program = (
        "import sys; from solarcal.cli import run_command;"
        "run_command(['sun', '--lat', '35', '--lon', '-106', '--at', '2026-06-21T18:00Z']);"
        "sys.exit('scipy' in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", program], check=True, stdout=subprocess.DEVNULL)
