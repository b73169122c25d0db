"""The same seed gives the same day, however time was cut and whoever looked on the way."""

from hypothesis import given, settings
from hypothesis import strategies as st

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.unit.frames import Request, encode_request

SCENARIO = load_scenario(
    "missed-counts",
    ["truth.missed_counts=[{at='+20min',axis=1,counts=300}]", "truth.missed_per_hour2=30",
     "truth.backlash1_deg=0.1", "truth.unit_drift_s_per_day=40"],
)  # fmt: skip


def tracking(seed: int = 1) -> Emulator:
    """Referenced and tracking, a minute after the start."""
    emulator = Emulator(SCENARIO, seed=seed)
    for number, text in enumerate(("UNLOCK", "REF START", "X ADVANCE 59.5", "MODE TRACK"), start=1):
        verb, *arguments = text.split()
        emulator.handle_input(encode_request(Request(number, verb, tuple(arguments))))
    return emulator


def state(emulator: Emulator) -> tuple[object, ...]:
    """Everything that can be seen, to the last bit."""
    now_s = emulator.now_s()
    return (
        emulator.controller.status(now_s),
        [motor.collector_deg(now_s) for motor in emulator.world.motors],
        emulator.controller.next_event_s(),
        emulator.world.next_event_s(),
    )


REFERENCE = tracking()
REFERENCE.advance(3600.0)
AN_HOUR_LATER = state(REFERENCE)


def test_an_hour_is_an_hour_in_any_pieces():
    pieces = tracking()
    for _ in range(3600):
        pieces.advance(1.0)
    assert state(pieces) == AN_HOUR_LATER


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.lists(st.integers(1, 400_000), min_size=1, max_size=12))
def test_an_hour_is_an_hour_in_uneven_pieces_of_milliseconds(milliseconds):
    pieces, left = tracking(), 3_600_000
    for piece in milliseconds:
        step = min(piece, left)
        pieces.advance(step / 1000.0)
        left -= step
    pieces.advance(left / 1000.0)
    assert state(pieces) == AN_HOUR_LATER


def test_looking_changes_nothing():
    watched = tracking()
    for number in range(100, 460):
        watched.advance(10.0)
        for offset, text in enumerate(("STATUS", "REF", "X TRUTH", "COEF")):
            if text == "X TRUTH" and number % 100:
                continue
            verb, *arguments = text.split()
            request = Request(4 * number + offset, verb, tuple(arguments))
            watched.handle_input(encode_request(request))
    assert state(watched) == AN_HOUR_LATER


def test_extra_looks_at_the_spot_disturb_the_eye_only():
    """The switch's noise is a stream of its own."""

    def differences(looks: int) -> tuple[int, int]:
        emulator = tracking()
        for _ in range(looks):
            emulator.spot()
        emulator.controller.unlock(emulator.now_s())
        emulator.controller.start_ref_check(emulator.now_s())
        emulator.advance(600.0)
        found = emulator.controller.ref_check_result()
        return found.difference1, found.difference2

    assert differences(0) == differences(17)


def test_another_seed_is_another_day():
    first, second, other = tracking(1), tracking(1), tracking(2)
    for emulator in (first, second, other):
        emulator.advance(60.0)
    looks = [emulator.spot() for emulator in (first, second, other, first)]
    assert all(spot.visible for spot in looks)
    assert looks[0] == looks[1]
    assert looks[0] != looks[2]
    assert looks[0] != looks[3]


def test_at_a_speed_time_follows_the_injected_clock():
    real_s = [100.0]
    emulator = Emulator(SCENARIO, speed=60.0, monotonic=lambda: real_s[0])
    start = emulator.times_utc_s()[0]
    real_s[0] += 2.5
    emulator.handle_input(encode_request(Request(1, "STATUS")))
    assert emulator.times_utc_s()[0] - start == 150.0
    still = Emulator(SCENARIO, monotonic=lambda: real_s[0])
    real_s[0] += 100.0
    still.catch_up()
    assert still.now_s() == 0.0
