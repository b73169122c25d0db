"""Ways to spoil a good file: bytes, numbers, words and lines, from one seed."""

import random
import re

NUMBERS = (
    "0", "-0.0", "1", "-1", "1e308", "-1e308", "1e999", "-1e999", "1e-320", "nan", "inf", "-inf",
    "NaN", "Infinity", "90", "90.0000001", "-90", "180", "360", "1_000", "0x10", "1,5", "١٢",
    "9" * 25, "9" * 5000, "1e", ".", "-", "1.5e3", "2026-06-21", "9223372036854775808",
)  # fmt: skip
WORDS = (
    "", " ", "null", "true", "[]", "{}", "[[]]", '""', "'", '"', "=", ",", ";", ":", "#", "[", "]",
    "{", "}", "\\", "/", "..", "../../x", "\x00", "\x1b[31m", "\x07", "\x7f", "\u2028", "\u202e",
    "\ufeff", "é", "𝄞", "\r", "\n", "\r\n", "\t", "header", "point", "torn", "void", "type", "seq",
    "utc", "truth", "unit", "site", "rotary", "screwjack", "azel", "polar", "extends",
    "[" * 3000, "0001-01-01T00:00:00Z", "9999-12-31T23:59:59.999999Z", "2026-06-21T15:30:00+23:59",
    "2026-W25-7", "24:00", "2026-02-30T00:00:00Z",
)  # fmt: skip
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
_WORD = re.compile(rb"[A-Za-z_][A-Za-z_0-9-]*")


def damaged(good: bytes, chance: random.Random) -> bytes:
    """The bytes with one to four things done to them."""
    for _ in range(chance.choice((1, 1, 1, 2, 4))):
        good = chance.choice(_WAYS)(good, chance)
    return good


def _span(good: bytes, chance: random.Random, most: int) -> tuple[int, int]:
    start = chance.randrange(len(good) + 1)
    return start, min(len(good), start + chance.randrange(1, most))


def _drop(good: bytes, chance: random.Random) -> bytes:
    start, end = _span(good, chance, 40)
    return good[:start] + good[end:]


def _double(good: bytes, chance: random.Random) -> bytes:
    start, end = _span(good, chance, 200)
    return good[:end] + good[start:]


def _byte(good: bytes, chance: random.Random) -> bytes:
    start, _ = _span(good, chance, 2)
    return good[:start] + bytes((chance.randrange(256),)) + good[start + 1 :]


def _cut(good: bytes, chance: random.Random) -> bytes:
    return good[: chance.randrange(len(good) + 1)]


def _insert(good: bytes, chance: random.Random) -> bytes:
    at = chance.randrange(len(good) + 1)
    return good[:at] + chance.choice(WORDS + NUMBERS).encode() + good[at:]


def _replace(pattern: re.Pattern[bytes], good: bytes, new: bytes, chance: random.Random) -> bytes:
    found = list(pattern.finditer(good))
    if not found:
        return good
    one = chance.choice(found)
    return good[: one.start()] + new + good[one.end() :]


def _number(good: bytes, chance: random.Random) -> bytes:
    return _replace(_NUMBER, good, chance.choice(NUMBERS).encode(), chance)


def _word(good: bytes, chance: random.Random) -> bytes:
    if chance.random() < 0.5:
        # Another word of the same file: names and values at each other's places.
        words = _WORD.findall(good) or [b""]
        return _replace(_WORD, good, chance.choice(words), chance)
    return _replace(_WORD, good, chance.choice(WORDS + NUMBERS).encode(), chance)


def _lines(good: bytes, chance: random.Random) -> bytes:
    lines = good.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    match chance.randrange(4):
        case 0:
            lines[one], lines[other] = lines[other], lines[one]
        case 1:
            lines.insert(other, lines[one])
        case 2:
            del lines[one]
        case _:
            lines[one] += lines[other]
    return b"\n".join(lines)


_WAYS = (_drop, _double, _byte, _cut, _insert, _number, _number, _word, _word, _lines)
