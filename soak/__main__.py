"""``make soak``: a thousand killed journals, and a month in the workstation."""

import argparse
import asyncio
import os
import sys
import tempfile
from pathlib import Path

from soak.kills import kill_writers
from soak.month import live_a_month


def main() -> int:
    """Run both and tell what was measured; 1 when something is not as it must be."""
    parser = argparse.ArgumentParser(prog="python -m soak")
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--days", type=int, default=30)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="soak-") as name:
        folder = Path(name)
        # Nothing of the user's is touched, whatever the program remembers.
        os.environ["SOLARCAL_CONFIG"] = str(folder / "config")
        os.environ["SOLARCAL_SESSIONS"] = str(folder / "sessions")
        for part in ("kills", "month"):
            (folder / part).mkdir()
        if asked.kills:
            print(kill_writers(folder / "kills", asked.kills, asked.seed).words(), flush=True)
        if not asked.days:
            return 0
        month = asyncio.run(live_a_month(folder / "month", asked.days, _say))
        print(month.words())
        complaints = month.complaints(asked.days)
        print("NOT WELL: " + "; ".join(complaints) if complaints else "all well")
        return 1 if complaints else 0


def _say(sentence: str) -> None:
    print(sentence, flush=True)


if __name__ == "__main__":
    sys.exit(main())
