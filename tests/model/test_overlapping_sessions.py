"""Sessions that overlap in time cannot be told apart by a move; where they differ, it is said."""

import msgspec
import numpy as np
import pytest
from made_up_trackers import JUNE, TRACKER, context_of, measured

from benchmarks.judgement_trackers import daylight_s
from solarcal.model.evidence.direct import weigh
from solarcal.model.finding import Finding
from solarcal.model.methods import DEFAULT_PRIOR
from solarcal.model.overlapping_sessions import contradictions, groups_in_time
from solarcal.model.points import Points
from solarcal.model.repeats import contradicted

CONTEXT = context_of("azel")
FIRST_S, LAST_S = daylight_s(CONTEXT, JUNE)
TIMES = np.linspace(FIRST_S, LAST_S, 22)


def by_two(lean_deg: float) -> list[Points]:
    """Every second point of a day read on a tower that leans otherwise."""
    other = msgspec.structs.replace(TRACKER, P3=TRACKER.P3 + lean_deg)
    rng = np.random.default_rng(3)
    mechanisms = ((TRACKER, TIMES[::2]), (other, TIMES[1::2]))
    return [measured(CONTEXT, one, times, rng) for one, times in mechanisms]


def found(parts: list[Points]) -> tuple[Finding, ...]:
    return contradictions(parts, ("a.csv", "b.csv"), CONTEXT, DEFAULT_PRIOR, 0.05)


def test_sessions_that_alternate_and_differ_contradict_each_other_and_nothing_moved() -> None:
    (finding,) = found(by_two(0.3))
    assert "a.csv and b.csv alternate in time and differ by 0.2" in finding.sentence
    assert finding.number == pytest.approx(0.27, abs=0.04)
    assert weigh([finding], frozenset({1}), 0.1).wrong == (finding.sentence,)
    assert found(by_two(0.0)) == ()


def test_only_sessions_one_after_the_other_have_an_order() -> None:
    first, second = by_two(0.0)
    later = first.replace(utc_s=first.utc_s + 86400.0)
    assert groups_in_time([later, second, first]) == [[2, 1], [0]]
    assert groups_in_time([later, first]) == [[1], [0]]
    beside = second.replace(utc_s=second.utc_s + 86400.0)
    assert groups_in_time([first, beside, later, second]) == [[0, 3], [2, 1]]
    assert groups_in_time([first, first.replace(utc_s=np.full(len(first), np.nan))]) is None


@pytest.mark.parametrize(("apart_deg", "waits"), [(0.2, True), (0.03, False)])
def test_readings_of_one_instant_that_clearly_differ_keep_done_back(apart_deg, waits) -> None:
    (finding,) = contradicted([(20, 4, apart_deg)])
    assert weigh([finding], frozenset({4, 5}), 0.1).waiting == (finding.sentence,) * waits
    assert weigh([finding], frozenset({5, 6}), 0.1).waiting == ()
