"""The beginning of a text: its encoding, and the layout of the first table below any other lines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.formats import truncation
from sigmatau.io.read.formats.layout import Layout, find_layout
from sigmatau.io.read.formats.text_lines import LINES, NoRowsError
from sigmatau.io.read.table import HEAD

_UTF16 = {b"\xff\xfe": ("utf-16-le", "UTF-16 LE"), b"\xfe\xff": ("utf-16-be", "UTF-16 BE")}
_BOM = b"\xef\xbb\xbf"
_OVERLAP = 50  # lines that are searched twice, because the names and units of columns are above the samples
# largest number of parts (256 KiB or 2000 lines) that are searched for a table: 16 MiB of text above it
_MAX_PREAMBLES = 64


@frozen
class Beginning:
    """The head of a file in UTF-8, up to the first byte that is not text."""

    data: bytes
    whole: bool
    encoding: str
    called: str  # name of the encoding for the notes; empty if it is ASCII or not known yet
    skip: int = 0  # number of lines of the file above this text

    @classmethod
    def decode(cls, head: bytes, *, whole: bool) -> Beginning:
        encoding, called = _UTF16.get(head[:2], ("ascii", "UTF-8 with a byte order mark" if head[:3] == _BOM else ""))
        data = head
        if encoding != "ascii":
            data = head[: len(head) // 2 * 2].decode(encoding, errors="replace").encode("utf-8", errors="replace")
        if bad := truncation.BREAK.search(data):
            return cls(
                data=data[: data.rfind(b"\n", 0, bad.start()) + 1], whole=False, encoding=encoding, called=called
            )
        return cls(data=data, whole=whole, encoding=encoding, called=called)


def skip_lines(source: Path | bytes, beginning: Beginning, skip: int) -> Beginning:
    """The beginning of a text below `skip` lines; raises `OptionError` if there is none."""
    data = truncation.beginning_below(source, skip, beginning.encoding, HEAD)
    if not data:
        raise OptionError(f"has fewer than {skip + 1} lines; {{option}} skips all of them", option="skip")
    return replace(beginning, data=data[:HEAD], whole=len(data) <= HEAD, skip=skip)


def find_first_layout(source: Path | bytes, beginning: Beginning) -> Layout:
    """Find the layout of the first table in a text, however many lines precede it. Raises `DataError`.

    Lines above a table may look like rows of another table. A layout that does not fit the last line is therefore only used
    if the text continues in it, or if no other layout is found.
    """
    first: Layout | NoRowsError
    try:
        first = find_layout(beginning.data, whole=beginning.whole, encoding=beginning.called, skip=beginning.skip)
    except NoRowsError as error:
        if beginning.whole and error.last - beginning.skip < LINES:
            raise DataError(error.message) from None
        first = error
    last = truncation.last_line(source, beginning.encoding)
    if isinstance(first, Layout) and (last is None or first.fits(last)):
        return first
    searched, skip = first.last, beginning.skip
    for _ in range(_MAX_PREAMBLES):
        layout: Layout | None = None
        if searched - skip <= _OVERLAP:
            break
        skip = searched - _OVERLAP
        data = truncation.beginning_below(source, skip, beginning.encoding, HEAD)
        if not data or truncation.BREAK.search(data):
            break
        try:
            layout = find_layout(data[:HEAD], whole=len(data) <= HEAD, encoding=beginning.called, skip=skip)
            if isinstance(first, NoRowsError) or (last is not None and layout.fits(last)):
                return layout
            searched = layout.last
        except NoRowsError as error:
            searched = error.last
        except DataError:
            break
        if (
            isinstance(first, Layout)
            and layout is not None
            and layout.has_same_rows(first)
            and any(c.name for c in first.columns)
        ):
            break  # one table, whose end is damaged
        if len(data) <= HEAD and searched - skip < LINES:
            break
    if isinstance(first, Layout):
        return first
    raise DataError(
        f"{first}; if the table begins further down, give {Hint('skip', value='N')} for N lines above it"
    ) from None
