"""Every test of the screens has a config and a sessions folder of its own."""

import asyncio
import inspect

import pytest


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    monkeypatch.setenv("SOLARCAL_CONFIG", str(tmp_path / "config"))
    monkeypatch.setenv("SOLARCAL_SESSIONS", str(tmp_path / "sessions"))
    monkeypatch.setenv("SOLARCAL_UNITS", str(tmp_path / "units"))
    monkeypatch.delenv("NO_COLOR", raising=False)


@pytest.hookimpl(tryfirst=True)
def pytest_pyfunc_call(pyfuncitem):
    """Run a test written as a coroutine on an event loop of its own."""
    if not inspect.iscoroutinefunction(pyfuncitem.obj):
        return None
    names = pyfuncitem._fixtureinfo.argnames
    asyncio.run(pyfuncitem.obj(**{name: pyfuncitem.funcargs[name] for name in names}))
    return True
