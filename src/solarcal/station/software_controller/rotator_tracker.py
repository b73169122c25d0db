"""A ``Tracker`` made of a rotator and the station: what a SolarTrak is in one box.

The rotator turns and tells where it stands. Sun, clock, P, O, modes and limits are the station's,
so they exist only while the station does: when the program is left, a jog ends, and the axes stand
where they were last sent. After a lost line nothing moves before the next command.
"""

import threading
from collections.abc import Callable

import msgspec

from solarcal.errors import ConfigurationError, LinkError, SolarcalError
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.profiles import MountDescription
from solarcal.site import Site
from solarcal.station.described_unit import centre_deg
from solarcal.station.software_controller.coefficient_store import CoefficientStore, UnitLock
from solarcal.station.software_controller.controller_model import AzElAxes, SoftwareControllerModel
from solarcal.station.software_controller.motion import Pace, ThreadPace
from solarcal.station.software_controller.rotator_control import Look, RotatorControl
from solarcal.timescale import Clock
from solarcal.unit.rotator import Rotator, RotatorIdentity
from solarcal.unit.tracker import (
    ROTATOR,
    Capabilities,
    Emulation,
    Mode,
    RefCheckResult,
    Status,
    Stored,
    UnitIdentity,
    UnitParameters,
    UnitSite,
)


