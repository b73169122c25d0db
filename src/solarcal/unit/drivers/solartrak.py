"""The driver for units that speak the wire protocol of ``docs/protocol.md``."""

import math
import secrets
import threading
from collections.abc import Callable
from typing import TypeVar

from solarcal.errors import ConfigurationError, LinkError, ProtocolError, UnitRefused
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.unit import fields, values
from solarcal.unit.conversation import Conversation, Timing
from solarcal.unit.fields import ABSENT, PARAMETER_NAMES, parameters_from_texts
from solarcal.unit.frames import Code
from solarcal.unit.link import Link
from solarcal.unit.tracker import (
    Capabilities,
    EmulatedSky,
    Emulation,
    Mode,
    RefCheckResult,
    Spot,
    Status,
    Stored,
    Truth,
    UnitIdentity,
    UnitParameters,
    UnitSite,
)
from solarcal.unit.verbs import expect, read, verb

PROTOCOL_VERSION = 1

EMULATOR = "X"
"""The extension an emulated unit announces."""

T = TypeVar("T")
A = TypeVar("A")

LONGEST_ADVANCE_S = 86400.0
"""What one ``X ADVANCE`` may ask for."""


class SolarTrakUnit:
    """A ``Tracker`` over a link.

    Parameters
    ----------
    link_factory : opens the line; called by every ``open``, so that a lost link can be opened
        again.
    port : what messages call the line.

    Methods may be called from several threads. They take turns, but for ``stop`` and ``stow``,
    which go out at once.
    """

    def __init__(
        self,
        link_factory: Callable[[], Link],
        *,
        port: str = "the unit",
        timing: Timing | None = None,
    ) -> None:
        self._link_factory = link_factory
        self._port = port
        self._timing = timing if timing is not None else Timing()
        self._conversation: Conversation | None = None
        self._last_seq = 0
        self._identity: UnitIdentity | None = None
        self._zone_west_h: float | None = None
        self._decimals: tuple[int, int] | None = None
        self.standing: tuple[float, float] | None = None
        """True and laptop's time of an emulator at speed 0, which only ``advance`` moves."""

    @property
    def emulation(self) -> Emulation | None:
        """The emulator's own requests; None where the unit does not announce them."""
        return _SolarTrakEmulation(self) if self.capabilities.emulated else None

    @property
    def display(self) -> None:
        return None

    @property
    def capabilities(self) -> Capabilities:
        return Capabilities(
            emulated=self._identity is not None and EMULATOR in self._identity.extensions
        )

    def open(self) -> UnitIdentity:
        self.close()
        link = self._link_factory()
        # Numbers go on where they stopped: a late reply from before cannot be taken for a new one.
        talk = Conversation(link, self._port, self._timing, self._last_seq)
        self._conversation = talk
        talk.open(secrets.token_hex(4).upper())
        identity = self._read("ID", fields.IDENTITY.read, talk.ask("ID"))
        if identity.protocol != PROTOCOL_VERSION:
            raise ProtocolError(
                f"{self._port}: the unit speaks version {identity.protocol} of the protocol, this "
                f"program version {PROTOCOL_VERSION}; update the older of the two"
            )
        self._identity = identity
        return identity

    def close(self) -> None:
        talk, self._conversation = self._conversation, None
        if talk is not None:
            self._last_seq = talk.last_seq
            talk.close()
        # Another unit may be on the line next time.
        self._identity = self._zone_west_h = self._decimals = self.standing = None

    def site(self) -> UnitSite:
        answer = self._read("SITE", fields.SITE.read, self._talk.ask("SITE"))
        self._zone_west_h = answer.zone_west_h
        return answer

    def parameters(self) -> UnitParameters:
        talk = self._talk
        with talk.turn:
            texts = {name: self._parameter(name) for name in PARAMETER_NAMES}
        parameters = self._read("PARAM", parameters_from_texts, texts)
        self._decimals = (parameters.tilt_decimals, parameters.scale_decimals)
        return parameters

    def status(self) -> Status:
        return self._status("STATUS", self._talk.ask("STATUS"))

    def set_clock(self, utc_s: float) -> None:
        local_time = values.local_time_text(utc_s, self._zone())
        answer = self._talk.command("CLOCK", "SET", local_time)
        _, zone_west_h = self._read("CLOCK SET", fields.CLOCK.read, answer)
        if zone_west_h != self._zone():
            raise ProtocolError(
                f"{self._port}: the unit's zone has become {zone_west_h:g} h west since it was "
                "read, so its clock is set wrong; connect again"
            )

    def set_mode(self, mode: Mode) -> None:
        if mode not in (Mode.TRACK, Mode.MANUAL):
            raise ConfigurationError(f"mode {mode} cannot be set; only TRACK and MANUAL can")
        self._echoed((mode.value,), self._talk.command("MODE", mode.value, moves=True), "MODE")

    def stop(self) -> None:
        self._echoed(("STOP",), self._talk.interrupt("STOP"), "STOP")

    def stow(self) -> None:
        self._echoed(("STOW",), self._talk.interrupt("STOW"), "STOW")

    def jog(self, target1_deg: float, target2_deg: float) -> None:
        targets = fields.JOG.write((target1_deg, target2_deg))
        answer = self._talk.command("JOG", *targets, moves=True)
        taken = self._read("JOG", fields.JOG.read, answer)
        if taken != fields.JOG.read(targets):
            raise ProtocolError(f"{self._port}: asked to jog to {targets}, it answered {answer}")

    def set_sun_offset(self) -> Status:
        return self._status("OFFSET SET", self._talk.command("OFFSET", "SET"))

    def start_ref_check(self) -> None:
        self._read(
            "REF START",
            lambda answer: read(verb("REF START").reply, answer),
            self._talk.command("REF", "START", moves=True),
        )

    def ref_check_result(self) -> RefCheckResult:
        return self._read("REF", fields.REF_CHECK.read, self._talk.ask("REF"))

    def stored(self) -> Stored:
        with self._talk.turn:
            coefficients, offsets = self._coefficients("COEF")
            permanent, permanent_offsets = self._coefficients("COEF", "STORED")
        return Stored(coefficients, offsets, permanent, permanent_offsets)

    def write_coefficients(
        self, coefficients: Coefficients, offsets: Offsets, *, store: bool = True
    ) -> Stored:
        """Write P and O, store them permanently, and return what both memories then hold.

        The numbers go out with the decimals the unit keeps. A unit that reads back something else
        does NOT get the STORE command: its permanent memory stays as it was, and the caller sees
        the difference in what is returned.
        """
        talk = self._talk
        with talk.turn:
            decimals = self._kept_decimals()
            wanted = fields.COEFFICIENTS.write((coefficients, offsets), decimals)
            talk.command("COEF", "SET", *wanted)
            in_force = self._coefficients("COEF")
            if store and fields.COEFFICIENTS.write(in_force, decimals) == wanted:
                self._echoed(("1",), talk.command("STORE"), "STORE")
            return Stored(*in_force, *self._coefficients("COEF", "STORED"))

    def ask_emulator(self, verb: str, reader: Callable[[tuple[str, ...]], T], *arguments: str) -> T:
        """Ask ``X verb``; never sent to a unit that does not announce X."""
        request = f"X {verb}"
        talk = self._talk
        if not self.capabilities.emulated:
            raise UnitRefused(Code.NOT_ANNOUNCED, "this unit is no emulator", request)
        answer_s = self._timing.advance_s if verb == "ADVANCE" else None
        return self._read(request, reader, talk.ask("X", verb, *arguments, answer_s=answer_s))

    def recent_traffic(self) -> tuple[str, ...]:
        """The last frames of this connection; none while it is closed."""
        talk = self._conversation
        return tuple(talk.recent.copy()) if talk is not None else ()

    @property
    def turn(self) -> threading.RLock:
        """Held while requests that belong together are made."""
        return self._talk.turn

    @property
    def _talk(self) -> Conversation:
        if self._conversation is None:
            raise LinkError(f"the line to {self._port} is not open; connect first")
        return self._conversation

    def _zone(self) -> float:
        """The unit's zone, which turns its local time into UTC; asked once per connection."""
        if self._zone_west_h is None:
            return self.site().zone_west_h
        return self._zone_west_h

    def _kept_decimals(self) -> tuple[int, int]:
        """How many decimals the unit keeps of tilts and of scales; asked once per connection."""
        if self._decimals is None:
            self.parameters()
        assert self._decimals is not None
        return self._decimals

    def _parameter(self, name: str) -> str:
        try:
            answer = self._talk.ask("PARAM", name)
        except UnitRefused as refusal:
            # Units older than these parameters do not know their names.
            if name not in ABSENT or refusal.code != Code.BAD_ARGUMENT:
                raise
            return ABSENT[name]
        (text,) = self._read(f"PARAM {name}", lambda answer: expect(answer, "value"), answer)
        return text

    def _coefficients(self, *request: str) -> tuple[Coefficients, Offsets]:
        return self._read(" ".join(request), fields.COEFFICIENTS.read, self._talk.ask(*request))

    def _status(self, request: str, answer: tuple[str, ...]) -> Status:
        return self._read(request, fields.status(self._zone()).read, answer)

    def _echoed(self, wanted: tuple[str, ...], answer: tuple[str, ...], request: str) -> None:
        if answer != wanted:
            raise ProtocolError(
                f"{self._port}, reply to {request}: {' '.join(answer)!r} where "
                f"{' '.join(wanted)!r} belongs"
            )

    def _read(self, request: str, reader: Callable[[A], T], answer: A) -> T:
        """A reply's meaning; an error in it names the port and the request as well."""
        try:
            return reader(answer)
        except ProtocolError as error:
            raise ProtocolError(f"{self._port}, reply to {request}: {error}") from None


