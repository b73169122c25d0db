"""``solarcal doctor``: is this laptop ready for a day in the field? ``solarcal ports``: its lines.

Each check says what it found and what to do. The JSON document: ``ready`` and ``checks`` (``name``,
``verdict`` ok, warning or failed, ``found``, ``remedy``).
"""

import argparse
import locale
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from solarcal.cli.process import add_json_option, print_json
from solarcal.config import config_dir, load_keymap, load_settings, sessions_dir
from solarcal.errors import SolarcalError
from solarcal.profiles import load_profile, profile_names
from solarcal.unit.link import describe

Verdict = Literal["ok", "warning", "failed"]

LEAST_SIZE = (80, 24)
LEAST_FREE_MB = 50
_GRABBING_TERMINALS = {
    "linux": "the Linux console switches screens on Alt+F-keys: use the plain F-keys or letters",
    "rxvt-unicode": "urxvt sends Alt+F-keys as Escape and F-key: use the plain F-keys or letters",
    "rxvt-unicode-256color": "urxvt sends Alt+F-keys as Escape and F-key: use the plain F-keys",
}


@dataclass(frozen=True, slots=True)
class Check:
    """One thing looked at. ``remedy`` says what to do; empty when all is well."""

    name: str
    verdict: Verdict
    found: str
    remedy: str = ""


def check_all() -> list[Check]:
    """Every check, none of which changes anything that stays."""
    checks: tuple[Callable[[], Check], ...] = (
        terminal, characters, keys, ports, clock, disk, configuration, plots,
    )  # fmt: skip
    return [check() for check in checks]


def terminal() -> Check:
    if not sys.stdout.isatty():
        return Check(
            "terminal", "warning", "not a terminal", "run this in the terminal of the workstation"
        )
    size = shutil.get_terminal_size()
    name = os.environ.get("TERM", "unknown")
    colours = "no colours (NO_COLOR)" if os.environ.get("NO_COLOR") else "colours"
    found = f"{name}, {size.columns} x {size.lines}, {colours}"
    if name in ("dumb", "unknown"):
        return Check(
            "terminal", "failed", found, "set TERM to the type of the terminal, e.g. xterm"
        )
    if size.columns < LEAST_SIZE[0] or size.lines < LEAST_SIZE[1]:
        return Check("terminal", "failed", found, "make the window at least 80 x 24")
    return Check("terminal", "ok", found)


def characters() -> Check:
    encoding = (sys.stdout.encoding or locale.getpreferredencoding(False)).lower()
    if encoding.replace("-", "") == "utf8":
        return Check("characters", "ok", "UTF-8")
    return Check(
        "characters",
        "failed",
        f"{encoding}, not UTF-8",
        "set a UTF-8 locale, e.g. LANG=C.UTF-8: bars and plots need it",
    )


def keys() -> Check:
    from solarcal.tui.keys import checked_keymap

    try:
        keymap = checked_keymap(load_keymap())
    except SolarcalError as error:
        return Check("keys", "failed", str(error), "correct or remove keymap.toml")
    found = f"{len(keymap)} changed by keymap.toml" if keymap else "as in the manual"
    trouble = _GRABBING_TERMINALS.get(os.environ.get("TERM", ""))
    if trouble:
        return Check("keys", "warning", found, trouble)
    return Check("keys", "ok", f"{found}; solarcal keys shows what this terminal sends")


def ports() -> Check:
    from serial.tools.list_ports import comports

    found = [describe(port) for port in comports()]
    likely = [port for port in found if port["likely"]]
    if not likely:
        return Check(
            "ports",
            "warning",
            "no serial port for a controller",
            "plug the adapter in; the emulator needs none",
        )
    names = ", ".join(f"{port['port']} ({port['looks_like']})" for port in likely)
    shut = [p["port"] for p in likely if p["readable"] is False or p["writable"] is False]
    if shut:
        return Check(
            "ports",
            "failed",
            f"{names}; no access to {', '.join(shut)}",
            "join the group that owns the port (often dialout or uucp) and log in again",
        )
    return Check("ports", "ok", names)


