"""``solarcal serve``: the workstation in a browser, one process for each page that is opened.

A browser lets any page open a websocket to this machine. Without a check a page of a stranger could
press keys here; so a request must name this server as its host, and as its origin if it has one.
"""

import argparse
import shlex
import subprocess
import sys
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import TYPE_CHECKING

from solarcal.errors import ConfigurationError

if TYPE_CHECKING:
    from aiohttp import web
    from textual_serve.server import Server

    Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

LOOPBACK = ("localhost", "127.0.0.1", "::1")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "file",
        nargs="?",
        type=Path,
        metavar="FILE",
        help="replay this session; default: choose on the page",
    )
    parser.add_argument(
        "--host", default="localhost", metavar="HOST",
        help="address to listen on (localhost: this machine only)",
    )  # fmt: skip
    parser.add_argument(
        "--tcp-port", type=int, default=8000, metavar="N", help="TCP port to listen on (8000)"
    )
    parser.add_argument(
        "--allow-motion", action="store_true",
        help="also open units: everyone who can open the page can then move the tracker",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl+C."""
    if not 1 <= args.tcp_port <= 65535:
        raise ConfigurationError(f"--tcp-port {args.tcp_port} is not between 1 and 65535")
    if args.file is not None and args.allow_motion:
        raise ConfigurationError("--allow-motion opens units; FILE is only replayed: give one")
    if args.file is not None:
        from solarcal.session.view import read_session

        read_session(args.file)
    try:
        server = guarded_server(workstation_command(args), args.host, args.tcp_port)
    except ModuleNotFoundError as error:
        raise ConfigurationError(
            f"serve needs the package textual-serve ({error.name} is missing); install it with: "
            "pip install 'solarcal[serve]'"
        ) from None
    if args.host not in LOOPBACK:
        print(
            f"solarcal: {args.host} may be reached from other machines: whoever opens the page can "
            + ("MOVE THE TRACKER and " if args.allow_motion else "")
            + "read every saved session. There is no password and no encryption.",
            file=sys.stderr,
        )
    server.serve()
    return 0


def workstation_command(args: argparse.Namespace) -> str:
    """Return the shell command that runs one page's workstation."""
    words = [sys.executable, "-m", "solarcal"]
    if args.file is not None:
        words += ["replay", str(args.file.resolve())]
    else:
        words += ["run"] if args.allow_motion else ["run", "--offline"]
    return subprocess.list2cmdline(words) if sys.platform == "win32" else shlex.join(words)


def guarded_server(command: str, host: str, port: int) -> "Server":
    """Serves ``command`` at ``http://host:port`` and refuses (403) what comes from elsewhere."""
    from aiohttp import web
    from textual_serve.server import Server

    class GuardedServer(Server):
        async def _make_app(self) -> web.Application:
            app = await super()._make_app()
            app.middlewares.append(self._only_own_pages)
            return app

        @web.middleware
        async def _only_own_pages(
            self, request: web.Request, handler: "Handler"
        ) -> web.StreamResponse:
            origin = request.headers.get("Origin")
            own = (self.public_url, self.public_url.replace("//localhost", "//127.0.0.1"))
            if f"http://{request.host}" not in own or (origin is not None and origin not in own):
                raise web.HTTPForbidden(
                    text=f"open {self.public_url} itself; this page is of another"
                )
            return await handler(request)

    return GuardedServer(command, host, port, "solarcal")
