"""The few operating-system calls a session file rests on, and its lock.

The lock is the operating system's own, held by the open file: it goes away with the process,
however that ends, so a lock can never be stale.
"""

import errno
import os
import sys
from contextlib import suppress
from pathlib import Path

from solarcal.errors import SessionFileError
from solarcal.input_files import refuse_large

# Windows locks are mandatory: locking bytes far beyond any session leaves its content readable.
_LOCK_OFFSET = 1 << 40


class Disk:
    """Real files. Tests put a recording or failing one in its place."""

    def create(self, path: Path) -> int:
        """Open a file that must not exist yet, for appending; returns its descriptor."""
        return os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | os.O_EXCL | _binary(), 0o644)

    def open(self, path: Path) -> int:
        """Open an existing file for reading and appending; returns its descriptor."""
        refuse_large(path, SessionFileError)
        return os.open(path, os.O_RDWR | os.O_APPEND | _binary())

    def read(self, descriptor: int) -> bytes:
        """Everything in the file."""
        os.lseek(descriptor, 0, os.SEEK_SET)
        parts = []
        while part := os.read(descriptor, 1 << 20):
            parts.append(part)
        return b"".join(parts)

    def write(self, descriptor: int, content: bytes) -> int:
        """Append some of ``content``, as ``os.write``; returns how many bytes were taken."""
        return os.write(descriptor, content)

    def size(self, descriptor: int) -> int:
        return os.fstat(descriptor).st_size

    def has_name(self, descriptor: int, path: Path) -> bool:
        """Whether ``path`` names this open file; an error where it names another one."""
        try:
            there = path.stat()
        except FileNotFoundError:
            return False
        if not os.path.samestat(os.fstat(descriptor), there):
            raise SessionFileError(
                f"another file has taken the place of {path}: move it away and try again, the "
                "session is written there anew"
            )
        return True

    def sync(self, descriptor: int) -> None:
        """Return when the file's content is on the medium."""
        os.fsync(descriptor)

    def sync_folder(self, folder: Path) -> None:
        """Return when the folder's entries are on the medium (a no-op where that is not possible).

        Without it a power cut can lose a new file whose content was synced; and without the folder
        above it, a new folder with all that is in it.
        """
        if sys.platform == "win32":
            return
        folder = folder.absolute()
        _sync_entries(folder)
        with suppress(PermissionError):
            # A folder above that one may not read was there before.
            _sync_entries(folder.parent)

    def close(self, descriptor: int) -> None:
        os.close(descriptor)

    def remove(self, path: Path) -> None:
        path.unlink(missing_ok=True)

    def lock(self, descriptor: int, path: Path) -> None:
        """Take the exclusive lock or say who has it.

        Raises
        ------
        SessionFileError
            Another program has it, or the file system cannot lock.
        """
        try:
            _lock(descriptor)
        except OSError as error:
            if error.errno in (errno.EAGAIN, errno.EACCES, errno.EDEADLK):
                raise SessionFileError(
                    f"{path} is being written by {_holder(descriptor)}; "
                    "close the session there first"
                ) from None
            raise SessionFileError(
                f"{path} cannot be locked ({error.strerror}); put the session on a local disk"
            ) from error


def _sync_entries(folder: Path) -> None:
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    except OSError as error:
        # Some network and foreign file systems know no such thing for a folder.
        if error.errno not in (errno.EINVAL, errno.ENOTSUP, errno.ENOSYS):
            raise
    finally:
        os.close(descriptor)


def _binary() -> int:
    return getattr(os, "O_BINARY", 0)


if sys.platform == "win32":
    import msvcrt

    def _lock(descriptor: int) -> None:
        os.lseek(descriptor, _LOCK_OFFSET, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

    def _holder(descriptor: int) -> str:
        return "another program"
else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # flock, not lockf: a POSIX record lock would be lost as soon as any reader in this
        # process closes the same file.
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _holder(descriptor: int) -> str:
        """The process that holds the lock, where the system tells (Linux)."""
        state = os.fstat(descriptor)
        try:
            table = Path("/proc/locks").read_text(encoding="ascii")
        except OSError:
            return "another program"
        wanted = f"{os.major(state.st_dev):02x}:{os.minor(state.st_dev):02x}:{state.st_ino}"
        for line in table.splitlines():
            fields = line.split()
            # One that waits for the lock has an arrow in the place of the word.
            if fields[1:2] == ["FLOCK"] and fields[5:6] == [wanted]:
                return f"another program (process {fields[4]})"
        return "another program"
