"""Inspection of a log: its content, and the findings about the file and its samples."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from sigmatau.errors import DataError
from sigmatau.findings.curves import CheckedWithoutFit
from sigmatau.findings.finding import Finding, Span
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.io.read import inspection
from sigmatau.io.read.inspection import Inspection
from sigmatau.options import keywords_of
from sigmatau.quality.check import LARGEST, LOOKED_AT, LOOKED_AT_BOUNDED, check_fits, examine
from sigmatau.quality.curves import constant_channels, rounding
from sigmatau.quality.facts import keep_facts
from sigmatau.quality.fit_findings import by_channel, without_explained
from sigmatau.quality.options import Bandwidth, InspectOptions
from sigmatau.quality.selection.exclusion import causes_to_keep, from_the_start, leave_out, spans_to_keep
from sigmatau.quality.selection.rest import at_rest_only, rest
from sigmatau.record import memory
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

FITTED = 8_000_000
"""Largest number of samples of all channels that are fitted for the checks: a few seconds on one core."""


@keywords_of(InspectOptions)
@keep_facts()
def inspect(path: str | os.PathLike[str], options: InspectOptions) -> Inspection:
    """The content of a file, and the findings about it and about the samples that would be analysed.

    No option is required. Tables whose column names indicate a sensor, and those selected by `topic` or `channels`, are
    read; the others are listed by name only.

    Parameters
    ----------
    path : str or path
        The file, or the folder of a ROS 2 bag.

    Returns
    -------
    Inspection

    Raises
    ------
    DataError
        If the file cannot be read.
    OptionError
        For an invalid option, or a topic or sensor that the file does not have.

    See Also
    --------
    read : the record of a file.
    check : the faults of a record.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     log = pathlib.Path(folder) / "log.csv"
    ...     st.write(st.simulate(model, duration=10, rate=100, rng=1), log)
    ...     (table,) = st.inspect(log).tables
    >>> table.rows, table.rate, [column.channel for column in table.columns]
    (1000, 100.0, ['time', 'gyro_x'])
    """
    inspected = inspection.inspect(path, options)
    if inspected.record is None:
        return inspected
    untouched = causes_to_keep(options.keep), spans_to_keep(options.keep)
    record = from_the_start(inspected.record)
    excluded: list[Finding] = []
    if options.leave_out is not None:
        record, excluded = leave_out(record, options.leave_out)
    constant = [finding for stream in record.streams for finding in constant_channels(stream)]
    resting = rest(record)
    record, motion = at_rest_only(record, resting, assumed=False)
    if not resting.is_usable:
        return replace(inspected, record=record, checks=(*excluded, *constant, *motion))
    bounded = [s.name for s in record.streams if s.mask is None and not memory.fits(s, None)]
    try:
        still, checks = _examined(record, options.bandwidth, *untouched, bounded)
    except MemoryError:
        if bounded:
            raise
        bounded = [s.name for s in record.streams]
        still, checks = _examined(record, options.bandwidth, *untouched, bounded)
    checked = [*excluded, *constant, *motion, *checks]
    return replace(inspected, record=record, checks=tuple(_against_fits(still, checked, bounded)))


def _examined(
    record: Record, bandwidth: Bandwidth | None, keep: Sequence[str], keep_spans: Sequence[Span], bounded: Sequence[str]
) -> tuple[Record, tuple[Finding, ...]]:
    """Examine a record as `sigmatau.analyze` does, or only its beginning if it does not fit in memory."""
    looked_at = LOOKED_AT_BOUNDED if bounded else LOOKED_AT
    examined = examine(
        record, bandwidth=bandwidth, looked_at=looked_at, keep=keep, keep_spans=keep_spans, untouched=bounded
    )
    return examined.record, examined.findings


def _against_fits(record: Record, sample_findings: Sequence[Finding], bounded: Sequence[str]) -> list[Finding]:
    """Add the findings that need a fit, as `sigmatau.analyze` does."""
    streams = [stream for stream in record.streams if stream.quantity != "temperature"]
    number = sum(stream.grid.n * len(stream.channels) for stream in streams)
    if number > FITTED or bounded or not all(memory.fits(stream, None) for stream in streams):
        return [*sample_findings, Finding(details=CheckedWithoutFit(samples=number), severity="info")]
    fits: dict[str, NoiseFit] = {}
    for stream in streams:
        for channel in stream.channels:
            if not _varies(stream, channel):
                continue
            with contextlib.suppress(DataError):  # too short, or too many samples are missing
                fits[channel] = fit_channel(record, channel)
    return [
        *without_explained(sample_findings, fits),
        *by_channel(fits, sample_findings, record),
        *check_fits(record, fits, findings=sample_findings),
    ]


def _varies(stream: Stream, channel: str) -> bool:
    """Whether a channel changes by more than rounding, and its squares are within range."""
    x = stream.column(channel)
    low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
    largest = LARGEST
    return -largest < low < high < largest and high - low > max(rounding(stream, channel), 1 / largest)
