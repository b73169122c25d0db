"""What a serial port is, may it be opened, and may a controller well hang on it."""

import os
from typing import Any

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


def _said(text: str | None) -> str:
    """pyserial writes n/a for what it does not know."""
    return "" if text in (None, "n/a") else str(text)
