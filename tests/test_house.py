"""The floors stay apart: each one is imported alone in a fresh interpreter and looked at."""

import dataclasses
import importlib
import inspect
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

import solarcal

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


IN_ONE_GO = (
    ("solarcal", "solarcal.profiles", "solarcal.cli"),
    ("solarcal.sun",),
    ("solarcal.mount.mechanism", "solarcal.model.fit", "solarcal.station.connect",
     "solarcal.station.headless", "solarcal.report.session_report"),
    ("solarcal.session.journal",),
    ("solarcal.unit.drivers.solartrak",),
    ("solarcal.emulator.world",),
    ("solarcal.emulator.controller",),
    ("solarcal.emulator.emulation",),
)  # fmt: skip
"""One interpreter for floors of which each may know those before it."""


def test_every_floor_is_imported():
    assert sorted(LOADED) == sorted(module for going in IN_ONE_GO for module in going)


@pytest.mark.parametrize("modules", IN_ONE_GO)
def test_importing_a_floor_loads_nothing_it_must_not_know(modules):
    code = "import sys\n" + "".join(f"import {name}\nprint(*sys.modules)\n" for name in modules)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for module, loaded in zip(modules, done.stdout.splitlines(), strict=True):
        assert not LOADED[module] & set(loaded.split()), module


CHANGING = {
    "solarcal.session.interchange.tpoint._Reading",
    "solarcal.session.parsing.SessionText",
    "solarcal.session.parsing._Reading",
    "solarcal.station.opening.OpenLine",
    "solarcal.station.saved_sessions.Replay",
    "solarcal.station.sun_tracking.TrackingRun",
}
"""What holds a state that moves on: readers under way, an open line, a replay, a run."""


@pytest.mark.parametrize("floor", ["sun", "optics", "mount", "session", "unit", "model", "station"])
def test_values_cannot_be_changed_once_made(floor):
    """Records, points, solutions and settings are shared by threads, screens and caches."""
    package = importlib.import_module(f"solarcal.{floor}")
    changeable = set()
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        found = importlib.import_module(module.name)
        for name, kind in vars(found).items():
            if not inspect.isclass(kind) or kind.__module__ != module.name:
                continue
            if issubclass(kind, msgspec.Struct):
                frozen = kind.__struct_config__.frozen
            elif dataclasses.is_dataclass(kind):
                frozen = kind.__dataclass_params__.frozen
            else:
                continue
            if not frozen:
                changeable.add(f"{module.name}.{name}")
    assert changeable == {name for name in CHANGING if name.startswith(f"solarcal.{floor}.")}


SIGNED_DECIMALS = re.compile(r":[<>=^]?\+[0-9]*\.[0-9{]")


def test_no_number_is_written_with_a_negative_zero():
    """``z`` in the format: -0.0004 to three decimals is +0.000."""
    for source in sorted(Path(solarcal.__file__).parent.rglob("*.py")):
        found = SIGNED_DECIMALS.findall(source.read_text(encoding="utf-8"))
        assert not found, f"{source.name}: {found} without z"
