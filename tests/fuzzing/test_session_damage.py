"""A sample of the damage that `make fuzz` does to every bit and at every offset."""

import random

import pytest

from fuzzing.session_damage import SAVED, Unnoticed, try_cuts, try_flips
from solarcal.session.lines import sealed


@pytest.mark.parametrize("path", SAVED, ids=lambda path: path.stem)
def test_a_flipped_bit_is_refused_or_reported(path):
    content = path.read_bytes()
    rng = random.Random(path.name)
    # The ends of lines, and the whole last line, are where a flip could pass for a power cut.
    last = content.rindex(b"\n", 0, -1) + 1
    ends = [at for at, byte in enumerate(content) if byte == 0x0A]
    places = {*range(last, len(content)), *ends, *rng.sample(range(len(content)), 60)}
    bits = [8 * place + rng.randrange(8) for place in sorted(places)]
    refused, reported = try_flips(path, bits)
    assert refused + reported == len(bits)
    assert refused > 0.9 * len(bits)


@pytest.mark.parametrize("path", SAVED, ids=lambda path: path.stem)
def test_a_file_cut_off_is_refused_or_reported(path):
    content = path.read_bytes()
    ends = [at for at, byte in enumerate(content) if byte == 0x0A]
    cuts = random.Random(path.name).sample(range(len(content)), 60)
    refused, reported = try_cuts(path, sorted({0, *cuts, *ends, *(end + 1 for end in ends)}))
    assert refused > 0
    assert reported > 0


def test_the_measure_sees_another_answer(tmp_path):
    """Of a file without checksums a flip of a digit goes unnoticed."""
    lines = SAVED[0].read_bytes().replace(b'"format":2', b'"format":1').splitlines()
    path = tmp_path / "old.jsonl"
    path.write_bytes(
        b"".join(sealed(line)[: -len(',"crc32c":"01234567"}\n')] + b"}\n" for line in lines)
    )
    digit = path.read_bytes().index(b'"error_deg":[') + len(b'"error_deg":[-0.4')
    with pytest.raises(Unnoticed):
        try_flips(path, [8 * digit])
