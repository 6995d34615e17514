"""Detection of the format of a file from its content.

A reader is a module with ``read(path, head) -> tables``. It is imported only if the first bytes are those of its format. If
they are not enough, its ``sniff(head, path) -> bool`` decides. To add a reader, list it in `_FORMATS`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import cast

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.io.read.table import FORMATS, Format, Head, TextFormat

NOT_LOGS = (
    *(".json", ".toml", ".yaml", ".yml", ".md", ".rst", ".ini", ".cfg", ".py", ".sh", ".m"),
    *(".png", ".svg", ".pdf", ".html", ".jpg", ".jpeg", ".gif", ".mp4", ".mov", ".doc", ".docx", ".odt"),
)
"""File name endings in folders of logs that do not belong to logs."""


@frozen(kw_only=False)
class _Format:
    """A format and its reader."""

    module: str
    what: str  # Description for errors
    likely: Callable[[bytes], bool]  # Fast test of the first bytes; True for all files of the format
    gzip: bool = False  # Whether gzip-compressed files are read
    binary: bool = True  # Whether the file is not text
    sniffs: bool = False  # Whether the first bytes do not decide, so that the reader's `sniff` is asked

    def accept(self, head: bytes, path: Path) -> Format | None:
        """Import the reader; None if the file is not of this format."""
        if not self.likely(head):
            return None
        reader = cast("Format", import_module(f"sigmatau.io.read.formats.{self.module}"))
        return reader if not self.sniffs or reader.sniff(head, path) else None


def _begins(*marks: bytes) -> Callable[[bytes], bool]:
    return lambda head: head.startswith(marks)


_HDF5 = b"\x89HDF\r\n\x1a\n"
_OBJECT = rb"\A(?:\xef\xbb\xbf)?\s*[{\[]"
_OBJECT_ON_A_LINE = rb"\n[ \t]*\{"
_PAIR = rb"(?:[A-Za-z_)\]][ \t]*[:=][ \t]*|\d[ \t]*=[ \t]*|\d:[ \t]+)[-+.]?\d"


def _has_matlab_header(head: bytes) -> bool:
    """Whether the head is that of MATLAB's version 5 or 7.3. Version 7.3 is HDF5 after a block of 512 bytes."""
    return head[124:128] in (b"\0\1IM", b"\1\0MI") or head[512:520] == _HDF5


def _has_objects(head: bytes) -> bool:
    """Whether the head, or a line in it, begins with a JSON object or array."""
    return re.match(_OBJECT, head) is not None or (b"{" in head and re.search(_OBJECT_ON_A_LINE, head) is not None)


def _has_pairs(head: bytes) -> bool:
    """Whether two lines of the head contain names with numbers, separated by a colon or an equals sign."""
    if b":" not in head and b"=" not in head:
        return False  # fast path: most tables
    pairs = re.finditer(_PAIR, head)
    first = next(pairs, None)
    return first is not None and any(b"\n" in head[first.end() : pair.start()] for pair in pairs)


# The more specific format first: zip archives of arrays before zip archives of tables. Text has no signature and is last.
_FORMATS = (
    _Format("npy", "a NumPy file", _begins(b"\x93NUMPY", b"PK\x03\x04"), sniffs=True),
    _Format("xlsx", "an Excel workbook", _begins(b"PK\x03\x04"), sniffs=True),
    _Format("zipped", "a zip archive", _begins(b"PK\x03\x04")),
    _Format("roslog", "an MCAP file or a ROS bag", _begins(b"\x89MCAP", b"#ROSBAG V")),
    _Format("rosbag2", "an SQLite database", _begins(b"SQLite format 3\0")),
    _Format("ulog", "a PX4 flight log", _begins(b"ULog")),
    _Format("dataflash", "an ArduPilot log", _begins(b"\xa3\x95")),
    _Format("matlab", "a MATLAB file", _has_matlab_header),
    _Format("hdf5", "an HDF5 file", _begins(_HDF5)),
    _Format("arrow", "a Parquet or Arrow file", _begins(b"PAR1", b"ARROW1", b"\xff\xff\xff\xff"), sniffs=True),
    _Format("tdms", "a TDMS file", _begins(b"TDSm")),
    _Format(
        "novatel",
        "a NovAtel log",
        lambda head: b"RAWIMU" in head or b"\xaaD" in head or b"A,COM" in head,
        binary=False,
        sniffs=True,
    ),
    _Format("vectornav", "VectorNav sentences", lambda head: b"$VN" in head, gzip=True, binary=False, sniffs=True),
    _Format(
        "lvm",
        "a LabVIEW measurement file",
        _begins(b"LabVIEW Measurement", b"\xef\xbb\xbfLabVIEW Measurement"),
        gzip=True,
        binary=False,
    ),
    _Format("json_rows", "JSON", _has_objects, gzip=True, binary=False, sniffs=True),
    _Format("keyed", "text of names and values", _has_pairs, gzip=True, binary=False, sniffs=True),
    _Format("text", "text", lambda _: True, gzip=True, binary=False, sniffs=True),
)

