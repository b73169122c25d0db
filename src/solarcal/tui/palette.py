"""The command palette: every action by its name, and the themes."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, cast

from textual.command import DiscoveryHit, Hit, Hits, Provider

if TYPE_CHECKING:
    from solarcal.tui.app import SolarcalApp


class ActionProvider(Provider):
    """Every action of the workstation, with its keys and what it is for."""

    def _entries(self) -> Iterator[tuple[str, str, str]]:
        app = cast("SolarcalApp", self.app)
        for action in app.actions:
            yield f"{action.label}   {action.shown}", action.tooltip, action.id

    async def discover(self) -> Hits:
        app = cast("SolarcalApp", self.app)
        for title, tooltip, action_id in self._entries():
            yield DiscoveryHit(title, lambda name=action_id: app.action_perform(name), help=tooltip)

    async def search(self, query: str) -> Hits:
        app = cast("SolarcalApp", self.app)
        matcher = self.matcher(query)
        for title, tooltip, action_id in self._entries():
            score = max(matcher.match(title), 0.8 * matcher.match(tooltip))
            if score > 0.0:
                yield Hit(
                    score,
                    matcher.highlight(title),
                    lambda name=action_id: app.action_perform(name),
                    help=tooltip,
                )
