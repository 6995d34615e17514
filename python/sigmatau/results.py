"""Shared by all results: notebook display, mappings by channel, number formats."""

from __future__ import annotations

import io
import math
import re
import textwrap
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any, ClassVar, TypeVar, cast

from sigmatau.errors import printable as printable  # defined in errors.py, which uses it and cannot import this module


class Printed:
    """A result whose notebook display is its printed form."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(repr(self))}</pre>"


class Plain:
    """A dataclass whose JSON form has its fields, by their names."""

    __slots__ = ()

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, *(field.name for field in fields(cast("Any", self))))


class Tabular(Printed):
    """A result that is a table: for a data frame, for CSV, and for a notebook."""

    __slots__ = ()

    _dimensions: ClassVar[tuple[str, ...]] = ()  # columns that distinguish the rows

    def columns(self) -> dict[str, list[Any]]:
        """The table by column, for any data-frame library: ``polars.DataFrame(result.columns())``. Numbers are in SI."""
        raise NotImplementedError

    def to_dataframe(self) -> Any:  # noqa: ANN401  pandas is optional
        """The table as a data frame of pandas.

        Raises
        ------
        ImportError
            Without pandas; use `columns` with other libraries.
        """
        try:
            import pandas as pd
        except ImportError:
            raise ImportError(
                "a data frame needs pandas: pip install pandas; or any other library with .columns(),"
                " e.g. polars.DataFrame(result.columns())"
            ) from None
        return pd.DataFrame(self.columns())

    def to_xarray(self) -> Any:  # noqa: ANN401  xarray is optional
        """The table as a Dataset of xarray, in SI: curves by channel and averaging time, coefficients by channel and term.

        Cells that a table does not have are missing values. Other tables have the dimension ``row``.

        Raises
        ------
        ImportError
            Without xarray.
        """
        try:
            import xarray as xr
        except ImportError:
            raise ImportError("a dataset needs xarray: pip install xarray") from None
        frame = self.to_dataframe()
        dimensions = list(self._dimensions)
        if dimensions and {*dimensions} <= {*frame.columns} and not frame.duplicated(dimensions).any():
            dataset = xr.Dataset.from_dataframe(frame.set_index(dimensions))  # sorted by channel and term
            texts = [name for name in dimensions if frame[name].dtype.kind not in "iuf"]
            return dataset.reindex({name: frame[name].unique() for name in texts})
        return xr.Dataset.from_dataframe(frame.rename_axis("row"))

    def _repr_html_(self) -> str:
        columns = self.columns()
        rows = list(zip(*columns.values(), strict=True))
        hidden = "" if len(rows) <= _HTML_ROWS else f"<p>… {len(rows) - _HTML_ROWS} more rows</p>"
        return html_table([tuple(columns), *(tuple(map(_cell, row)) for row in rows[:_HTML_ROWS])]) + hidden


_HTML_ROWS = 40


def html_table(rows: Sequence[Sequence[str]], *, ready: Container[int] = ()) -> str:
    """Rows of text as a table for a notebook, the first row as its head; columns in `ready` are HTML already."""
    from html import escape

    def line(row: Sequence[str], tag: str) -> str:
        cells = (text if k in ready else escape(text) for k, text in enumerate(row))
        return f"<tr>{''.join(f'<{tag} style=text-align:left>{cell}</{tag}>' for cell in cells)}</tr>"

    return f"<table>{line(rows[0], 'th')}{''.join(line(row, 'td') for row in rows[1:])}</table>"


def aligned(rows: Sequence[Sequence[str]], *, right: Container[int] = ()) -> list[str]:
    """Rows of text in columns of one width; the columns in `right` are flush right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = []
    for row in rows:
        cells = (
            text.rjust(w) if k in right else text.ljust(w) for k, (text, w) in enumerate(zip(row, widths, strict=True))
        )
        lines.append("  ".join(cells).rstrip())
    return lines


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return "" if value is None else str(value)


def csv_text(columns: Mapping[str, Sequence[object]], *, decimal_comma: bool = False) -> str:
    """A table as CSV: numbers with all digits, nothing for None.

    Text that a spreadsheet would take for a formula gets an apostrophe in front. With a decimal comma the separator is a
    semicolon.
    """
    import csv

    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n", delimiter=";" if decimal_comma else ",")
    writer.writerow(columns)
    writer.writerows(
        [_csv_cell(value, decimal_comma=decimal_comma) for value in row] for row in zip(*columns.values(), strict=True)
    )
    return out.getvalue()


def _csv_cell(value: object, *, decimal_comma: bool) -> object:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(_FORMULA_BEGINS) else value
    if decimal_comma and isinstance(value, float):
        return str(value).replace(".", ",")
    return value


