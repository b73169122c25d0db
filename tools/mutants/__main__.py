"""Run it: ``python -m tools.mutants --help``."""

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue

from tools.mutants.candidates import Mutant, chosen_mutants
from tools.mutants.reach import VARIABLE, Reach
from tools.mutants.worker import Worker

ROOT = Path(__file__).resolve().parents[2]
SUBJECTS = ("model", "mount", "session", "unit", "station")
COUNT, SEED, WORKERS = 300, 20260621, 2
TESTS_S = 20.0
"""Of the processor's: so long the tests look for one mutant."""
CHEAP_S = 0.025
"""A test that takes no longer counts as a case of its own."""
MOST_TESTS = 1500

KILLED, SURVIVED, UNREACHED = "killed", "survived", "not reached"


@dataclass(frozen=True, slots=True)
class Outcome:
    mutant: Mutant
    state: str
    by: str = ""


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tools.mutants", description=__doc__)
    parser.add_argument("--count", type=int, default=COUNT, help="mutants to draw")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=WORKERS)
    parser.add_argument("--part", default="1/1", help="i/n: the i-th of n parts of the draw")
    parser.add_argument(
        "--only", default="", help="only mutants at PATH[:LINE]; several with commas"
    )
    parser.add_argument("--tests-s", type=float, default=TESTS_S, help="of tests for a mutant")
    parser.add_argument("--reach", type=Path, help="folder to keep and reuse the measured reach in")
    args = parser.parse_args()
    begun_s = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        trees = [_copy(Path(folder) / str(i)) for i in range(max(args.workers, 2))]
        folders = tuple(f"src/solarcal/{subject}" for subject in SUBJECTS)
        # The mutants are drawn while the tests of the untouched trees run.
        with ThreadPoolExecutor(1) as pool:
            measured = pool.submit(_measured, trees, args.reach or Path(folder))
            mutants = chosen_mutants(trees[0], folders, args.count, args.seed)
            reach = measured.result()
        part, parts = map(int, args.part.split("/"))
        mutants = [m for m in mutants[part - 1 :: parts] if _asked(m, args.only)]
        print(f"reach of {len(reach.durations)} tests known after {_minutes(begun_s)}", flush=True)
        outcomes = _tried(mutants, trees[: args.workers], reach, args.tests_s)
    _report(outcomes, begun_s)


def _asked(mutant: Mutant, only: str) -> bool:
    place = f"{mutant.path}:{mutant.first_line} "
    return any(
        f"{part} " in place or (":" not in part and part in place) for part in only.split(",")
    )


def _copy(tree: Path) -> Path:
    """The files of the checkout as they are, tracked or new, without what is ignored."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / name, tree / name)
    return tree


def _environment(tree: Path) -> dict[str, str]:
    return {
        **os.environ,
        "PYTHONPATH": os.pathsep.join((str(tree / "src"), str(tree))),
        "PYTHONDONTWRITEBYTECODE": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }


def _pytest(tests: list[str], *options: str) -> list[str]:
    return [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, *tests]


def _measured(trees: list[Path], folder: Path) -> Reach:
    """Each folder's tests once, under coverage, on the untouched trees."""
    folder.mkdir(parents=True, exist_ok=True)
    documents = {subject: folder / f"{subject}.json" for subject in SUBJECTS}
    free: SimpleQueue[Path] = SimpleQueue()
    for tree in trees[:2]:
        free.put(tree)

    def measure(subject: str) -> None:
        if documents[subject].exists():
            return
        tree = free.get()
        environment = {**_environment(tree), VARIABLE: str(documents[subject])}
        run = subprocess.run(
            _pytest([f"tests/{subject}"], "-p", "tools.mutants.reach"),
            cwd=tree, env=environment, capture_output=True, text=True,
        )  # fmt: skip
        free.put(tree)
        if run.returncode:
            raise SystemExit(
                f"the tests of {subject} fail without any mutant:\n{run.stdout[-3000:]}"
            )

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(measure, SUBJECTS))
    return Reach(list(documents.values()), trees[0])


def _tried(mutants: list[Mutant], trees: list[Path], reach: Reach, tests_s: float) -> list[Outcome]:
    free: SimpleQueue[Worker] = SimpleQueue()
    workers = [Worker(tree) for tree in trees]
    for worker in workers:
        free.put(worker)

    def attempt(mutant: Mutant) -> Outcome:
        tests = _in_order(mutant, reach, tests_s)
        if not tests:
            return Outcome(mutant, UNREACHED)
        worker = free.get()
        cpu_s = round(4.0 * sum(reach.durations[test] for test in tests) + 20.0)
        killer = worker.tries(mutant.path, mutant.text, tests, cpu_s)
        free.put(worker)
        print("." if killer else f"\n{mutant}\n", end="", flush=True)
        return Outcome(mutant, KILLED if killer else SURVIVED, killer)

    with ThreadPoolExecutor(len(trees)) as pool:
        outcomes = list(pool.map(attempt, mutants))
    for worker in workers:
        worker.close()
    print()
    return outcomes


def _in_order(mutant: Mutant, reach: Reach, tests_s: float) -> list[str]:
    """The tests that reach a mutant, as many as their time allows.

    Its own folder's first, of them those named after the module, and one case of each that takes
    a while before a second of any; the fastest first.
    """
    _, _, subject, *_, name = mutant.path.removesuffix(".py").split("/")
    reached = reach.tests(mutant.path, mutant.first_line, mutant.last_line)
    cases: Counter[str] = Counter()
    order = []
    for test in sorted(reached, key=lambda test: reach.durations[test]):
        file, _, function = test.partition("[")[0].partition("::")
        cases[test.partition("[")[0]] += 1
        order.append(
            (
                not file.startswith(f"tests/{subject}/"),
                name not in file,
                cases[f"{file}::{function}"] if reach.durations[test] > CHEAP_S else 1,
                reach.durations[test],
                test,
            )
        )
    chosen: list[str] = []
    spent_s = 0.0
    for *_, duration_s, test in sorted(order)[:MOST_TESTS]:
        spent_s += duration_s
        if chosen and spent_s > tests_s:
            break
        chosen.append(test)
    return chosen


def _report(outcomes: list[Outcome], begun_s: float) -> None:
    for state in (UNREACHED, SURVIVED):
        of_state = [outcome for outcome in outcomes if outcome.state == state]
        print(f"\n{len(of_state)} {state}:", *sorted(str(o.mutant) for o in of_state), sep="\n")
    killed = [o for o in outcomes if o.state == KILLED]
    own = sum(o.by.startswith(f"tests/{o.mutant.path.split('/')[2]}") for o in killed)
    print()
    for subject in SUBJECTS:
        of_subject = [o for o in outcomes if o.mutant.path.split("/")[2] == subject]
        if of_subject:
            share = sum(o.state == KILLED for o in of_subject)
            print(f"{subject:8} {share:3} of {len(of_subject):3}")
    if outcomes:
        print(
            f"{len(killed)} of {len(outcomes)} mutants killed "
            f"({100.0 * len(killed) / len(outcomes):.1f} %), {own} of them by a test of the same "
            f"folder; {_minutes(begun_s)}"
        )


def _minutes(begun_s: float) -> str:
    return f"{(time.monotonic() - begun_s) / 60.0:.1f} min"


if __name__ == "__main__":
    main()
