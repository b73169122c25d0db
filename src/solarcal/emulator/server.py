"""How a station reaches the emulator: in process, over a pseudo-terminal, over TCP."""

import contextlib
import ipaddress
import os
import select
import socket
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

from solarcal.emulator.line_faults import HungUp
from solarcal.errors import ConfigurationError, LinkError

WAKE_S = 0.2
"""How long a server waits for input before it looks whether it shall end, and lets paced time
catch up. Input wakes it at once."""

PSEUDO_TERMINALS = Path("/dev/pts")

BUSY = b"# busy: one station at a time\r\n"
"""What a second simultaneous TCP client receives; no frame, so a station sees a damaged reply."""


class UnitOnALine(Protocol):
    """What can be served: an emulator, or one behind a line with faults."""

    def handle_input(self, data: bytes) -> list[bytes]:
        """Replies to a piece of the stream."""
        ...

    def catch_up(self) -> None:
        """Let the time pass that real time owes."""
        ...

    def link_lost(self) -> None:
        """The station is gone."""
        ...


class InProcessLink:
    """A ``Link`` without a wire: replies are there when ``write`` returns, so silence is final."""

    def __init__(self, emulator: UnitOnALine) -> None:
        self._emulator = emulator
        self._replies: deque[bytes] = deque()
        self._closed = False

    def write(self, data: bytes) -> None:
        if self._closed:
            raise LinkError("the line to the emulator is closed")
        self._replies.extend(self._emulator.handle_input(data))

    def read_line(self, timeout_s: float) -> bytes | None:
        if self._replies:
            return self._replies.popleft().rstrip(b"\r\n")
        if self._closed:
            raise LinkError("the line to the emulator is closed")
        return None

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._emulator.link_lost()


@contextlib.contextmanager
def serve_pty(emulator: UnitOnALine, link_path: str | Path | None = None) -> Iterator[str]:
    """Serve on a pseudo-terminal while the context lasts; gives the name to connect to.

    With ``link_path`` a symbolic link of that name is made and removed again. The station may
    close and reopen the line any number of times.

    Raises
    ------
    ConfigurationError
        No pseudo-terminals on this system, or the link cannot be made.
    """
    try:
        import pty  # noqa: PLC0415
        import tty  # noqa: PLC0415
    except ImportError:
        raise ConfigurationError(
            "this system has no pseudo-terminals; use --tcp 127.0.0.1:PORT instead"
        ) from None
    unit_end, station_end = pty.openpty()
    # Raw, and kept open here: the settings live as long as somebody holds the station's end, and
    # without a holder reading the unit's end would fail whenever the station closes.
    tty.setraw(station_end)
    name = os.ttyname(station_end)
    link = Path(link_path) if link_path is not None else None
    try:
        if link is not None:
            _make_link(link, name)
        with _in_thread(_PtyServer(emulator, unit_end)):
            yield str(link) if link is not None else name
    finally:
        if link is not None and _points_to(link, name):
            link.unlink()
        os.close(unit_end)
        os.close(station_end)


@contextlib.contextmanager
def serve_tcp(emulator: UnitOnALine, host: str = "127.0.0.1", port: int = 0) -> Iterator[str]:
    """Serve on TCP while the context lasts; gives the URL to connect to (port 0: a free one).

    One station at a time, any number one after the other; a second simultaneous one gets a line
    that says busy, and is closed.

    Raises
    ------
    ConfigurationError
        The address cannot be served.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        listener = socket.create_server((host, port), family=family)
    except (OSError, OverflowError, UnicodeError) as error:
        # Python adds in brackets what the message says already.
        reason = (getattr(error, "strerror", None) or str(error)).partition(" (while")[0]
        raise ConfigurationError(f"cannot serve on {host}:{port}: {reason}") from None
    with listener, _in_thread(_TcpServer(emulator, listener)):
        shown = f"[{host}]" if ":" in host else host
        yield f"socket://{shown}:{listener.getsockname()[1]}"


@contextlib.contextmanager
def serve_here(emulator: UnitOnALine) -> Iterator[str]:
    """Serve for a station in this process: a pseudo-terminal, or TCP where there is none."""
    with contextlib.ExitStack() as line:
        try:
            url = line.enter_context(serve_pty(emulator))
        except ConfigurationError:
            url = line.enter_context(serve_tcp(emulator))
        yield url


def tcp_address(text: str) -> tuple[str, int]:
    """Host and port of ``HOST:PORT``, ``[IPV6]:PORT`` or ``:PORT`` (this machine only)."""
    host, colon, port = text.rpartition(":")
    if not colon or not port.isascii() or not port.isdigit() or int(port) > 65535:
        raise ConfigurationError(f"{text!r} is not HOST:PORT; write it like 127.0.0.1:7777")
    return host.removeprefix("[").removesuffix("]") or "127.0.0.1", int(port)


def exposure(host: str) -> str:
    """What serving on ``host`` lets strangers do; nothing where only this machine reaches it."""
    try:
        address = ipaddress.ip_address(socket.getaddrinfo(host, 0)[0][4][0])
    except (OSError, UnicodeError, ValueError):
        return ""  # not an address at all: serving on it will say so
    if address.is_loopback:
        return ""
    return (
        f"{host} is not this machine alone: anyone who reaches it over the network can connect, "
        "move the emulated unit's axes and overwrite its coefficients; there is no password and "
        "no encryption"
    )


class _Server(ABC):
    """Runs in its own thread until it is closed."""

    def __init__(self, emulator: UnitOnALine) -> None:
        self.emulator = emulator
        self._wake_reader, self._wake_writer = os.pipe()
        self._ending = False

    def end(self) -> None:
        self._ending = True
        os.write(self._wake_writer, b"!")

    def dispose(self) -> None:
        os.close(self._wake_reader)
        os.close(self._wake_writer)

    def ready(self, *sources: int) -> list[int]:
        """Descriptors with input, an empty list after a while; raises ``_Ended`` on request."""
        readable, _, _ = select.select([*sources, self._wake_reader], [], [], WAKE_S)
        if self._ending:
            raise _Ended
        if not readable:
            self.emulator.catch_up()
        return readable

    @abstractmethod
    def serve(self) -> None: ...


class _Ended(Exception):
    """The way out of a server's loop."""


