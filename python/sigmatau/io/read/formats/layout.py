"""The layout of a text table, detected from its beginning: delimiter, first row, names, units."""

from __future__ import annotations

import math
import re

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.formats.text_delimiter import (
    HEADERS,
    exchange_decimal_commas,
    find_delimiter,
    find_names,
    names_in,
    names_something,
    refuse_other_delimiters,
    refuse_split_numbers,
)
from sigmatau.io.read.formats.text_lines import (
    ARROW,
    DELIMITERS,
    EXCHANGED,
    LINES,
    Line,
    NoRowsError,
    decode,
    is_number,
    kibibytes,
    numbers_in_line,
    split_lines,
    without_arrows,
)
from sigmatau.io.read.formats.text_programs import (
    SAMPLE_TIME,
    StatedRate,
    counts_per_second,
    find_rate,
    units_of_mt_manager,
)
from sigmatau.io.read.table import FORMATS, Column

_MAX_TRANSPOSED_ROWS = 16  # largest number of rows of a table that has one row per channel
_MIN_TRANSPOSED_COLUMNS = 512  # smallest number of columns of such a table; no log of a sensor has as many
_COMPARED_FIRST = 50  # number of rows that usually show that a first row is not odd
_MIN_SAMPLES = 100  # number of rows that must follow an odd first row
# distance of a number from the range of its column, in units of that range, beyond which it is not a sample
_OUTLYING = 10
_HEAD_OF_RESULT = 100  # beginning of a JSON of sigmatau that contains its version [characters]
_SENTENCE = re.compile(r"\$[A-Z]{3,},[^*]*\*[0-9A-Fa-f]{2}")  # sentence of NMEA 0183
_SEPARATOR = re.compile(r'"?sep=.{1,3}$', re.IGNORECASE)  # line that states the delimiter for Excel


@frozen
class Layout:
    """The layout of a text table."""

    delimiter: str | None  # One character; None for runs of spaces and tabs
    skip_lines: int  # Lines before the data
    columns: tuple[Column, ...]
    notes: tuple[str, ...]  # Properties of the table, for the provenance of the record
    decimal_comma: bool = False  # Whether 0,5 is one half
    arrow: bool = False  # Whether ``15:00:00.010 ->`` precedes each row; that clock becomes the last column
    rate: StatedRate | None = None  # Rate that a line above the table states
    last: int = 0  # Number of the last line that was searched
    # Rate of the counter in the column SampleTimeFine, if the stated rate confirms it
    counts_per_second: int | None = None

    def fits(self, line: str) -> bool:
        """Whether a line has as many fields as a row of this layout, or is blank."""
        text = line.translate(EXCHANGED) if self.decimal_comma else line
        columns = len(self.columns) - self.arrow
        text = ARROW.sub("", text) if self.arrow else text
        fields = Line(0, text.strip() if self.delimiter != "\t" else text, comment=False).split(self.delimiter)
        return not text.strip() or len(fields) == columns or (len(fields) == columns + 1 and not fields[-1])

    def has_same_rows(self, layout: Layout) -> bool:
        """Whether another layout has the same delimiter and the same number of columns."""
        return (self.delimiter, len(self.columns)) == (layout.delimiter, len(layout.columns))


def find_layout(data: bytes, *, whole: bool, encoding: str = "", skip: int = 0) -> Layout:
    """The layout of the table that begins with `data`. `data`: beginning of the file after the skipped lines,
    decompressed; `whole`: true if the file ends there; else the last line is ignored; `encoding`: encoding of the file,
    if it differs from that of `data`; for the notes; `skip`: lines before `data`.
    """
    text, read_as = decode(data, whole=whole)
    written = f", {encoding}" if encoding else read_as
    lines, arrow = without_arrows(split_lines(text, skip))
    rows = [line for line in lines if not line.comment]
    if not rows:
        if not data and not skip:
            raise DataError("is empty: no line has arrived")
        what = "comments and blank lines" if lines else "blank lines"
        if whole and text.count("\n") < LINES:
            raise DataError(f"has only {what}")
        raise NoRowsError(
            f"has only {what} in its first {kibibytes(data)} KiB", last=skip + min(text.count("\n"), LINES)
        )
    if rows[0].text.startswith("{") and '"sigmatau":' in text[:_HEAD_OF_RESULT]:
        raise DataError("is a result of sigmatau, not a log; sigmatau export, compare, plan and predict read it")
    if rows[0].text.startswith(("{", "<")):
        raise DataError(f"is JSON or XML, not a format that is read: {FORMATS}")
    _refuse_sentences(rows)
    if whole and len(rows) == 1 and len(rows[0].text) > 1000:
        error = numbers_in_line(rows[0].text.encode(), "the only line")
        if error is not None:
            raise error
    _refuse_transposed(rows)
    decimal_comma = exchange_decimal_commas(rows)
    delimiter, columns = find_delimiter(rows, lines)
    data_rows = [line for line in rows if line.is_data(delimiter, columns)]
    first, skipped = _first_sample(rows, data_rows, delimiter, columns)
    if delimiter == ",":
        refuse_split_numbers(rows, first, columns)
    before = [line for line in lines if line.number < first.number and line not in skipped]
    refuse_other_delimiters(first, delimiter)
    names, units, header, layout_notes = find_names(before, delimiter, columns)
    _refuse_cut_rows(before, header, first, delimiter, columns)

    kind = f"{DELIMITERS[delimiter]}-separated" if columns > 1 else "one column of"
    commas = " with decimal commas" if decimal_comma else ""
    notes = [
        f"{kind} text{commas}, {'no header' if header is None else f'header on line {header}'}{written}",
        *layout_notes,
        *_note_above(rows, header),
        *(("time of day before -> on each line, read as column clock",) if arrow else ()),
        *(f"line {line.number} skipped: its numbers are not those of a sample" for line in skipped),
    ]
    above = [(line.number, line.text) for line in before]
    rate = find_rate(above)
    units_by_manual = units_of_mt_manager(above, names, units)
    if units_by_manual != tuple(units):
        notes.append("units of acceleration and angular rate by the manual of MT Manager")
    fine = [k for k, name in enumerate(names) if name.lower() == SAMPLE_TIME]
    counts = [row.values(delimiter)[fine[0]] for row in data_rows] if fine and rate else []
    return Layout(
        delimiter=delimiter,
        rate=rate,
        last=lines[-1].number,
        counts_per_second=counts_per_second(counts, rate.rate) if rate else None,
        skip_lines=first.number - 1,
        columns=tuple(
            Column(name=n, unit=u, first=f)
            for n, u, f in zip(names, units_by_manual, first.split(delimiter)[:columns], strict=True)
        )
        + ((Column(name="clock", first=first.clock),) if arrow else ()),
        notes=tuple(notes),
        decimal_comma=decimal_comma,
        arrow=arrow,
    )


