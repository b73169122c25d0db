"""What keys mean: the manual's chords, the user's keymap, and the Alt+F3 terminals cannot send."""

import json
import time

import pytest
from procedure_bench import bench, shows, workstation
from textual import _parser, events
from textual._xterm_parser import XTermParser

from solarcal.cli import run_command
from solarcal.cli.keys import read_keys
from solarcal.config import config_dir
from solarcal.errors import ConfigurationError
from solarcal.tui.action_handlers import ACTION_HANDLERS
from solarcal.tui.app import SolarcalApp
from solarcal.tui.keys import (
    ACTIONS,
    BY_ID,
    action_for,
    bound_actions,
    checked_keymap,
    modified_f3,
    shown_key,
)
from solarcal.tui.workstation.screen import WorkstationScreen

ALT_F3 = "\x1b[1;3R"


def test_the_alt_f3_workaround_is_still_needed():
    """Fails when Textual gives Alt+F3 as a key: then ``keyboard.modified_f3`` can go."""
    parser = XTermParser()
    told = [*parser.feed(ALT_F3), *parser.feed("")]
    assert not any(isinstance(event, events.Key) for event in told)
    assert any(isinstance(event, events.CursorPosition) for event in told)


@pytest.mark.parametrize(
    ("row", "column", "key"),
    [
        (1, 2, "shift+f3"),
        (1, 3, "alt+f3"),
        (1, 5, "ctrl+f3"),
        (1, 7, "alt+ctrl+f3"),
        (1, 67, "alt+f3"),  # with Caps Lock
        (1, 131, "alt+f3"),  # with Num Lock
        (1, 1, None),
        (2, 3, None),
        (1, 9, None),
        (1, 400, None),
    ],
)
def test_a_row_one_cursor_report_is_a_modified_f3(row, column, key):
    assert modified_f3(row, column) == key


async def test_alt_f3_as_terminals_send_it_asks_for_initialise(tmp_path):
    station, _ = bench(tmp_path / "session.jsonl")
    async with workstation(station) as (app, pilot):
        app.push_screen(WorkstationScreen())
        await shows(pilot, "LINK OK")
        parser = XTermParser()
        for event in [*parser.feed(ALT_F3), *parser.feed("")]:
            app.post_message(event)
        await shows(pilot, "Initialise the data file", "Are you sure?")


def test_every_chord_of_the_manual_is_its_action():
    chords = {
        "alt+f3": "initialise", "alt+f5": "ref_check", "alt+f7": "take_point",
        "full_stop": "take_point", "ctrl+f9": "recompute",
    }  # fmt: skip
    for key, action_id in chords.items():
        assert action_for(key).id == action_id


def test_no_key_has_two_actions_and_every_action_does_something():
    keys = [key for action in ACTIONS for key in action.keys]
    assert len(keys) == len(set(keys))
    assert "escape" not in keys
    assert set(BY_ID) - {"stop"} == set(ACTION_HANDLERS)


def test_no_action_needs_a_modifier_but_the_way_out():
    for action in ACTIONS:
        assert action.id == "quit" or any("+" not in key for key in action.keys)


@pytest.mark.parametrize(
    ("keymap", "words"),
    [
        ({"take_pint": "t"}, "did you mean take_point"),
        ({"note": ""}, "note has no key"),
        ({"note": "f12"}, "F12 is always STOP"),
        ({"note": "ctrl+s"}, "is always STOP"),
        ({"note": "t", "void": "t"}, "assigned to note and to void"),
        ({"note": "escape"}, "escape always leaves"),
    ],
)
def test_mistakes_in_the_keymap_are_named(keymap, words):
    with pytest.raises(ConfigurationError, match=words):
        checked_keymap(keymap)


def test_a_keymap_gives_keys_and_takes_them_away():
    actions = bound_actions(checked_keymap({"note": "v,f11"}))
    assert action_for("v", actions).id == "note"
    assert action_for("f11", actions).shown == "v F11"
    assert action_for("n", actions) is None
    assert next(a for a in actions if a.id == "next_plot").keys == ()


def test_stop_keeps_f12_and_ctrl_s_whatever_the_keymap_says():
    actions = bound_actions({"stop": "space"})
    assert action_for("f12", actions).id == action_for("ctrl+s", actions).id == "stop"


async def test_the_keymap_rules_the_program_and_its_help(tmp_path):
    app = SolarcalApp(keymap=checked_keymap({"help": "z"}))
    async with app.run_test(size=(100, 50)) as pilot:
        await pilot.press("z")
        await shows(pilot, "THE PROCEDURE", "z Help")


def test_shown_keys_read_as_on_the_keyboard():
    assert [shown_key(k) for k in ("alt+f3", "ctrl+s", "full_stop", "f12", "n")] == [
        "Alt+F3", "^S", ".", "F12", "n",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("sent", "key", "action_id"),
    [
        (b"\x1b[1;3R", "alt+f3", "initialise"),
        (b"\x1b[15;3~", "alt+f5", "ref_check"),
        (b"\x1b[20;5~", "ctrl+f9", "recompute"),
        (b"\x1bOR", "f3", "initialise"),
        (b".", "full_stop", "take_point"),
        (b"\x13", "ctrl+s", "stop"),
    ],
)
def test_solarcal_keys_tells_bytes_key_and_action(sent, key, action_id):
    ((name, line),) = read_keys(sent, ACTIONS)
    assert name == key
    assert sent.hex(" ") in line
    assert f"({action_id})" in line


@pytest.mark.parametrize(
    ("sent", "key"), [(b"\x1b[M", "F1"), (b"\x1b[O", "F3"), (b"\x1b[T", "F8"), (b"\x1b[X", "F12")]
)
def test_function_keys_of_putty_in_its_sco_setting_are_no_letters_but_an_advice(sent, key):
    ((name, line),) = read_keys(sent, ACTIONS)
    assert name == ""
    assert f"SCO {key}" in line
    assert "Xterm R6" in line


@pytest.mark.parametrize(("stop", "key"), [("\x13", "ctrl+s"), ("s", "s"), ("\x1b[24~", "f12")])
def test_stop_pressed_right_after_puttys_sco_f1_arrives(stop, key, monkeypatch):
    """``ESC[M`` begins an old mouse report: three more bytes are waited for, but not for long."""
    parser = XTermParser()
    assert list(parser.feed("\x1b[M")) == []
    seen = list(parser.feed(stop))
    monkeypatch.setattr(_parser, "get_time", lambda: time.monotonic() + 10.0)
    seen += parser.tick()
    assert key in [event.key for event in seen if isinstance(event, events.Key)]


def test_solarcal_keys_without_a_terminal_prints_the_table(capsys):
    assert run_command(["keys", "--headless"]) == 0
    printed = capsys.readouterr().out
    assert all(action.id in printed for action in ACTIONS)


def test_solarcal_keys_follows_the_keymap_file(capsys):
    config_dir().mkdir(parents=True)
    (config_dir() / "keymap.toml").write_text('take_point = "space"\n')
    assert run_command(["keys", "--json"]) == 0
    actions = {a["id"]: a for a in json.loads(capsys.readouterr().out)["actions"]}
    assert actions["take_point"]["keys"] == ["space"]


def test_a_broken_keymap_file_is_one_line(capsys):
    config_dir().mkdir(parents=True)
    (config_dir() / "keymap.toml").write_text('fly = "f"\n')
    assert run_command(["keys"]) == 2
    assert "no action 'fly'" in capsys.readouterr().err
