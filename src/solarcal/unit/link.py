"""The line to a unit: whole lines in, bytes out, over anything pyserial can open; which ports are.

This module and ``solarcal.timescale`` are the only ones that ask the operating system for the time.
"""

import contextlib
import errno
import os
import re
import threading
import time
from collections import deque
from pathlib import Path
from typing import Any, Protocol

from solarcal.errors import ConfigurationError, LinkError
from solarcal.timescale import format_utc
from solarcal.unit.frames import LineBuffer

_NETWORK = ("socket://", "rfc2217://")
_OPENED = (*_NETWORK, "loop://")

READ_TIMEOUT_S = 0.1
"""How long the reader thread sleeps in the driver when nothing comes: the most ``close`` waits.
Bytes that come wake it at once."""

WRITE_TIMEOUT_S = 2.0
"""250 characters take 0.26 s at 9600 baud; a line that stays full longer than this is stuck."""

LINES_KEPT = 64
"""Unread lines kept; the oldest go first. A unit never has more than a few replies under way."""


class Link(Protocol):
    """A line to a unit. Methods may be called from several threads."""

    def write(self, data: bytes) -> None:
        """Send all of ``data``; raises LinkError when the line is gone."""
        ...

    def read_line(self, timeout_s: float) -> bytes | None:
        """The next line without its line end; None when none came within ``timeout_s`` (0: poll).

        Raises LinkError when the line is gone and every line received before has been read.
        """
        ...

    def close(self) -> None:
        """Idempotent. Ends a ``read_line`` of another thread with LinkError."""
        ...


class Transcript:
    """A readable record of everything said on a line, appended to a file: ``--trace FILE``.

    On a full disk it ends; the conversation goes on.
    """

    def __init__(self, path: str | Path, port: str) -> None:
        self._lock = threading.Lock()
        self._started = time.monotonic()
        try:
            self._file = open(path, "a", encoding="ascii", errors="backslashreplace")  # noqa: SIM115
            self._put(f"# {port}, opened {format_utc(time.time())}; seconds since then\n")
        except OSError as error:
            raise ConfigurationError(
                f"trace file {path} cannot be written: {error.strerror}"
            ) from None

    def note(self, direction: str, data: bytes) -> None:
        """One line of the transcript. ``direction``: sent, received or a remark."""
        text = data.decode("ascii", errors="backslashreplace").rstrip("\r\n")
        readable = "".join(c if " " <= c <= "~" else f"\\x{ord(c):02x}" for c in text)
        with self._lock:
            if not self._file.closed:
                elapsed_s = time.monotonic() - self._started
                with contextlib.suppress(OSError):
                    self._put(f"{elapsed_s:10.3f} {direction:8} {readable}\n")

    def _put(self, line: str) -> None:
        try:
            self._file.write(line)
            self._file.flush()
        except OSError:
            self._close()
            raise

    def close(self) -> None:
        with self._lock:
            self._close()

    def _close(self) -> None:
        # What a failed write has left is written again here, and fails again.
        with contextlib.suppress(OSError):
            self._file.close()


