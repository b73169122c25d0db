"""Bars made of characters, readable without colour."""


def limit_bar(low: float, high: float, value: float, width: int) -> str:
    """Where a read-out stands between its limits: ``├──●─────┤``, the mark outside when beyond."""
    inside = max(1, width - 2)
    share = (value - low) / (high - low)
    place = round(share * (inside - 1))
    if share < 0.0:
        return "●" + "─" * inside + "┤"
    if share > 1.0:
        return "├" + "─" * inside + "●"
    return "├" + "─" * place + "●" + "─" * (inside - 1 - place) + "┤"


def phase_bar(phase: float, width: int) -> str:
    """How far the update cycle is, 0 just after an update, 1 when the next one is due."""
    full = round(min(max(phase, 0.0), 1.0) * width)
    return "█" * full + "░" * (width - full)
