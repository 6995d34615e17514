"""Render a page of a PDF file to a picture, by PDFium."""

from __future__ import annotations

import struct
import zlib

import numpy as np
from numpy.typing import NDArray

from sigmatau.io.read.figure.pdf import opened_page

_RESOLUTION = 300 / 72  # pixels per point of a page: a line of 0.5 points has 2 pixels
_LONGEST = 4000  # longest side of the picture [pixels]


def render(data: bytes, page: int | None) -> bytes:
    """PNG data of a page, numbered from 1."""
    with opened_page(data, page) as content:
        scale = min(_RESOLUTION, _LONGEST / max(content.get_size()))
        return png(content.render(scale=scale, rev_byteorder=True).to_numpy()[:, :, :3])


def png(pixels: NDArray[np.uint8]) -> bytes:
    """PNG data of pixels, shape (height, width, 3)."""
    height, width, _ = pixels.shape
    rows = np.zeros((height, 1 + 3 * width), dtype=np.uint8)  # the first byte of a row is its filter: none
    rows[:, 1:] = pixels.reshape(height, -1)
    parts = {b"IHDR": struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0), b"IDAT": zlib.compress(rows.tobytes(), 3)}
    result = b"\x89PNG\r\n\x1a\n"
    for kind, body in [*parts.items(), (b"IEND", b"")]:
        result += struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    return result
