"""Selection of a part of a record by time, or of its most stable part.

The paper analyses the best two hours of four. A window chosen for the least scatter of the measured noise underestimates
this noise: for a rate random walk, half of the Allan variance at a quarter of the window is missing
(docs/study/selection.md). The criterion is therefore independent of the noise if possible: the temperature, or the
accelerometers for gyros and the gyros for accelerometers. Their noise is independent, and disturbances of both (motion,
temperature, supply) still show.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from sigmatau.arrays import Floats, median
from sigmatau.errors import OptionError
from sigmatau.findings.disturbances import ChosenWindow, WindowChosen
from sigmatau.findings.finding import Finding, Severity
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import block_means
from sigmatau.quality.selection.time_text import parse_time
from sigmatau.record.record import MIN_SAMPLES, Record
from sigmatau.record.streams import Stream
from sigmatau.results import seconds

_FORMS = "give two times such as 600s:7800s, one such as 10min: or :2h, or most-stable=2h"


# Length of the means that are compared. [s] Judgement: white noise averages out, drifts do not.
_BLOCK = 60.0
# Smallest number of means in a window; the means in a short window are shorter. [1] Judgement: their standard deviation
# then has an error of a quarter.
_MIN_BLOCKS = 10
# Smallest number of blocks in a record by which a window is chosen. [1] Derived: one block has no scatter.
_MIN_RECORD_BLOCKS = 2
# Share of the blocks in a window that may have no mean. [1] Judgement: a window with more is not stable.
_MAX_EMPTY = 0.1


@frozen
class Criterion:
    """Criterion by which the window of a stream is chosen."""

    # smallest range of a temperature; smallest scatter of the other kind of sensor; smallest scatter of the stream itself
    kind: Literal["temperature", "other", "own"]
    stream: Stream  # the stream whose values decide


def choose(record: Record, text: str) -> tuple[Record, list[Finding]]:
    """Cut a record to the part that ``--window`` selects, with the finding ``"window_chosen"`` of `most_stable`.

    Parameters
    ----------
    record : Record
    text : str
        ``"600s:7800s"``, ``"600s:"``, ``":2h"``: times from the beginning of the record; units ms, s, min, h, d.
        ``"most-stable=2h"``: see `most_stable`.

    Raises
    ------
    OptionError
        For any other text, or a window beyond the record.
    """
    length = wanted_length(text)
    return (cut(record, text), []) if length is None else most_stable(record, length)


def wanted_length(text: str) -> float | None:
    """Length in ``"most-stable=2h"`` [s]; None for a text with two times."""
    name, equals, value = text.partition("=")
    if not equals:
        return None
    if name.strip() != "most-stable":
        raise _refused(text, f"is not understood: {_FORMS}")
    length = _time(value, text)
    if not length > 0:
        raise OptionError(f"{{option}} {text!r}: a window must be longer than 0 s; {_FORMS}", option="window")
    return length


def cut(record: Record, text: str) -> Record:
    """The part of a record between two times, ``"600s:7800s"``, from the beginning of its first stream."""
    first, colon, last = text.partition(":")
    if not colon or ":" in last:
        raise _refused(text, f"is not understood: {_FORMS}")
    origin = min(stream.grid.start for stream in record.streams)
    end = max(stream.grid.start + stream.grid.duration for stream in record.streams) - origin
    start = _time(first, text) if first.strip() else 0.0
    stop = _time(last, text) if last.strip() else end
    slack = max(stream.grid.tau0 for stream in record.streams)
    if start >= stop:
        raise _refused(text, f"ends at {seconds(stop)} s, before it begins")
    if stop > end + slack:
        raise _refused(text, f"ends at {seconds(stop)} s; the record is {seconds(end)} s long")
    streams = [_between(stream, start + origin, stop + origin, text) for stream in record.streams]
    return _with_streams(record, streams, f"window from {seconds(start)} s to {seconds(min(stop, end))} s")


def most_stable(record: Record, length: float) -> tuple[Record, list[Finding]]:
    """Cut a record to its most stable window of a length [s]; the criterion of each stream is independent of its noise if
    possible.

    With a temperature: for all streams, the window in which the range of its means over 60 s is smallest. Without a
    temperature: for gyros the window in which the standard deviation of the accelerometers' means over 60 s is smallest, and
    vice versa. Without the other sensor: the same for the stream itself. Standard deviations of several axes are multiplied.

    Raises
    ------
    OptionError
        For a window longer than the record, or of fewer than 4 samples.
    """
    streams, windows = [], list[ChosenWindow]()
    origin = min(stream.grid.start for stream in record.streams)
    for stream in record.streams:
        by = criterion(record, stream)
        total = stream.grid.duration
        if not 0 < length <= total * (1 + 1e-9):
            raise OptionError(
                f"most-stable={seconds(length)}s: {stream.name} is {seconds(total)} s long", option="window"
            )
        start, relative = _most_stable_start(by, length)
        # Times are in the clock of the log, so that streams on different grids are cut alike.
        begin = max(by.stream.grid.start + start, stream.grid.start)
        begin = min(begin, stream.grid.start + total - length)
        streams.append(_between(stream, begin, begin + length, f"most-stable={seconds(length)}s"))
        if stream.quantity != "temperature":
            block = block_length(length, by.stream.grid.tau0) * by.stream.grid.tau0
            windows.append(
                ChosenWindow(
                    stream=stream.name,
                    start=begin - origin,
                    criterion=by.kind,
                    by=by.stream.name,
                    block=block,
                    relative=relative,
                )
            )
    chosen = _with_streams(record, streams, f"most stable window of {seconds(length)} s")
    spans = tuple(dict.fromkeys((window.start, window.start + length) for window in windows))
    details = WindowChosen(length=length, windows=tuple(windows))
    severity: Severity = "warning" if any(window.criterion == "own" for window in windows) else "info"
    return chosen, [Finding(details=details, severity=severity, spans=spans, size=length, unit="s")]


def criterion(record: Record, stream: Stream) -> Criterion:
    """Criterion by which the most stable window of a stream is chosen; see `most_stable`."""
    usable = [s for s in record.streams if s.grid.duration >= _MIN_RECORD_BLOCKS * _BLOCK and s.grid.tau0 <= _BLOCK]
    for candidate in usable:
        if candidate.quantity == "temperature" and candidate is not stream:
            return Criterion(kind="temperature", stream=candidate)
    kinds = {"angular_rate": "acceleration", "acceleration": "angular_rate"}
    for candidate in usable:
        if candidate.quantity == kinds.get(stream.quantity):
            return Criterion(kind="other", stream=candidate)
    return Criterion(kind="own", stream=stream)


def block_length(length: float, tau0: float) -> int:
    """Samples in a block: 60 s, or a tenth of the window if that is less."""
    return max(round(min(_BLOCK, length / _MIN_BLOCKS) / tau0), 1)


def scatter(means: Floats, size: int) -> Floats:
    """Logarithm of the standard deviation of block means in each window of `size` blocks, summed over channels.

    Means of shape (..., n_channels, n_blocks) give (..., n_blocks − size + 1); infinite if more than a tenth is missing.
    """
    is_present = ~np.isnan(means)
    centred = np.where(is_present, means - np.nanmean(means, axis=-1, keepdims=True), 0.0)
    number = _running(is_present.astype(float), size)
    mean = _running(centred, size) / np.maximum(number, 1)
    square = _running(centred**2, size) - number * mean**2
    variance = np.maximum(square, 0.0) / np.maximum(number - 1, 1)
    smallest = np.finfo(float).tiny
    result = 0.5 * np.log(np.maximum(variance, smallest)).sum(axis=-2)
    return np.asarray(np.where((number >= (1 - _MAX_EMPTY) * size).all(axis=-2), result, np.inf))


def _running(values: Floats, size: int) -> Floats:
    total = np.cumsum(values, axis=-1)
    total = np.concatenate([np.zeros_like(total[..., :1]), total], axis=-1)
    return np.asarray(total[..., size:] - total[..., :-size])


def _most_stable_start(by: Criterion, length: float) -> tuple[float, float]:
    """Start of the most stable window, from the first sample of the deciding stream, and its scatter over the median
    scatter.
    """
    stream = by.stream
    block = block_length(length, stream.grid.tau0)
    means = [_means(stream, channel, block) for channel in stream.channels]
    varying = [row for row in means if np.nanmax(row, initial=-np.inf) > np.nanmin(row, initial=np.inf)]
    size = round(length / (block * stream.grid.tau0))
    if not varying or size >= len(varying[0]) or size < 2:
        return 0.0, 1.0
    table = np.stack(varying)
    if by.kind == "temperature":
        windows = np.lib.stride_tricks.sliding_window_view(np.where(np.isnan(table), np.inf, table), size, axis=-1)
        with np.errstate(invalid="ignore"):
            span = np.ptp(windows, axis=-1).sum(axis=0)
        score = np.where(np.isfinite(span), span, np.inf)
        middle = median(score[np.isfinite(score)]) if np.isfinite(score).any() else 1.0
        k = int(np.argmin(score))
        relative = float(score[k] / middle) if middle > 0 else 1.0
    else:
        score = scatter(table, size)
        if not np.isfinite(score).any():
            return 0.0, 1.0
        k = int(np.argmin(score))
        relative = math.exp((score[k] - median(score[np.isfinite(score)])) / len(table))
    return k * block * stream.grid.tau0, relative


def _means(stream: Stream, channel: str, block: int) -> Floats:
    means = block_means(stream, channel, block)
    return means if len(means) else np.full(1, np.nan)


def _between(stream: Stream, start: float, stop: float, text: str) -> Stream:
    """Cut the samples from `start` to `stop`, in the clock of the log."""
    grid = stream.grid
    first = max(round((start - grid.start) / grid.tau0), 0)
    last = min(round((stop - grid.start) / grid.tau0), grid.n)
    if last - first < MIN_SAMPLES:
        got = max(last - first, 0)
        raise _refused(text, f"leaves {got} samples of {stream.name}; at least {MIN_SAMPLES} are needed")
    return stream if (first, last) == (0, grid.n) else stream.cut(first, last)


def _with_streams(record: Record, streams: Sequence[Stream], conversion: str) -> Record:
    provenance = replace(record.provenance, conversions=(*record.provenance.conversions, conversion))
    return replace(record, streams=tuple(streams), provenance=provenance)


def _time(text: str, whole: str) -> float:
    return parse_time(text, whole, option="window", forms=_FORMS)


def _refused(text: str, why: str) -> OptionError:
    return OptionError(f"{{option}} {text!r} {why}", option="window")
