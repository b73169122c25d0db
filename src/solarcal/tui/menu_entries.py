"""What the start screen offers: ports with what they are, emulated trackers, saved sessions."""

from dataclasses import dataclass

from serial.tools import list_ports

from solarcal.config import Choice, Settings
from solarcal.emulator.scenario import load_scenario, scenario_names
from solarcal.station.saved_sessions import continuing, saved_sessions
from solarcal.unit.link import describe

Entry = tuple[str, Choice]


@dataclass(frozen=True, slots=True)
class MenuEntries:
    """Entries of each section, the likeliest first."""

    unfinished: list[Entry]
    ports: list[Entry]
    scenarios: list[Entry]
    replays: list[Entry]


def menu_entries(settings: Settings) -> MenuEntries:
    """Look at ports, scenarios and saved sessions; takes as long as they take."""
    saved = saved_sessions()
    known, unknown = [], []
    for session in saved:
        if session.finished or session.damage:
            continue
        if choice := continuing(session, settings.line_of(session.path)):
            known.append((session.words(), choice))
        else:
            asked = Choice(session=str(session.path))
            unknown.append((f"{session.words()}, on which line?", asked))
    replays = [
        (session.words(), Choice(replay=str(session.path))) for session in saved if session.points
    ]
    return MenuEntries([*known, *unknown], _ports(), _scenarios(), replays)


def _ports() -> list[Entry]:
    ports = [describe(port) for port in list_ports.comports()]
    entries = []
    for port in sorted(ports, key=lambda port: (not port["likely"], port["port"])):
        shut = port["readable"] is False or port["writable"] is False
        access = "  NO ACCESS: see solarcal doctor" if shut else ""
        words = f"{port['port']:16} {port['looks_like']}{access}"
        entries.append((words, Choice(port=port["port"])))
    return entries


def _scenarios() -> list[Entry]:
    return [
        (f"{name:20} {load_scenario(name).summary}", Choice(scenario=name))
        for name in scenario_names()
    ]
