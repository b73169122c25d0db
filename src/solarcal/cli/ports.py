"""``solarcal ports``: what is plugged in, may it be opened, and what it looks like."""

import argparse
import os
from typing import Any

HELP = "what is plugged in"

# USB vendor -> what its devices usually are, and whether a controller may hang on them.
_USB_VENDORS = {
    0x0403: ("USB serial adapter (FTDI)", True),
    0x10C4: ("USB serial adapter (Silicon Labs)", True),
    0x1A86: ("USB serial adapter (CH340)", True),
    0x067B: ("USB serial adapter (Prolific)", True),
    0x04D8: ("USB serial adapter (Microchip)", True),
    0x0557: ("USB serial adapter (ATEN)", True),
    0x1546: ("GPS receiver (u-blox)", False),
    0x2341: ("Arduino", False),
    0x1D6B: ("USB gadget", False),
    0x1199: ("mobile modem (Sierra)", False),
    0x12D1: ("mobile modem (Huawei)", False),
    0x2C7C: ("mobile modem (Quectel)", False),
}
# A word in the description says more than the vendor of the chip ...
_NOT_A_CONTROLLER = {
    "gps": "GPS receiver",
    "gnss": "GPS receiver",
    "modem": "modem",
    "bluetooth": "Bluetooth port",
}
# ... or less, where the vendor is not known.
_MAYBE_A_CONTROLLER = {"serial": "serial adapter", "uart": "serial adapter"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="one JSON document")


def run(args: argparse.Namespace) -> int:
    from serial.tools.list_ports import comports

    ports = [describe(port) for port in sorted(comports(), key=lambda port: str(port.device))]
    if args.json:
        from solarcal.cli.output import print_json

        print_json({"ports": ports})
    else:
        print(ports_text(ports))
    return 0


def describe(port: Any) -> dict[str, Any]:
    """One entry of pyserial's ``comports`` as what a technician wants to know of it."""
    looks_like, likely = _guess(port.vid, f"{port.description} {port.product or ''}", port.device)
    # Windows devices are no files: there only opening tells.
    is_file = os.path.exists(port.device)
    return {
        "port": port.device,
        "description": _said(port.description),
        "manufacturer": _said(port.manufacturer),
        "serial_number": _said(port.serial_number),
        "usb_id": None if port.vid is None else f"{port.vid:04x}:{port.pid:04x}",
        "looks_like": looks_like,
        "likely": likely,
        "readable": os.access(port.device, os.R_OK) if is_file else None,
        "writable": os.access(port.device, os.W_OK) if is_file else None,
    }


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


def _guess(vid: int | None, text: str, device: str) -> tuple[str, bool]:
    """What the port looks like, and whether a controller may well hang on it."""
    said = text.lower()
    for word, meaning in _NOT_A_CONTROLLER.items():
        if word in said:
            return meaning, False
    if vid in _USB_VENDORS:
        return _USB_VENDORS[vid]
    for word, meaning in _MAYBE_A_CONTROLLER.items():
        if word in said:
            return meaning, True
    if vid is None and os.path.basename(device).startswith(("ttyS", "ttyAMA", "COM")):
        return "built-in serial port", True
    return "unknown", False


def _access(port: dict[str, Any]) -> str:
    if port["readable"] is None:
        return "?"
    words = {(True, True): "yes", (True, False): "read only", (False, True): "write only"}
    return words.get((port["readable"], port["writable"]), "none")


def _said(text: str | None) -> str:
    """pyserial writes n/a for what it does not know."""
    return "" if text in (None, "n/a") else str(text)
