"""Pictures of a screen one after the other, as one SVG that plays by itself and fetches nothing."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from tools.pictures.screen_svg import BASELINE, CELL_HEIGHT, FONT_SIZE, MARGIN

_SVG = re.compile(r'<svg [^>]*viewBox="0 0 ([\d.]+) ([\d.]+)"[^>]*>(.*)</svg>', re.DOTALL)


@dataclass(frozen=True, slots=True)
class Frame:
    """A picture of ``screen_svg``, what was done to come there, and how long it is shown."""

    svg: str
    caption: str
    seconds: float = 3.0


def film(frames: Sequence[Frame], *, title: str, ink: str, paper: str) -> str:
    """All frames, each for its time, over and over; the caption stands below the screen.

    Who asked the system for less motion sees the last frame only.
    """
    bodies = [match for match in (_SVG.search(frame.svg) for frame in frames) if match is not None]
    assert len(bodies) == len(frames), "a frame is no picture of ours"
    width = max(float(body[1]) for body in bodies)
    screen = max(float(body[2]) for body in bodies)
    height = screen + CELL_HEIGHT + MARGIN
    total_s = sum(frame.seconds for frame in frames)
    rules, groups, begins_s = [], [], 0.0
    for number, (frame, body) in enumerate(zip(frames, bodies, strict=True)):
        begin, end = 100.0 * begins_s / total_s, 100.0 * (begins_s + frame.seconds) / total_s
        begins_s += frame.seconds
        hidden = "0%{visibility:hidden}" if number else ""
        over = f"{end:.4g}%{{visibility:hidden}}" if number < len(frames) - 1 else ""
        rules.append(f"@keyframes f{number}{{{hidden}{begin:.4g}%{{visibility:visible}}{over}}}")
        groups.append(
            f'<g class="f" style="animation-name:f{number}">{body[3]}'
            f'<text x="{MARGIN:g}" y="{screen + BASELINE:g}" fill="{ink}">'
            f"{escape(frame.caption, quote=False)}</text></g>"
        )
    style = (
        f".f{{visibility:hidden;animation-duration:{total_s:g}s;animation-timing-function:step-end;"
        "animation-iteration-count:infinite}"
        "@media(prefers-reduced-motion){.f{animation:none}.f:last-child{visibility:visible}}"
    )
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" '
            f'width="{width:g}" height="{height:g}" role="img">',
            f"<title>{escape(title)}</title>",
            f"<style>{style}{''.join(rules)}</style>",
            f'<rect width="{width:g}" height="{height:g}" rx="5" fill="{paper}"/>',
            f'<g font-family="DejaVu Sans Mono, Menlo, Consolas, monospace" '
            f'font-size="{FONT_SIZE}">',
            *groups,
            "</g>",
            "</svg>",
            "",
        ]
    )
