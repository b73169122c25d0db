"""A bright disc in an image: its centre to a small part of a pixel, and images that are refused."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest

from solarcal.errors import InputFileError
from solarcal.optics.disc_image import find_disc, find_spot_and_hole, newest_image, read_image
from solarcal.units import FloatArray


def picture(
    x: float, y: float, radius: float, size: tuple[int, int] = (96, 128), noise: float = 0.0
) -> FloatArray:
    """A disc with an edge one pixel soft, on a dark ground, (rows, columns)."""
    rows, columns = np.mgrid[: size[0], : size[1]]
    edge = np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0.0, 1.0)
    generator = np.random.default_rng(7)
    return np.clip(0.05 + 0.8 * edge + noise * generator.standard_normal(size), 0.0, 1.0)


def pgm(image: FloatArray, largest: int = 255) -> bytes:
    values = np.round(image * largest)
    kind = ">u2" if largest > 255 else "u1"
    head = f"P5\n# made up\n{image.shape[1]} {image.shape[0]}\n{largest}\n"
    return head.encode() + values.astype(kind).tobytes()


def chunk(kind: bytes, body: bytes) -> bytes:
    crc = zlib.crc32(kind + body)
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", crc)


def png(image: FloatArray, *, bits: int = 8, rgb: bool = False, filter_kind: int = 0) -> bytes:
    """A PNG whose every row has the same filter."""
    height, width = image.shape
    values = np.round(image * (2**bits - 1)).astype(">u2" if bits == 16 else "u1")
    if rgb:
        values = np.repeat(values[:, :, np.newaxis], 3, axis=2)
    step = (3 if rgb else 1) * bits // 8
    table = np.frombuffer(values.tobytes(), dtype=np.uint8).reshape(height, -1).astype(int)
    left = np.zeros_like(table)
    left[:, step:] = table[:, :-step]
    up = np.zeros_like(table)
    up[1:] = table[:-1]
    corner = np.zeros_like(table)
    corner[1:, step:] = table[:-1, :-step]
    guess = left + up - corner
    apart = np.stack((abs(guess - left), abs(guess - up), abs(guess - corner)))
    paeth = np.choose(apart.argmin(axis=0), (left, up, corner))
    near = (np.zeros_like(table), left, up, (left + up) // 2, paeth)[filter_kind]
    rows = np.column_stack((np.full(height, filter_kind), (table - near) % 256)).astype(np.uint8)
    header = struct.pack(">IIBBBBB", width, height, bits, 2 if rgb else 0, 0, 0, 0)
    body = zlib.compress(rows.tobytes())
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b"")
    )


def stored(folder: Path, name: str, content: bytes) -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def test_the_centre_is_found_to_a_small_part_of_a_pixel() -> None:
    disc = find_disc(picture(61.3, 40.7, 22.4))
    assert (disc.x, disc.y) == pytest.approx((61.3, 40.7), abs=0.03)
    assert disc.radius == pytest.approx(22.4, abs=0.1)


def test_the_sigma_is_that_of_many_noisy_pictures() -> None:
    generator = np.random.default_rng(3)
    off, sigmas = [], []
    for _ in range(40):
        x, y = generator.uniform(50.0, 70.0), generator.uniform(40.0, 50.0)
        image = picture(x, y, 20.0) + 0.05 * generator.standard_normal((96, 128))
        disc = find_disc(image)
        off.append(disc.x - x)
        sigmas.append(disc.sigma)
    assert 0.5 < np.std(off) / np.mean(sigmas) < 2.0


@pytest.mark.parametrize("largest", [255, 4095])
def test_a_pgm_is_read(tmp_path: Path, largest: int) -> None:
    image = picture(30.0, 50.0, 12.0)
    read = read_image(stored(tmp_path, "a.pgm", pgm(image, largest)))
    np.testing.assert_allclose(read, image, atol=0.51 / largest)


def test_a_pgm_of_text_is_read(tmp_path: Path) -> None:
    read = read_image(stored(tmp_path, "a.pgm", b"P2 3 3 10\n0 5 0\n5 10 5\n0 5 0\n"))
    np.testing.assert_allclose(read[1], [0.5, 1.0, 0.5])


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("rgb", [False, True])
@pytest.mark.parametrize("filter_kind", range(5))
def test_a_png_is_read_with_every_filter(
    tmp_path: Path, bits: int, rgb: bool, filter_kind: int
) -> None:
    image = picture(20.0, 15.0, 8.0, (32, 40))
    content = png(image, bits=bits, rgb=rgb, filter_kind=filter_kind)
    read = read_image(stored(tmp_path, "a.png", content))
    np.testing.assert_allclose(read, image, atol=0.51 / (2**bits - 1))


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"GIF89a", "neither a PGM .* nor a PNG"),
        (b"P5 4 4 255\n12", "is cut short"),
        (b"P5 0 4 255\n", "0 x 4 pixels is not read"),
        (b"P5 four", "begins with width, height"),
        (b"P2 3 3 10\n0 5", "9 greys come"),
        (png(picture(20, 15, 8, (32, 40)))[:60], "is cut short|no PNG header"),
        (png(picture(20, 15, 8, (32, 40))).replace(b"IHDR\0\0\0", b"IHDR\0\0\1"), "checksum"),
        (
            b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 9, 9, 8, 6, 0, 0, 1)),
            "RGB with alpha, interlaced is not read",
        ),
    ],
)
def test_other_images_are_refused_by_name(tmp_path: Path, content: bytes, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        read_image(stored(tmp_path, "a.img", content))


@pytest.mark.parametrize(
    ("image", "complaint"),
    [
        (np.full((30, 30), 0.2), "no bright disc stands out"),
        (picture(2.0, 40.0, 10.0), "touches the border"),
        (np.pad(np.ones((4, 60)), 20), "is no disc"),
    ],
)
def test_what_is_no_disc_is_refused(image: FloatArray, complaint: str) -> None:
    with pytest.raises(InputFileError, match=complaint):
        find_disc(image)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "camera.pgm")
    with pytest.raises(InputFileError, match="a pipe or a device"):
        read_image(tmp_path / "camera.pgm")
    assert newest_image(tmp_path) is None


def plate(
    spot: tuple[float, float, float], hole: tuple[float, float, float], darkness: float = 0.1
) -> FloatArray:
    """A bright spot with a dark hole in it; centre and radius of each in pixels."""
    rows, columns = np.mgrid[:160, :200]
    image = np.full(rows.shape, 0.15)
    for (x, y, radius), brightness in ((spot, 0.9), (hole, darkness)):
        part = np.clip(radius - np.hypot(columns - x, rows - y) + 0.5, 0.0, 1.0)
        image += (brightness - image) * part
    return image


@pytest.mark.parametrize("darkness", [0.02, 0.3])
def test_spot_and_hole_are_two_circles(darkness: float) -> None:
    spot, hole = find_spot_and_hole(plate((101.3, 77.6, 52.0), (95.2, 80.1, 16.4), darkness))
    assert (spot.x, spot.y, spot.radius) == pytest.approx((101.3, 77.6, 52.0), abs=0.1)
    assert (hole.x, hole.y, hole.radius) == pytest.approx((95.2, 80.1, 16.4), abs=0.1)


def test_a_spark_outside_and_a_stain_inside_do_not_move_the_disc() -> None:
    image = plate((101.3, 77.6, 52.0), (95.2, 80.1, 5.0))
    image[3:9, 3:9] = 1.0
    image[60, 120:123] = 0.0
    disc = find_disc(image)
    assert (disc.x, disc.y, disc.radius) == pytest.approx((101.3, 77.6, 52.0), abs=0.1)


def test_a_spot_without_a_hole_asks_for_its_place() -> None:
    with pytest.raises(InputFileError, match="--hole-at X Y"):
        find_spot_and_hole(picture(61.3, 40.7, 22.4))


def test_the_newest_whole_image_of_a_folder_is_taken(tmp_path: Path) -> None:
    assert newest_image(tmp_path) is None
    for age, name in enumerate(("3.pgm", "2.PGM", "1.png", "notes.txt")):
        content = (
            png(picture(20, 15, 8, (32, 40)))[:60] if name == "1.png" else b"P5 3 3 9\n012345678"
        )
        os.utime(stored(tmp_path, name, content), ns=(age * 10**9,) * 2)
    # A name whose file is gone again, as while a camera renames one.
    (tmp_path / "4.pgm").symlink_to(tmp_path / "4.part")
    found = newest_image(tmp_path)
    assert found is not None
    assert found[0].endswith("2.PGM")
    older = newest_image(tmp_path, {found[0]})
    assert older is not None
    assert older[0].endswith("3.pgm")
    with pytest.raises(InputFileError, match="cannot be read"):
        newest_image(tmp_path / "none")
