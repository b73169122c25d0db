"""A frame survives the line unchanged, or is thrown away. Nothing in between."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scripted_link import sealed

from solarcal.errors import ProtocolError
from solarcal.unit.frames import (
    MAX_FRAME_CHARS,
    Code,
    LineBuffer,
    Reply,
    Request,
    decode_reply,
    decode_request,
    encode_reply,
    encode_request,
)

every = settings(derandomize=True, deadline=None, max_examples=150)

token = st.text(
    st.characters(min_codepoint=33, max_codepoint=126, exclude_characters="*<>"),
    min_size=1,
    max_size=20,
)
tokens = st.lists(token, max_size=8).map(tuple)
seq = st.integers(0, 0xFFFF)
requests = st.builds(Request, seq, token, tokens)
results = st.builds(Reply, seq, tokens)
refusals = st.builds(
    lambda seq, code, words: Reply(seq, (), code, " ".join(words)),
    st.none() | seq,
    st.integers(1, 99),
    st.lists(token, min_size=1, max_size=6),
)


PROTOCOL_PAGE = Path(__file__).parents[2] / "docs" / "protocol.md"


def test_the_checksum_is_the_one_the_protocol_page_shows():
    shown = re.findall(r"^    ([<>][0-9A-F]{4} .*)$", PROTOCOL_PAGE.read_text(), re.MULTILINE)
    assert len(shown) == 8
    for line in shown:
        if line.startswith(">"):
            assert encode_request(decode_request(line.encode())) == line.encode() + b"\r\n"
        else:
            assert encode_reply(decode_reply(line.encode())) == line.encode() + b"\r\n"


def test_the_checksum_is_crc32_with_its_published_check_value():
    assert sealed("123456789") == b"123456789*CBF43926"
    assert encode_request(Request(1, "STATUS")) == sealed(">0001 STATUS") + b"\r\n"


@every
@given(requests)
def test_requests_round_trip(request):
    assert decode_request(encode_request(request)) == request


@every
@given(results | refusals)
def test_replies_round_trip(reply):
    assert decode_reply(encode_reply(reply)) == reply


@every
@given(st.data(), requests | results | refusals)
def test_any_single_damaged_byte_is_noticed(data, message):
    is_request = isinstance(message, Request)
    line = (encode_request if is_request else encode_reply)(message).removesuffix(b"\r\n")
    place = data.draw(st.integers(0, len(line) - 1))
    damaged = bytearray(line)
    damaged[place] ^= data.draw(st.integers(1, 255))
    with pytest.raises(ProtocolError):
        (decode_request if is_request else decode_reply)(bytes(damaged))


@every
@given(st.data(), requests)
def test_a_cut_frame_is_noticed(data, request):
    line = encode_request(request).removesuffix(b"\r\n")
    with pytest.raises(ProtocolError):
        decode_request(line[: data.draw(st.integers(0, len(line) - 1))])


@every
@given(st.binary(max_size=400))
def test_noise_is_no_frame(noise):
    for decode in (decode_request, decode_reply):
        with pytest.raises(ProtocolError):
            decode(noise)


@pytest.mark.parametrize(
    "body",
    [
        ">1 STATUS",
        ">000a STATUS",
        ">0001  STATUS",
        ">0001 STATUS ",
        ">0001",
        "<0001 STATUS",
        ">0001 ST*TUS",
        ">0001 STAT\tUS",
        ">0001 STATÜS",
    ],
)
def test_a_right_checksum_does_not_make_a_request(body):
    with pytest.raises(ProtocolError):
        decode_request(sealed(body))


@pytest.mark.parametrize(
    "body",
    ["<0001", "<0001 OK  1", "<---- OK", "<0001 NO", "<0001 NO 20", "<0001 NO x y", "<0001 YES"],
)
def test_a_right_checksum_does_not_make_a_reply(body):
    with pytest.raises(ProtocolError):
        decode_reply(sealed(body))


def test_the_checksum_is_written_in_capitals():
    line = encode_request(Request(0xABCD, "ID"))
    with pytest.raises(ProtocolError):
        decode_request(line.lower().replace(b"id", b"ID").replace(b"abcd", b"ABCD"))


def test_what_is_no_frame_is_never_sent():
    for request in (
        Request(1, "JOG", ("1 2",)),
        Request(1, "JOG", ("",)),
        Request(1, "PARAM", ("a*b",)),
        Request(1, "PARAM", ("ä",)),
        Request(1, "PARAM", ("x" * MAX_FRAME_CHARS,)),
    ):
        with pytest.raises(ProtocolError):
            encode_request(request)
    with pytest.raises(ProtocolError):
        encode_reply(Reply(1, ("two words",)))
    with pytest.raises(ProtocolError):
        encode_reply(Reply(1, (), 20, "with * star"))


def test_the_longest_frame_passes_and_one_more_character_does_not():
    assert f"than {MAX_FRAME_CHARS} characters before its line end" in PROTOCOL_PAGE.read_text()
    room = MAX_FRAME_CHARS - len(">0001 PARAM *01234567")
    longest = encode_request(Request(1, "PARAM", ("x" * room,)))
    assert len(longest) == MAX_FRAME_CHARS + 2
    assert LineBuffer().feed(longest) == [longest[:-2]]
    with pytest.raises(ProtocolError):
        encode_request(Request(1, "PARAM", ("x" * (room + 1),)))
    with pytest.raises(ProtocolError, match="longer"):
        decode_request(sealed(">0001 PARAM " + "x" * (room + 1)))


lines = st.lists(
    st.binary(min_size=1, max_size=60).filter(lambda b: b"\n" not in b and b"\r" not in b),
    max_size=10,
)


@every
@given(lines, st.lists(st.integers(1, 30), min_size=1), st.sampled_from([b"\n", b"\r\n"]))
def test_lines_come_out_whole_however_the_bytes_come_in(lines, sizes, end):
    stream = b"".join(line + end for line in lines)
    buffer = LineBuffer()
    out = []
    turn = 0
    while stream:
        size = sizes[turn % len(sizes)]
        out += buffer.feed(stream[:size])
        stream = stream[size:]
        turn += 1
    assert out == lines
    assert len(buffer) == 0


def test_empty_lines_are_ignored():
    assert LineBuffer().feed(b"\r\n\n\r\nA\n\n") == [b"A"]


def test_endless_babble_is_kept_in_bounded_memory_and_reported_once():
    buffer = LineBuffer()
    reported = []
    for _ in range(1000):
        reported += buffer.feed(b"x" * 1000)
        assert len(buffer) <= MAX_FRAME_CHARS + 2
    assert len(reported) == 1
    with pytest.raises(ProtocolError):
        decode_reply(reported[0])
    assert buffer.feed(b"yyy\r\n<good>\r\n") == [b"<good>"]


@every
@given(st.integers(245, 260), st.lists(st.integers(1, 9), min_size=1))
def test_an_overlong_line_never_passes_for_a_frame(length, sizes):
    stream = b"z" * length + b"\r\nnext\r\n"
    buffer = LineBuffer()
    out = []
    turn = 0
    while stream:
        size = sizes[turn % len(sizes)]
        out += buffer.feed(stream[:size])
        stream = stream[size:]
        turn += 1
    first, last = out
    assert last == b"next"
    assert (len(first) <= MAX_FRAME_CHARS) == (length <= MAX_FRAME_CHARS)


def test_refusals_have_the_numbers_of_the_protocol_page():
    page = PROTOCOL_PAGE.read_text(encoding="utf-8")
    texts = {
        "DAMAGED": "damaged frame",
        "UNKNOWN": "unknown request",
        "SEQUENCE_REUSED": "sequence number used for another request",
        "BAD_ARGUMENT": "bad argument",
        "LOCKED": "locked",
        "BEYOND_LIMIT": "beyond limit",
        "BUSY": "busy",
        "MOVING": "axis moving",
        "NOT_REFERENCED": "not referenced",
        "SUN_DOWN": "Sun below horizon",
        "STOPPED": "stopped",
        "NOT_ANNOUNCED": "not announced",
    }
    assert {code.name for code in Code} == set(texts)
    for name, text in texts.items():
        assert f"| {Code[name]:d} | {text}" in page
