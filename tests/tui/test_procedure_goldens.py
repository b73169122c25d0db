"""The procedure's screens as text, at 80x24 and 140x45, against what was looked at once.

``SOLARCAL_WRITE_GOLDENS=1`` writes them anew; look at them before committing. Digits may differ:
numpy versions round the last ones differently, clocks go on.
"""

import os
import re
from pathlib import Path

import pytest
from procedure_bench import (
    LARGE,
    SMALL,
    bench,
    offset_set,
    on_loop,
    settled_text,
    shows,
    take_points,
    until,
    workstation,
)

from solarcal.tui.offset.dialog import SunOffsetDialog
from solarcal.unit.drivers.solartrak import SolarTrakUnit

GOLDENS = Path(__file__).parent / "goldens"
SIZES = [SMALL, LARGE]


def without_digits(text: str) -> list[str]:
    return [re.sub(r"[0-9]", "0", line).rstrip() for line in text.splitlines()]


def compare(name: str, size: tuple[int, int], text: str) -> None:
    path = GOLDENS / f"procedure-{name}-{size[0]}x{size[1]}.txt"
    if os.environ.get("SOLARCAL_WRITE_GOLDENS"):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.rstrip() + "\n")
    golden = path.read_text()
    assert without_digits(text) == without_digits(golden)


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_questions(size: tuple[int, int]) -> None:
    station, _ = bench()
    station.initialise(confirmed=True)
    offset_set(station)
    async with workstation(station, size) as (_, pilot):
        await pilot.press("f7")
        await shows(pilot, "1. Did")
        await pilot.press("y")
        await shows(pilot, "2. Did")
        await pilot.press("y")
        await shows(pilot, "3. Do", "The spot is")
        compare("questions", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_result(size: tuple[int, int]) -> None:
    station, _ = bench()
    take_points(station, 4)
    offset_set(station)
    async with workstation(station, size) as (_, pilot):
        await pilot.press("f7")
        for words in ("1. Did", "2. Did", "3. Do"):
            await shows(pilot, words)
            await pilot.press("y")
        await shows(pilot, "Store it?")
        compare("result", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_sun_offset(size: tuple[int, int]) -> None:
    station, _ = bench(None, "truth.noise_deg=0.0")
    async with workstation(station, size) as (app, pilot):
        await pilot.press("f6")
        await shows(pilot, "mode TRACK", "spot")
        dialog = app.screen
        assert isinstance(dialog, SunOffsetDialog)
        await until(pilot, lambda: not dialog._waiting)
        compare("sun-offset", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_sun_offset_on_a_real_unit(
    size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    station, _ = bench()
    monkeypatch.setattr(SolarTrakUnit, "emulation", property(lambda unit: None))
    async with workstation(station, size) as (app, pilot):
        await pilot.press("f6")
        await shows(pilot, "mode TRACK", "Sunspot plate", "Leave")
        dialog = app.screen
        assert isinstance(dialog, SunOffsetDialog)
        await until(pilot, lambda: not dialog._waiting)
        compare("sun-offset-real", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_upload(size: tuple[int, int]) -> None:
    station, _ = bench()
    take_points(station, 5)
    async with workstation(station, size) as (_, pilot):
        await pilot.press("f8")
        await shows(pilot, "Upload?")
        compare("upload", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_link_lost(size: tuple[int, int]) -> None:
    station, cable = bench()
    async with workstation(station, size) as (_, pilot):
        await pilot.press("f5")
        await shows(pilot, "Watch both axes")
        cable.pulled = True
        await shows(pilot, "LINK LOST")
        compare("link-lost", size, only_dialog(await settled_text(pilot)))


@pytest.mark.parametrize("size", SIZES)
@on_loop
async def test_recompute(
    size: tuple[int, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path))
    station, _ = bench(tmp_path / "tijeras.jsonl")
    take_points(station, 7)
    async with workstation(station, size) as (_, pilot):
        await pilot.press("f9", "enter")
        await shows(pilot, "OPEN", "P6", "axis error, deg")
        # Where a point falls in its cell may differ by a rounding: the plot has goldens of its own.
        text = (await settled_text(pilot)).splitlines()
        compare("recompute", size, "\n".join(text[: 11 if size is SMALL else 20]))


def only_dialog(text: str) -> str:
    """The lines of the dialog's frame: what lies behind it belongs to others."""
    lines = text.splitlines()
    top = next(i for i, line in enumerate(lines) if "┏━ " in line)
    at = lines[top].index("┏━ ")
    foot = max(i for i, line in enumerate(lines) if line[at : at + 1] == "┗")
    width = lines[top].rindex("┓") + 1
    return "\n".join(line[at:width].rstrip() for line in lines[top : foot + 1])
