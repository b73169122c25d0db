"""A few thousand cases of what `make fuzz` does a million of."""

import pytest

from fuzzing.doors import DOORS, Door, DoorBroken
from fuzzing.trying import attempt
from solarcal.errors import ConfigurationError


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_nothing_but_a_refusal_with_a_place_comes_out(door):
    counted = attempt(door, max(100, 30 * door.share), derandomize=True)
    # A door that refuses everything, or takes everything, is not being tried.
    assert counted[True] > 0
    assert counted[False] > 0 or door.name in ("frames", "unit")


@pytest.mark.parametrize("door", DOORS, ids=lambda door: door.name)
def test_what_belongs_in_is_taken(door):
    assert all(door.enter(good) for good in door.good())


def test_the_measure_sees_what_may_not_come_out():
    def door(raised: Exception) -> Door:
        def goes_in(content: bytes) -> None:
            raise raised

        return Door("a door", 1, lambda: (b"x",), goes_in, ("file:1",))

    with pytest.raises(DoorBroken, match="no place named"):
        door(ConfigurationError("something is wrong")).enter(b"x")
    with pytest.raises(ZeroDivisionError):
        door(ZeroDivisionError()).enter(b"x")
    assert not door(ConfigurationError("file:1: something is wrong")).enter(b"x")
