"""Samples of a live log: lines of text as they arrive, see `sigmatau.io.follow`.

The layout is detected from the first lines, as in a whole file. A line that cannot be read is skipped and counted, because
one bad byte on a serial line should not end a night's record. Nothing replaces it.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import formats
from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.rates import RateChange
from sigmatau.hints import RATE
from sigmatau.io.live_lines import (
    find_named_layout,
    has_repeated_rows,
    not_loaded,
    refuse_kinds,
    split_lines,
    without_absurd,
    without_repeats,
)
from sigmatau.io.read.columns import ColumnChoice
from sigmatau.io.read.formats import lvm
from sigmatau.io.read.formats.keyed_records import in_words
from sigmatau.io.read.formats.layout import Layout, find_layout
from sigmatau.io.read.formats.text_lines import NoRowsError
from sigmatau.io.read.formats.text_rows import Text, read_rows
from sigmatau.io.read.interleaving import find_interleaving
from sigmatau.io.read.options import Options
from sigmatau.io.read.resolve import resolve
from sigmatau.io.read.table import HEAD, Table
from sigmatau.io.read.table_streams import find_rate
from sigmatau.io.read.time.clock_line import rate_change
from sigmatau.io.read.time.dates import is_date
from sigmatau.io.read.time.stamps import rate_changed
from sigmatau.record.record import stream_name
from sigmatau.record.sampling import GIVEN_RATE, RateSource

_FIRST_ROWS = 4096  # number of rows to test whether several sensors take turns: 16 parts of 256
_FIRST_LINES = 50  # number of lines needed to detect the layout and the rate
_LONGEST_LINE = 1 << 20  # longest line [bytes]

_PRINTABLE = bytes([*b"\t\n\r\f", *range(32, 256)])
_MANY_BAD = 16  # a piece with more bad lines is read line by line
_MAX_BLOCKS = 4096  # largest number of mean intervals in memory
_GAP = 20  # interval between stamps that is a gap, as in `sigmatau.io.read.time.stamps` [sample intervals]


@dataclass(slots=True)
class Live:
    """Converts lines to samples."""

    options: Options  # Options of the user about the columns
    skip: int = 0  # Lines to skip at the beginning
    rate: float = 0.0  # Sampling rate; 0 until the layout is known. [Hz]
    source_of_rate: RateSource = GIVEN_RATE
    unit: dict[str, str] = field(default_factory=dict)  # Unit by channel, as spelled
    lost: int = 0  # Lines that could not be read
    lost_example: str = ""  # Reason why the last of these lines could not be read
    lines: int = 0  # Lines of data that were read
    repeated: int = 0  # Lines that repeat the line before, with its stamp
    leaps: int = 0  # Intervals between stamps that are negative or longer than 20 sample intervals
    _rest: bytes = b""
    _marks: bool = False  # whether names and delimiters separate the values
    _lines_needed: int = _FIRST_LINES  # lines needed before the layout is looked for
    _layout: Layout | None = None
    _choice: ColumnChoice | None = None
    _intervals: tuple[int, float] = (0, 0.0)
    _last_stamp: float | None = None
    _repeats: bool = False  # Whether lines with the stamp of the line before are skipped
    _last_row: NDArray[np.float64] | None = None
    # stamps and samples of the first rows; None once they are checked
    _first_rows: list[NDArray[np.float64]] | None = field(default_factory=list)
    _blocks: list[float] = field(default_factory=list)  # mean intervals of blocks of lines [s]
    _block: int = 16
    _pending: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))

    @property
    def channels(self) -> tuple[str, ...]:
        """Channels in the order of the columns of `push`; empty until the layout is known."""
        return () if self._choice is None else tuple(self._choice.channels)

    def rate_by_stamps(self) -> float | None:
        """Rate from the intervals between stamps of consecutive lines, if the stamps have a unit; gaps are left out. [Hz]"""
        count, total = self._intervals
        return count / total if count > 1 and total > 0 else None

    def rate_change(self) -> Finding | None:
        """A finding about an abrupt change of the rate, from the stamps."""
        blocks = np.array(self._blocks)
        change = rate_change(blocks)
        if change is None:
            return None
        place, before, after = change
        details = RateChange(before=1 / before, after=1 / after, grid=self.rate)
        times = self._block * np.cumsum(blocks)
        return rate_changed(time=float(times[place - 1]), end=float(times[-1]), details=details, empty=False)

    def push(self, piece: bytes, *, last: bool = False) -> NDArray[np.float64]:
        """Rates or increments in the given unit, shape (n, n_channels), of the lines that `piece` completes.

        n is 0 until there are enough lines to detect the layout. `last`: whether this is the last piece.
        """
        self._rest += piece
        while self.skip and b"\n" in self._rest:
            self._rest = self._rest.partition(b"\n")[2]
            self.skip -= 1
        if self.skip and not last:
            return np.empty((0, 0))
        end = len(self._rest) if last else self._rest.rfind(b"\n") + 1
        if self._layout is None:
            head = self._rest[:end]
            if not last and head.count(b"\n") < self._lines_needed and len(self._rest) < HEAD:
                return np.empty((0, 0))
            wait = not last and len(self._rest) < HEAD
            body = self._detect_layout(head, wait=wait)
            if body is None:
                return np.empty((0, 0))
            self._rest = body + self._rest[end:]
            end = len(self._rest) if last else self._rest.rfind(b"\n") + 1
        lines, self._rest = self._rest[:end], self._rest[end:]
        lines = in_words(lines) if self._marks else lines
        if len(self._rest) > _LONGEST_LINE:
            raise DataError("a line is longer than 1 MiB, so this is not a table of numbers")
        return self._numbers(lines, last=last)

    def _detect_layout(self, head: bytes, *, wait: bool) -> bytes | None:
        """Detect layout, columns, units and rate from the first lines; later lines are data.

        `wait`: return None if there are too few rows yet, because a device may print lines of text before its samples.
        """
        # A line with a bad byte is skipped.
        if head.startswith((b"\x93NUMPY", b"\x1f\x8b", b"PK\x03\x04")) or len(
            head.translate(None, _PRINTABLE)
        ) > 0.01 * len(head):
            raise DataError("is binary data, not a table of text")
        if head.removeprefix(b"\xef\xbb\xbf").startswith(lvm.MARK):
            raise DataError("is a LabVIEW measurement file, which watch does not read: run sigmatau analyze FILE")
        named = find_named_layout(head)
        if named is not None:
            self._marks = True
            head = in_words(head)
        try:
            layout = find_layout(head, whole=True) if named is None else named
        except NoRowsError:
            if wait:
                self._lines_needed = head.count(b"\n") + _FIRST_LINES
                return None
            raise
        if wait and head.count(b"\n") < layout.skip_lines + _FIRST_LINES:
            self._lines_needed = layout.skip_lines + _FIRST_LINES
            return None
        # Always the same lines, so that the result does not depend on how the input arrives.
        refuse_kinds(b"".join(split_lines(head)[: layout.skip_lines + _FIRST_LINES]))
        table = Table(
            format="text",
            columns=layout.columns,
            notes=(),
            load=not_loaded,
            where=lambda row: f"row {row} of the data",
        )
        try:
            choice, unit, _ = resolve(table, self.options)
        except OptionError:
            # The question may show values of the samples that have arrived; nothing else depends on their number.
            with contextlib.suppress(DataError):
                text = Text(source=head, layout=layout, encoding="ascii", gzip=False, dates={})
                resolve(replace(table, load=text.load), self.options)
            raise
        self.options = self.options.for_streams(tuple(dict.fromkeys(map(stream_name, choice.channels))))
        if choice.time is not None and (choice.split or is_date(table.columns[choice.time].first)):
            if self.options.rate is None:
                what = "has seconds and their fractions in two columns" if choice.split else "has dates or clock times"
                raise OptionError(
                    f"column {table.label(choice.time)} {what}, which watch does not read: give {RATE}",
                    option="rate",
                )
            choice = replace(choice, time=None, split=None)  # lines are read as plain numbers here
        self._layout, self._choice, self.unit = layout, choice, unit
        body = b"".join(split_lines(head)[layout.skip_lines :])
        stamps, bad = np.empty(0), list[str]()
        if choice.time is not None:
            time_place = self._wanted_columns().index(choice.time)
            # Always the same lines: the rate must not depend on how the input arrives.
            good, bad = self._good_columns(b"".join(split_lines(body)[:_FIRST_LINES]))
            good = [part for columns in good for part in without_absurd(columns, bad)]
            self._repeats = has_repeated_rows(good, time_place)
            good = [without_repeats(columns, None) if self._repeats else columns for columns in good]
            stamps = np.concatenate([stamps, *(columns[time_place] for columns in good)])
            if len(stamps) < 3 and self.options.rate is None:
                raise OptionError(f"has too few time stamps to show the rate. Give {RATE}", option="rate")
        if len(stamps) < 3:  # nothing to check
            choice = replace(choice, time=None)
        self.rate, self.source_of_rate, counted = find_rate(table, choice, stamps, unit.get("time"), self.options)
        if choice.time is not None and self.options.rate is None and bad and not counted:
            # Further samples replace the lines that could not be read.
            self.rate *= (len(stamps) - 1 + len(bad)) / (len(stamps) - 1)
        return body

    def _wanted_columns(self) -> tuple[int, ...]:
        assert self._choice is not None
        time = () if self._choice.time is None else (self._choice.time,)
        return tuple(dict.fromkeys((*self._choice.channels.values(), *time)))

    def _good_columns(self, lines: bytes) -> tuple[list[list[NDArray[np.float64]]], list[str]]:
        """Columns of the stretches between unreadable lines, and the reasons why those cannot be read."""
        good: list[list[NDArray[np.float64]]] = []
        bad: list[str] = []
        while lines.strip() and len(bad) < _MANY_BAD:
            try:
                good.append(self._parse(lines))
            except formats.TextReadError as error:
                if error.kind == "empty":
                    return good, bad
                until = max(error.line, 1)
                bad.append(error.text or f"{error.got} fields in place of {error.expected}")
            else:
                return good, bad
            split = split_lines(lines)
            before = b"".join(split[: until - 1])
            if before.strip():
                good.append(self._parse(before))
            lines = b"".join(split[until:])
        for line in split_lines(lines):
            try:
                good.append(self._parse(line))
            except formats.TextReadError as error:
                if error.kind != "empty":
                    bad.append(error.text or f"{error.got} fields in place of {error.expected}")
        return good, bad

    def _parse(self, lines: bytes) -> list[NDArray[np.float64]]:
        assert self._layout is not None
        return read_rows(lines, self._layout, self._wanted_columns()).columns

    def _numbers(self, lines: bytes, *, last: bool) -> NDArray[np.float64]:
        assert self._choice is not None
        good, bad = self._good_columns(lines)
        good = [part for columns in good for part in without_absurd(columns, bad)]
        self.lost += len(bad)
        self.lost_example = bad[-1] if bad else self.lost_example
        good = self._skip_repeats(good) if self._repeats else good
        wanted = self._wanted_columns()
        place_by_column = {index: k for k, index in enumerate(wanted)}
        channels = self._choice.channels
        rows = [np.stack([columns[place_by_column[index]] for index in channels.values()], axis=1) for columns in good]
        samples = np.concatenate(rows) if rows else np.empty((0, len(channels)))
        if self._choice.time is not None and "time" in self.unit:
            self._note_stamps([columns[place_by_column[self._choice.time]] for columns in good], broken=bool(bad))
        self.lines += len(samples)
        if self._first_rows is not None and self.options.interleaved is None:
            stamps = (
                [] if self._choice.time is None else [columns[place_by_column[self._choice.time]] for columns in good]
            )
            first = np.concatenate(stamps) if stamps else np.zeros(len(samples))
            self._first_rows.append(np.column_stack((first, samples)))
            if last or sum(map(len, self._first_rows)) >= _FIRST_ROWS:
                self._refuse_interleaved()
        for k, channel in enumerate(channels):
            stream = channel.split("_")[0]
            offset = self.options.offset.get(channel, self.options.offset.get(stream, 0.0))
            scale = self.options.scale.get(channel, self.options.scale.get(stream, 1.0))
            samples[:, k] = (samples[:, k] - offset) * scale
        return samples

    def _refuse_interleaved(self) -> None:
        """Raise `OptionError` if the first rows are, or may be, those of several sensors that take turns."""
        assert self._choice is not None
        assert self._layout is not None
        rows = np.concatenate(self._first_rows or [])[:_FIRST_ROWS]  # always the same rows, however the input arrives
        self._first_rows = None
        axes = {name: rows[:, k] for k, name in enumerate(self.channels, 1) if name.startswith(("gyro", "accel"))}
        interleaving = find_interleaving(axes, None if self._choice.time is None else rows[:, 0])
        if interleaving is not None:
            index = self._choice.channels[interleaving.channel]
            raise interleaving.error_of_live(repr(self._layout.columns[index].name or index + 1))

    def _skip_repeats(self, good: list[list[NDArray[np.float64]]]) -> list[list[NDArray[np.float64]]]:
        """Remove lines that repeat the line before from the stretches."""
        stretches = []
        for columns in good:
            different = without_repeats(columns, self._last_row)
            self.repeated += len(columns[0]) - len(different[0])
            self._last_row = np.array([column[-1] for column in columns]) if len(columns[0]) else self._last_row
            stretches += [different] if len(different[0]) else []
        return stretches

    def _note_stamps(self, stretches: list[NDArray[np.float64]], *, broken: bool) -> None:
        """Note the intervals within stretches, but not those across a lost line."""
        from sigmatau.units import find

        second = find(self.unit["time"]).factor * float(self.options.scale.get("time", 1.0))
        last = None if broken else self._last_stamp
        for stretch in stretches:
            stamps = stretch * second if last is None else np.concatenate([[last], stretch * second])
            intervals = np.diff(stamps)
            even = (intervals >= 0) & (intervals * self.rate <= _GAP)
            self.leaps += int(np.count_nonzero(~even))
            count, total = self._intervals
            self._note_blocks(intervals[even])
            self._intervals = count + int(np.count_nonzero(even)), total + float(intervals[even].sum())
            last = None
        if stretches:
            self._last_stamp = float(stretches[-1][-1]) * second

    def _note_blocks(self, intervals: NDArray[np.float64]) -> None:
        """Note the mean intervals of blocks. If there are too many blocks, blocks of twice as many lines replace them."""
        held = np.concatenate((self._pending, intervals))
        whole = len(held) // self._block * self._block
        self._blocks += held[:whole].reshape(-1, self._block).mean(axis=1).tolist()
        self._pending = held[whole:]
        while len(self._blocks) > _MAX_BLOCKS:
            if len(self._blocks) % 2:
                self._pending = np.concatenate((np.full(self._block, self._blocks.pop()), self._pending))
            self._blocks = np.array(self._blocks).reshape(-1, 2).mean(axis=1).tolist()
            self._block *= 2
