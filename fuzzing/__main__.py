"""A million cases of nonsense, or as many as asked for: ``python -m fuzzing [CASES]``."""

import sys
import time

from fuzzing.doors import DOORS
from fuzzing.trying import attempt

CASES = 1_000_000


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
    minutes = (time.perf_counter() - started) / 60.0
    print(f"{cases} cases in {minutes:.1f} min: " + (f"BROKEN: {broken}" if broken else "all well"))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else CASES))
