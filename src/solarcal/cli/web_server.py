"""textual-serve's server, closed to pages of other sites.

A browser lets any page open a websocket to this machine. Without a check a page of a stranger could
press keys here; so a request must name this server as its host, and as its origin if it has one.
"""

from collections.abc import Awaitable, Callable

from aiohttp import web
from textual_serve.server import Server

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class GuardedServer(Server):
    """Serves ``command`` at ``http://host:port`` and refuses (403) what comes from elsewhere."""

    async def _make_app(self) -> web.Application:
        app = await super()._make_app()
        app.middlewares.append(self._only_own_pages)
        return app

    @web.middleware
    async def _only_own_pages(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        origin = request.headers.get("Origin")
        own = (self.public_url, self.public_url.replace("//localhost", "//127.0.0.1"))
        if f"http://{request.host}" not in own or (origin is not None and origin not in own):
            raise web.HTTPForbidden(text=f"open {self.public_url} itself; this page is of another")
        return await handler(request)
