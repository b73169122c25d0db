"""A session's records folded once: what they say so far, voided ones left out.

They come from the journal of a running program, or from a file, whether or not a program is still
writing it.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import msgspec
import numpy as np

from solarcal.decimals import Pair
from solarcal.errors import SessionFileError
from solarcal.input_files import read_bytes
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.mount.geometry import MountGeometry
from solarcal.session.parsing import parse_session
from solarcal.session.points import PointTable, table_of_points
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
    Void,
)
from solarcal.session.voids import TAKEN_BACK, live_records, offsets_struck
from solarcal.units import wrap_deg

_SAME_DEG = 1e-4
"""Numbers rounded to 1e-5 deg or to the read-out's digits, of which one follows from the others."""

UNCLOSED = "was not closed: the session goes on, or its end is missing"

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
    reconnections: tuple[LinkRestored, ...] = ()
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

    def true_axes_deg(self, azimuth_deg: float, zenith_deg: float) -> Pair:
        """AX1 on the branch and AX2 of a light there, or of the normal that reflects it."""
        if self.header.unit.heliostat is not None:
            aim = self.header.unit.heliostat.true_normal_deg(azimuth_deg, zenith_deg)
            azimuth_deg, zenith_deg = aim
        ax1, ax2 = self.geometry.axes_from_horizontal(azimuth_deg, zenith_deg)
        return float(ax1), float(ax2)

    @cached_property
    def accepted(self) -> tuple[PointRecord, ...]:
        return tuple(p for p in self.points if p.status == "accepted")

    @cached_property
    def offset_at(self) -> dict[str, SunOffset]:
        """The Set Sun Offsets by the instant of their read-outs."""
        return {offset.instant: offset for offset in self.sun_offsets}

    @property
    def struck_out(self) -> tuple[tuple[Record, Void], ...]:
        """The records that do not count, each with the one that strikes it; no void that is
        struck itself: what it struck counts again."""
        by = {r.voids: r for r in live_records(self.records) if isinstance(r, Void)}
        own = (record for record in self.records if not isinstance(record, Void))
        return tuple((record, by[record.seq]) for record in own if record.seq in by)

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

    def written_since(self, upload: UploadRecord) -> int:
        """The record since which the unit has had what an upload wrote: the same numbers written
        once more leave the check points before them their meaning."""
        since = upload.seq
        for earlier in reversed(self.uploads):
            if earlier.seq < since:
                if not (earlier.verified and earlier.writes == upload.writes):
                    break
                since = earlier.seq
        return since

    def checks_after(self, upload: UploadRecord) -> list[CheckRecord]:
        """The check points stored since the unit has had what an upload wrote."""
        since = self.written_since(upload)
        return [c for c in self.checks if c.status == "accepted" and c.seq > since]

    @property
    def holds_upload(self) -> bool:
        """Whether the unit held the newest upload when it was seen last."""
        return held_instead([self]) is None

    @property
    def fresh_sun_offset(self) -> SunOffset | None:
        """The newest Set Sun Offset, while a point can be taken from it.

        A second one would repeat the error of the first: whether that was stored, rejected or
        struck out. With a NO to 'Did you do a Set Sun Offset?' it is not to be used either.
        """
        return self._in_force_after(record.seq for record in self.records if _uses_offset(record))

    @property
    def unused_sun_offset(self) -> SunOffset | None:
        """The newest Set Sun Offset, while no stored point rests on it: it can be taken back."""
        return self._in_force_after(p.seq for p in self.accepted)

    @property
    def offset_left(self) -> SunOffset | PointRecord | CheckRecord | None:
        """The newest record of another O than was uploaded, while the unit has it in force.

        A record that is struck out puts no O back: only an upload, a stored check point and a Set
        Sun Offset taken back write one.
        """
        if not self.uploads:
            return None
        uploaded = self.uploads[-1].new_offsets
        back = {void.seq for _, void in self.struck_out if void.reason.startswith(TAKEN_BACK)}
        undone = math.inf
        for record in reversed(self.records):
            if isinstance(record, Void) and record.seq in back:
                undone = min(undone, record.voids)
            if record.seq >= undone:
                continue
            stored = getattr(record, "status", "") == "accepted"
            if isinstance(record, UploadRecord) or (isinstance(record, CheckRecord) and stored):
                return None
            if isinstance(record, SunOffset | PointRecord | CheckRecord):
                seen = _offsets_seen(record)
                if seen is not None:
                    return None if seen == uploaded else record
        return None

    def _in_force_after(self, ends: Iterable[int]) -> SunOffset | None:
        """The newest Set Sun Offset, where none of these records came later, and no upload or
        stored check point, struck out or not, with which another O was written."""
        newest = next(reversed(self.sun_offsets), None)
        written = (
            record.seq
            for record in self.records
            if isinstance(record, UploadRecord)
            or (isinstance(record, CheckRecord) and record.status == "accepted")
        )
        return newest if newest and all(s < newest.seq for s in (*ends, *written)) else None

    @cached_property
    def known_offsets(self) -> dict[Offsets, int]:
        """Every O the program knows the unit to have held, and the first record that says so.

        A unit that holds one of them was not set on the Sun anew.
        """
        known = {self.header.offsets: self.header.seq}
        for record in self.records:
            if isinstance(record, SunOffset | InForce):
                known.setdefault(record.offsets, record.seq)
            elif isinstance(record, PointRecord) and record.offsets is not None:
                if record.status == "accepted":
                    known.setdefault(record.offsets, record.seq)
            elif isinstance(record, UploadRecord):
                known.setdefault(record.new_offsets, record.seq)
            elif isinstance(record, CheckRecord) and record.status == "accepted":
                known.setdefault(Offsets(), record.seq)
        return known


