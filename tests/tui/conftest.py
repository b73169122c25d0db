"""Every test of the screens has folders and a terminal of its own."""

import asyncio
import inspect

import pytest
import textual.app
import textual.pilot
from textual.app import App
from textual.css.stylesheet import Stylesheet


@pytest.fixture(scope="session", autouse=True)
def paints_are_counted():
    """`app.paints`: so that a test looks at a screen again only when it has changed."""
    display = App._display

    def counting(app, screen, renderable):
        app.paints = getattr(app, "paints", 0) + 1
        display(app, screen, renderable)

    patched = pytest.MonkeyPatch()
    patched.setattr(App, "_display", counting)
    yield
    patched.undo()


@pytest.fixture(scope="session", autouse=True)
def keys_wait_for_messages():
    """A key pressed by a test is dealt with when the event loop has nothing more to run.

    Textual's own tests wait until the processor has been idle for a fiftieth of a second, which
    with a busy second worker never comes, and otherwise is most of what a test takes.
    """

    async def nothing_to_run(min_sleep: float = 0.0, max_sleep: float = 1.0) -> None:
        loop, idle = asyncio.get_running_loop(), 0
        for _ in range(100_000):
            await asyncio.sleep(0)
            idle = 0 if loop._ready else idle + 1
            if idle == 3:
                return
        raise AssertionError("the event loop never comes to rest")

    async def nothing_to_paint(min_sleep: float = 0.0, max_sleep: float = 1.0) -> None:
        """Layout and painting follow a message by a sixtieth of a second."""
        await asyncio.sleep(1 / 50)
        await nothing_to_run()

    patched = pytest.MonkeyPatch()
    patched.setattr(textual.app, "wait_for_idle", nothing_to_run)
    patched.setattr(textual.pilot, "wait_for_idle", nothing_to_paint)
    yield
    patched.undo()


@pytest.fixture(scope="session", autouse=True)
def style_sheets_are_parsed_once():
    """A program has one app, which parses each style sheet once; a test run has hundreds of apps.

    What the rules are depends on the text, where it comes from, and the theme's variables, and they
    are only read afterwards. Gives what parses them in the program.
    """
    parse_rules, parsed = Stylesheet._parse_rules, {}

    def known(self, css, read_from, is_default_rules=False, tie_breaker=0, scope=""):
        # The theme's variables are the same object until the theme is another.
        if getattr(self, "_variables_known", None) is not self._variables:
            self._variables_known = self._variables
            self._variables_key = tuple(self._variables.items())
        place = (css, read_from, is_default_rules, tie_breaker, scope)
        rules = parsed.setdefault(self._variables_key, {})
        if place not in rules:
            rules[place] = parse_rules(self, *place)
        return rules[place]

    patched = pytest.MonkeyPatch()
    patched.setattr(Stylesheet, "_parse_rules", known)
    yield parse_rules
    patched.undo()


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "sessions"))
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path / "units"))
    monkeypatch.setenv("TERM", "xterm-256color")
    monkeypatch.delenv("NO_COLOR", raising=False)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    """Run a test written as a coroutine on an event loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    names = pyfuncitem._fixtureinfo.argnames
    asyncio.run(pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in names}))
    return True
