"""Which tests reach which line: measured once, by coverage, test by test and fixture by fixture.

As a pytest plugin (``-p tools.mutants.reach``) it writes, for the run it is loaded in, a JSON
document to the file named by ``MUTANTS_REACH``; `Reach` reads such documents.
"""

import functools
import importlib
import json
import os
import pkgutil
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import coverage
import pytest

import solarcal

VARIABLE = "MUTANTS_REACH"
_CALLED = "test "
_SET_UP = "fixture "


class _Recorder:
    """Switches coverage's context with every test and every fixture of a wider scope.

    What the program keeps of earlier calls is forgotten before each test: else only the first of
    them would reach it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.coverage = coverage.Coverage(data_file=None, source=["src/solarcal"], branch=False)
        self.durations: dict[str, float] = {}
        self.used: dict[str, list[str]] = defaultdict(list)
        self.caches: list[Any] = []
        made: Any = functools._lru_cache_wrapper

        def remembered(*args: Any) -> Any:
            self.caches.append(made(*args))
            return self.caches[-1]

        functools._lru_cache_wrapper = remembered  # type: ignore[misc, assignment]
        self.coverage.start()
        # Else what runs at import would be of the test that happens to import it first.
        for module in pkgutil.walk_packages(solarcal.__path__, "solarcal."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        for cached in self.caches:
            if str(cached.__module__).startswith("solarcal."):
                cached.cache_clear()
        begun = os.times()
        self.coverage.switch_context(_CALLED + item.nodeid)
        information: Any = getattr(item, "_fixtureinfo", None)
        for name, fixtures in information.name2fixturedefs.items() if information else ():
            for fixture in fixtures:
                self.used[_SET_UP + f"{fixture.baseid}::{name}"].append(item.nodeid)
        result = yield
        self.coverage.switch_context("")
        # Of the processor's, children included: the machine may have other work.
        self.durations[item.nodeid] = sum(os.times()[:4]) - sum(begun[:4])
        return result

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: Any, request: pytest.FixtureRequest
    ) -> Iterator[None]:
        shared = fixturedef.scope != "function"
        if shared:
            self.coverage.switch_context(_SET_UP + f"{fixturedef.baseid}::{fixturedef.argname}")
        try:
            return (yield)
        finally:
            if shared and hasattr(request, "_pyfuncitem"):
                self.coverage.switch_context(_CALLED + request._pyfuncitem.nodeid)

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        self.coverage.stop()
        if exitstatus:
            return
        data = self.coverage.get_data()
        lines: dict[str, dict[int, list[str]]] = {}
        for file in data.measured_files():
            name = Path(file).relative_to(Path.cwd()).as_posix()
            by_line = data.contexts_by_lineno(file)
            lines[name] = {
                line: [c for c in contexts if c] for line, contexts in by_line.items() if contexts
            }
        document = {"durations": self.durations, "used": self.used, "lines": lines}
        self.path.write_text(json.dumps(document), encoding="utf-8")


def pytest_configure(config: pytest.Config) -> None:
    path = os.environ.get(VARIABLE)
    if path:
        config.pluginmanager.register(_Recorder(Path(path)), "mutants-reach")


class Reach:
    """What the documents of one or more runs say together."""

    def __init__(self, documents: list[Path], root: Path) -> None:
        self.durations: dict[str, float] = {}
        self._root = root
        self._texts: dict[str, str] = {}
        self._lines: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
        for path in documents:
            document = json.loads(path.read_text(encoding="utf-8"))
            self.durations |= document["durations"]
            used = document["used"]
            for file, lines in document["lines"].items():
                for line, contexts in lines.items():
                    for context in contexts:
                        reached = self._lines[file][int(line)]
                        if context.startswith(_CALLED):
                            reached.add(context.removeprefix(_CALLED))
                        else:
                            reached.update(used.get(context, ()))

    def tests(self, path: str, first_line: int, last_line: int) -> set[str]:
        """Tests that reach any of these lines; of what runs at import, those that use its names,
        themselves or in a line of the program that they reach."""
        found = self._of_lines(path, range(first_line, last_line + 1))
        if found:
            return found
        names = self._names(path, first_line)
        if names:
            word = re.compile(rf"\b(?:{'|'.join(map(re.escape, names))})\b")
            for file in list(self._lines):
                text = (self._root / file).read_text(encoding="utf-8").splitlines()
                using = [i for i, line in enumerate(text, start=1) if word.search(line)]
                found |= self._of_lines(file, using)
            found |= {test for test in self.durations if word.search(self._text_of(test))}
        return found or self._of_lines(path, self._lines[path])

    def _text_of(self, test: str) -> str:
        """Of the file a test stands in."""
        file = test.partition("::")[0]
        if file not in self._texts:
            self._texts[file] = (self._root / file).read_text(encoding="utf-8")
        return self._texts[file]

    def _of_lines(self, path: str, lines: Any) -> set[str]:
        known = self._lines.get(path, {})
        return {test for line in lines for test in known.get(line, ())}

    def _names(self, path: str, line: int) -> list[str]:
        """What a statement outside functions binds: constants, fields and their class."""
        text = (self._root / path).read_text(encoding="utf-8").splitlines()
        names: list[str] = []
        for at in range(line - 1, -1, -1):
            bound = re.match(r"( *)(?:class |def )?([A-Za-z_]\w*(?:, *[A-Za-z_]\w*)*)", text[at])
            if bound is None or (names and bound[1]):
                continue
            names += re.split(r", *", bound[2])
            if not bound[1]:
                break
        return names
