"""A million cases of nonsense, or as many as asked for: ``python -m fuzzing [CASES]``."""

import shlex
import sys
import tempfile
import time
from pathlib import Path

from fuzzing.calls import CALLS, sweep
from fuzzing.doors import DOORS
from fuzzing.session_damage import SAVED, Unnoticed, try_cuts, try_flips
from fuzzing.trying import attempt

CASES = 1_000_000
SEED = 825
GOOD = Path(__file__).parents[1] / "sessions" / "azel-good-day.jsonl"


def main(cases: int) -> int:
    """Every door in turn; 1 when something came out of one that may not."""
    started = time.perf_counter()
    broken = []
    for door in DOORS:
        share = cases * door.share // 100
        done, said_s, began_s = 0, time.perf_counter(), time.perf_counter()

        def seen(batch: int, name: str = door.name, share: int = share) -> None:
            nonlocal done, said_s
            done += batch
            if time.perf_counter() - said_s > 5.0:
                said_s = time.perf_counter()
                print(f"  {name}: {done} of {share}", file=sys.stderr, flush=True)

        try:
            counted = attempt(door, share, derandomize=False, seen=seen)
        except Exception as error:  # noqa: BLE001 - whatever comes out is what we look for
            broken.append(door.name)
            print(f"{door.name}: BROKEN: {type(error).__name__}: {error}", flush=True)
            for note in getattr(error, "__notes__", ()):
                print(f"    {note}", flush=True)
            continue
        taken, refused = counted[True], counted[False]
        seconds = time.perf_counter() - began_s
        print(
            f"{door.name}: {taken + refused} cases in {seconds:.0f} s, {taken} taken, "
            f"{refused} refused in proper words",
            flush=True,
        )
    broken += _bad_calls(min(CALLS, cases // 1000))
    broken += _every_bit_and_cut()
    minutes = (time.perf_counter() - started) / 60.0
    print(f"{cases} cases in {minutes:.1f} min: " + (f"BROKEN: {broken}" if broken else "all well"))
    return 1 if broken else 0


def _bad_calls(count: int) -> list[str]:
    """The calls of the program that cannot be; the names of what is broken."""
    began_s, faults, slowest_s, largest_mb = time.perf_counter(), 0, 0.0, 0.0
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "bad"
        folder.mkdir()
        for outcome in sweep(count, SEED, folder, GOOD):
            slowest_s = max(slowest_s, outcome.seconds)
            largest_mb = max(largest_mb, outcome.megabytes)
            if outcome.fault:
                faults += 1
                print(f"  {outcome.fault}: solarcal {shlex.join(outcome.words)[:300]}", flush=True)
    print(
        f"bad calls: {count} in {time.perf_counter() - began_s:.0f} s, slowest {slowest_s:.1f} s, "
        f"largest {largest_mb:.0f} MB, {faults} at fault",
        flush=True,
    )
    return ["bad calls"] if faults else []


def _every_bit_and_cut() -> list[str]:
    """The saved sessions with every bit flipped, and cut at every offset."""
    broken = []
    for path in SAVED:
        size = path.stat().st_size
        try:
            refused, reported = try_flips(path, range(8 * size))
            cut_refused, cut_reported = try_cuts(path, range(size))
        except Unnoticed as error:
            broken.append(path.name)
            print(f"{path.name}: BROKEN: {error}", flush=True)
            continue
        print(
            f"{path.name}: {8 * size} flipped bits, {refused} refused and {reported} reported; "
            f"{size} cuts, {cut_refused} refused and {cut_reported} reported",
            flush=True,
        )
    return broken


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else CASES))