class SerialLink:
    """A line over any pyserial URL: a device or pty by its path, ``socket://``, ``rfc2217://``, ...

    Parameters
    ----------
    url : ``/dev/ttyUSB0``, ``COM3``, ``socket://host:port``, ``rfc2217://host:port``, ``loop://``.
    baudrate : 8N1; meaningless on a pty or a socket.
    trace : file to which a transcript is appended.
    lines_kept : unread lines kept; the oldest go first.

    Raises
    ------
    LinkError
        The port cannot be opened; one line says why and what to do.
    """

    def __init__(
        self,
        url: str,
        baudrate: int = 9600,
        trace: str | Path | None = None,
        *,
        lines_kept: int = LINES_KEPT,
    ) -> None:
        self.url = url
        self._port = _open_port(url, baudrate)
        try:
            self._transcript = Transcript(trace, url) if trace is not None else None
        except ConfigurationError:
            self._port.close()
            raise
        self._writing = threading.Lock()
        self._arrived = threading.Condition()
        self._lines: deque[bytes] = deque(maxlen=lines_kept)
        self._lost = ""
        self._closing = False
        self._reader = threading.Thread(target=self._read, name=f"reader of {url}", daemon=True)
        self._reader.start()

    def write(self, data: bytes) -> None:
        with self._writing:
            if self._lost or self._closing:
                raise LinkError(self._lost or f"the line to {self.url} is closed")
            if self._transcript:
                self._transcript.note("sent", data)
            try:
                self._port.write(data)
            except OSError as error:
                raise LinkError(self._trouble(error)) from None

    def read_line(self, timeout_s: float) -> bytes | None:
        with self._arrived:
            if not self._lines and not self._lost:
                self._arrived.wait_for(lambda: self._lines or self._lost, timeout_s)
            if self._lines:
                return self._lines.popleft()
            if self._lost:
                raise LinkError(self._lost)
            return None

    def close(self) -> None:
        with self._arrived:
            if self._closing:
                return
            self._closing = True
        # A read under way is ended where the driver can; elsewhere READ_TIMEOUT_S ends it.
        if hasattr(self._port, "cancel_read"):
            with contextlib.suppress(OSError):
                self._port.cancel_read()
        self._reader.join()
        with self._writing, contextlib.suppress(OSError):
            self._port.close()
        self._end(f"the line to {self.url} is closed")
        if self._transcript:
            self._transcript.close()

    def _read(self) -> None:
        """The reader thread: hands over whole lines the moment their last byte is there."""
        buffer = LineBuffer()
        while not self._closing:
            try:
                data = self._read_bytes()
            # in_waiting raises a bare OSError on hang-up, read a SerialException, which is one too.
            except OSError as error:
                self._end(self._trouble(error))
                return
            lines = buffer.feed(data) if data else ()
            if not lines:
                continue
            if self._transcript:
                for line in lines:
                    self._transcript.note("received", line)
            with self._arrived:
                self._lines.extend(lines)
                self._arrived.notify_all()

    def _read_bytes(self) -> bytes:
        """Wait for the first byte, then take what is there."""
        first: bytes = self._port.read(1)
        if not first:
            return b""
        if not self.url.startswith("socket://"):
            rest: bytes = self._port.read(self._port.in_waiting)
            return first + rest
        # On a socket in_waiting is only 0 or 1, which would mean a system call a byte. With a zero
        # timeout pyserial gives everything that is there; setting it costs nothing on a socket.
        self._port.timeout = 0
        try:
            rest = self._port.read(4096)
        finally:
            self._port.timeout = READ_TIMEOUT_S
        return first + rest

    def _end(self, reason: str) -> None:
        with self._arrived:
            if not self._lost:
                self._lost = reason
                if self._transcript:
                    self._transcript.note("lost", reason.encode())
            self._arrived.notify_all()

    def _trouble(self, error: BaseException) -> str:
        if type(error).__name__ == "SerialTimeoutException":
            return (
                f"{self.url} takes no more data for {WRITE_TIMEOUT_S:g} s; "
                "check that the unit is on and the cable is plugged in"
            )
        return f"the line to {self.url} was lost; check the cable and the unit's power"


def _open_port(url: str, baudrate: int) -> Any:
    """An open pyserial port, or LinkError in one line."""
    if "://" in url and not url.lower().startswith(_OPENED):
        # pyserial knows more, and one of them (spy) writes to any file a profile names.
        raise LinkError(
            f"port {url} cannot be opened: give a device, or one of {' '.join(_OPENED)} "
            "(--trace FILE records everything sent and received)"
        )
    import serial  # noqa: PLC0415

    try:
        return serial.serial_for_url(
            url,
            baudrate=baudrate,
            timeout=READ_TIMEOUT_S,
            write_timeout=WRITE_TIMEOUT_S,
            # Two programs on one line would take each other's replies.
            exclusive=True if "://" not in url else None,
        )
    # ValueError: not a URL pyserial knows, or a baud rate the port does not.
    except (OSError, ValueError) as error:
        raise LinkError(_cannot_open(url, error)) from None


def _names_a_tcp_port(url: str) -> bool:
    named = re.search(r":([0-9]{1,5})$", url)
    return named is not None and 1 <= int(named[1]) <= 65535


def _cannot_open(url: str, error: BaseException) -> str:
    # pyserial keeps the number of some errors only in the exception it replaced, and termios.error
    # has it as its first argument only.
    cause: BaseException | None = error
    number = None
    while cause is not None and number is None:
        number = getattr(cause, "errno", None)
        if number is None and type(cause).__module__ == "termios":
            number = cause.args[0]
        cause = cause.__context__
    if number in (errno.ENOENT, errno.ENODEV, errno.ENXIO):
        return f"port {url} does not exist; `solarcal ports` lists what is plugged in"
    if number in (errno.EACCES, errno.EPERM):
        return (
            f"port {url} may not be opened by you; join the group that owns it "
            "(often dialout or uucp) and log in again"
        )
    if number in (errno.EBUSY, errno.EAGAIN):
        return f"port {url} is in use by another program; close that one first"
    if number in (errno.ENOTTY, errno.EISDIR):
        return f"{url} is not a serial port; `solarcal ports` lists what is plugged in"
    if number == errno.ECONNREFUSED:
        return f"no answer from {url}; check host and port, and that the server is running"
    if url.startswith(_NETWORK) and not _names_a_tcp_port(url):
        return (
            f"port {url} cannot be opened; write it as {url.partition(':')[0]}://host:port, "
            "with a port from 1 to 65535"
        )
    return f"port {url} cannot be opened: {str(error).splitlines()[0]}"


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