class _SolarTrakEmulation:
    """The ``X`` requests. Refused here when the unit on the line does not announce them."""

    def __init__(self, unit: SolarTrakUnit) -> None:
        self._unit = unit
        self._ask = unit.ask_emulator

    def time(self) -> tuple[float, float]:
        return self._times()[0]

    def speed(self) -> float:
        return self._times()[1]

    def set_speed(self, speed: float) -> float:
        if not 0.0 <= speed < math.inf:
            raise ConfigurationError(f"virtual time cannot run {speed} times as fast")
        with self._unit.turn:
            self._unit.standing = None
            return self._ask("SPEED", fields.SPEED.read, *fields.SPEED.write(speed))

    def advance(self, seconds: float) -> tuple[float, float]:
        if not 0.0 <= seconds < math.inf:
            raise ConfigurationError(f"virtual time cannot be advanced by {seconds} s")
        times = None
        while times is None or seconds > 0.0:
            step_s = min(seconds, LONGEST_ADVANCE_S)
            seconds -= step_s
            with self._unit.turn:
                stood, self._unit.standing = self._unit.standing, None
                times = self._ask("ADVANCE", fields.TIMES.read, *fields.ADVANCE.write(step_s))
                if stood is not None:
                    self._unit.standing = times
        return times

    def spot(self) -> Spot:
        return self._ask("SPOT", fields.SPOT.read)

    def sky(self) -> EmulatedSky:
        return self._ask("SKY", fields.SKY.read)

    def truth(self) -> Truth:
        return self._ask("TRUTH", fields.TRUTH.read)

    def fault(self, name: str) -> None:
        self._ask("FAULT", lambda answer: expect(answer, "name"), name)

    def _times(self) -> tuple[tuple[float, float], float]:
        """True and laptop's time, and the speed; asked for again only where they may be others."""
        with self._unit.turn:
            if self._unit.standing is not None:
                return self._unit.standing, 0.0
            times, speed = self._ask("TIME", fields.TIMES_AND_SPEED.read)
            if speed == 0.0:
                self._unit.standing = times
            return times, speed
