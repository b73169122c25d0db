"""The unit's end of the wire: a line in, its replies out. ``docs/protocol.md`` made executable."""

from collections import OrderedDict
from collections.abc import Callable

import numpy as np

from solarcal.emulator.controller import Controller
from solarcal.emulator.emulator_requests import EmulatorRequests, Surroundings, without_arguments
from solarcal.errors import ConfigurationError, ProtocolError
from solarcal.unit import fields, values
from solarcal.unit.fields import PARAMETER_NAMES, parameters_from_texts, parameters_to_texts
from solarcal.unit.frames import Code, Refusal, Reply, Request, decode_request, encode_reply
from solarcal.unit.tracker import UnitIdentity
from solarcal.unit.verbs import expect, read, verb, write

REPLIES_REMEMBERED = 16
URGENT = ("STOP", "STOW")


class Faults:
    """How replies leave a faulty unit. ``kind``: ``""``, ``mute`` or ``garbage``."""

    def __init__(self, stream: np.random.Generator) -> None:
        self._stream = stream
        self.kind = ""

    def sent(self, reply: bytes) -> list[bytes]:
        """What really goes out in place of a reply."""
        if self.kind == "mute":
            return []
        if self.kind == "garbage":
            # Anything but a line end, which is added: noise as a wrong baud rate makes it.
            noise = self._stream.integers(0x80, 0x100, size=len(reply) - 2, dtype=np.uint8)
            return [noise.tobytes() + b"\r\n"]
        return [reply]