def _note_above(rows: list[Line], header: int | None) -> list[str]:
    """A note of the lines of text above the header; nothing if there are none."""
    above = [row for row in rows if header is not None and row.number < header and not _SEPARATOR.match(row.text)]
    if not above:
        return []
    count = f"{len(above)} lines" if len(above) > 1 else "1 line"
    return [f"{count} of text above the header skipped, from line {above[0].number}"]


def _refuse_sentences(rows: list[Line]) -> None:
    sentences = [row for row in rows if row.text.startswith("$") and _SENTENCE.match(row.text)]
    if 2 * len(sentences) > len(rows):
        name = sentences[0].text.split(",")[0]
        raise DataError(
            f"sentences like {name} (NMEA style, with checksums) are not read yet;"
            " cut the columns of numbers out, e.g. by cut -d, -f…",
            place=f"line {sentences[0].number}",
        )


def _refuse_transposed(rows: list[Line]) -> None:
    """Raise `DataError` for a table with one row of numbers per channel and one column per sample."""
    if len(rows) > _MAX_TRANSPOSED_ROWS:
        return
    delimiter = max(DELIMITERS, key=lambda d: len(rows[-1].split(d)))
    widths = {len(row.split(delimiter)) for row in rows}
    if len(widths) == 1 and (samples := widths.pop()) > max(_MIN_TRANSPOSED_COLUMNS, 10 * len(rows)):
        options = f", delimiter={delimiter!r}" if delimiter else ""
        if not is_number(rows[0].split(delimiter)[0]):
            options += f", usecols=range(1, {samples})"
        raise DataError(
            f"has {len(rows)} rows of {samples} fields, so a row is a channel; turn the table with python -c"
            f" \"import numpy as n; n.savetxt('rows.csv', n.loadtxt('LOG'{options}).T, delimiter=',')\""
        )


def _first_sample(rows: list[Line], data: list[Line], delimiter: str | None, columns: int) -> tuple[Line, list[Line]]:
    """The first row of samples, and the rows of numbers before it.

    Those rows are above the header, or differ from all later rows, as scales or a position do.
    """
    numbers = {line.number for line in data}
    latest = data[min(HEADERS, len(data) - 1)].number  # a later header is part of the samples
    words = (line for line in rows if line.number <= latest and line.number not in numbers)
    headers = [line for line in words if names_something(names_in(line, delimiter, columns))]
    above = [line for line in data if headers and line.number < headers[-1].number]
    rest = data[len(above) :] or data
    above = above if data[len(above) :] else []
    while len(above) < HEADERS and len(rest) > _MIN_SAMPLES and _is_odd(rest, delimiter, columns):
        above, rest = [*above, rest[0]], rest[1:]
    return rest[0], above


def _is_odd(rows: list[Line], delimiter: str | None, columns: int) -> bool:
    """Whether most numbers of the first row are far outside the range of their columns, or have decimals in columns of
    whole numbers.
    """
    table = [row.values(delimiter)[:columns] for row in rows]
    first, rest = table[0], list(zip(*table[1:], strict=True))
    if not any(first):
        return False  # a row without a sample
    odd = 0
    for value, column in zip(first, rest, strict=True):
        some = [x for x in column[:_COMPARED_FIRST] if math.isfinite(x)]
        if some and min(some) <= value <= max(some) and not all(x.is_integer() for x in some):
            continue  # more rows do not change this
        numbers = [x for x in column if math.isfinite(x)]
        if not numbers or not math.isfinite(value):
            continue
        low, high = min(numbers), max(numbers)
        room = _OUTLYING * (high - low)
        whole = all(x.is_integer() for x in numbers)
        odd += not low - room <= value <= high + room or (whole and not value.is_integer())
    return 2 * odd > columns


def _refuse_cut_rows(before: list[Line], header: int | None, first: Line, delimiter: str | None, columns: int) -> None:
    for line in before:
        fields = line.split(delimiter)
        if line.comment or (header is not None and line.number <= header):
            continue
        if all(map(is_number, fields)):
            raise DataError(
                f"{len(fields)} field{'s' if len(fields) != 1 else ''}, but {columns} on line"
                f" {first.number}; correct or delete the line",
                place=f"line {line.number}",
            )


def header_fields(text: str, layout: Layout) -> list[str]:
    """The names in a comment line among the rows; empty if the line is not a header."""
    columns = len(layout.columns) - layout.arrow
    fields = names_in(Line(0, text, comment=True), layout.delimiter, columns)
    return fields if names_something(fields) else []
