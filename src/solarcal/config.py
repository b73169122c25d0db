"""Where the program keeps what is the user's: sessions, profiles, settings."""

import os
from pathlib import Path

import platformdirs

from solarcal.timescale import parse_utc

APP = "solarcal"


def sessions_dir() -> Path:
    """Folder of saved sessions; ``SOLARCAL_SESSIONS`` names another."""
    named = os.environ.get("SOLARCAL_SESSIONS")
    return Path(named) if named else Path(platformdirs.user_data_dir(APP, False)) / "sessions"


def new_session_path(name: str, utc: str) -> Path:
    """A path in the sessions folder that no file has yet: ``name-YYYY-MM-DD.jsonl``, ``-2`` ..."""
    folder = sessions_dir()
    folder.mkdir(parents=True, exist_ok=True)
    parse_utc(utc)
    stem = f"{name}-{utc[:10]}"
    for number in range(1, 100_000):
        path = folder / (f"{stem}.jsonl" if number == 1 else f"{stem}-{number}.jsonl")
        if not path.exists():
            return path
    raise FileExistsError(f"{folder} is full of sessions named {stem}")