class _PtyServer(_Server):
    def __init__(self, emulator: UnitOnALine, descriptor: int) -> None:
        super().__init__(emulator)
        self._descriptor = descriptor
        # A station that no longer reads must not block the unit for ever.
        os.set_blocking(descriptor, False)

    def serve(self) -> None:
        while True:
            if self._descriptor not in self.ready(self._descriptor):
                continue
            with contextlib.suppress(BlockingIOError):
                for reply in self.emulator.handle_input(os.read(self._descriptor, 4096)):
                    self._write(reply)

    def _write(self, reply: bytes) -> None:
        while reply:
            _, writable, _ = select.select([], [self._descriptor], [], WAKE_S)
            if not writable:
                return
            reply = reply[os.write(self._descriptor, reply) :]


class _TcpServer(_Server):
    def __init__(self, emulator: UnitOnALine, listener: socket.socket) -> None:
        super().__init__(emulator)
        self._listener = listener

    def serve(self) -> None:
        while True:
            if self._listener.fileno() in self.ready(self._listener.fileno()):
                client, _ = self._listener.accept()
                with client:
                    self._talk(client)
                self.emulator.link_lost()

    def _talk(self, client: socket.socket) -> None:
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.settimeout(WAKE_S * 10)
        while True:
            readable = self.ready(client.fileno(), self._listener.fileno())
            if self._listener.fileno() in readable:
                self._turn_away()
            if client.fileno() not in readable:
                continue
            try:
                data = client.recv(4096)
                if not data:
                    return
                for reply in self.emulator.handle_input(data):
                    client.sendall(reply)
            except HungUp:
                return
            except OSError:
                # Reset or stuck: this station is gone, the next may come.
                return

    def _turn_away(self) -> None:
        second, _ = self._listener.accept()
        with second, contextlib.suppress(OSError):
            second.settimeout(WAKE_S)
            second.sendall(BUSY)
            # Told again when it speaks: pyserial throws away what came before it had opened. To
            # close on what it sends would be a reset. The first station can wait that long.
            while second.recv(4096):
                second.sendall(BUSY)


@contextlib.contextmanager
def _in_thread(server: _Server) -> Iterator[None]:
    def run() -> None:
        with contextlib.suppress(_Ended):
            server.serve()

    thread = threading.Thread(target=run, name="emulated unit", daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.end()
        thread.join()
        server.dispose()


def _make_link(link: Path, name: str) -> None:
    try:
        # One left behind by an emulator that was killed may be replaced; nothing else may.
        if link.is_symlink() and (not link.exists() or _outlived(link)):
            link.unlink()
        link.symlink_to(name)
    except FileExistsError:
        raise ConfigurationError(f"{link} exists already; give another name") from None
    except OSError as error:
        raise ConfigurationError(f"cannot make the link {link}: {error.strerror}") from None


def _outlived(link: Path) -> bool:
    """Whether the pseudo-terminal this link was made for is gone, and its name another's by now.

    A pseudo-terminal is older than the link to it; one that is younger has only its number.
    """
    try:
        target = link.readlink()
        return target.parent == PSEUDO_TERMINALS and (
            target.stat().st_ctime_ns > link.lstat().st_mtime_ns
        )
    except OSError:
        return False


def _points_to(link: Path, name: str) -> bool:
    try:
        return str(link.readlink()) == name
    except OSError:
        return False
