"""Size of a picture whose points are clicked: PNG, JPEG, GIF and WebP by their headers, SVG by its root."""

from __future__ import annotations

import math
import struct
import zlib
from pathlib import Path
from typing import Literal

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.figure.drawing import MAX_BYTES
from sigmatau.io.read.figure.svg import numbers
from sigmatau.io.read.figure.svg_style import length
from sigmatau.io.read.figure.svg_tree import parse

Form = Literal["png", "jpeg", "gif", "webp", "svg"]

MAX_PIXELS = 60_000_000
"""Largest number of pixels of a picture. Judgement: a page that is scanned at 600 dpi has 35 million."""

_FRAMES = (
    *range(0xC0, 0xC4),
    *range(0xC5, 0xC8),
    *range(0xC9, 0xCC),
    *range(0xCD, 0xD0),
)  # markers of JPEG with a size
_BARE = (0x01, *range(0xD0, 0xD8))  # markers of JPEG without a length
_DAMAGED = "is damaged. Download it, or save it again"


@frozen(kw_only=False)
class PictureSize:
    """The form of a picture, and its width and height in pixels, of SVG in units of the page."""

    form: Form
    width: float
    height: float


def picture_size(path: Path) -> PictureSize:
    """The size of a picture. Raises `DataError` if it is damaged, too large, or in a form that browsers do not show."""
    if path.stat().st_size > MAX_BYTES:
        raise DataError(f"is larger than {MAX_BYTES / 1e6:g} MB. Cut out the figure, and save it alone")
    size = _size(path.read_bytes())
    if not (min(size.width, size.height) > 0 and math.isfinite(size.width * size.height)):
        raise DataError("has no width or height. Save it again, e.g. as PNG")
    if size.form != "svg" and size.width * size.height > MAX_PIXELS:
        raise DataError(
            f"has {size.width:.0f} × {size.height:.0f} pixels, above {MAX_PIXELS / 1e6:g} million. Cut out the figure"
        )
    return size


def _size(data: bytes) -> PictureSize:
    try:
        if data.startswith(b"\x89PNG\r\n\x1a\n"):
            return _png(data)
        if data.startswith(b"\xff\xd8\xff"):
            return _jpeg(data)
        if data.startswith((b"GIF87a", b"GIF89a")):
            return PictureSize("gif", *struct.unpack_from("<HH", data, 6))
        if data.startswith(b"RIFF") and data[8:12] == b"WEBP":
            return _webp(data)
    except (struct.error, IndexError):
        raise DataError(_DAMAGED) from None
    if data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        return _svg(data)
    raise DataError("is not a picture that a browser shows. Save it as PNG, JPEG, WebP or SVG")


def _png(data: bytes) -> PictureSize:
    """The size of PNG data, all of whose parts have the right checksum."""
    place, width, height, has_end = 8, 0, 0, False
    while place < len(data) and not has_end:
        size, kind = struct.unpack_from(">I4s", data, place)
        (checksum,) = struct.unpack_from(">I", data, place + 8 + size)
        if zlib.crc32(data[place + 4 : place + 8 + size]) != checksum:
            raise DataError(_DAMAGED)
        if kind == b"IHDR":
            width, height = struct.unpack_from(">II", data, place + 8)
        has_end = kind == b"IEND"
        place += 12 + size
    if not has_end:
        raise DataError(_DAMAGED)
    return PictureSize("png", width, height)


def _jpeg(data: bytes) -> PictureSize:
    """The size of JPEG data, without the turn that the orientation of a photo may state."""
    place = 2
    while True:
        if data[place] != 0xFF:
            raise DataError(_DAMAGED)
        marker = data[place + 1]
        if marker == 0xFF:  # padding
            place += 1
        elif marker in _BARE:
            place += 2
        elif marker in _FRAMES:
            height, width = struct.unpack_from(">HH", data, place + 5)
            return PictureSize("jpeg", width, height)
        else:
            (size,) = struct.unpack_from(">H", data, place + 2)
            place += 2 + size


def _webp(data: bytes) -> PictureSize:
    kind = data[12:16]
    if kind == b"VP8 ":
        width, height = (side & 0x3FFF for side in struct.unpack_from("<HH", data, 26))
    elif kind == b"VP8L":
        (bits,) = struct.unpack_from("<I", data, 21)
        width, height = (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    elif kind == b"VP8X" and len(data) >= 30:
        width, height = (1 + int.from_bytes(data[k : k + 3], "little") for k in (24, 27))
    else:
        raise DataError(_DAMAGED)
    return PictureSize("webp", width, height)


def _svg(data: bytes) -> PictureSize:
    root = parse(data)
    width, height = (length(root.attributes.get(name, ""), 0.0) for name in ("width", "height"))
    box = numbers(root.attributes.get("viewBox", ""))
    if len(box) == 4 and box[2] > 0 and box[3] > 0:
        scale = width / box[2] if width > 0 else height / box[3] if height > 0 else 1.0
        width, height = width or scale * box[2], height or scale * box[3]
    return PictureSize("svg", width, height)
