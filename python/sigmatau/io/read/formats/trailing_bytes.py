"""Bytes behind the end that a file declares: another log that was appended by ``cat``, or filler.

Formats that say how long they are read to there and no further, and their libraries pass over what follows without a word.
"""

from __future__ import annotations

from pathlib import Path

from sigmatau.findings.finding import Finding

__all__ = ["BEHIND", "archive_ends", "behind", "lost"]

BEHIND = "what they hold is not read: if another log was appended there, cut the file in two and read each"
"""Effect of bytes that are not read."""

_PIECE = 1 << 20
_END_RECORD, _END_LENGTH, _COMMENT = b"PK\x05\x06", 22, 1 << 16  # of zip archives


def behind(path: Path, end: int, what: str) -> tuple[Finding, ...]:
    """What to say of the bytes behind the end of the contents; nothing if there are none.

    Parameters
    ----------
    path : Path
    end : int
        Where the contents end. [bytes]
    what : str
        That ends there, in words.
    """
    size = path.stat().st_size
    if size <= end:
        return ()
    if filler := _filler(path, end):
        message = f"{size - end} bytes of {filler} lie behind the end of {what} at byte {end}"
        return (Finding(code="filler", severity="info", message=message, effect="they hold nothing"),)
    return (lost(f"{size - end} bytes lie behind the end of {what} at byte {end}, and are not read"),)


def lost(message: str) -> Finding:
    """That a file holds bytes that are not read."""
    return Finding(code="bytes_not_read", severity="error", message=message, effect=BEHIND)


def _filler(path: Path, start: int) -> str:
    """The one byte that a file consists of from a place on, if that is what a disk is filled with; in words."""
    with path.open("rb") as stream:
        stream.seek(start)
        first = stream.read(1)
        if first not in (b"\0", b"\xff"):
            return ""
        while piece := stream.read(_PIECE):
            if piece.strip(first):
                return ""
    return "zeros" if first == b"\0" else "0xff"


def archive_ends(path: Path, first: int) -> tuple[Finding, ...]:
    """What stands before and behind a zip archive, of which the library reads the last that it finds.

    Parameters
    ----------
    path : Path
    first : int
        Where the first member begins. [bytes]
    """
    found: tuple[Finding, ...] = ()
    if first > 0:
        found = (lost(f"{first} bytes stand before the archive that is read, and are not read"),)
    size = path.stat().st_size
    start = max(0, size - _END_LENGTH - _COMMENT)
    with path.open("rb") as stream:
        stream.seek(start)
        tail = stream.read()
    at = tail.rfind(_END_RECORD)
    if at < 0 or at + _END_LENGTH > len(tail):
        return found
    comment = int.from_bytes(tail[at + 20 : at + 22], "little")
    return (*found, *behind(path, start + at + _END_LENGTH + comment, "the archive"))
