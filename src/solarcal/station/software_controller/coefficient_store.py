"""P and O of a unit that cannot keep them, kept for it by the station.

One small TOML file a unit, replaced whole at every change: a power cut leaves the old numbers or
the new. The session files tell who changed them, when and why; this file only what is in force.
"""

import os
import re
from pathlib import Path
from typing import Protocol

import msgspec

from solarcal.config import read_toml, units_dir, write_toml
from solarcal.errors import ConfigurationError, ProcedureRefused, SessionFileError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.session.disk import Disk


class StoredCorrection(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What the station commands a unit besides the Sun's own angles. ``utc``: of the change."""

    coefficients: Coefficients = Coefficients()
    offsets: Offsets = Offsets()
    utc: str = ""


class CoefficientStore(Protocol):
    """Where a unit's P and O are kept."""

    def load(self) -> StoredCorrection: ...

    def keep(self, correction: StoredCorrection) -> None: ...

    def lock(self) -> "UnitLock | None":
        """What no two programs can have; ``None`` where no other could want it."""
        ...


class FileStore:
    """In a file of the user's data folder.

    Raises
    ------
    ConfigurationError
        From the methods: the file cannot be read or written, or is damaged. Nothing is assumed
        then: wrong coefficients would drive the axes wrong.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def of_unit(cls, model: str, serial: str) -> "FileStore":
        """The file of one unit, by what it is called in its sessions."""
        return cls(units_dir() / f"{_plain(model)}-{_plain(serial)}.toml")

    def load(self) -> StoredCorrection:
        if not self.path.exists():
            return StoredCorrection()
        return read_toml(self.path, StoredCorrection)

    def keep(self, correction: StoredCorrection) -> None:
        write_toml(self.path, correction)

    def lock(self) -> "UnitLock":
        try:
            return UnitLock(self.path.with_suffix(".lock"))
        except OSError as error:
            raise ConfigurationError(
                f"{self.path.parent} cannot be written: {error.strerror}; SOLARCAL_UNITS names "
                "another folder"
            ) from None


class UnitLock:
    """One station a unit: where a line lets several in, two of them must not drive its axes.

    Refused (ProcedureRefused) where another program has it.
    """

    def __init__(self, path: Path) -> None:
        disk = Disk()
        path.parent.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        try:
            disk.lock(descriptor, path)
        except SessionFileError as error:
            disk.close(descriptor)
            holder = str(error).partition(" is being written by ")[2].partition(";")[0]
            raise ProcedureRefused(
                f"{path.stem} is driven by {holder or 'another program'} already; "
                "leave it there first: two stations must not move one unit"
            ) from None
        self._descriptor: int | None = descriptor

    def release(self) -> None:
        """Idempotent. The empty file stays."""
        if self._descriptor is not None:
            Disk().close(self._descriptor)
            self._descriptor = None


class MemoryStore:
    """In this process only: for emulated units, and where something else keeps the record."""

    def __init__(self, kept: StoredCorrection | None = None) -> None:
        self._correction = kept or StoredCorrection()

    def load(self) -> StoredCorrection:
        return self._correction

    def keep(self, correction: StoredCorrection) -> None:
        self._correction = correction

    def lock(self) -> None:
        return None


def _plain(name: str) -> str:
    """A name that cannot lead out of its folder."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip(".-") or "unit"
