"""``solarcal scenarios``: what the emulator can play.

The JSON document: ``scenarios`` (``name``, ``summary``, ``start_utc``, ``settings``: every key of
``--set`` with its value) and ``default`` (a name).
"""

import argparse
from typing import Any

from solarcal.cli.output import add_json_option, print_json
from solarcal.timescale import format_utc


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Options of the command."""
    parser.add_argument(
        "scenario", nargs="?", metavar="NAME|FILE", help="show this one with all its keys"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """List all, or one with its keys."""
    from solarcal.emulator.scenario import DEFAULT_SCENARIO, load_scenario, scenario_names
    from solarcal.emulator.settings import settings_of

    names = [args.scenario] if args.scenario else scenario_names()
    scenarios = [load_scenario(name) for name in names]
    if args.json:
        found: list[dict[str, Any]] = [
            {
                "name": scenario.name,
                "summary": scenario.summary,
                "start_utc": format_utc(scenario.start_utc_s(), 0),
                "settings": settings_of(scenario),
            }
            for scenario in scenarios
        ]
        print_json({"scenarios": found, "default": DEFAULT_SCENARIO})
        return 0
    if args.scenario:
        (scenario,) = scenarios
        print(f"{scenario.name}: {scenario.summary}\n")
        settings = settings_of(scenario)
        width = max(map(len, settings))
        for key, value in settings.items():
            print(f"  {key:{width}}  {value_text(value)}")
        return 0
    width = max(len(scenario.name) for scenario in scenarios)
    for scenario in scenarios:
        mark = "  (default)" if scenario.name == DEFAULT_SCENARIO else ""
        print(f"{scenario.name:{width}}  {scenario.summary}{mark}")
    return 0


def value_text(value: Any) -> str:
    """A value as it would be written after ``KEY=``."""
    if value is None:
        return "(as built)"
    if isinstance(value, dict):
        inner = ", ".join(f"{key} = {value_text(item)}" for key, item in value.items())
        return "{ " + inner + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(value_text, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else f"{value}"
