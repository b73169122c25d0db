"""Tracking the Sun with a unit for a while, and then stopping it; coefficients from a file.

A file is a document of ``solarcal fit --json``, or a session that is fitted.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from solarcal.errors import InputFileError, LinkError, SolarcalError
from solarcal.input_files import read_bytes
from solarcal.mount.formula import COEFFICIENT_NAMES, Coefficients, Offsets
from solarcal.station.analysing import analyse_files, read_files
from solarcal.sun import sun_position
from solarcal.timescale import Clock, format_utc
from solarcal.unit.tracker import Mode, Status, Tracker


class _Value(msgspec.Struct, frozen=True):
    value: float


class _FitDocument(msgspec.Struct, frozen=True):
    geometry: str
    coefficients: dict[str, _Value]
    method: str = ""


class FileCoefficients(msgspec.Struct, frozen=True):
    """P1..P6, the geometry they mean something for, and where they are from, in words."""

    coefficients: Coefficients
    geometry: str
    source: str


def read_coefficients(path: Path, method: str | None = None) -> FileCoefficients:
    """The coefficients a file gives.

    ``method``: how a session is fitted; a document's fit has been made.

    Raises
    ------
    InputFileError
        Neither of the two, or a document without all six terms.
    FitError
        A session whose points allow no fit.
    """
    if path.suffix.lower() == ".jsonl":
        judged = analyse_files(read_files([path], {}), method=method)
        solution = judged.of_the_controller().solution
        return FileCoefficients(
            solution.coefficients(), judged.table.geometry, f"{solution.method} fit of {path}"
        )
    content = read_bytes(path)
    try:
        document = msgspec.json.decode(content, type=_FitDocument)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputFileError(
            f"{path} is neither a session (.jsonl) nor what `solarcal fit --json` prints: {error}"
        ) from None
    told = {name: term.value for name, term in document.coefficients.items()}
    missing = [name for name in COEFFICIENT_NAMES if not math.isfinite(told.get(name, math.nan))]
    if missing:
        raise InputFileError(
            f"{path}: {', '.join(missing)} missing; a controller needs all of P1..P6, so fit "
            "without --terms"
        )
    return FileCoefficients(
        Coefficients(*(told[name] for name in COEFFICIENT_NAMES)),
        document.geometry,
        f"{document.method} fit in {path}".strip(),
    )


SHORTEST_WAIT_S = 0.01
"""So that the end is passed, whatever a clock makes of less than a millisecond."""

RETRY_S = 5.0
THERE_DEG = 1.0
"""Farther from the Sun than this, at first, the axes are on their way to it."""

MOST_RETRIES = 24
"""Two minutes; a line that is gone for longer needs a person who looks after it."""


@dataclass(slots=True)
class TrackingRun:
    """What a run of tracking was: angles on sky, between the axes and where they were sent."""

    unit: str
    coefficients: Coefficients
    source: str
    started_utc_s: float
    offsets: Offsets = field(default_factory=Offsets)
    ended_utc_s: float = 0.0
    ended_by: str = ""
    lines_lost: int = 0
    offs_deg: list[float] = field(default_factory=list)
    at_limit: int = 0

    def document(self) -> dict[str, Any]:
        """The summary for ``--json``."""
        offs = self.offs_deg
        return {
            "unit": self.unit,
            "coefficients": msgspec.to_builtins(self.coefficients),
            "coefficients_from": self.source,
            "offsets": msgspec.to_builtins(self.offsets),
            "started_utc": format_utc(self.started_utc_s, 0),
            "ended_utc": format_utc(self.ended_utc_s, 0),
            "ended_by": self.ended_by,
            "looks": len(offs) + self.at_limit,
            "looks_at_limit": self.at_limit,
            "off_rms_deg": math.sqrt(sum(off * off for off in offs) / len(offs)) if offs else None,
            "off_max_deg": max(offs, default=None),
            "lines_lost": self.lines_lost,
        }


class SunTracking:
    """Tells a unit to track, looks at it, and stops it whatever ends the run.

    Parameters
    ----------
    tracker : open.
    clock : the laptop's.
    say : called with a line at every look.
    """

    def __init__(
        self, tracker: Tracker, clock: Clock, run: TrackingRun, say: Callable[[str], None]
    ) -> None:
        self._tracker = tracker
        self._clock = clock
        self._run = run
        self._say = say

    def until(self, until_utc_s: float | None, every_s: float) -> TrackingRun:
        """Track until then, or until the Sun is down, or until interrupted (Ctrl-C).

        Raises
        ------
        LinkError
            The line was lost and could not be opened again for two minutes, or the STOP at the
            end could not be sent.
        UnitRefused
            The unit does not track: the Sun is down, say.
        """
        run = self._run
        try:
            self._tracker.set_mode(Mode.TRACK)
            run.ended_by = self._followed(until_utc_s, every_s)
        except KeyboardInterrupt as interrupt:
            run.ended_by = str(interrupt).removeprefix("ended by ") or "interrupted"
            # In here, where a signal that asks again breaks nothing off.
            self._end()
        else:
            self._end()
        return run

    def _followed(self, until_utc_s: float | None, every_s: float) -> str:
        """What ended it."""
        clock = self._clock
        try:
            while True:
                now_s = clock.utc_s()
                if until_utc_s is not None and now_s >= until_utc_s:
                    return "until"
                sun = sun_position("solartrak", now_s, self._tracker.site().site)
                if float(sun.elevation_deg) < 0.0:
                    return "sunset"
                try:
                    status = self._tracker.status()
                except LinkError as error:
                    self._again(error)
                    continue
                if status.mode not in (Mode.TRACK, Mode.LIMIT):
                    # Somebody stopped it by another way in: that counts.
                    return f"mode {status.mode}"
                self._look(status)
                left_s = math.inf if until_utc_s is None else until_utc_s - clock.utc_s()
                clock.wait(max(min(every_s, left_s), SHORTEST_WAIT_S))
        except (SolarcalError, RuntimeError):
            # The second of a lock that an interrupt broke.
            self._stop_if_possible()
            raise

    def _end(self) -> None:
        self._run.ended_utc_s = self._clock.utc_s()
        try:
            self._tracker.stop()
        except LinkError as error:
            try:
                # An interrupt may have broken off a request, and the line with it.
                self._tracker.open()
                self._tracker.stop()
            except LinkError:
                raise LinkError(
                    f"{self._run.ended_by}; the unit could NOT be stopped: {error}"
                ) from None

    def _stop_if_possible(self) -> None:
        """The cause of the end is reported, not that a lost line cannot carry a STOP either."""
        try:
            self._tracker.stop()
        except SolarcalError as error:
            self._say(f"it could not be stopped: {error}")

    def _look(self, status: Status) -> None:
        run = self._run
        when = format_utc(status.unit_utc_s, 0)
        axes = f"axes {status.reading1_deg:z8.2f} {status.reading2_deg:z7.2f} deg"
        if status.mode is Mode.LIMIT:
            run.at_limit += 1
            self._say(f"{when}  {axes}  the Sun is beyond the limits; waiting for it")
            return
        off = status.on_sky_deg(*status.off_target_deg)
        if not run.offs_deg and off > THERE_DEG:
            self._say(f"{when}  {axes}  on the way, {off:.1f} deg to go")
            return
        run.offs_deg.append(off)
        self._say(f"{when}  {axes}  {off:.3f} deg from their targets")

    def _again(self, error: LinkError) -> None:
        """Open the line again and go on: the command to track still stands."""
        self._run.lines_lost += 1
        self._say(str(error))
        begun_s = self._clock.utc_s()
        for attempt in range(1, MOST_RETRIES + 1):
            self._clock.wait(RETRY_S)
            try:
                self._tracker.open()
                self._tracker.set_mode(Mode.TRACK)
            except LinkError:
                # Each try takes some seconds of its own where nothing answers.
                late = self._clock.utc_s() - begun_s >= MOST_RETRIES * RETRY_S
                if late or attempt == MOST_RETRIES:
                    raise
                continue
            self._say("the line is open again; tracking goes on")
            return
