"""The floors stay apart: each one is imported alone in a fresh interpreter and looked at."""

import subprocess
import sys

import pytest

SCREEN = {"textual", "rich", "plotext"}
LOADED = {
    "solarcal": SCREEN | {"numpy", "scipy"},
    "solarcal.sun": SCREEN | {"scipy", "serial", "solarcal.mount", "solarcal.station"},
    "solarcal.mount.mechanism": SCREEN | {"scipy", "serial", "solarcal.sun", "solarcal.session"},
    "solarcal.model.fit": SCREEN | {"serial", "solarcal.session", "solarcal.unit"},
    "solarcal.session.journal": SCREEN | {"serial", "solarcal.model", "solarcal.unit"},
    "solarcal.unit.drivers.solartrak": SCREEN | {"scipy", "solarcal.sun", "solarcal.session"},
    "solarcal.emulator.emulation": SCREEN | {"serial", "solarcal.station", "solarcal.session"},
    "solarcal.emulator.world": {"solarcal.emulator.controller"},
    "solarcal.emulator.controller": {"solarcal.emulator.world"},
    "solarcal.profiles": SCREEN | {"numpy", "serial"},
    "solarcal.station.connect": SCREEN | {"solarcal.emulator", "solarcal.report"},
    "solarcal.station.headless": SCREEN | {"solarcal.emulator", "solarcal.report"},
    "solarcal.report.session_report": {"textual", "solarcal.tui", "solarcal.emulator"},
    "solarcal.cli": SCREEN | {"numpy", "scipy"},
}


@pytest.mark.parametrize("module", LOADED)
def test_importing_a_floor_loads_nothing_it_must_not_know(module):
    code = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    assert not LOADED[module] & loaded
