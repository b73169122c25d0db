"""What is imported late is imported by one thread at a time, and a fault of opening is shown."""

import ast
import threading
from pathlib import Path

import pytest
from procedure_bench import shows, until

import solarcal.emulated_units
import solarcal.tui
from solarcal.config import Choice
from solarcal.errors import ConfigurationError
from solarcal.tui.app import SolarcalApp
from solarcal.tui.base import ONE_IMPORT

FILES = sorted(Path(solarcal.tui.__path__[0]).rglob("*.py"))
IMPORTS = (ast.Import, ast.ImportFrom)


def imports_within(node: ast.AST, *, held: bool = False) -> list[int]:
    """Lines of the imports inside functions that are not under ``with ONE_IMPORT``."""
    lines = []
    for child in ast.iter_child_nodes(node):
        if isinstance(child, IMPORTS):
            lines += [] if held else [child.lineno]
            continue
        by_this = isinstance(child, ast.With) and any(
            isinstance(item.context_expr, ast.Name) and item.context_expr.id == "ONE_IMPORT"
            for item in child.items
        )
        lines += imports_within(child, held=held or by_this)
    return lines


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_late_import_of_the_screens_waits_for_the_others(path):
    tree = ast.parse(path.read_text())
    functions = [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]
    assert [line for function in functions for line in imports_within(function)] == []


async def test_a_line_is_opened_when_no_other_thread_is_importing(monkeypatch):
    opened, begun, done = (threading.Event() for _ in range(3))

    def open_choice(*_, **__):
        opened.set()
        raise ConfigurationError("there is no such unit")

    def importing():
        with ONE_IMPORT:
            begun.set()
            done.wait(10.0)

    monkeypatch.setattr(solarcal.emulated_units, "open_choice", open_choice)
    app = SolarcalApp()
    async with app.run_test() as pilot:
        await shows(pilot, "Emulated trackers")
        threading.Thread(target=importing, daemon=True).start()
        assert begun.wait(10.0)
        app.open_choice(Choice(scenario="tijeras-azel"))
        await shows(pilot, "opening emulated tracker")
        assert not opened.is_set()
        done.set()
        await shows(pilot, "there is no such unit")


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
async def test_a_fault_of_the_program_while_a_line_opens_ends_it(monkeypatch):
    def open_choice(*_, **__):
        raise ZeroDivisionError

    async def until_it_ends():
        async with SolarcalApp(start=Choice(scenario="tijeras-azel")).run_test() as pilot:
            await until(pilot, lambda: not pilot.app.is_running)

    monkeypatch.setattr(solarcal.emulated_units, "open_choice", open_choice)
    with pytest.raises(ZeroDivisionError):
        await until_it_ends()
