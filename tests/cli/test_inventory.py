"""Every command, option, form and form field there has been is still there (more may come)."""

import argparse
import json
from pathlib import Path

import pytest

from solarcal.cli import build_parser
from solarcal.instruments.catalogue import BY_ID

INVENTORY = json.loads(Path(__file__).with_name("inventory.json").read_text(encoding="utf-8"))


def parser_of(line: str) -> argparse.ArgumentParser:
    """The parser of a command, or of its subcommand."""
    parser = build_parser(line.split()[0])
    for word in line.split():
        (choices,) = (
            action.choices
            for action in parser._actions
            if isinstance(action, argparse._SubParsersAction)
        )
        parser = choices[word]
    return parser


@pytest.mark.parametrize("line", INVENTORY["commands"])
def test_a_command_still_takes_every_option(line):
    actions = parser_of(line)._actions
    names = {name for action in actions for name in action.option_strings or (action.dest,)}
    assert set(INVENTORY["commands"][line]) <= names


@pytest.mark.parametrize("name", INVENTORY["forms"])
def test_a_form_still_has_every_field_and_choice(name):
    fields = {field.name: set(field.choices) for field in BY_ID[name].rows}
    for field, choices in INVENTORY["forms"][name].items():
        assert set(choices) <= fields[field], field
