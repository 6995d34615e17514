"""Columns onto the grid of their stamps: which rows are whose, where samples are missing, and what that is called."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.errors import NonFiniteError
from sigmatau.findings.finding import Finding
from sigmatau.record.missing import missing_values

__all__ = ["laid", "missing_in", "mostly_missing", "own_rows", "with_missing"]

_MOSTLY = 0.5  # of the rows: a column that is empty more often holds no samples of this table
_OWN = 0.15  # share of empty rows from which on a sensor has rows of its own, if others fill those
_FILLED = 0.95


def with_missing(raw: Mapping[int, NDArray[Any]], indices: Sequence[int]) -> set[int]:
    """The columns that hold a NaN."""
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
    """Rows of the streams that have rows of their own: the others are filled by another sensor, and empty for this one.

    So do programs write that put a row down whenever any sensor has something. Streams that are in (nearly) all rows are
    not in the answer.
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
        if share < _OWN or share == 1:
            continue
        filled = np.zeros(len(nothing), dtype=bool)
        for other in by_stream:
            if other != name:
                filled |= ~empty[other] if other in empty else True
        if np.count_nonzero(filled & nothing) >= _FILLED * np.count_nonzero(nothing):
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
    """Channels that are empty in more than half of the rows of their stream, each with what is to be said of it.

    Parameters
    ----------
    raw, missing
        See `with_missing`.
    by_stream : mapping of str to mapping of str to int
        Columns by stream and channel.
    own : mapping of str to ndarray of int64
        From `own_rows`.
    where, label : callable
        Places of rows and names of columns, for the messages.
    timed : bool
        Whether the rows have time stamps: if not, streams with rows of their own cannot be told apart in time.

    Raises
    ------
    NonFiniteError
        If no channel is left, or another sensor has the rows that are empty and there are no time stamps.
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
            if count <= _MOSTLY * total:
                kept = True
                continue
            at = int(np.argmax(bad))
            first = at if rows is None else int(rows[at])
            refused = refused or NonFiniteError(
                f", {where(first)}: column {label(index)} has no number there, nor in {count - 1} other rows of {total};"
                " leave it out by naming the other channels in --channels; if its sensor has rows of its own, name their"
                " time stamps by --channels time=…",
                channel=channel,
                index=first,
            )
            found[channel] = Finding(
                code="empty_channel",
                severity="error",
                channel=channel,
                message=(
                    f"column {label(index)} has no number in {count} of {total} rows ({100 * count / total:.3g} %), the"
                    f" first: {where(first)}"
                ),
                where=where(first),
                size=count / total,
                effect="not analysed; the other channels are",
                remedy="check the wiring, the column, the program that writes the log; if its sensor has rows of its own,"
                " name their time stamps by --channels time=…",
            )
        others_rows |= kept and not timed and stream in own
    if refused is not None and (others_rows or len(found) == sum(map(len, by_stream.values()))):
        raise refused
    return found


def laid(
    column: NDArray[Any],
    rows: NDArray[np.int64] | None,
    places: NDArray[np.int64] | None,
    n: int | None,
) -> NDArray[Any]:
    """A column on its grid, NaN in empty places; the array itself if it is so already."""
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
    """One finding about the numbers that are missing in rows that are there; `tau0` is the time from row to row."""
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
