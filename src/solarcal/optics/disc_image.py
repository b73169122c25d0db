"""A bright disc in an image: where its centre is, how large it is, and how well that is known.

Pixels brighter than half-way between background and disc belong to it; a circle is fitted to the
places where the brightness crosses that level along rows and columns. Images are grey arrays from
PGM files or from PNG files of 8 or 16 bits, grey or RGB, not interlaced.
"""

import struct
import zlib
from collections.abc import Container
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from solarcal.errors import InputFileError
from solarcal.input_files import read_bytes
from solarcal.units import FloatArray, rms

Mask = NDArray[np.bool_]

ENDINGS = (".pgm", ".png")
PNG = b"\x89PNG\r\n\x1a\n"
LARGEST_IMAGE_BYTES = 200_000_000
_MOST_PIXELS = 50_000_000
_FEWEST_EDGES = 12
_LEAST_CONTRAST = 0.05


@dataclass(frozen=True, slots=True)
class Disc:
    """A circle in pixels: x to the right, y down from the middle of the first pixel.

    ``sigma``: one sigma of each coordinate of the centre, from the scatter of the edge.
    """

    x: float
    y: float
    radius: float
    sigma: float
    edges: int

    def as_json(self) -> dict[str, float]:
        """What a JSON document holds of it."""
        return {"x": self.x, "y": self.y, "radius": self.radius, "sigma": self.sigma}


def newest_image(folder: str | Path, seen: Container[str] = ()) -> tuple[str, FloatArray] | None:
    """Path and brightness of the newest whole image of a folder that is being filled.

    An image that is still being written is passed over for the one before it; None where there is
    none but those of ``seen``.

    Raises
    ------
    InputFileError
        The folder cannot be read.
    """
    found = []
    try:
        for path in Path(folder).iterdir():
            if path.suffix.lower() in ENDINGS and str(path) not in seen:
                # One that the camera has just renamed or removed is no trouble of the folder.
                with suppress(FileNotFoundError):
                    found.append((path.stat().st_mtime_ns, str(path)))
    except OSError as error:
        raise InputFileError(f"{folder} cannot be read: {error.strerror}") from None
    for _, name in sorted(found, reverse=True):
        try:
            return name, read_image(name)
        except InputFileError:
            continue
    return None


def read_image(path: str | Path) -> FloatArray:
    """Brightness (rows, columns) of a PGM or PNG file, 0..1.

    Raises
    ------
    InputFileError
        Missing, damaged, or of a kind that is not read, named.
    """
    content = read_bytes(path, LARGEST_IMAGE_BYTES)
    if content.startswith(PNG):
        return _png(content, str(path))
    if content[:2] in (b"P2", b"P5"):
        return _pgm(content, str(path))
    raise InputFileError(f"{path}: neither a PGM (P2, P5) nor a PNG image; convert it to one")


def find_disc(image: FloatArray, threshold: float | None = None) -> Disc:
    """The bright disc of an image (rows, columns).

    ``threshold``: the brightness of its edge; default half-way between the background (median)
    and the disc (the brightest hundredth).

    Raises
    ------
    InputFileError
        No disc stands out, it touches the border, or its edge is not that of a circle.
    """
    level = _edge_level(image, threshold)
    return _fitted_circle(image, _body(image >= level)[1], level, "the disc")


def find_spot_and_hole(image: FloatArray, threshold: float | None = None) -> tuple[Disc, Disc]:
    """The bright spot on the plate of a sunspot device, and the dark hole within it.

    Raises
    ------
    InputFileError
        As of `find_disc`, or no dark hole lies wholly within the spot.
    """
    level = _edge_level(image, threshold)
    bright, filled = _body(image >= level)
    spot = _fitted_circle(image, filled, level, "the spot")
    dark = filled & ~bright
    if not dark.any():
        raise InputFileError(
            "no dark hole lies within the spot; give its place in the picture as --hole-at X Y"
        )
    # The hole may be less dark than the plate around the spot: its edge has a level of its own.
    level = 0.5 * (float(np.median(image[bright])) + float(np.median(image[dark])))
    hole = _body(filled & (image < level))[1]
    return spot, _fitted_circle(image, hole, level, "the hole")


def _edge_level(image: FloatArray, threshold: float | None) -> float:
    """The brightness of an edge: as given, or half-way between background and disc."""
    if threshold is not None:
        return threshold
    background, bright = float(np.median(image)), float(np.quantile(image, 0.999))
    if bright - background < _LEAST_CONTRAST:
        raise InputFileError(
            "no bright disc stands out in the image; expose longer, or --threshold"
        )
    return 0.5 * (background + bright)


