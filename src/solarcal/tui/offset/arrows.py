"""Arrow keys as steps of a jog: how large each is, and what waits while the unit takes one."""

import math

from textual.content import Content

from solarcal.station.jogging import STEPS_DEG
from solarcal.tui.keys import DialogKey
from solarcal.unit.tracker import Spot

FIRST_STEP_DEG = 0.02
"""Of an arrow pressed once where nothing says how far the centre is."""

GROWS = ((24, 0.5), (16, 0.25), (10, 0.1), (4, 0.05))
"""After so many repeats of a held arrow, so large a step."""

MOST_WAITING = 3
"""Steps of a held arrow that may wait for the unit: what is more is not jogged after release."""

ARROW_KEYS = (
    DialogKey("step(None)", "step adapts", "0", "0", button=False),
    DialogKey("jog(-1,0)", "axis 1 -", "left", "left", button=False),
    DialogKey("jog(1,0)", "axis 1 +", "right", "right", button=False),
    DialogKey("jog(0,-1)", "axis 2 -", "down", "down", button=False),
    DialogKey("jog(0,1)", "axis 2 +", "up", "up", button=False),
    *(
        DialogKey(f"step({index})", f"{step:g}", str(index + 1), str(index + 1), button=False)
        for index, step in enumerate(STEPS_DEG)
    ),
    DialogKey("resize_step(-1)", "smaller step", "comma,left_square_bracket", ",", button=False),
    DialogKey("resize_step(1)", "larger step", "right_square_bracket", "]", button=False),
)


class ArrowSteps:
    """What the arrows ask for. ``jogging``: the unit is taking a step."""

    def __init__(self) -> None:
        self.jogging = False
        self._fixed: int | None = None
        """Index of the fixed step; ``None``: it adapts."""
        self._held: tuple[tuple[int, int], int] = ((0, 0), 0)
        self._to_jog = [0.0, 0.0]

    @property
    def nominal(self) -> int:
        """Index of the step that finer and coarser begin at."""
        return STEPS_DEG.index(0.05) if self._fixed is None else self._fixed

    def choose(self, index: int | None) -> None:
        """A fixed step, or ``None`` for one that adapts."""
        self._fixed = None if index is None else min(max(index, 0), len(STEPS_DEG) - 1)

    def press(self, axis1: int, axis2: int, spot: Spot | None) -> None:
        """An arrow: the axes' signs, and the spot as it was seen last."""
        step = self.step_deg(axis1, axis2, spot)
        most = MOST_WAITING * step
        for axis, sign in enumerate((axis1, axis2)):
            self._to_jog[axis] = min(max(self._to_jog[axis] + sign * step, -most), most)

    def take(self) -> tuple[float, float] | None:
        """What goes to the unit now: nothing while it takes a step, or where nothing waits."""
        if self.jogging or self._to_jog == [0.0, 0.0]:
            return None
        axis1_deg, axis2_deg = self._to_jog
        self.forget_waiting()
        return axis1_deg, axis2_deg

    def forget_waiting(self) -> None:
        self._to_jog = [0.0, 0.0]

    def forget(self) -> None:
        """Nothing that was asked for is jogged any more."""
        self.jogging = False
        self.forget_waiting()

    def step_deg(self, axis1: int, axis2: int, spot: Spot | None) -> float:
        """The fixed step, or one that suits: how far the spot is, else how long the key is held."""
        if self._fixed is not None:
            return STEPS_DEG[self._fixed]
        # An arrow that comes again before the unit has taken the one before it is held.
        arrow, count = self._held
        count = count + 1 if arrow == (axis1, axis2) and self.jogging else 0
        self._held = ((axis1, axis2), count)
        if spot is not None and spot.visible:
            far = abs(spot.error1_deg if axis1 else spot.error2_deg)
            return min(STEPS_DEG, key=lambda step: abs(math.log(step / max(far, STEPS_DEG[0]))))
        return next((step for repeats, step in GROWS if count >= repeats), FIRST_STEP_DEG)

    def words(self) -> Content:
        """All steps, the one in use marked."""
        adapts = self._fixed is None
        parts: list[str | tuple[str, str]] = [
            "Step ", ("[0:auto]" if adapts else " 0:auto ", "bold reverse" if adapts else "")
        ]  # fmt: skip
        for index, step in enumerate(STEPS_DEG):
            chosen = index == self._fixed
            text = f"[{index + 1}:{step:g}]" if chosen else f" {index + 1}:{step:g} "
            parts.append((text, "bold reverse" if chosen else ""))
        return Content.assemble(*parts, "deg")