ASCII = {
    "√Hz": "sqrt(Hz)",
    "√h": "sqrt(h)",
    "√s": "sqrt(s)",
    "√": "sqrt ",
    "µ": "u",
    "²": "^2",
    "³": "^3",
    "·": "*",
    "τ": "tau",
    "σ": "sigma",
    "χ": "chi",
    "±": "+-",
    "é": "e",
    "×": "x",
    "…": "...",
    "°": "deg",
}
"""Symbols of messages and tables in ASCII, the longer ones first."""

WIDTH = 80
"""Columns of a terminal, which printed forms do not exceed."""

_FORMULA_BEGINS = ("=", "+", "-", "@", "\t", "\r")  # of text that a spreadsheet takes for a formula
_OPTION = re.compile(r"--[a-z]+(?:-[a-z]+)+")
_HYPHEN = "\u2011"  # hyphen at which textwrap does not break


def wrapped(lines: Iterable[str], *, indent: int = 2, width: int = WIDTH) -> list[str]:
    """Wrap lines to at most `width` columns, with continuation lines indented. Names of options are not broken."""
    whole = (_OPTION.sub(lambda name: name[0].replace("-", _HYPHEN), line) for line in lines)
    parts = [part for line in whole for part in textwrap.wrap(line, width, subsequent_indent=" " * indent) or [""]]
    return [part.replace(_HYPHEN, "-") for part in parts]


T = TypeVar("T")


class ByChannel(Mapping[str, T], Printed):
    """Results by channel: an immutable mapping in the record's order."""

    __slots__ = ("_by_channel",)

    def __init__(self, by_channel: Mapping[str, T]) -> None:
        self._by_channel = dict(by_channel)

    def __getitem__(self, channel: str) -> T:
        try:
            return self._by_channel[channel]
        except KeyError:
            raise KeyError(f"no channel {channel!r}; channels: {', '.join(self._by_channel)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._by_channel)

    def __len__(self) -> int:
        return len(self._by_channel)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self._by_channel.values()))


class TablesByChannel(ByChannel[T], Tabular):
    """Tables by channel, which `columns` joins."""

    __slots__ = ()

    def columns(self) -> dict[str, list[Any]]:
        """The rows of all channels, see `Tabular.columns`."""
        tables = [cast(Tabular, result).columns() for result in self.values()]
        return {name: [value for table in tables for value in table[name]] for name in (tables[0] if tables else ())}


def plain(result: object, *names: str, **values: object) -> dict[str, Any]:
    """Attributes of a result as JSON values, then `values`. `names` are ``"name"`` or ``"key=attribute"``, separated by
    blanks.

    Examples
    --------
    >>> plain(1 + 2j, "real im=imag", sides=("left", "right"))
    {'real': 1.0, 'im': 2.0, 'sides': ['left', 'right']}
    """
    attributes = {name.partition("=")[0]: getattr(result, name.rpartition("=")[2]) for name in " ".join(names).split()}
    return {key: plain_value(value) for key, value in (attributes | values).items()}


def plain_value(value: Any) -> Any:  # noqa: ANN401
    """A value as in JSON: mappings and dataclasses as dictionaries, tuples as lists, no NaN or infinity."""
    if isinstance(value, Mapping):
        return {str(key): plain_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if convert := getattr(value, "to_dict", None) or getattr(value, "tolist", None):
        return convert()
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain_value(getattr(value, field.name)) for field in fields(value)}
    return value


SERIAL_NOTES = ("serial number", "serial", "unit", "device", "sn")
"""Notes of `analyze` that name the unit; the first existing one is used."""


def noted_unit(notes: Mapping[str, str]) -> str:
    """The unit that the notes of a result name; empty if none does."""
    by_key = {key.strip().lower(): text for key, text in notes.items()}
    return next((by_key[key] for key in SERIAL_NOTES if by_key.get(key)), "")


def lines_text(lines: Iterable[str]) -> str:
    """Lines of a printed form, each as `printable` returns it: names from files do not add lines."""
    return "\n".join(map(printable, lines))


def seconds(value: float) -> str:
    """A time with three significant digits and no exponent.

    Examples
    --------
    >>> seconds(0.01), seconds(40.96), seconds(1310.7)
    ('0.01', '41', '1311')
    """
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def option_seconds(value: float) -> str:
    """A time for an option of the command line, rounded up to three digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - 2)
    return f"{math.ceil(value / step * (1 - 1e-9)) * step:.12g}"


def duration_text(seconds_: float) -> str:
    """A length of time in a suitable unit, with two or three digits.

    Examples
    --------
    >>> duration_text(40), duration_text(7200)
    ('40 s', '2 h')
    """
    for unit, size, smallest in (
        ("years", 31557600.0, 3.0),
        ("d", 86400.0, 10.0),
        ("h", 3600.0, 1.0),
        ("min", 60.0, 2.0),
    ):
        if seconds_ >= smallest * size:
            amount = seconds_ / size
            return f"{amount:.0f} {unit}" if amount >= 10 else f"{amount:.2g} {unit}"
    return f"{seconds(seconds_)} s"