class RotatorTracker:
    """A rotator as a ``Tracker``.

    Parameters
    ----------
    rotator, serial : the rotator, and what stands for its serial number (its address, or the name
        it was given).
    description, site : how it is mounted, and where.
    clock : the laptop's.
    store_of : where P and O of a model and serial are kept.
    emulation : the world around an emulated rotator; ``None`` for a real one.
    pace : what keeps it going between commands; a thread by default.

    Methods may be called from several threads: they take turns, but for ``stop`` and ``stow``.
    """

    def __init__(
        self,
        rotator: Rotator,
        serial: str,
        description: MountDescription,
        site: Site,
        clock: Clock,
        store_of: Callable[[str, str], CoefficientStore],
        *,
        emulation: Emulation | None = None,
        pace: Pace | None = None,
    ) -> None:
        self._rotator = rotator
        self._serial = serial
        self._description = description
        self._site = site
        self._clock = clock
        self._store_of = store_of
        self._emulation = emulation
        self._pace = pace if pace is not None else ThreadPace()
        self._turn = threading.RLock()
        self._control: RotatorControl | None = None
        self._model: SoftwareControllerModel | None = None
        self._lock: UnitLock | None = None
        self._unit_model = ""
        self._for_now: Coefficients | None = None
        self._interrupted = False
        self._trouble: LinkError | None = None

    @property
    def emulation(self) -> Emulation | None:
        return self._emulation

    @property
    def display(self) -> None:
        return None

    @property
    def capabilities(self) -> Capabilities:
        return msgspec.structs.replace(ROTATOR, emulated=self._emulation is not None)

    # -- the line ------------------------------------------------------------------------------

    def open(self) -> UnitIdentity:
        with self._turn:
            before, self._control = self._control, None
            self._trouble = None
            self._pace.end()
            if before is not None:
                self._interrupted = before.let_go() or self._interrupted
                self._model = before.model
            told = self._rotator.open()
            axes = AzElAxes(
                self._description.geometry,
                centre_deg(self._description, self._site),
                told.azimuth,
                told.elevation,
            )
            store = self._held(told)
            model = SoftwareControllerModel(
                self._description, self._site, self._clock, store, axes.limits
            )
            if self._model is not None:
                model.set_clock_as(self._model)
            if self._for_now is not None:
                model.use_for_now(self._for_now)
            if self._interrupted:
                # It was on its way when the line went, and went on without anybody watching.
                self._rotator.stop()
                self._interrupted = False
            self._control = RotatorControl(self._rotator, axes, model, told.read_out_deg)
            self._control.look()
            self._pace.begin(self)
            return UnitIdentity(
                model=told.model,
                serial=self._serial,
                firmware=told.version,
                extensions=frozenset("X") if self._emulation is not None else frozenset(),
            )

    def _held(self, told: RotatorIdentity) -> CoefficientStore:
        """Where its P and O are kept; one process at a time."""
        store = self._store_of(told.model, self._serial)
        if self._lock is None or told.model != self._unit_model:
            self._release()
            self._lock = store.lock()
            self._unit_model = told.model
        return store

    def _release(self) -> None:
        lock, self._lock = self._lock, None
        if lock is not None:
            lock.release()

    def close(self) -> None:
        """A jog or check under way is stopped: nothing would end it."""
        self._pace.end()
        with self._turn:
            control, self._control = self._control, None
            try:
                if control is not None and control.mode in (Mode.JOG, Mode.REF):
                    control.stop()
            except SolarcalError:
                # The line is gone; the next one that opens it is told to stop first.
                self._interrupted = True
            finally:
                self._rotator.close()
                self._release()

    def recent_traffic(self) -> tuple[str, ...]:
        return self._rotator.recent_traffic()

    # -- what it is asked ----------------------------------------------------------------------

    def site(self) -> UnitSite:
        return self._here.model.unit_site

    def parameters(self) -> UnitParameters:
        return self._here.model.parameters

    def status(self) -> Status:
        with self._turn:
            trouble, self._trouble = self._trouble, None
            if trouble is not None:
                raise trouble
            control = self._here
            # What is due comes first: a jog must not outlive its time while it is looked at.
            control.act()
            return self._status(control, control.watch())

    def stored(self) -> Stored:
        return self._here.model.stored()

    def ref_check_result(self) -> RefCheckResult:
        return self._here.check_result()

    # -- what it is told -----------------------------------------------------------------------

    def set_clock(self, utc_s: float) -> None:
        with self._turn:
            self._here.model.set_clock(utc_s)
            self._here.rethink()

    def set_mode(self, mode: Mode) -> None:
        if mode not in (Mode.TRACK, Mode.MANUAL):
            raise ConfigurationError(f"mode {mode} cannot be set; only TRACK and MANUAL can")
        with self._turn:
            if mode is Mode.TRACK:
                self._here.track()
            else:
                self._here.manual()

    def stop(self) -> None:
        try:
            self._here.stop()
        except LinkError:
            # What could not be said now is the first thing said on a new line.
            self._interrupted = True
            raise

    def stow(self) -> None:
        self._here.stow()

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        with self._turn:
            self._here.jog(target1_deg, target2_deg)

    def set_sun_offset(self) -> Status:
        with self._turn:
            control = self._here
            look = control.set_sun_offset()
            status = self._status(control, look)
            control.rethink()
            return status

    def start_ref_check(self) -> None:
        """To the reference position: the rotator has no switches, only marks to be looked at."""
        with self._turn:
            self._here.start_check()

    def write_coefficients(
        self, coefficients: Coefficients, offsets: Offsets, *, store: bool = True
    ) -> Stored:
        """There is one memory, and it survives."""
        del store
        with self._turn:
            stored = self._here.model.write(coefficients, offsets)
            self._here.rethink()
            return stored

    def use_for_now(self, coefficients: Coefficients) -> None:
        """Drive by these, with O = 0, as long as this tracker is used; what is kept for the unit
        stays as it is."""
        with self._turn:
            self._for_now = coefficients
            self._here.model.use_for_now(coefficients)
            self._here.rethink()

    # -- of its own accord ---------------------------------------------------------------------

    def act(self) -> None:
        """Do what is due. For the pace; a lost line is for the next command to notice."""
        with self._turn:
            if self._control is None:
                return
            try:
                self._control.act()
            except LinkError as error:
                self._interrupted = self._control.let_go() or self._interrupted
                # Whoever looks next must learn why it does not track any more.
                self._trouble = error
            except SolarcalError:
                # A STOP came between, or the rotator refuses a step: the status shows it.
                return

    def next_act_s(self) -> float:
        """Laptop seconds from now until something is due; infinite where nothing is."""
        control = self._control
        return control.next_s() - control.model.utc_s() if control is not None else float("inf")

    def in_force(self) -> tuple[Coefficients, Offsets]:
        """P and O the axes are driven by."""
        model = self._here.model
        return model.coefficients, model.offsets

    # -- inside --------------------------------------------------------------------------------

    @property
    def _here(self) -> RotatorControl:
        if self._control is None:
            raise LinkError("the line to the rotator is not open; connect first")
        return self._control

    def _status(self, control: RotatorControl, look: Look) -> Status:
        model, reading = control.model, look.reading_deg
        ideal = model.ideal_deg(look.utc_s)
        goals = control.goals_deg if control.mode in (Mode.JOG, Mode.REF) else None
        target = goals or (reading if control.mode is Mode.STOW else model.target_deg(look.utc_s))
        counts = control.counts(reading)
        first, second = control.watches
        return Status(
            mode=control.mode,
            unit_utc_s=look.utc_s,
            ideal1_deg=round(ideal[0], 6),
            ideal2_deg=round(ideal[1], 6),
            reading1_deg=round(reading[0], 6),
            reading2_deg=round(reading[1], 6),
            counts1=counts[0],
            counts2=counts[1],
            target1_deg=round(target[0], 6),
            target2_deg=round(target[1], 6),
            offsets=model.offsets,
            moving=(first.moving, second.moving),
            approach=(first.approach, second.approach),
            update_phase=control.steps.phase(look.utc_s) if control.at_rest else 0.0,
            referenced=True,
            unlocked_s=0.0,
        )
