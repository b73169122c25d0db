"""``solarcal ports``: what is plugged in, may it be opened, and what it looks like."""

import argparse
from typing import Any

from solarcal.cli.output import print_json
from solarcal.unit.link import describe


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document")


def run(args: argparse.Namespace) -> int:
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
