"""Run the benchmarks: all of them, or those whose names are given."""

import importlib
import pkgutil
import sys

import benchmarks


def main(asked: list[str]) -> int:
    # What measures speed takes seconds and comes first; populations of trackers take minutes.
    names = sorted(
        (
            module.name
            for module in pkgutil.iter_modules(benchmarks.__path__)
            if not module.name.startswith("_")
        ),
        key=lambda name: (name.startswith(("judgement", "diagnosis")), name),
    )
    modules = {name: importlib.import_module(f"benchmarks.{name}") for name in asked or names}
    for name, module in modules.items():
        if hasattr(module, "run"):
            print(f"== {name}", flush=True)
            print("\n".join(module.run()), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
