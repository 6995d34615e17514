"""The formats that are read, and how each is told from the others before its reader is loaded: most files need but one.

A reader is a module with ``sniff(head, path) -> bool``, which recognises its format by content, and ``read(path, head)
-> tables``, which hands over columns. To add one, write such a module and name it in `_KNOWN`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import cast

from sigmatau.errors import DataError
from sigmatau.io.read.table import FORMATS, Format, Head

__all__ = ["reader_of"]


@dataclass(frozen=True, slots=True)
class _Known:
    """A format.

    Attributes
    ----------
    module : str
    what : str
        In the words of an error.
    likely : callable
        Whether a file that begins so may be one; cheap, and never False of one that `sniff` takes.
    packed : bool
        Whether it is read compressed by gzip too.
    """

    module: str
    what: str
    likely: Callable[[bytes], bool]
    packed: bool = False


def _begins(*marks: bytes) -> Callable[[bytes], bool]:
    return lambda head: head.startswith(marks)


# Of those that begin alike the more particular one first: zip archives of arrays before those of tables; text last, which
# has no mark of its own.
_KNOWN = (
    _Known("npy", "a NumPy file", _begins(b"\x93NUMPY", b"PK\x03\x04")),
    _Known("zipped", "a zip archive", _begins(b"PK\x03\x04")),
    _Known("roslog", "an MCAP file or a ROS bag", _begins(b"\x89MCAP", b"#ROSBAG")),
    _Known("rosbag2", "an SQLite database", _begins(b"SQLite format 3")),
    _Known("ulog", "a PX4 flight log", _begins(b"ULog")),
    _Known("dataflash", "an ArduPilot log", _begins(b"\xa3\x95")),
    _Known("matlab", "a MATLAB file", lambda head: head[126:128] in (b"IM", b"MI") or head[512:516] == b"\x89HDF"),
    _Known("hdf5", "an HDF5 file", _begins(b"\x89HDF")),
    _Known("arrow", "a Parquet or Arrow file", _begins(b"PAR1", b"ARROW1", b"\xff\xff\xff\xff")),
    _Known("tdms", "a TDMS file", _begins(b"TDSm")),
    _Known("novatel", "a NovAtel log", lambda head: b"RAWIMU" in head or b"\xaaD" in head or b"A,COM" in head),
    _Known("vectornav", "VectorNav sentences", lambda head: b"$VN" in head, packed=True),
    _Known("text", "text", lambda _: True, packed=True),
)

# First bytes of files that people have at hand and that are no tables; only for the words of the error.
_MARKS = (
    (b"%PDF", "a PDF"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"PARE", "an encrypted Parquet file"),
    (b"FEA1", "a Feather file of version 1"),
    (b"\xd0\xcf\x11\xe0", "an old Excel file"),
    (b"\x7fELF", "a program"),
)

# Compressed files, also inside of gzip: by what, and how they are decompressed.
_COMPRESSED = (
    (re.compile(rb"\x28\xb5\x2f\xfd"), "compressed by zstd", "zstd -d"),
    (re.compile(rb"\xfd7zXZ\0"), "compressed by xz", "xz -d"),
    (re.compile(rb"BZh[1-9](?:1AY&SY|\x17rE8P\x90)"), "compressed by bzip2", "bzip2 -d"),
    (re.compile(rb"\x04\x22\x4d\x18"), "compressed by lz4", "lz4 -d"),
    (re.compile(rb"7z\xbc\xaf\x27\x1c"), "an archive of 7-Zip", "7z x"),
    (re.compile(rb"\x1f\x8b"), "compressed twice", "gzip -d"),
    (re.compile(rb"(?s:.{257})ustar"), "an archive of tar", "tar -xf"),
)


def reader_of(head: Head, path: Path) -> Format:
    """The reader of a file; raises `DataError` if there is none, in words that say what the file is."""
    for mark, what, command in _COMPRESSED:
        if mark.match(head.data):
            twice = " compressed by gzip" if head.gzip and "tar" in what else ""
            raise DataError(f"is {what}{twice}: decompress it first ({command} {path.name}) and give what is in it")
    for known in _KNOWN:
        if not known.likely(head.data):
            continue
        reader = cast("Format", import_module(f"sigmatau.io.read.formats.{known.module}"))
        if not reader.sniff(head.data, path):
            continue
        if head.gzip and not known.packed:
            raise DataError(f"is {known.what} compressed by gzip; decompress it first (gzip -d {path.name})")
        return reader
    found = next((what for mark, what in _MARKS if head.data.startswith(mark)), "binary data")
    if _every_other_byte_is_null(head.data):
        raise DataError("is text in UTF-16 without a byte order mark; save it as UTF-8")
    raise DataError(f"is {found}, not a format that is read: {FORMATS}")


def _every_other_byte_is_null(data: bytes) -> bool:
    some = data[:64]
    return len(some) >= 4 and (not any(some[::2]) or not any(some[1::2]))
