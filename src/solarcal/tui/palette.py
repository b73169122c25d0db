"""The command palette: every action and every calculator by its name, and the themes."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import TYPE_CHECKING, cast

from textual.command import DiscoveryHit, Hit, Hits, Provider

if TYPE_CHECKING:
    from solarcal.tui.app import SolarcalApp


class ActionProvider(Provider):
    """Every action of the workstation with its keys, every calculator, and what they are for."""

    def _entries(self) -> Iterator[tuple[str, str, Callable[[], object]]]:
        from solarcal.tui.calculators.catalogue import CALCULATORS
        from solarcal.tui.screens.calculators import open_calculator

        app = cast("SolarcalApp", self.app)
        for action in app.actions:
            run = partial(app.action_perform, action.id)
            yield f"{action.label}   {action.shown}", action.tooltip, run
        for one in CALCULATORS:
            title = f"Calculator: {one.group}, {one.title}"
            yield title, one.purpose, partial(open_calculator, app, one)

    async def discover(self) -> Hits:
        for title, tooltip, run in self._entries():
            yield DiscoveryHit(title, run, help=tooltip)

    async def search(self, query: str) -> Hits:
        matcher = self.matcher(query)
        for title, tooltip, run in self._entries():
            score = max(matcher.match(title), 0.8 * matcher.match(tooltip))
            if score > 0.0:
                yield Hit(score, matcher.highlight(title), run, help=tooltip)
