"""``python -m tools.pictures FOLDER [NAME ...]``: all pictures, or those named."""

import asyncio
import os
import sys
import tempfile
from pathlib import Path

from tools.pictures.scenes import SCENES


def main() -> int:
    names = sys.argv[2:] or list(SCENES)
    unknown = [name for name in names if name not in SCENES]
    if len(sys.argv) < 2 or unknown:
        print("usage: python -m tools.pictures FOLDER [NAME ...]", file=sys.stderr)
        print(f"names: {' '.join(SCENES)}", file=sys.stderr)
        return 2
    target = Path(sys.argv[1]).resolve()
    target.mkdir(parents=True, exist_ok=True)
    for name in names:
        with tempfile.TemporaryDirectory() as home:
            # Relative, so that no picture shows a folder of the computer it was made on.
            os.chdir(home)
            os.environ |= {"SOLARCAL_SESSIONS": "sessions", "SOLARCAL_CONFIG": "config"}
            # The colours of that one, wherever they are drawn.
            os.environ["TERM"] = "xterm-256color"
            sessions = Path("sessions")
            sessions.mkdir()
            svg = asyncio.run(SCENES[name](sessions))
            os.chdir(target)
        (target / f"{name}.svg").write_text(svg, encoding="utf-8")
        print(f"{name}.svg", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
