"""Replacement of symbols such as √, µ and ± by ASCII if the locale or the encoding of the output lacks them."""

from __future__ import annotations

import codecs
import io
import os
import re
import sys
from pathlib import Path

from sigmatau.results import ASCII

_HANDLER = "sigmatau-ascii"
_CELL = re.compile(r"(?P<text>(?:[^ \n]| (?! ))*)(?P<gap> {2,}(?=[^ \n]))?")
"""A cell of a table, with the spaces up to the next cell."""


def plain_streams() -> None:
    """Set up standard output and standard error. Characters that they cannot encode are written in ASCII; in the locale C
    all output is ASCII, although Python would write UTF-8.

    A stream that the caller has closed (`>&-`) discards all output.
    """
    codecs.register_error(_HANDLER, _plain)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115  it stays open until the end
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(encoding="ascii" if _in_c_locale() else None, errors=_HANDLER)


def _in_c_locale() -> bool:
    """Whether the user selects the locale C without an encoding, for which Python itself sets LC_CTYPE to C.UTF-8."""
    if os.environ.get("PYTHONIOENCODING") or os.environ.get("PYTHONUTF8") == "1":
        return False
    chosen = os.environ.get("LC_ALL") or os.environ.get("LC_CTYPE") or os.environ.get("LANG", "")
    if chosen == "C.UTF-8" and not os.environ.get("LC_ALL"):
        chosen = os.environ.get("LANG", "")
    return chosen in ("C", "POSIX")


def _plain(error: UnicodeError) -> tuple[str, int]:
    """Convert a cell to the characters of the encoding. If it becomes longer, trailing spaces are removed, so that
    columns remain aligned.
    """
    if not isinstance(error, UnicodeEncodeError):
        raise error
    match = _CELL.match(error.object, error.start)
    assert match is not None
    text = match["text"]
    for symbol, plain in ASCII.items():
        if not _encodable(symbol, error.encoding):
            text = text.replace(symbol, plain)
    text = "".join(c if _encodable(c, error.encoding) else ascii(c)[1:-1] for c in text)
    gap = len(match["gap"] or "")
    longer = len(text) - len(match["text"])
    return text + " " * (max(gap - longer, 1) if gap else 0), match.end()


def _encodable(text: str, encoding: str) -> bool:
    try:
        text.encode(encoding)
    except UnicodeEncodeError:
        return False
    return True