def _body(inside: Mask) -> tuple[Mask, Mask]:
    """The largest connected body of a mask, as it is and with its holes filled."""
    # Its import takes 60 ms, which no other calculator has to pay for.
    from scipy import ndimage  # noqa: PLC0415

    labels, count = ndimage.label(inside)
    if not count:
        raise InputFileError("nothing in the image is brighter than the threshold")
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    body = labels == sizes.argmax()
    return body, np.asarray(ndimage.binary_fill_holes(body))


def _fitted_circle(image: FloatArray, body: Mask, level: float, name: str) -> Disc:
    """The circle of a body's edge, doubtful crossings left out."""
    if body[0].any() or body[-1].any() or body[:, 0].any() or body[:, -1].any():
        raise InputFileError(f"{name} touches the border of the image, or the threshold is too low")
    x, y = _crossings(image, body, level)
    if len(x) < _FEWEST_EDGES:
        raise InputFileError(
            f"{name} is too small: fewer than {_FEWEST_EDGES} edge crossings; bring it nearer"
        )
    for _ in range(3):
        centre_x, centre_y, radius = _circle(x, y)
        off = np.hypot(x - centre_x, y - centre_y) - radius
        spread = 1.4826 * float(np.median(np.abs(off)))
        kept = np.abs(off) <= max(4.0 * spread, 0.5)
        if kept.all() or kept.sum() < _FEWEST_EDGES:
            break
        x, y = x[kept], y[kept]
    scatter = rms(off)
    if scatter > 0.2 * radius:
        raise InputFileError(
            f"{name} is no disc: its edge scatters by {scatter:.1f} pixels about a radius of "
            f"{radius:.1f}"
        )
    # A coordinate has half the weight of the edge; neighbouring crossings share their noise.
    sigma = scatter * np.sqrt(2.0 / len(x)) * np.sqrt(2.0)
    return Disc(centre_x, centre_y, radius, float(sigma), len(x))


def _crossings(image: FloatArray, body: Mask, level: float) -> tuple[FloatArray, FloatArray]:
    """Places (x, y) where the brightness crosses the level at the edge of a body."""
    x, y = [], []
    for row, column in ((0, 1), (1, 0)):
        near = slice(None, -row or None), slice(None, -column or None)
        far = slice(row, None), slice(column, None)
        r, c = np.nonzero(body[near] != body[far])
        a, b = image[near][r, c], image[far][r, c]
        part = (level - a) / (b - a)
        x.append(c + column * part)
        y.append(r + row * part)
    return np.concatenate(x), np.concatenate(y)


def _circle(x: FloatArray, y: FloatArray) -> tuple[float, float, float]:
    """Least squares of x^2 + y^2 = 2 a x + 2 b y + c about the mean, then one geometric step."""
    x0, y0 = float(x.mean()), float(y.mean())
    u, v = x - x0, y - y0
    columns = np.column_stack((2.0 * u, 2.0 * v, np.ones_like(u)))
    a, b, c = np.linalg.lstsq(columns, u * u + v * v, rcond=None)[0]
    radius = float(np.sqrt(max(c + a * a + b * b, 0.0)))
    for _ in range(5):
        du, dv = u - a, v - b
        distance = np.hypot(du, dv)
        slopes = np.column_stack((-du / distance, -dv / distance, -np.ones_like(u)))
        step = np.linalg.lstsq(slopes, -(distance - radius), rcond=None)[0]
        a, b, radius = a + step[0], b + step[1], radius + float(step[2])
    return x0 + float(a), y0 + float(b), radius


def _pgm(content: bytes, path: str) -> FloatArray:
    fields: list[int] = []
    at = 2
    while len(fields) < 3:
        while at < len(content) and content[at : at + 1].isspace():
            at += 1
        if content[at : at + 1] == b"#":
            at = content.find(b"\n", at)
            if at < 0:
                break
            continue
        end = at
        while end < len(content) and content[end : end + 1].isdigit():
            end += 1
        if end == at or end - at > 9:
            break
        fields.append(int(content[at:end]))
        at = end
    if len(fields) < 3:
        raise InputFileError(f"{path}: a PGM begins with width, height and the largest grey")
    width, height, largest = fields
    _require_size(width, height, path)
    if not 0 < largest < 65536:
        raise InputFileError(f"{path}: a PGM's largest grey is 1 to 65535, not {largest}")
    count = width * height
    if content[:2] == b"P2":
        words = content[at:].split()
        if len(words) < count or not all(
            word.isdigit() and len(word) < 6 for word in words[:count]
        ):
            raise InputFileError(f"{path}: {count} greys come, and not all are there")
        values = np.array(words[:count], dtype=np.float64)
    else:
        kind = np.dtype(">u2" if largest > 255 else "u1")
        data = content[at + 1 : at + 1 + count * kind.itemsize]
        if len(data) < count * kind.itemsize:
            raise InputFileError(f"{path} is cut short: {len(data)} bytes of greys are there")
        values = np.frombuffer(data, dtype=kind).astype(np.float64)
    return values.reshape(height, width) / largest


