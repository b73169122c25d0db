"""A picture of the workstation, made by the program: ``python -m solarcal.tui.picture FILE.svg``.

The automatic technician takes twelve points on the emulator; then the screen is kept as SVG.
"""

import asyncio
import re
import sys
import tempfile
from pathlib import Path

from solarcal.config import Settings
from solarcal.tui.themes import DEFAULT_THEME

SIZE = (140, 45)
POINTS = 12
_REMOTE_FONT = re.compile(r"@font-face\s*\{.*?\}\s*", re.DOTALL)


async def workstation_svg(session_file: Path, theme: str = DEFAULT_THEME) -> str:
    """The workstation after a day's points, as SVG without anything fetched from elsewhere."""
    from solarcal.emulator.emulation import Emulator
    from solarcal.emulator.scenario import load_scenario
    from solarcal.emulator.server import InProcessLink
    from solarcal.session.journal import Journal
    from solarcal.station.emulated_clock import EmulatedClock
    from solarcal.station.procedure import Station
    from solarcal.station.technician import AutomaticTechnician, Schedule
    from solarcal.tui.app import SolarcalApp
    from solarcal.tui.performers import PERFORMERS
    from solarcal.tui.screens.workstation import WorkstationScreen
    from solarcal.unit.drivers.solartrak import SolarTrakUnit

    emulator = Emulator(load_scenario("tijeras-azel"))
    unit = SolarTrakUnit(lambda: InProcessLink(emulator))
    unit.open()
    assert unit.emulation is not None  # we made it an emulator
    station = Station(unit, EmulatedClock(unit.emulation), operator="the picture's technician")
    station.connect()
    station.open_session(lambda header: Journal.create(session_file, header))
    technician = AutomaticTechnician(station, unit.emulation.spot, Schedule(POINTS, checks=0))
    technician.prepare()
    technician.take_points()
    technician.sight.centre()
    technician.sight.watch()
    app = SolarcalApp(PERFORMERS, settings=Settings(theme=theme))
    async with app.run_test(size=SIZE) as pilot:
        app.adopt(station)
        app.push_screen(WorkstationScreen())
        while app.fit is None or not app.state.session or not app.state.session.fit_recorded:
            await pilot.pause(0.05)
        await pilot.pause(0.2)
        picture = app.export_screenshot(title="solarcal")
        if app.conductor is not None:
            app.conductor.close()
    return _REMOTE_FONT.sub("", picture)


def main() -> int:
    if len(sys.argv) != 2:
        print("usage: python -m solarcal.tui.picture FILE.svg", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        session_file = Path(folder) / "tijeras-azel-2026-06-03.jsonl"
        picture = asyncio.run(workstation_svg(session_file))
    Path(sys.argv[1]).write_text(picture, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
