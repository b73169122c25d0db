"""The workstation in a browser: what is opened, who may reach it, and that keys act."""

import asyncio
import base64
import contextlib
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from pathlib import Path

import aiohttp
import pytest

from solarcal.cli import run_command

SESSION = Path(__file__).parents[2] / "sessions" / "azel-good-day.jsonl"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


STYLE = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")


@pytest.fixture
def page(tmp_path: Path, free_port: Callable[[], int]) -> Iterator[str]:
    """The address of a served workstation."""
    (tmp_path / "sessions").mkdir()
    shutil.copy(SESSION, tmp_path / "sessions")
    port = free_port()
    environment = {
        **os.environ,
        "SOLARCAL_CONFIG": str(tmp_path / "config"),
        "SOLARCAL_SESSIONS": str(tmp_path / "sessions"),
    }
    command = [sys.executable, "-m", "solarcal", "serve", "--tcp-port", str(port)]
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as server:
        try:
            yield f"http://localhost:{port}"
        finally:
            server.terminate()
            server.wait(timeout=30)


async def fetched(address: str, **headers: str) -> tuple[int, str]:
    """Status and text, as soon as the server is there."""
    async with aiohttp.ClientSession() as client:
        for _ in range(600):
            with contextlib.suppress(aiohttp.ClientConnectorError):
                async with client.get(address, headers=headers) as answer:
                    return answer.status, await answer.text()
            await asyncio.sleep(0.05)
    raise AssertionError(f"nothing answers at {address}")


async def drawn_until(wanted: str, socket_of_page: aiohttp.ClientWebSocketResponse) -> str:
    """What a page is sent until it holds ``wanted``."""
    text = ""
    async with asyncio.timeout(60):
        async for message in socket_of_page:
            if message.type is aiohttp.WSMsgType.BINARY:
                text += message.data.decode("utf-8", "replace")
            if wanted in STYLE.sub("", text):
                return text
    raise AssertionError(f"{wanted!r} was not drawn")


def test_pages_of_other_sites_are_refused(page):
    async def all_of_it() -> None:
        assert (await fetched(page))[0] == 200
        assert (await fetched(page, Origin="http://elsewhere.example"))[0] == 403
        assert (await fetched(page, Host="elsewhere.example"))[0] == 403
        async with aiohttp.ClientSession() as client:
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await client.ws_connect(f"{page}/ws", headers={"Origin": "http://a.example"})

    asyncio.run(all_of_it())


def test_a_page_offers_saved_sessions_and_no_unit(page):
    async def all_of_it() -> str:
        await fetched(page)
        async with (
            aiohttp.ClientSession() as client,
            client.ws_connect(f"{page}/ws?width=100&height=30") as drawing,
        ):
            text = await drawn_until(SESSION.name, drawing)
            await drawing.send_json(["stdin", "\r"])
            return text + await drawn_until("nothing recorded yet", drawing)

    text = asyncio.run(all_of_it())
    assert "Emulated trackers" not in text
    assert "Serial ports" not in text


@contextlib.asynccontextmanager
async def browser(
    address: str, folder: Path, port: int
) -> AsyncIterator[aiohttp.ClientWebSocketResponse]:
    """A real Chromium at ``address``, and the socket that its debugger listens on."""
    assert CHROMIUM is not None
    process = await asyncio.create_subprocess_exec(
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
        f"--user-data-dir={folder}", f"--remote-debugging-port={port}", "--window-size=1200,800",
        "about:blank", stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL,
    )  # fmt: skip
    try:
        pages = json.loads((await fetched(f"http://127.0.0.1:{port}/json"))[1])
        debugger = next(one for one in pages if one["type"] == "page")["webSocketDebuggerUrl"]
        async with aiohttp.ClientSession() as client, client.ws_connect(debugger) as devtools:
            await devtools.send_json({"id": 1, "method": "Network.enable"})
            await devtools.send_json(
                {"id": 2, "method": "Page.navigate", "params": {"url": address}}
            )
            yield devtools
    finally:
        process.terminate()
        await process.wait()


async def answered(
    devtools: aiohttp.ClientWebSocketResponse, number: int, method: str, **params: object
) -> None:
    """Ask the browser for something and wait until it has done it."""
    await devtools.send_json({"id": number, "method": method, "params": params})
    async with asyncio.timeout(60):
        async for message in devtools:
            if json.loads(message.data).get("id") == number:
                return


async def shown_until(wanted: str, devtools: aiohttp.ClientWebSocketResponse) -> None:
    """Wait until the page's own websocket has brought ``wanted``."""
    text = ""
    async with asyncio.timeout(60):
        async for message in devtools:
            event = json.loads(message.data)
            if event.get("method") == "Network.webSocketFrameReceived":
                frame = event["params"]["response"]
                if frame["opcode"] == 2:
                    text += base64.b64decode(frame["payloadData"]).decode("utf-8", "replace")
            if wanted in STYLE.sub("", text):
                return
    raise AssertionError(f"{wanted!r} was not shown")


@pytest.mark.skipif(CHROMIUM is None, reason="needs Chromium")
def test_in_a_real_browser_keys_act(page, tmp_path, free_port):
    async def all_of_it() -> None:
        await fetched(page)
        async with browser(page, tmp_path / "chromium", free_port()) as devtools:
            await shown_until(SESSION.name, devtools)
            focus = "document.querySelector('.xterm-helper-textarea').focus()"
            await answered(devtools, 3, "Runtime.evaluate", expression=focus)
            f1 = {"key": "F1", "code": "F1", "windowsVirtualKeyCode": 112}
            await answered(devtools, 4, "Input.dispatchKeyEvent", type="rawKeyDown", **f1)
            await shown_until("Set Sun Offset", devtools)

    asyncio.run(all_of_it())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--tcp-port", "0"], "--tcp-port 0 is not between 1 and 65535"),
        (["missing.jsonl"], "missing.jsonl"),
        ([str(SESSION), "--allow-motion"], "give one"),
    ],
)
def test_what_cannot_be_served_is_one_line(words, message, capsys):
    assert run_command(["serve", *words]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
