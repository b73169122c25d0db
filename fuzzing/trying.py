"""Cases from hypothesis: a good file and a seed, from which a batch of bad files comes."""

import random
from collections import Counter
from collections.abc import Callable

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fuzzing.damage import damaged
from fuzzing.doors import Door

BATCH = 50
"""Cases of one seed: what hypothesis does to choose one costs more than most doors."""


def attempt(
    door: Door,
    cases: int,
    *,
    derandomize: bool,
    seen: Callable[[int], None] = lambda cases: None,
) -> Counter[bool]:
    """So many cases at one door; how many were taken (True) and refused (False).

    Raises
    ------
    AssertionError and whatever else comes out of the door
        Hypothesis tells the good file, the seed and the place in its batch that did it.
    """
    counted: Counter[bool] = Counter()
    goods = door.good()
    batch = min(BATCH, cases)

    @settings(
        max_examples=max(cases // batch, 1),
        deadline=None,
        database=None,
        derandomize=derandomize,
        phases=[Phase.generate, Phase.shrink],
        suppress_health_check=list(HealthCheck),
    )
    @given(good=st.sampled_from(goods), seed=st.integers(0, 2**32 - 1))
    def try_batch(good: bytes, seed: int) -> None:
        for number in range(batch):
            content = damaged(good, random.Random(seed + number))
            try:
                counted[door.enter(content)] += 1
            except BaseException as error:
                error.add_note(f"door {door.name}, case {number} of this seed: {content!r}")
                raise
        seen(batch)

    try_batch()
    return counted
