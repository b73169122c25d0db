"""A whole calibration without a screen: connect, open the file, let the technician work."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import msgspec
import numpy as np

from solarcal.errors import ConfigurationError, LinkError, ProcedureRefused
from solarcal.model.evidence.branch import branch_warning
from solarcal.model.evidence.unit_state import check_evidence, held_evidence
from solarcal.model.methods import DEFAULT_METHOD
from solarcal.model.solution import Solution
from solarcal.profiles import Profile
from solarcal.session.journal import Journal
from solarcal.session.records import Closed, Header, UploadRecord
from solarcal.session.view import SessionView
from solarcal.station.clocks import EmulatedClock
from solarcal.station.connect import disagreements, other_site
from solarcal.station.fitting import solve
from solarcal.station.procedure import Station
from solarcal.station.recording import profile_settings
from solarcal.station.technician import AutomaticTechnician, Schedule
from solarcal.stopping_rule import SYNCHRONISED_S
from solarcal.sun.position import require_supported_times
from solarcal.timescale import SECONDS_PER_DAY, Clock, SystemClock
from solarcal.unit.tracker import Emulation, Tracker, Truth

FIRST_PAUSE_S, LONGEST_PAUSE_S = 1.0, 15.0
GIVE_UP_S = 120.0
"""A line that is gone for longer needs a person who looks after it."""
AROUND_S = 20.0 * SECONDS_PER_DAY
"""A calibration takes some days at most, and an emulated Sun needs to be known some days around."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """What a headless calibration left behind. Truth only where the unit is an emulator.

    ``refused``: why nothing was uploaded; the session can be gone on with.
    ``checks``: how many check points were to be taken.
    """

    session: SessionView
    path: Path
    solution: Solution
    upload: UploadRecord | None
    refused: str
    truth_before: Truth
    truth_after: Truth
    checks: int = 0

    @property
    def completed(self) -> bool:
        """The read-back was exact, the unit still holds it, and check points that were to be taken
        were, none beyond the tolerance."""
        return not self.failure

    @property
    def failure(self) -> str:
        """Why it is not completed, or nothing."""
        if self.refused:
            return self.refused
        if self.upload is None or not self.upload.verified:
            return "the values read back differ from those written"
        if self.session.offset_left is not None:
            return "a Set Sun Offset is still in force beside what was uploaded"
        if self.checks and not self.session.checks_after(self.upload):
            return "no check point could be taken after the upload, so nothing proves it"
        against = (
            *held_evidence([self.session]),
            *check_evidence(self.session, self.solution.noise_deg),
        )
        return "; ".join(finding.sentence for finding in against)

    def truth_document(self) -> dict[str, float | None]:
        """The contract's ``truth``: the world's P1..P6 and the TRUE error before and after."""
        before, after = self.truth_before, self.truth_after
        return {
            **msgspec.to_builtins(after.coefficients),
            "day_rms_before_deg": before.day_rms_deg,
            "day_rms_after_deg": after.day_rms_deg,
            "day_max_after_deg": after.day_max_deg,
            "year_rms_before_deg": before.year_rms_deg,
            "year_rms_after_deg": after.year_rms_deg,
        }


def calibrate(
    tracker: Tracker,
    create_journal: Callable[[Header], Journal],
    schedule: Schedule,
    *,
    profile: Profile | None = None,
    method: str = DEFAULT_METHOD,
    eye_sigma_deg: float = 0.02,
    force: str | None = None,
    say: Callable[[str], None] = lambda sentence: None,
    resume: Path | None = None,
    pauses: Clock | None = None,
) -> Calibration:
    """Run the whole manual procedure by the automatic technician.

    A lost line is opened again for two minutes, and the step that was broken off is done anew.

    Parameters
    ----------
    profile : as a new session's header has it; the unit keeps its own site and weather.
    force : why to upload although something speaks against it; recorded with the upload.
    resume : a session to go on with instead of a new one.
    pauses : what waits between two tries to open a lost line; real time by default, for the
        emulated clock is gone with the line.

    Raises
    ------
    ConfigurationError
        The unit is not an emulator: this program cannot see a real sunspot. Or its time is near the
        end of those that the Sun models hold for.
    LinkError, ProcedureRefused, SessionFileError
        As the steps raise them; the session file keeps everything up to there.
    """
    station, emulation = emulated_station(
        tracker,
        "is not an emulator: the automatic technician cannot see its sunspot; calibrate a real "
        "unit with `solarcal run`",
        profile,
        operator="automatic technician",
        pointing_device="emulated sunspot device",
        say=say,
    )
    now_s = station.clock.utc_s()
    require_supported_times(now_s + np.array([-AROUND_S, AROUND_S]))
    journal = station.open_session(create_journal) if resume is None else _taken_up(station, resume)
    path = journal.path or Path()
    try:
        truth_before = emulation.truth()
        for sentence in disagreements(station):
            say(sentence)
        if warning := branch_warning(station.session.header, station.clock.utc_s()):
            say(warning)
        technician = AutomaticTechnician(
            station,
            emulation.spot,
            schedule,
            method=method,
            eye_sigma_deg=eye_sigma_deg,
            force=force,
            say=say,
            reopen=lambda error: _reopen(station, error, pauses or SystemClock()),
        )
        upload = technician.calibrate()
        truth_after = emulation.truth()
    except LinkError as error:
        station.link_lost(error)
        raise
    else:
        session = station.session
        solution = solve(session, method)
        assert solution is not None  # nothing could have been offered without one
        if upload is not None:
            station.close("calibration finished")
        return Calibration(
            session=station.session,
            path=path,
            solution=solution,
            upload=upload,
            refused=technician.refused,
            truth_before=truth_before,
            truth_after=truth_after,
            checks=schedule.checks,
        )
    finally:
        # Also where it was interrupted: the session can be gone on with.
        if station.state.attempt is not None:
            station.abort_attempt("interrupted")
        station.leave()


def emulated_station(
    tracker: Tracker,
    refused: str,
    profile: Profile | None = None,
    *,
    operator: str,
    pointing_device: str,
    target: str = "sun",
    say: Callable[[str], None],
) -> tuple[Station, Emulation]:
    """A connected station in the world of an emulated unit.

    ConfigurationError of another one; ``refused`` says what is amiss then. ``operator`` and
    ``pointing_device`` are those where the profile names none.
    """
    profile = profile or Profile()
    identity = tracker.open()
    emulation = tracker.emulation
    if emulation is None:
        tracker.close()
        raise ConfigurationError(f"{identity.model} {identity.serial} {refused}")
    sky = emulation.sky()
    settings = profile_settings(profile, SYNCHRONISED_S)
    settings |= {"site": None, "weather": sky.weather, "true_sun": sky.sun, "target": target}
    settings["operator"] = profile.operator or operator
    settings["pointing_device"] = profile.pointing_device or pointing_device
    station = Station(tracker, EmulatedClock(emulation), **settings)
    station.connect()
    for sentence in other_site(station, profile.site):
        say(sentence)
    return station, emulation


def _taken_up(station: Station, path: Path) -> Journal:
    """Go on with a session; ProcedureRefused where it is finished, or another unit answers."""
    journal = Journal.resume(path)
    last = journal.records[-1] if journal.records else None
    if isinstance(last, Closed):
        journal.close()
        raise ProcedureRefused(f"{path} is finished ({last.reason}); begin a new session")
    station.resume_session(journal)
    return journal


def _reopen(station: Station, lost: LinkError, clock: Clock) -> None:
    """Connect again with growing pauses; gives up after ``GIVE_UP_S``."""
    begun_s, waited_s, pause_s = clock.utc_s(), 0.0, FIRST_PAUSE_S
    # Each try takes some seconds of its own where nothing answers.
    while max(waited_s, clock.utc_s() - begun_s) < GIVE_UP_S:
        clock.wait(pause_s)
        waited_s += pause_s
        pause_s = min(2.0 * pause_s, LONGEST_PAUSE_S)
        try:
            station.reconnect()
        except LinkError as error:
            lost = error
        else:
            return
    raise LinkError(f"{lost}; given up after {GIVE_UP_S:.0f} s, the session can be continued")
