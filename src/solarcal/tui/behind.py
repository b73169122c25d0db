"""The screen behind a dialog: of it only the lines that changed are drawn again.

Textual draws all of it anew, by way of rich's console, for every cell of it that changes. While a
dialog is open that is each status of the unit and each look at the spot, and took longer than the
rest of the program. The picture is the same; ``tests/tui/test_behind.py`` compares the two.

For that it uses names that Textual keeps to itself. A release of Textual without one of them, or
with another meaning of it, draws all of the screen itself, slower.
"""

from functools import lru_cache
from typing import Any

from rich.segment import Segment
from rich.style import Style
from textual.color import Color
from textual.geometry import Region
from textual.screen import Screen
from textual.strip import Strip

try:
    from textual._context import visible_screen_stack
except ImportError:
    TEXTUAL_AS_KNOWN = False
else:
    TEXTUAL_AS_KNOWN = True


def draw_behind(screen: Screen[Any]) -> bool:
    """In place of a screen's ``_render_content``; ``False`` where Textual has to draw it."""
    if not TEXTUAL_AS_KNOWN:
        return False
    try:
        return _draw_changed(screen)
    except (AttributeError, TypeError, ValueError) as error:
        screen.log.warning(f"drawn by Textual itself: {error!r}")
        return False


def _draw_changed(screen: Screen[Any]) -> bool:
    stack, tint = screen.app.screen_stack, screen.styles.background
    if screen not in stack[1:] or tint.a == 1.0:
        return False
    at = stack.index(screen) - 1
    behind = stack[at]
    width, height = screen.size
    base = screen.visual_style.rich_style
    before = screen._render_cache
    if before.size == screen.size and len(before.lines) == height:
        lines = list(before.lines)
        changed = {y for region in screen._dirty_regions for y in region.line_range}
        changed.intersection_update(range(height))
    else:
        # With a style: one without has no colour to take away where the terminal shall have none.
        lines = [Strip.blank(width, base)] * height
        changed = set(range(height))
    if changed:
        top, bottom = min(changed), max(changed) + 1
        crop = Region(0, top, width, bottom - top)
        # What Textual draws of that screen itself may have others behind it.
        visible_screen_stack.set(list(stack[:at]))
        chops = behind._compositor._render_chops(crop, changed.__contains__)
        for y in changed.intersection(range(len(chops))):
            lines[y] = Strip(
                Segment(text, base + seen_through(style or Style.null(), tint))
                for text, style, _ in Strip.join(chops[y].values())
            )
    screen._render_cache = before._replace(size=screen.size, lines=lines)
    screen._dirty_regions.clear()
    return True


@lru_cache(maxsize=4096)
def seen_through(style: Style, tint: Color) -> Style:
    """A style under a translucent colour, without links."""
    plain = style.clear_meta_and_links()
    if tint.a == 0.0:
        return plain
    character, ground = (
        (Color.from_rich_color(colour) + tint).rich_color if colour is not None else None
        for colour in (plain.color, plain.bgcolor)
    )
    return plain + Style.from_color(character, ground)
