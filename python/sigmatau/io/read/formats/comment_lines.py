"""Lines among the rows of a text table that begin with a comment mark.

Most are comments. A flipped bit can turn a row into one, and the row is lost. In a file of several logs the next header may
follow a comment mark, and it may name other columns, or the same columns in another order or unit.
"""

from __future__ import annotations

from dataclasses import dataclass

from sigmatau._native.formats import TextColumns
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import Comments, HeaderAgain, HiddenRows, SecondHeader
from sigmatau.io.read.formats.layout import Layout, header_fields
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column

__all__ = ["SkippedLines"]

_EXCHANGED = str.maketrans(",.", ".,")


@dataclass(frozen=True, slots=True, kw_only=True)
class SkippedLines:
    """Lines that were skipped among the rows. Lines count from 1."""

    read: TextColumns
    stop: int | None  # Line of the first header that differs from the header of the table: rows after it are not read
    again: int | None  # Line of the first header before it that equals the header of the table

    @classmethod
    def between(cls, read: TextColumns, layout: Layout) -> SkippedLines:
        own = [column.name for column in layout.columns]
        stop = again = None
        for line, text in read.headers:
            # In text with decimal commas the decoder exchanges commas and points.
            fields = header_fields(text.translate(_EXCHANGED) if layout.decimal_comma else text, layout)
            if not fields:
                continue
            if fields != own and recognise([Column(name=name) for name in fields]) != recognise(layout.columns):
                stop = line
                break
            again = again or line
        return cls(read=read, stop=stop, again=again)

    def findings(self, rows: int) -> tuple[Finding, ...]:
        """Findings of the skipped lines; `rows` is the number of rows that were read."""
        read, stop = self.read, self.stop
        found: list[Finding] = []
        if stop is not None:
            found.append(Finding(details=SecondHeader(line=stop, kept=rows), severity="error"))
        if self.again is not None:
            found.append(Finding(details=HeaderAgain(line=self.again), severity="info"))
        if read.hidden and (stop is None or read.first_hidden < stop):
            hidden = HiddenRows(line=read.first_hidden, count=read.hidden)
            found.append(Finding(details=hidden, severity="error"))
        if read.remarks and (stop is None or read.first_remark < stop):
            found.append(Finding(details=Comments(line=read.first_remark, count=read.remarks), severity="info"))
        return tuple(found)