def _png(content: bytes, path: str) -> FloatArray:
    at, data, header = len(PNG), b"", None
    while at + 12 <= len(content):
        (length,) = struct.unpack(">I", content[at : at + 4])
        kind, body = content[at + 4 : at + 8], content[at + 8 : at + 8 + length]
        if len(body) < length:
            break
        if zlib.crc32(kind + body) != int.from_bytes(
            content[at + 8 + length : at + 12 + length], "big"
        ):
            raise InputFileError(f"{path}: a PNG chunk is damaged (checksum)")
        if kind == b"IHDR" and length == 13:
            header = struct.unpack(">IIBBBBB", body)
        elif kind == b"IDAT":
            data += body
        elif kind == b"IEND":
            break
        at += 12 + length
    if header is None:
        raise InputFileError(f"{path}: no PNG header (IHDR) in it")
    width, height, bits, colour, _, _, interlace = header
    _require_size(width, height, path)
    channels = {0: 1, 2: 3}.get(colour)
    if channels is None or bits not in (8, 16) or interlace:
        kinds = {3: "palette", 4: "grey with alpha", 6: "RGB with alpha"}
        raise InputFileError(
            f"{path}: a PNG of {bits} bits, {kinds.get(colour, 'grey or RGB')}"
            f"{', interlaced' if interlace else ''} is not read; save 8 or 16 bit grey or RGB, not "
            "interlaced"
        )
    step = channels * bits // 8
    wanted = height * (1 + width * step)
    try:
        raw = zlib.decompressobj().decompress(data, wanted)
    except zlib.error as error:
        raise InputFileError(f"{path}: the PNG's pixels are damaged: {error}") from None
    if len(raw) < wanted:
        raise InputFileError(f"{path} is cut short: {len(raw)} of {wanted} bytes of pixels")
    pixels = _unfiltered(raw, width, height, step, path)
    kind16 = np.dtype(">u2" if bits == 16 else "u1")
    values = pixels.reshape(height, -1).view(kind16).reshape(height, width, channels)
    return np.asarray(values.mean(axis=2) / (2.0**bits - 1.0))


def _unfiltered(
    raw: bytes, width: int, height: int, step: int, path: str
) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """The bytes of all rows, each filter undone (PNG specification, 9)."""
    stride = width * step
    table = np.frombuffer(raw, dtype=np.uint8).reshape(height, stride + 1)
    out = np.zeros((height + 1, stride), dtype=np.uint8)
    for row in range(height):
        kind, line, above = int(table[row, 0]), table[row, 1:], out[row]
        here = out[row + 1]
        if kind == 0:
            here[:] = line
        elif kind == 1:
            parts = line.reshape(width, step).astype(np.int64)
            here[:] = (np.cumsum(parts, axis=0) % 256).astype(np.uint8).ravel()
        elif kind == 2:
            here[:] = line + above
        elif kind in (3, 4):
            here[:] = _predicted(line.tolist(), above.tolist(), step, paeth=kind == 4)
        else:
            raise InputFileError(f"{path}: row {row + 1} has the PNG filter {kind}, which is none")
    return out[1:]


def _predicted(line: list[int], above: list[int], step: int, *, paeth: bool) -> list[int]:
    """A row of the filters Average and Paeth, byte by byte."""
    done = [0] * len(line)
    for at, value in enumerate(line):
        left = done[at - step] if at >= step else 0
        up = above[at]
        if paeth:
            corner = above[at - step] if at >= step else 0
            guess = left + up - corner
            distances = (abs(guess - left), abs(guess - up), abs(guess - corner))
            near = (left, up, corner)[distances.index(min(distances))]
        else:
            near = (left + up) // 2
        done[at] = (value + near) & 255
    return done


def _require_size(width: int, height: int, path: str) -> None:
    if not (width > 2 and height > 2 and width * height <= _MOST_PIXELS):
        raise InputFileError(
            f"{path}: an image of {width} x {height} pixels is not read (3 x 3 to 50 million)"
        )
