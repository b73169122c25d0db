"""The session's journal: appended, synced, and only then acknowledged.

Nothing is ever rewritten or removed. What ``append`` has returned from survives a kill and a power
cut; what it has not may be there or not, and is never half there (``lines`` says how).
"""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType

from solarcal.errors import SessionFileError
from solarcal.input_files import reason_of
from solarcal.session.disk import Disk
from solarcal.session.lines import encode_record, encode_records, torn_marker
from solarcal.session.parsing import parse_session
from solarcal.session.records import Header, Record


class Journal:
    """An open session. Make one with ``create``, ``resume`` or ``memory``.

    One program at a time has a session open for writing; within it, one thread at a time appends.

    Attributes
    ----------
    path : the file; ``None`` for a journal in memory.
    records : acknowledged so far, in order, without the header; voided ones included.
    warnings : what ``resume`` found to report (torn lines).
    """

    def __init__(
        self,
        header: Header,
        records: list[Record],
        *,
        path: Path | None = None,
        descriptor: int = -1,
        disk: Disk | None = None,
        end: int = 0,
        ended: bool = True,
        warnings: tuple[str, ...] = (),
    ) -> None:
        self.path = path
        self.header = header
        self.records = records
        self.warnings = warnings
        self._descriptor = descriptor
        self._disk = disk
        # Where the last good line ends, and whether its newline is there too.
        self._end = end
        self._ended = ended
        self._closed = False

    @classmethod
    def create(cls, path: str | Path, header: Header, *, disk: Disk | None = None) -> "Journal":
        """Begin a session file with its header line; returns when it is safely on the medium.

        Raises
        ------
        SessionFileError
            The file exists already or cannot be written.
        """
        path, disk = Path(path), disk or Disk()
        line = encode_record(header)
        try:
            descriptor = disk.create(path)
        except FileExistsError:
            raise SessionFileError(
                f"{path} exists already and is never overwritten; choose another name"
            ) from None
        except (OSError, ValueError) as error:
            raise SessionFileError(f"{path} cannot be created: {reason_of(error)}") from error
        journal = cls(header, [], path=path, descriptor=descriptor, disk=disk)
        try:
            disk.lock(descriptor, path)
            interrupt = journal._write(line)
            if interrupt is not None:
                raise interrupt
            disk.sync_folder(path.parent)
        except (OSError, SessionFileError, KeyboardInterrupt) as error:
            # Nobody was told of this file yet: a stump would only be in the way.
            journal.close()
            with suppress(OSError):
                disk.remove(path)
            if not isinstance(error, OSError):
                raise
            raise SessionFileError(f"{path} cannot be created: {reason_of(error)}") from error
        return journal

    @classmethod
    def resume(cls, path: str | Path, *, disk: Disk | None = None) -> "Journal":
        """Open an existing session file to append to it; the file is not changed by this.

        Raises
        ------
        SessionFileError
            Missing, not writable, damaged, or open in another program.
        """
        path, disk = Path(path), disk or Disk()
        try:
            descriptor = disk.open(path)
        except (OSError, ValueError) as error:
            raise SessionFileError(
                f"{path} cannot be opened for writing: {reason_of(error)}"
            ) from error
        try:
            disk.lock(descriptor, path)
            text = parse_session(disk.read(descriptor), str(path))
        except (OSError, SessionFileError) as error:
            disk.close(descriptor)
            if isinstance(error, SessionFileError):
                raise
            raise SessionFileError(f"{path} cannot be read: {reason_of(error)}") from error
        return cls(
            text.header,
            text.records,
            path=path,
            descriptor=descriptor,
            disk=disk,
            end=text.size if text.torn_start is None else text.torn_start,
            ended=text.ended or text.torn_start is not None,
            warnings=tuple(text.warnings),
        )

    @classmethod
    def memory(cls, header: Header) -> "Journal":
        """A journal without a file, for replays: the same checks, nothing kept."""
        encode_record(header)
        return cls(header, [])

    @property
    def next_seq(self) -> int:
        """The sequence number the next record must carry."""
        return (self.records[-1].seq if self.records else self.header.seq) + 1

    def append(self, record: Record) -> None:
        """Write one record; when this returns, it is on the medium.

        After an error the record is not part of the session and ``next_seq`` is unchanged: the
        same record may be appended again once the cause (a full disk) is gone.

        Raises
        ------
        SessionFileError
            The record or the file cannot be written.
        ValueError
            The record does not carry ``next_seq``, or is a header: the caller's mistake.
        """
        self.append_all([record])

    def append_all(self, records: Sequence[Record]) -> None:
        """Write several records with one sync; all of them are in the session, or none.

        Raises as ``append``.
        """
        seq = self.next_seq
        for record in records:
            if isinstance(record, Header) or record.seq != seq:
                raise ValueError(f"record {record.seq} where {seq} comes next")
            seq += 1
        if self._closed:
            raise SessionFileError(f"{self.path or 'this session'} is closed")
        lines = encode_records(records)
        interrupt = None
        if self._disk is not None and lines:
            try:
                interrupt = self._write(lines)
            except OSError as error:
                raise SessionFileError(
                    f"{self.path} cannot be written: {reason_of(error)}; "
                    f"record {self.next_seq} is not saved"
                ) from error
        self.records.extend(records)
        if interrupt is not None:
            raise interrupt

    def close(self) -> None:
        """Give up the file and its lock. Closing twice is allowed."""
        if not self._closed and self._disk is not None:
            self._disk.close(self._descriptor)
        self._closed = True

    def __enter__(self) -> "Journal":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _restore(self, disk: Disk, path: Path) -> None:
        """Removed or moved away by another program: write what we hold there again, and go on."""
        content = memoryview(disk.read(self._descriptor))
        descriptor = disk.create(path)
        try:
            disk.lock(descriptor, path)
            while content:
                content = content[disk.write(descriptor, bytes(content)) :]
            disk.sync(descriptor)
            disk.sync_folder(path.parent)
        except (OSError, SessionFileError):
            disk.close(descriptor)
            with suppress(OSError):
                disk.remove(path)
            raise
        disk.close(self._descriptor)
        self._descriptor = descriptor

    def _write(self, line: bytes) -> KeyboardInterrupt | None:
        """Write and sync; what interrupted it meanwhile, for the caller to raise at the end."""
        disk, path = self._disk, self.path
        assert disk is not None
        assert path is not None
        torn_bytes = disk.size(self._descriptor) - self._end
        if torn_bytes < 0:
            raise SessionFileError(
                f"{path} was cut short by another program: {-torn_bytes} bytes are missing; "
                "restore the file, or begin a new session"
            )
        if not disk.has_name(self._descriptor, path):
            self._restore(disk, path)
        if torn_bytes > 0 and not self._ended:
            # The newline the last good line lacked did get there.
            torn_bytes, self._end, self._ended = torn_bytes - 1, self._end + 1, True
        if torn_bytes > 0:
            # What an interrupted write left behind: close it, declare it, go on behind it.
            line = b"\n" + torn_marker(torn_bytes + 1) + line
        elif not self._ended:
            line = b"\n" + line
        interrupt = None
        begin = self._end + torn_bytes
        while self._end != begin + len(line):
            try:
                # Asked of the disk: an interrupt may come between a write and its answer.
                while (written := disk.size(self._descriptor) - begin) < len(line):
                    disk.write(self._descriptor, line[written:])
                disk.sync(self._descriptor)
                self._end = begin + len(line)
            except KeyboardInterrupt as error:
                interrupt = error
        self._ended = True
        return interrupt