# Texts that are saved by mistake in place of a log.
_INSTEAD = (
    (
        re.compile(rb"version https://git-lfs\.github\.com/"),
        "a pointer of Git LFS, not the file itself: run git lfs pull",
    ),
    (
        re.compile(rb"(?i)(?:\xef\xbb\xbf)?\s*(?:<\?xml[^>]{0,200}>\s*)?<(?:!doctype html|html|head|body)\b"),
        "a web page, perhaps one about an error: download the file again",
    ),
)

# Compressed files, also inside gzip: signature, name, and command to decompress them.
_COMPRESSED = (
    (re.compile(rb"\x28\xb5\x2f\xfd"), "compressed by zstd", "zstd -d"),
    (re.compile(rb"\xfd7zXZ\0"), "compressed by xz", "xz -d"),
    (re.compile(rb"BZh[1-9](?:1AY&SY|\x17rE8P\x90)"), "compressed by bzip2", "bzip2 -d"),
    (re.compile(rb"\x04\x22\x4d\x18"), "compressed by lz4", "lz4 -d"),
    (re.compile(rb"7z\xbc\xaf\x27\x1c"), "an archive of 7-Zip", "7z x"),
    (re.compile(rb"\x1f\x8b"), "compressed twice", "gzip -d"),
    (re.compile(rb"(?s:.{257})ustar"), "an archive of tar", "tar -xf"),
)


_FIGURES = b"0123456789+-.eE,;\t \r\n"


def may_need_translation(head: bytes) -> bool:
    """Whether the rows of a text may need a translation before they are read.

    Fast path: False for most tables, whose last rows contain only digits and one delimiter, and whose header names each
    column.
    """
    first, rows = head[:4096].split(b"\n")[:2], head[-4096:]
    rows = rows[rows.find(b"\n") + 1 :]
    if (
        rows.translate(None, _FIGURES)
        or b"@" in head[:4096]
        or head.startswith(b'"TOA5"')
        or (b"," in rows and (b";" in rows or b"\t" in rows))
    ):
        return True
    return len(first) > 1 and len(first[0].split()) + 1 == len(first[1].split())


def require_text(head: Head, path: Path) -> None:
    """Raise `OptionError` if lines are to be skipped in a file that is not text, judged by its first bytes."""
    for each in _FORMATS:
        if each.binary and each.likely(head.data):
            raise OptionError(f"{{option}} is for text tables, and this is {each.what}", option="skip")


_IN_ARCHIVES = ("lvm", "json_rows", "keyed", "text")  # formats whose readers take text in memory


def find_text_reader(head: Head, path: Path) -> TextFormat | None:
    """The reader of a text in memory, such as a member of an archive; None if it is not text."""
    for each in _FORMATS:
        if each.module in _IN_ARCHIVES and (reader := each.accept(head.data, path)) is not None:
            return cast("TextFormat", reader)
    return None


def find_reader(head: Head, path: Path) -> Format:
    """Find the reader of a file. If there is none, raises a `DataError` that names the kind of file."""
    for mark, what, command in _COMPRESSED:
        if mark.match(head.data):
            twice = " compressed by gzip" if head.gzip and "tar" in what else ""
            raise DataError(f"is {what}{twice}: decompress it first ({command} {path.name}) and give the file in it")
    for text, what in _INSTEAD:
        if text.match(head.data):
            raise DataError(f"is {what}")
    for each in _FORMATS:
        if (reader := each.accept(head.data, path)) is None:
            continue
        if head.gzip and not each.gzip:
            raise DataError(f"is {each.what} compressed by gzip; decompress it first (gzip -d {path.name})")
        return reader
    some = head.data[:64]
    if len(some) >= 4 and (not any(some[::2]) or not any(some[1::2])):  # every other byte is null
        raise DataError("is text in UTF-16 without a byte order mark; save it as UTF-8")
    raise DataError(f"is binary data, not a format that is read: {FORMATS}")
