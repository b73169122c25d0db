"""Words written anew with every status: a screen is laid out again only where it must be."""

from textual.content import Content
from textual.visual import VisualType
from textual.widgets import Static


class Words(Static):
    """A ``Static`` as wide as its place. Words it has already cost nothing; others are drawn, and
    only where they need more rows or fewer, the whole screen is laid out."""

    def update(self, content: VisualType = "", *, layout: bool = True) -> None:
        if _same(content, self.content):
            return
        rows = self._rows
        super().update(content, layout=layout and not self.is_mounted)
        if layout and self.is_mounted and (rows is None or rows != self._rows):
            self.refresh(layout=True)

    @property
    def _rows(self) -> int | None:
        """How many it needs, ``None`` where it is not in view; nought where they are fixed."""
        height = self.styles.height
        if height is not None and not height.is_auto:
            return 0
        width = self.size.width
        return self.get_content_height(self.app.size, self.app.size, width) if width else None


def _same(content: VisualType, before: VisualType) -> bool:
    if isinstance(content, Content):
        return isinstance(before, Content) and content.is_same(before)
    return isinstance(content, str) and isinstance(before, str) and content == before
