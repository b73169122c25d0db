"""Saved sessions: which there are, which are finished, how one is resumed, and their replay."""

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import msgspec
from msgspec.structs import astuple

from solarcal.config import Choice, in_sessions_dir, load_settings, sessions_dir
from solarcal.decimals import counted
from solarcal.errors import SolarcalError, harmless
from solarcal.optics.reflection import Target
from solarcal.session.points import SITE_TOLERANCE_DEG
from solarcal.session.records import Closed, Header, PointRecord, Record
from solarcal.session.view import UNCLOSED, SessionView, read_session, view_session
from solarcal.site import Site, longitude_apart_deg
from solarcal.timescale import parse_utc

NEWEST_SESSIONS = 40
"""How many saved sessions are looked into."""


def finished(session: "SessionView") -> str:
    """Why a session needs no going on with, or nothing: then the start screen offers it first."""
    if any(upload.verified and not upload.rollback for upload in session.uploads):
        return "calibration finished"
    if session.initialised is None and not session.accepted:
        return "left before the calibration was begun"
    return ""


@dataclass(frozen=True, slots=True)
class SavedSession:
    """A session file as the start screen offers it; ``damage`` says why it cannot be read."""

    path: Path
    last_utc: str = ""
    points: int = 0
    finished: bool = True
    damage: str = ""
    unit: tuple[str, str, str] = ("", "", "")
    """Model, serial number and geometry."""
    site: Site | None = None
    target: Target | None = None
    """Of a heliostat."""
    typed: bool = False

    def words(self) -> str:
        name = harmless(self.path.name)
        if self.damage:
            return f"{name}  cannot be read"
        where = "" if in_sessions_dir(self.path) else f"  in {harmless(str(self.path.parent))}"
        return f"{name}  {counted(self.points, 'point')}, last {self.last_utc[:16]}Z{where}"


def saved_sessions() -> list[SavedSession]:
    """The newest session files, newest first: of the sessions folder, and those that the
    workstation has written elsewhere."""
    named = [Path(name) for name in load_settings().lines]
    elsewhere = [path for path in named if path.is_absolute() and not in_sessions_dir(path)]
    files = session_files([sessions_dir()], elsewhere)
    return [look_into(path) for path in files[:NEWEST_SESSIONS]]


def session_files(folders: Iterable[Path], more: Iterable[Path] = ()) -> list[Path]:
    """Session files of these folders, and ``more``, newest first.

    Without files that are gone meanwhile, links that lead nowhere, folders that may not be read.
    """
    found = list(more)
    for folder in folders:
        with suppress(OSError):
            found.extend(folder.glob("*.jsonl"))
    files = []
    for path in found:
        with suppress(OSError):
            files.append((-path.stat().st_mtime, path.name, path))
    return [path for _, _, path in sorted(files)]


def unfinished_sessions(
    model: str, serial: str, geometry: str, site: Site, target: Target | None
) -> list[SavedSession]:
    """Those of one unit at its place that can be gone on with, newest first."""
    return [
        saved
        for saved in saved_sessions()
        if not saved.finished and not saved.damage
        if (saved.unit, saved.target) == ((model, serial, geometry), target)
        if saved.site is not None and _same_place(saved.site, site)
    ]


def _same_place(one: Site, other: Site) -> bool:
    pairs = (one.latitude_deg, other.latitude_deg), (one.longitude_deg, other.longitude_deg)
    return all(abs(longitude_apart_deg(*pair)) <= SITE_TOLERANCE_DEG for pair in pairs)


def look_into(path: Path) -> SavedSession:
    """A session file in one line, or why it cannot be read."""
    try:
        session = read_session(path)
    except SolarcalError as error:
        return SavedSession(path, damage=str(error))
    last = session.records[-1] if session.records else session.header
    header = session.header
    imported = header.sun_model != "solartrak"
    return SavedSession(
        path,
        last.utc,
        len(session.accepted),
        isinstance(last, Closed) or imported,
        unit=(header.unit.model, header.unit.serial, header.geometry),
        site=header.unit.site,
        target=None if header.unit.heliostat is None else header.unit.heliostat.target,
        typed=header.unit.typed,
    )


def continuing(saved: SavedSession, remembered: Choice | None) -> Choice | None:
    """How to go on with a session: the line it was taken on, if that is known."""
    if remembered is None:
        return Choice(driver="typed", session=str(saved.path)) if saved.typed else None
    return msgspec.structs.replace(remembered, session=str(saved.path))


def emulated_again(session: SessionView) -> tuple[str, ...]:
    """Settings of its scenario with which another emulated unit takes over a session.

    The one it was taken with died with its process. The other begins when the session broke off,
    with what was stored last in its permanent memory.
    """
    last = session.records[-1] if session.records else session.header
    settings = [f"start={last.utc}"]
    for upload in session.uploads:
        if upload.verified:
            settings.append(f"unit.coefficients={[*astuple(upload.new_coefficients)]}")
            settings.append(f"unit.offsets={[*astuple(upload.new_offsets)]}")
    return tuple(settings)


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

    @property
    def point_positions(self) -> list[int]:
        """Just after each point, accepted or not."""
        return [i for i, r in enumerate(self.records, start=1) if isinstance(r, PointRecord)]

    def jump_to_point(self, number: int) -> None:
        """Go to just after the ``number``-th accepted or unaccepted point, counted from one."""
        if places := self.point_positions:
            self.jump(places[min(max(number, 1), len(places)) - 1])