def _offsets_seen(record: SunOffset | PointRecord | CheckRecord) -> Offsets | None:
    """The O in force that a record shows, if any."""
    if isinstance(record, CheckRecord):
        return None if record.error_deg is None else Offsets(*record.error_deg)
    return record.offsets


def _uses_offset(record: Record) -> bool:
    """Whether the Set Sun Offset before this record gives no other point after it."""
    if not isinstance(record, PointRecord | CheckRecord):
        return False
    return record.status != "aborted" or record.answers.sun_offset is False


def held_instead(views: Sequence[SessionView]) -> tuple[Coefficients, UploadRecord] | None:
    """The P that a unit held instead of the newest upload of its sessions, when it was seen last.

    None where it held that upload, or nothing was uploaded. It is seen where both are compared, at
    every offset and point, and when a later session begins.
    """
    written = [(u.utc, at, u.seq, u) for at, view in enumerate(views) for u in view.uploads]
    if not written:
        return None
    since, own, _, upload = max(written, key=lambda one: one[:3])
    if not upload.verified:
        return None
    seen: list[tuple[str, int, Coefficients, bool]] = []
    for at, view in enumerate(views):
        header = view.header
        records: list[InForce | SunOffset | PointRecord]
        records = [*view.in_force, *view.sun_offsets, *view.accepted]
        if at == own:
            records = [record for record in records if record.seq > upload.seq]
        else:
            records = [record for record in records if record.utc > since]
            if header.utc > since and not header.unit.imported:
                same = header.coefficients == upload.new_coefficients
                seen.append((header.utc, header.seq, header.coefficients, same))
        for record in records:
            if (held := record.coefficients) is not None:
                same = held == upload.new_coefficients
                same = record.as_uploaded if isinstance(record, InForce) else same
                seen.append((record.utc, record.seq, held, same))
    if not seen:
        return None
    *_, held, same = max(seen, key=lambda one: one[:2])
    return None if same else (held, upload)


def read_session(path: str | Path) -> SessionView:
    """A session file, read and folded. What is wrong with it and can be lived with is in
    ``warnings``: a torn line, an end that is missing, a record that contradicts itself.

    Raises
    ------
    SessionFileError
        Missing, unreadable, a bad line (named), or a format of the future.
    """
    return session_of(read_bytes(path, error=SessionFileError), str(path))


def session_of(content: bytes, name: str) -> SessionView:
    """``read_session`` of a file's bytes; ``name`` is what messages call the file."""
    text = parse_session(content, name)
    view = view_session(text.header, tuple(text.records), name)
    warnings = [*text.warnings, *contradictions(view, name)]
    if not any(isinstance(record, Closed) for record in text.records):
        warnings.append(f"{name} {UNCLOSED}")
    # It is ours until it is returned: a copy would look for what belongs together once more.
    object.__setattr__(view, "warnings", tuple(warnings))
    return view


def view_session(
    header: Header, records: tuple[Record, ...], path: str = "", warnings: tuple[str, ...] = ()
) -> SessionView:
    """Fold the records of a session into what they say."""
    kinds: dict[type, list[Record]] = {}
    live = live_records(records)
    lost = offsets_struck(records, live)
    for record in live:
        if record.seq in lost and isinstance(record, PointRecord | CheckRecord):
            reason = f"its Set Sun Offset, record {lost[record.seq]}, is struck out"
            record = msgspec.structs.replace(record, status="rejected", reason=reason)
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
        reconnections=of(LinkRestored),
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


def contradictions(view: SessionView, name: str) -> Iterator[str]:
    """Points that are not used for want of an offset, and records in which a number does not agree
    with the others it can be had from."""
    header, records = view.header, view.records
    offsets = view.offset_at
    found = [record for record in records if isinstance(record, PointRecord)]
    taken = {r.seq for r in records if getattr(r, "status", "") == "accepted"}
    for what, attempts in (("point", view.points), ("check point", view.checks)):
        for attempt in attempts:
            if attempt.seq in taken and attempt.status != "accepted":
                yield f"{name}: {what} {attempt.seq} is not used: {attempt.reason}"
    parts = [
        (record.seq, axis, *numbers)
        for record in found
        if record.reading_deg and record.ideal_deg and record.error_deg
        for axis, numbers in enumerate(
            zip(record.reading_deg, record.ideal_deg, record.error_deg, strict=True), start=1
        )
    ]
    if parts and not header.unit.typed:
        _, _, reading, ideal, error = np.array(parts).T
        for at in np.flatnonzero(np.abs(wrap_deg(reading - ideal - error)) > _SAME_DEG).tolist():
            seq, axis, *numbers = parts[at]
            yield (
                f"{name}: point {seq}: reading {numbers[0]:z.5f} - ideal {numbers[1]:z.5f} of "
                f"axis {axis} is not the recorded error {numbers[2]:z.5f} deg"
            )
    for record in found:
        offset = offsets.get(record.read_utc or "")
        if record.basis == "sun_offset" and offset is not None:
            for what in ("ideal_deg", "reading_deg", "counts", "offsets"):
                if getattr(record, what) != getattr(offset, what):
                    yield (
                        f"{name}: point {record.seq}: its {what} are not those of the Set Sun "
                        f"Offset it was taken on, record {offset.seq}"
                    )
