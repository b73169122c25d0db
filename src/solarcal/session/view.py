"""A session's records folded once: what they say so far, voided ones left out."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from solarcal.mount.geometry import MountGeometry
from solarcal.session.points import PointTable, table_of_points
from solarcal.session.reader import live_records, read_session
from solarcal.session.records import (
    CheckRecord,
    ClockSet,
    Closed,
    FitRecord,
    Header,
    InForce,
    Initialised,
    LinkLost,
    LinkRestored,
    Note,
    PointRecord,
    Record,
    RefCheck,
    Restarted,
    SunOffset,
    Typed,
    UploadBegun,
    UploadRecord,
)

_NO_EVIDENCE = (FitRecord, Note, Typed, LinkLost, LinkRestored, Closed)


@dataclass(frozen=True)
class SessionView:
    """What a session's records say so far, voided ones left out.

    ``path`` and ``warnings`` are of the file, where it was read from one.
    """

    header: Header
    records: tuple[Record, ...] = ()
    initialised: Initialised | None = None
    clock_sets: tuple[ClockSet, ...] = ()
    ref_checks: tuple[RefCheck, ...] = ()
    sun_offsets: tuple[SunOffset, ...] = ()
    points: tuple[PointRecord, ...] = ()
    checks: tuple[CheckRecord, ...] = ()
    uploads: tuple[UploadRecord, ...] = ()
    fits: tuple[FitRecord, ...] = ()
    in_force: tuple[InForce, ...] = ()
    restarts: tuple[Restarted, ...] = ()
    path: str = ""
    warnings: tuple[str, ...] = ()

    @cached_property
    def table(self) -> PointTable:
        """All attempts with their statuses, as every fit takes them."""
        return table_of_points(self.header, self.points, self.path, self.warnings)

    @property
    def geometry(self) -> MountGeometry:
        return MountGeometry(
            self.header.geometry, self.header.site.latitude_deg, self.header.ax1_centre_deg
        )

    @cached_property
    def accepted(self) -> tuple[PointRecord, ...]:
        return tuple(p for p in self.points if p.status == "accepted")

    @property
    def newest_evidence(self) -> int:
        """Sequence number of the newest record that a judgement may rest on; -1 without any."""
        bearing = (r.seq for r in reversed(self.records) if not isinstance(r, _NO_EVIDENCE))
        return next(bearing, -1)

    @property
    def fit_recorded(self) -> bool:
        """Whether the newest fit record is of the points accepted now."""
        accepted = self.accepted
        if not accepted or not self.fits:
            return not accepted
        newest = self.fits[-1]
        return newest.points == len(accepted) and newest.seq > accepted[-1].seq

    @property
    def holds_upload(self) -> bool:
        """Whether the unit held the newest upload when the two were compared last."""
        if not self.uploads:
            return True
        newest = self.uploads[-1].seq
        compared = [record for record in self.in_force if record.seq > newest]
        return compared[-1].as_uploaded if compared else True

    @property
    def fresh_sun_offset(self) -> SunOffset | None:
        """The newest Set Sun Offset not yet used by a stored point or check."""
        if not self.sun_offsets:
            return None
        newest = self.sun_offsets[-1]
        used = [p.seq for p in self.points if p.status == "accepted"]
        used += [c.seq for c in self.checks if c.status == "accepted"]
        written = [u.seq for u in self.uploads]
        return newest if newest.seq > max([*used, *written, -1]) else None


def read_view(path: str | Path) -> SessionView:
    """A session file, read and folded; raises as ``read_session``."""
    session = read_session(path)
    return view_session(session.header, session.records, session.path, session.warnings)


def view_session(
    header: Header,
    records: tuple[Record, ...],
    path: str = "",
    warnings: tuple[str, ...] = (),
) -> SessionView:
    """Fold the records of a session into what they say."""
    kinds: dict[type, list[Record]] = {}
    live = live_records(records)
    for record in live:
        kinds.setdefault(type(record), []).append(record)

    def of(kind: type) -> tuple:  # type: ignore[type-arg]
        return tuple(kinds.get(kind, ()))

    initialised = of(Initialised)
    return SessionView(
        header=header,
        records=records,
        initialised=initialised[-1] if initialised else None,
        clock_sets=of(ClockSet),
        ref_checks=of(RefCheck),
        sun_offsets=of(SunOffset),
        points=of(PointRecord),
        checks=of(CheckRecord),
        uploads=_uploads(records, {record.seq for record in live}),
        fits=of(FitRecord),
        in_force=of(InForce),
        restarts=of(Restarted),
        path=path,
        warnings=warnings,
    )


def _uploads(records: tuple[Record, ...], live: set[int]) -> tuple[UploadRecord, ...]:
    """Every upload with its outcome; one without an outcome reads back as not verified."""
    found: list[UploadRecord] = []
    begun: UploadBegun | None = None
    for record in records:
        if isinstance(record, UploadBegun):
            if begun is not None and begun.seq in live:
                found.append(_unfinished(begun))
            begun = record
        elif isinstance(record, UploadRecord):
            begun = None
            if record.seq in live:
                found.append(record)
    if begun is not None and begun.seq in live:
        found.append(_unfinished(begun))
    return tuple(found)


def _unfinished(begun: UploadBegun) -> UploadRecord:
    return begun.outcome(
        begun.seq,
        begun.utc,
        verified=False,
        failure="no outcome was recorded; the unit may hold the old numbers or the new",
    )
