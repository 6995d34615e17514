"""The logo of a certificate: a PNG or SVG of bounded size, embedded in the report."""

from __future__ import annotations

import base64
import re
import struct
from pathlib import Path
from typing import Literal

from sigmatau.errors import DataError
from sigmatau.frozen import frozen

_LARGEST = 512 << 10  # [bytes]
_MOST_PIXELS = 4_000_000  # of a PNG; more are slow to decode
_PNG = b"\x89PNG\r\n\x1a\n"
_SVG = re.compile(rb"\A(?:\xef\xbb\xbf)?\s*(?:<\?xml[^>]*\?>\s*)?(?:<!--.*?-->\s*)*<svg[\s>]", re.DOTALL)
# What may load or run something: entities, scripts, handlers, foreign elements, links to other files.
_UNSAFE = re.compile(
    rb"<!|<script|<foreignObject|\son\w+\s*=|href\s*=\s*[\"'](?!#|data:image/png)|url\(\s*[\"']?(?!#)|@import", re.I
)


@frozen
class Logo:
    """A picture.

    Attributes
    ----------
    kind : {"png", "svg"}
    content : bytes
    """

    kind: Literal["png", "svg"]
    content: bytes

    @property
    def url(self) -> str:
        """The picture as a URL that contains it."""
        mime = "image/png" if self.kind == "png" else "image/svg+xml"
        return f"data:{mime};base64,{base64.b64encode(self.content).decode('ascii')}"


def why_unreadable(error: OSError) -> str:
    """Words for a file that cannot be opened."""
    return "does not exist" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror or error}"


def read_logo(path: Path) -> Logo:
    """Read a logo. Raises `DataError` if it cannot be read, is too large, or is neither a PNG nor a plain SVG."""
    try:
        with path.open("rb") as stream:
            content = stream.read(_LARGEST + 1)
    except OSError as error:
        raise DataError(f"the logo {why_unreadable(error)}").about(str(path)) from None
    if len(content) > _LARGEST:
        raise DataError(f"the logo has more than {_LARGEST >> 10} KiB; make it smaller").about(str(path))
    if content.startswith(_PNG):
        if len(content) < 33 or content[12:16] != b"IHDR":
            raise DataError("the logo is a damaged PNG; write it again").about(str(path))
        width, height = struct.unpack(">II", content[16:24])
        if not 0 < width * height <= _MOST_PIXELS:
            raise DataError(f"the logo has {width} × {height} pixels; make it smaller").about(str(path))
        return Logo(kind="png", content=content)
    if _SVG.match(content) is None:
        raise DataError("the logo must be a PNG or an SVG").about(str(path))
    body = re.sub(rb"<!--.*?-->", b"", content, flags=re.DOTALL)
    if _UNSAFE.search(body):
        raise DataError("the logo has scripts, entities or links; export it as a plain SVG or as a PNG").about(
            str(path)
        )
    return Logo(kind="svg", content=content)
