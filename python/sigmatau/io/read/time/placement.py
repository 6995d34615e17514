"""Columns on the grid of their stamps: rows of each stream, missing samples, and the findings about them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import NonFiniteError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.stamps import EmptyChannel
from sigmatau.record.missing import missing_values

__all__ = ["laid", "missing_in", "mostly_missing", "own_rows", "with_missing"]

_MOST_EMPTY = 0.5  # share of empty rows above which a column is not used
_LEAST_OTHER_ROWS = 0.15  # share of empty rows from which on a stream may have separate rows
_FILLED_BY_OTHERS = 0.95  # share of these empty rows that other streams must fill


def with_missing(raw: Mapping[int, NDArray[Any]], indices: Sequence[int]) -> set[int]:
    """The columns that contain a NaN."""
    doubles = [i for i in indices if raw[i].dtype == np.float64 and raw[i].flags.c_contiguous]
    found = dict(zip(doubles, kernels.all_finite([raw[i] for i in doubles]), strict=True)) if doubles else {}
    with np.errstate(over="ignore", invalid="ignore"):
        return {
            i
            for i in indices
            if not found.get(i, False) and raw[i].dtype.kind == "f" and bool(np.isnan(np.sum(raw[i], dtype=np.float64)))
        }


def own_rows(
    raw: Mapping[int, NDArray[Any]], by_stream: Mapping[str, Sequence[int]], missing: set[int]
) -> dict[str, NDArray[np.int64]]:
    """Rows of each stream that fills only part of the rows, where other streams fill the rest.

    Logging programs that write a row for each sample of any sensor make such tables. Streams that fill (nearly) all rows are
    not in the result.
    """
    empty: dict[str, NDArray[np.bool_]] = {}
    for name, indices in by_stream.items():
        if indices and all(i in missing for i in indices):
            nothing = np.isnan(raw[indices[0]])
            for i in indices[1:]:
                nothing &= np.isnan(raw[i])
            empty[name] = nothing
    found: dict[str, NDArray[np.int64]] = {}
    for name, nothing in empty.items():
        share = np.count_nonzero(nothing) / len(nothing)
        if share < _LEAST_OTHER_ROWS or share == 1:
            continue
        filled = np.zeros(len(nothing), dtype=bool)
        for other in by_stream:
            if other != name:
                filled |= ~empty[other] if other in empty else True
        if np.count_nonzero(filled & nothing) >= _FILLED_BY_OTHERS * np.count_nonzero(nothing):
            found[name] = np.flatnonzero(~nothing)
    return found


def mostly_missing(
    raw: Mapping[int, NDArray[Any]],
    by_stream: Mapping[str, Mapping[str, int]],
    missing: set[int],
    own: Mapping[str, NDArray[np.int64]],
    where: Callable[[int], str],
    label: Callable[[int], str],
    *,
    timed: bool,
) -> dict[str, Finding]:
    """Findings about channels that are empty in more than half of the rows of their stream.

    `where, label`: places of rows and names of columns, for the messages; `timed`: whether the rows have time stamps;
    without them, the times of streams with separate rows are unknown.
    """
    found: dict[str, Finding] = {}
    refused: NonFiniteError | None = None
    others_rows = False
    for stream, columns in by_stream.items():
        rows = own.get(stream) if timed else None
        kept = False
        for channel, index in columns.items():
            bad = np.isnan(raw[index] if rows is None else raw[index][rows]) if index in missing else np.zeros(1, bool)
            count, total = int(np.count_nonzero(bad)), len(bad)
            if count <= _MOST_EMPTY * total:
                kept = True
                continue
            at = int(np.argmax(bad))
            first = at if rows is None else int(rows[at])
            refused = refused or NonFiniteError(
                f", {where(first)}: column {label(index)} has no number there, nor in {count - 1} other rows of {total};"
                " leave it out by naming the other channels in --channels; if its sensor has rows of its own, name their"
                " time stamps with --channels time=…",
                channel=channel,
                index=first,
            )
            details = EmptyChannel(column=label(index), count=count, rows=total, place=where(first))
            found[channel] = Finding(details=details, severity="error", channels=(channel,), size=count / total)
        others_rows |= kept and not timed and stream in own
    if refused is not None and (others_rows or len(found) == sum(map(len, by_stream.values()))):
        raise refused
    return found


def laid(
    column: NDArray[Any], rows: NDArray[np.int64] | None, places: NDArray[np.int64] | None, n: int | None
) -> NDArray[Any]:
    """A column on its grid, NaN in empty places; the array itself if nothing changes."""
    if rows is not None:
        column = column[rows]
    if places is None or n is None:
        return column
    grid = np.full(n, np.nan)
    grid[places] = column
    return grid


def missing_in(
    raw: Mapping[int, NDArray[Any]],
    channels: Mapping[str, int],
    missing: set[int],
    used: Mapping[int, NDArray[np.int64]],
    where: Callable[[int], str],
    tau0: float,
) -> tuple[Finding, ...]:
    """A finding about missing numbers in the rows in use; `tau0` is the time from row to row."""
    said: dict[str, NDArray[np.bool_]] = {}
    for channel, index in channels.items():
        if index not in missing:
            continue
        bad = np.isnan(raw[index])
        if index in used:
            inside = np.zeros(len(bad), dtype=bool)
            inside[used[index]] = True
            bad &= inside
        said[channel] = bad
    of = {channel: len(used[channels[channel]]) for channel in said if channels[channel] in used}
    return missing_values(said, where, tau0, of=of)
