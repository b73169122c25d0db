"""A saved session as a station: the same state, its events read from the journal.

Step forward, back, or jump: the state after ``n`` records is the fold of the first ``n``, exactly
what the live station showed when it had written them.
"""

from dataclasses import dataclass
from pathlib import Path

from solarcal.session.reader import UNCLOSED, read_session
from solarcal.session.records import Header, PointRecord, Record
from solarcal.station.state import SessionView, view_session
from solarcal.timescale import parse_utc


@dataclass(slots=True)
class Replay:
    """Where a replay stands in its session. ``position`` is the number of records seen."""

    header: Header
    records: tuple[Record, ...]
    warnings: tuple[str, ...] = ()
    position: int = 0

    @classmethod
    def open(cls, path: Path) -> "Replay":
        session = read_session(path)
        # Where the records end is what a replay shows anyway.
        warnings = tuple(line for line in session.warnings if not line.endswith(UNCLOSED))
        return cls(session.header, session.records, warnings)

    def __len__(self) -> int:
        return len(self.records)

    @property
    def view(self) -> SessionView:
        """The session as it stood after ``position`` records."""
        return view_session(self.header, self.records[: self.position])

    @property
    def utc_s(self) -> float:
        """The laptop's time of the record last seen."""
        seen = self.records[self.position - 1] if self.position else self.header
        return parse_utc(seen.utc)

    def jump(self, position: int) -> None:
        """Go to just after that many records; beyond the ends means the ends."""
        self.position = min(max(position, 0), len(self.records))

    def step(self, records: int = 1) -> None:
        """Forward, or with a negative number back."""
        self.jump(self.position + records)

    def jump_to_point(self, number: int) -> None:
        """Go to just after the ``number``-th accepted or unaccepted point, counted from one."""
        places = [i for i, record in enumerate(self.records) if isinstance(record, PointRecord)]
        if places:
            self.jump(places[min(max(number, 1), len(places)) - 1] + 1)
