"""Why a unit says NO: the numbers of ``docs/protocol.md``."""

from enum import IntEnum


class Code(IntEnum):
    """Refusal numbers of the wire protocol."""

    DAMAGED = 10
    UNKNOWN = 11
    SEQUENCE_REUSED = 12
    BAD_ARGUMENT = 13
    LOCKED = 20
    BEYOND_LIMIT = 21
    BUSY = 22
    MOVING = 23
    NOT_REFERENCED = 24
    SUN_DOWN = 25
    STOPPED = 26
    NOT_ANNOUNCED = 30


class Refusal(Exception):
    """Raised within an emulated unit: a request it does not carry out; nothing has changed."""

    def __init__(self, code: Code, text: str) -> None:
        super().__init__(text)
        self.code = code
        self.text = text
