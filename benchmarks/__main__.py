"""Run benchmarks: those of speed, or those whose names are given, or ``judgement`` for the studies.

The studies (``judgement_*``, ``diagnosis``) are of made-up trackers by the thousand and measure how
good the answers are; they take some two hours.
"""

import importlib
import pkgutil
import sys
import time

import benchmarks

STUDIES = ("judgement", "diagnosis")
GROUP = "judgement"


def main(asked: list[str]) -> int:
    there = {
        module.name: importlib.import_module(f"benchmarks.{module.name}")
        for module in pkgutil.iter_modules(benchmarks.__path__)
        if not module.name.startswith("_")
    }
    runnable = {name: module for name, module in there.items() if hasattr(module, "run")}
    studies = [name for name in runnable if name.startswith(STUDIES)]
    names = asked or [name for name in runnable if name not in studies]
    if asked == [GROUP]:
        names = studies
    if unknown := [name for name in names if name not in runnable]:
        print(f"no benchmark {unknown[0]!r}; there are: {', '.join((GROUP, *runnable))}")
        return 2
    for name in names:
        started = time.perf_counter()
        print(f"== {name}", flush=True)
        print("\n".join(runnable[name].run()), flush=True)
        print(f"   ({time.perf_counter() - started:.0f} s)\n", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
