"""Lines among the rows of a text table that begin with the mark of a comment.

Most are remarks. One flipped bit makes one of a row, which is lost then; and where logs are put one after the other, the
header of the next may stand behind a mark and name other columns, or the same ones in another order or unit.
"""

from __future__ import annotations

from dataclasses import dataclass

from sigmatau._native.formats import TextColumns
from sigmatau.findings.finding import Finding
from sigmatau.io.read.formats.layout import Layout, header_fields
from sigmatau.io.read.names import recognise
from sigmatau.io.read.table import Column

__all__ = ["Passed"]

_EXCHANGED = str.maketrans(",.", ".,")


@dataclass(frozen=True, slots=True, kw_only=True)
class Passed:
    """What was passed over among the rows. Lines count from 1.

    Attributes
    ----------
    read : TextColumns
    stop : int or None
        Line of the first header that names other columns than the one in front does: rows after it are not to be had.
    again : int or None
        Line of the first header before that which says the same.
    """

    read: TextColumns
    stop: int | None
    again: int | None

    @classmethod
    def between(cls, read: TextColumns, layout: Layout) -> Passed:
        own = [column.name for column in layout.columns]
        stop = again = None
        for line, text in read.headers:
            # Text with decimal commas comes with commas and points exchanged.
            fields = header_fields(text.translate(_EXCHANGED) if layout.decimal_comma else text, layout)
            if not fields:
                continue
            if fields != own and recognise([Column(name=name) for name in fields]) != recognise(layout.columns):
                stop = line
                break
            again = again or line
        return cls(read=read, stop=stop, again=again)

    def findings(self, rows: int) -> tuple[Finding, ...]:
        """What there is to say of them; `rows` were read."""
        read, stop = self.read, self.stop
        found = []
        if stop is not None:
            message = (
                f"line {stop} is a header that names other columns; {rows} rows were read before it, none after it"
            )
            effect = "split the file there: it holds several logs"
            found.append(Finding(code="second_header", severity="error", message=message, effect=effect))
        if self.again is not None:
            message = f"line {self.again} is a header like the first one: several logs were joined"
            found.append(Finding(code="header_again", severity="info", message=message))
        if read.hidden and (stop is None or read.first_hidden < stop):
            message = (
                f"line {read.first_hidden} begins with a comment mark and else looks like a row of data"
                if read.hidden == 1
                else f"{read.hidden} lines begin with a comment mark and else look like rows of data, the first is line"
                f" {read.first_hidden}"
            )
            effect = "left out, so that samples may be missing there; mend the file, or delete what is no row"
            found.append(Finding(code="hidden_rows", severity="error", message=message, effect=effect))
        if read.remarks and (stop is None or read.first_remark < stop):
            message = f"comments among the rows are passed over: {read.remarks}, the first on line {read.first_remark}"
            found.append(Finding(code="comments", severity="info", message=message))
        return tuple(found)