class ProtocolServer:
    """Decodes requests, has them carried out, remembers and encodes the replies."""

    def __init__(
        self,
        controller: Controller,
        surroundings: Surroundings,
        identity: UnitIdentity,
        faults: Faults,
    ) -> None:
        self._controller = controller
        self._surroundings = surroundings
        self._faults = faults
        self._memory: OrderedDict[int, tuple[str, bytes]] = OrderedDict()
        self._verbs: dict[str, Callable[[list[str]], list[str]]] = {
            "OPEN": self._open,
            "ID": without_arguments(lambda: fields.IDENTITY.write(identity)),
            "CLOCK": self._clock,
            "SITE": self._site,
            "STATUS": without_arguments(self._status),
            "PARAM": self._param,
            "UNLOCK": without_arguments(self._unlock),
            "LOCK": without_arguments(self._lock),
            "MODE": self._mode,
            "STOP": self._stop,
            "STOW": self._stow,
            "JOG": self._jog,
            "OFFSET": self._offset,
            "REF": self._ref,
            "COEF": self._coef,
            "STORE": without_arguments(self._store),
            "X": EmulatorRequests(surroundings).carry_out,
        }

    def answer(self, line: bytes, *, overtaken: bool = False) -> list[bytes]:
        """Replies to one line, each with its line end; none while the unit is mute.

        ``overtaken``: a STOP or STOW sent after this line has been executed already.
        """
        try:
            request = decode_request(line)
        except ProtocolError:
            damaged = Reply(None, code=Code.DAMAGED, text="damaged frame")
            return self._faults.sent(encode_reply(damaged))
        before = self._faults.kind
        reply = self._reply(request, overtaken)
        # The request that orders silence, or ends it, is itself still answered.
        return [reply] if before != self._faults.kind else self._faults.sent(reply)

    def forget(self) -> None:
        """Lose the memory of replies, as at power-up."""
        self._memory.clear()

    def _reply(self, request: Request, overtaken: bool) -> bytes:
        remembered = self._memory.get(request.seq)
        if remembered is not None:
            text, reply = remembered
            if text == request.text:
                return reply
            # A new conversation may begin with any number; OPEN is how it says so.
            if request.verb != "OPEN":
                return encode_reply(
                    Reply(
                        request.seq,
                        code=Code.SEQUENCE_REUSED,
                        text="sequence number used for another request",
                    )
                )
        reply = encode_reply(self._carry_out(request, overtaken))
        self._memory[request.seq] = (request.text, reply)
        self._memory.move_to_end(request.seq)
        while len(self._memory) > REPLIES_REMEMBERED:
            self._memory.popitem(last=False)
        return reply

    def _carry_out(self, request: Request, overtaken: bool) -> Reply:
        verb = self._verbs.get(request.verb)
        try:
            if verb is None:
                raise Refusal(Code.UNKNOWN, f"unknown request {request.verb[:20]}")
            if overtaken and _moves(request):
                raise Refusal(Code.STOPPED, "stopped: a STOP or STOW overtook this; MODE first")
            answer = verb(list(request.arguments))
        except Refusal as refusal:
            return Reply(request.seq, code=refusal.code, text=refusal.text)
        except (ProtocolError, ConfigurationError) as error:
            return Reply(request.seq, code=Code.BAD_ARGUMENT, text=_speakable(str(error)))
        self._surroundings.settle()
        return Reply(request.seq, fields=tuple(answer))

    @property
    def _now_s(self) -> float:
        return self._surroundings.now_s()

    def _unlocked(self) -> Controller:
        self._controller.use_unlock(self._now_s)
        return self._controller

    # --- conversation, identity, clock, site --------------------------------------------------

    def _open(self, arguments: list[str]) -> list[str]:
        (nonce,) = read(verb("OPEN").arguments, arguments)
        self._memory.clear()
        self._controller.cancel_jog(self._now_s)
        self._controller.lock()
        return [nonce]

    def _clock(self, arguments: list[str]) -> list[str]:
        if arguments:
            word, local_time = expect(arguments, "SET local_time")
            _require(word == "SET", word)
            controller = self._unlocked()
            utc_s = values.utc_from_local_time(local_time, controller.model.zone_west_h)
            controller.set_clock(utc_s, self._now_s)
        model = self._controller.model
        return fields.CLOCK.write((model.utc_s(self._now_s), model.zone_west_h))

    def _site(self, arguments: list[str]) -> list[str]:
        if arguments:
            _require(arguments[0] == "SET", arguments[0])
            controller = self._unlocked()
            site, zone_west_h = fields.SITE_SET.read(arguments[1:])
            controller.set_site(site, zone_west_h, self._now_s)
        return fields.SITE.write(self._controller.unit_site())

    # --- status, parameters, lock -------------------------------------------------------------

    def _status(self) -> list[str]:
        return fields.status(self._controller.model.zone_west_h).write(
            self._controller.status(self._now_s), self._decimals()
        )

    def _decimals(self) -> tuple[int, int]:
        parameters = self._controller.parameters()
        return parameters.tilt_decimals, parameters.scale_decimals

    def _param(self, arguments: list[str]) -> list[str]:
        if not 1 <= len(arguments) <= 2 or arguments[0] not in PARAMETER_NAMES:
            raise ProtocolError(f"parameters are {' '.join(PARAMETER_NAMES)}")
        name = arguments[0]
        if len(arguments) == 2:
            controller = self._unlocked()
            if name.endswith("_decimals"):
                raise ProtocolError(f"{name} is read only")
            texts = parameters_to_texts(controller.parameters()) | {name: arguments[1]}
            new = parameters_from_texts(texts)
            controller.set_parameters(new, self._now_s)
        return [parameters_to_texts(self._controller.parameters())[name]]

    def _unlock(self) -> list[str]:
        seconds = self._controller.unlock(self._now_s)
        return write(verb("UNLOCK").reply, [round(seconds)])

    def _lock(self) -> list[str]:
        self._controller.lock()
        return []

    # --- motion -------------------------------------------------------------------------------

    def _mode(self, arguments: list[str]) -> list[str]:
        (mode,) = expect(arguments, "mode")
        _require(mode in ("TRACK", "MANUAL"), mode)
        controller = self._unlocked()
        if mode == "TRACK":
            controller.set_track(self._now_s)
        else:
            controller.set_manual(self._now_s)
        # What was accepted; that the Sun may stand beyond a limit is for STATUS to say.
        return [mode]

    def _stop(self, arguments: list[str]) -> list[str]:
        # Whatever stands behind the word: a STOP is a STOP.
        self._controller.stop(self._now_s)
        return ["STOP"]

    def _stow(self, arguments: list[str]) -> list[str]:
        self._controller.stow(self._now_s)
        return ["STOW"]

    def _jog(self, arguments: list[str]) -> list[str]:
        target1_deg, target2_deg = fields.JOG.read(arguments)
        self._unlocked().jog(target1_deg, target2_deg, self._now_s)
        return fields.JOG.write((target1_deg, target2_deg))

    def _offset(self, arguments: list[str]) -> list[str]:
        (word,) = expect(arguments, "SET")
        _require(word == "SET", word)
        self._unlocked().set_sun_offset(self._now_s)
        return self._status()

    def _ref(self, arguments: list[str]) -> list[str]:
        if arguments:
            (word,) = expect(arguments, "START")
            _require(word == "START", word)
            number = self._unlocked().start_ref_check(self._now_s)
            return write(verb("REF START").reply, [number])
        return fields.REF_CHECK.write(self._controller.ref_check_result())

    # --- coefficients -------------------------------------------------------------------------

    def _coef(self, arguments: list[str]) -> list[str]:
        permanent = arguments == ["STORED"]
        if arguments and not permanent:
            _require(arguments[0] == "SET", arguments[0])
            controller = self._unlocked()
            coefficients, offsets = fields.COEFFICIENTS.read(arguments[1:])
            controller.set_coefficients(coefficients, offsets, self._now_s)
        stored = self._controller.stored()
        memory = stored.coefficients, stored.offsets
        if permanent:
            memory = stored.permanent_coefficients, stored.permanent_offsets
        return fields.COEFFICIENTS.write(memory, self._decimals())

    def _store(self) -> list[str]:
        self._unlocked().store()
        return ["1"]


def _require(right: bool, word: str) -> None:
    if not right:
        raise ProtocolError(f"{word[:20]} is not known here")


def _moves(request: Request) -> bool:
    starts_ref_check = request.verb == "REF" and request.arguments[:1] == ("START",)
    return request.verb in ("MODE", "JOG") or starts_ref_check


def is_urgent(line: bytes) -> bool:
    """Whether a line is a STOP or STOW, which no other request may hold up."""
    try:
        return decode_request(line).verb in URGENT
    except ProtocolError:
        return False


def _speakable(text: str) -> str:
    """A refusal's text without the characters no frame may hold, and short enough for one."""
    kept = "".join(c if c.isascii() and c.isprintable() and c not in "*<>" else "?" for c in text)
    return " ".join(("bad argument: " + kept).split())[:200]