def clock() -> Check:
    from solarcal.station.clocks import laptop_clock

    answer = laptop_clock()
    if answer.synchronised:
        return Check("clock", "ok", answer.sentence)
    return Check(
        "clock",
        "warning" if answer.synchronised is None else "failed",
        answer.sentence,
        "let it synchronise, or enter a time tick on the clock screen (F10): "
        "24 s of error are 0.1 deg of Sun",
    )


def disk() -> Check:
    """Room for sessions, and a folder that can be written and synced."""
    folder = sessions_dir()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=folder, prefix=".doctor-") as file:
            file.write(b"solarcal\n")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        return Check(
            "disk",
            "failed",
            f"{folder} cannot be written: {error.strerror}",
            "make it writable, or name another folder in SOLARCAL_SESSIONS",
        )
    free_mb = shutil.disk_usage(folder).free // 2**20
    found = f"{free_mb} MB free for sessions in {folder}"
    if free_mb < LEAST_FREE_MB:
        return Check("disk", "failed", found, "make room: a full disk stops the session")
    return Check("disk", "ok", found)


def configuration() -> Check:
    folder = config_dir()
    try:
        settings = load_settings()
        for name in profile_names():
            load_profile(name)
    except SolarcalError as error:
        return Check("config", "failed", str(error), "correct the file or remove it")
    if not _writable(folder):
        return Check(
            "config",
            "warning",
            f"{folder} cannot be written",
            "profiles and themes are not saved; SOLARCAL_CONFIG names another folder",
        )
    profile = f"profile {settings.profile}" if settings.profile else "no profile yet"
    return Check("config", "ok", f"{folder}, {profile}, theme {settings.theme}")


def _writable(folder: Path) -> bool:
    place = folder
    while not place.exists() and place != place.parent:
        place = place.parent
    return os.access(place, os.W_OK)


def plots() -> Check:
    """The compiled parts are there for this machine."""
    try:
        import erfa
        import numpy as np
        import plotext
    except ImportError as error:
        return Check("libraries", "failed", str(error), "install solarcal again on this machine")
    return Check(
        "libraries",
        "ok",
        f"numpy {np.__version__}, plotext {plotext.__version__}, erfa {erfa.__version__}",
    )


add_doctor_arguments = add_ports_arguments = add_json_option


def run_doctor(args: argparse.Namespace) -> int:
    """0 when no check failed; warnings do not count."""
    checks = check_all()
    failed = [check.name for check in checks if check.verdict == "failed"]
    args.exit_code = 1 if failed else 0
    if args.json:
        print_json({"ready": not failed, "checks": [asdict(check) for check in checks]})
    else:
        for check in checks:
            print(f"{check.verdict:8} {check.name:12} {check.found}")
            if check.remedy:
                print(f"{'':21} -> {check.remedy}")
        print(f"not ready: {', '.join(failed)}" if failed else "ready")
    return int(args.exit_code)


def run_ports(args: argparse.Namespace) -> int:
    from serial.tools.list_ports import comports

    ports = [describe(port) for port in sorted(comports(), key=lambda port: str(port.device))]
    if args.json:
        print_json({"ports": ports})
    else:
        print(ports_text(ports))
    return 0


def ports_text(ports: list[dict[str, Any]]) -> str:
    """A table for 80 columns, likely ports first."""
    if not ports:
        return (
            "no serial ports found; plug the adapter in, "
            "or try the emulator: solarcal demo --headless"
        )
    lines = [f"{'port':16} {'access':10} {'looks like':28} description"]
    for port in sorted(ports, key=lambda port: (not port["likely"], port["port"])):
        row = f"{port['port']:16} {_access(port):10} {port['looks_like']:28} {port['description']}"
        lines.append(row.rstrip())
    if any(port["readable"] is False or port["writable"] is False for port in ports):
        lines.append(
            "no access: join the group that owns the port (often dialout or uucp), log in again"
        )
    return "\n".join(lines)


def _access(port: dict[str, Any]) -> str:
    if port["readable"] is None:
        return "?"
    words = {(True, True): "yes", (True, False): "read only", (False, True): "write only"}
    return words.get((port["readable"], port["writable"]), "none")
