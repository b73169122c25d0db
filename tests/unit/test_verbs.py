"""Every request as it is described: its fields are written, read and refused by their names."""

import re
from pathlib import Path

import pytest

from solarcal.emulator.emulation import Emulator
from solarcal.emulator.scenario import load_scenario
from solarcal.errors import ProtocolError
from solarcal.unit.frames import Request, decode_reply, encode_request
from solarcal.unit.values import KINDS
from solarcal.unit.verbs import VERBS, read, verb, write
from tools.protocol_page import page

PAGE = Path(__file__).parents[2] / "docs" / "protocol.md"
SIDES = [
    (one.request, side, names)
    for one in VERBS
    for side, names in (("request", one.arguments), ("reply", one.reply))
    if names and all(name in KINDS for name in names.split())
]


@pytest.mark.parametrize(("request_", "side", "names"), SIDES)
def test_what_is_written_is_read_again(request_, side, names):
    for choice in (0, -1):
        texts = [KINDS[name].examples[choice] for name in names.split()]
        assert write(names, read(names, texts)) == texts


@pytest.mark.parametrize(("request_", "side", "names"), SIDES)
def test_a_field_too_few_or_too_many_and_a_wrong_one_are_refused(request_, side, names):
    texts = [KINDS[name].examples[0] for name in names.split()]
    with pytest.raises(ProtocolError, match="belong"):
        read(names, texts[:-1])
    with pytest.raises(ProtocolError, match="belong"):
        read(names, [*texts, "1"])
    for place, name in enumerate(names.split()):
        for wrong in KINDS[name].wrong:
            with pytest.raises(ProtocolError, match=f"field {re.escape(name)}:"):
                read(names, [*texts[:place], wrong, *texts[place + 1 :]])


def test_the_page_has_its_tables_from_the_descriptions():
    text = PAGE.read_text(encoding="utf-8")
    assert page(text) == text, "python -m tools.protocol_page writes them anew"


@pytest.mark.parametrize("one", VERBS, ids=lambda one: one.request)
def test_the_emulated_unit_knows_every_request_and_asks_for_the_unlock_where_it_says(one):
    emulator = Emulator(load_scenario("tijeras-azel", []))
    words = []
    for word in one.request.split():
        words.append(KINDS[word].examples[0] if word in KINDS else word)
    if one.request.startswith("PARAM"):
        words[1:] = ["update_range", "0.2"][: len(words) - 1]
    if one.request == "X FAULT name":
        words[-1] = "none"
    (line,) = emulator.handle_input(encode_request(Request(1, words[0], tuple(words[1:]))))
    reply = decode_reply(line)
    assert reply.code == (20 if one.unlock else None), reply
    if not one.unlock and all(name in KINDS for name in one.reply.split()):
        assert read(one.reply, reply.fields) is not None


def test_a_request_is_found_by_its_words():
    assert verb("COEF SET").arguments == "P1 P2 P3 P4 P5 P6 O1 O2"
    assert verb("JOG").unlock
    assert not verb("STOP").unlock
