"""An emulated tracker spoken to in protocol lines, with its innards at hand."""

from collections.abc import Callable

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.mount.formula import Coefficients, Offsets
from solarcal.unit import fields
from solarcal.unit.frames import Reply, Request, decode_reply, encode_request
from solarcal.unit.tracker import Mode, RefCheckResult, Spot, Status


class Rig:
    """One emulated tracker and the station's end of its line."""

    def __init__(self, emulator: Emulator) -> None:
        self.emulator = emulator
        self.seq = 0

    def reply(self, text: str, seq: int | None = None) -> Reply:
        """Ask with the next number, or with one of the test's own, which leaves the count alone."""
        if seq is None:
            self.seq = seq = self.seq + 1
        verb, *arguments = text.split()
        (line,) = self.emulator.handle_input(encode_request(Request(seq, verb, tuple(arguments))))
        return decode_reply(line)

    def ask(self, text: str) -> tuple[str, ...]:
        reply = self.reply(text)
        assert not reply.refused, f"{text}: NO {reply.code} {reply.text}"
        return reply.fields

    def refusal(self, text: str) -> int | None:
        return self.reply(text).code

    def status(self) -> Status:
        return fields.status(self.zone_west_h).read(self.ask("STATUS"))

    @property
    def zone_west_h(self) -> float:
        return self.emulator.controller.model.zone_west_h

    def spot(self) -> Spot:
        return fields.SPOT.read(self.ask("X SPOT"))

    def ref(self) -> RefCheckResult:
        return fields.REF_CHECK.read(self.ask("REF"))

    def advance(self, seconds: float) -> None:
        self.ask(f"X ADVANCE {seconds:.6f}")

    def unlocked(self, text: str) -> tuple[str, ...]:
        self.ask("UNLOCK")
        return self.ask(text)

    def reference(self) -> RefCheckResult:
        self.unlocked("REF START")
        for _ in range(2000):
            if self.status().mode is not Mode.REF:
                return self.ref()
            self.advance(1.0)
        raise AssertionError("the reference check never ends")

    def drive_to(self, target1_deg: float, target2_deg: float) -> None:
        """Jog, renewed like a careful technician's, until both axes stand."""
        for _ in range(2000):
            self.unlocked(f"JOG {target1_deg:.5f} {target2_deg:.5f}")
            if self.status().mode is Mode.MANUAL:
                return
            self.advance(0.25)
        raise AssertionError("the jog never ends")

    def load(self, coefficients: Coefficients, offsets: Offsets | None = None) -> None:
        texts = fields.COEFFICIENTS.write((coefficients, offsets or Offsets()))
        self.unlocked("COEF SET " + " ".join(texts))

    def true_coefficients(self) -> Coefficients:
        m = self.emulator.world.mechanism
        return Coefficients(m.P1, m.P2, m.P3, m.P4, m.P5, m.P6)


@pytest.fixture
def rig() -> Callable[..., Rig]:
    """``rig("tijeras-azel", "truth.lean_deg=0.1", seed=3)``: a tracker at its start."""

    def make(
        name: str = "tijeras-azel", *settings: str, referenced: bool = False, **options: float
    ) -> Rig:
        made = Rig(Emulator(load_scenario(name, list(settings)), **options))
        if referenced:
            made.reference()
        return made

    return make
