"""A bright disc in an image: where its centre is, how large it is, and how well that is known.

Pixels brighter than half-way between background and disc belong to it; a circle is fitted to the
places where the brightness crosses that level along rows and columns. Images are grey arrays from
PGM files or from PNG files of 8 or 16 bits, grey or RGB, not interlaced.
"""

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from solarcal.errors import InputFileError
from solarcal.units import FloatArray

_PNG = b"\x89PNG\r\n\x1a\n"
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
    scatter: float


def read_image(path: str | Path) -> FloatArray:
    """Brightness (rows, columns) of a PGM or PNG file, 0..1.

    Raises
    ------
    InputFileError
        Missing, damaged, or of a kind that is not read, named.
    """
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise InputFileError(f"{path} is missing: no such file") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputFileError(f"{path} cannot be read: {reason}") from None
    if content.startswith(_PNG):
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
    background, bright = float(np.median(image)), float(np.quantile(image, 0.999))
    level = 0.5 * (background + bright) if threshold is None else threshold
    if threshold is None and bright - background < _LEAST_CONTRAST:
        raise InputFileError(
            "no bright disc stands out in the image; expose longer, or --threshold"
        )
    inside = image >= level
    if inside[0].any() or inside[-1].any() or inside[:, 0].any() or inside[:, -1].any():
        raise InputFileError(
            "the disc touches the border of the image, or the threshold is too low"
        )
    rows, columns = np.nonzero(inside)
    if not len(rows):
        raise InputFileError("nothing in the image is brighter than the threshold")
    x, y = _crossings(image, level)
    # Only what belongs to the largest body: sparks and stars lie apart.
    middle = np.median(columns), np.median(rows)
    size = np.sqrt(len(rows) / np.pi)
    near = np.hypot(x - middle[0], y - middle[1]) < 1.5 * size + 2.0
    x, y = x[near], y[near]
    if len(x) < _FEWEST_EDGES:
        raise InputFileError("the disc is too small: fewer than 12 edge crossings; bring it nearer")
    for _ in range(3):
        centre_x, centre_y, radius = _circle(x, y)
        off = np.hypot(x - centre_x, y - centre_y) - radius
        spread = 1.4826 * float(np.median(np.abs(off)))
        kept = np.abs(off) <= max(4.0 * spread, 0.5)
        if kept.all() or kept.sum() < _FEWEST_EDGES:
            break
        x, y = x[kept], y[kept]
    scatter = float(np.sqrt(np.mean(off**2)))
    if scatter > 0.2 * radius:
        raise InputFileError(
            f"the bright region is no disc: its edge scatters by {scatter:.1f} pixels about a "
            f"radius of {radius:.1f}"
        )
    # A coordinate has half the weight of the edge; neighbouring crossings share their noise.
    sigma = scatter * np.sqrt(2.0 / len(x)) * np.sqrt(2.0)
    return Disc(centre_x, centre_y, radius, float(sigma), len(x), scatter)


def disc_errors_deg(
    disc: Disc, aim_x: float, aim_y: float, pixel_deg: float
) -> tuple[float, float, float]:
    """How far the disc stands to the right of and above the aim, and one sigma of each, degrees."""
    return (
        (disc.x - aim_x) * pixel_deg,
        (aim_y - disc.y) * pixel_deg,
        disc.sigma * pixel_deg,
    )


def _crossings(image: FloatArray, level: float) -> tuple[FloatArray, FloatArray]:
    """Places (x, y) where the brightness crosses the level along rows and along columns."""
    above = image >= level
    found = []
    for axis in (1, 0):
        first = np.take(image, range(image.shape[axis] - 1), axis=axis)
        second = np.take(image, range(1, image.shape[axis]), axis=axis)
        crossed = np.take(above, range(image.shape[axis] - 1), axis=axis) != np.take(
            above, range(1, image.shape[axis]), axis=axis
        )
        row, column = np.nonzero(crossed)
        a, b = first[crossed], second[crossed]
        part = (level - a) / (b - a)
        found.append((column + part, row + 0.0) if axis == 1 else (column + 0.0, row + part))
    return (
        np.concatenate([x for x, _ in found]),
        np.concatenate([y for _, y in found]),
    )


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
    at, data, header = len(_PNG), b"", None
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
