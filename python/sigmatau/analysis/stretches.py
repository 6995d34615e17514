"""Analysis of a record that is too large for one process: several workers sum its stretches, and the sums are merged.

The stretches depend only on the record and are merged in order, so that the digits of a result depend neither on the
number of workers nor on workers that end early.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sigmatau.analysis.entry import of_curves
from sigmatau.analysis.options import AnalysisOptions
from sigmatau.errors import DataError, OptionError, RecordTooShortError
from sigmatau.estimators.accumulator import Accumulator, strided_sizes
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.estimators.gapped import GappedSums
from sigmatau.findings.finding import Finding
from sigmatau.findings.stretches import InStretches, PairsAcrossGaps
from sigmatau.frozen import frozen
from sigmatau.options import options_that_differ
from sigmatau.record.on_disk import FileColumn
from sigmatau.record.record import Provenance
from sigmatau.record.sampling import Sampling
from sigmatau.record.streams import Stream, describe_sampling

if TYPE_CHECKING:
    from sigmatau.analysis.result import Analysis
    from sigmatau.io.read.stretches import Unread

_VALUES = 1 << 25  # number of values of all channels in a stretch: about a second for a worker
_PIECE = 1 << 16  # samples that are read at a time
_COMPLETE = 0.9  # smallest share of remaining pairs at a cluster size that is fitted: gaps then change intervals by 5 %
_CURVE_OPTIONS = ("method", "long", "notes", "threads")
"""Options of `analyze` that apply to a fit of curves, or need no samples."""


@frozen
class Division:
    """Division of a record into stretches."""

    place: str
    samples: int
    stretches: tuple[tuple[int, int], ...]  # first sample, and the sample after the last
    source: Provenance
    findings: tuple[Finding, ...]
    grids: Mapping[str, Sampling]


def too_large(place: str, reading: Mapping[str, Any], memory: int) -> bool:
    """Whether the analysis of a log with columns on disk needs more memory than `memory`. [bytes]"""
    try:
        streams = _unread(place, reading).streams
    except (DataError, OptionError):  # the analysis reports the error
        return False
    return sum(s.grid.n * len(s.channels) for s in streams) * _BYTES > memory


_BYTES = 48  # largest memory per sample that an analysis needs [bytes]


def divide(place: str, reading: Mapping[str, Any], settings: Mapping[str, Any]) -> Division:
    """Divide a record.

    Raises
    ------
    OptionError
        For settings that need all samples in one process.
    DataError
        For a log that cannot be read in stretches.
    """
    options = AnalysisOptions(**settings)
    for name, _ in options_that_differ(options):
        if name not in _CURVE_OPTIONS:
            raise OptionError(
                f"{{option}} needs the whole record in a worker, and {place} is too large; give the workers more memory",
                option=name,
            )
    record = _unread(place, reading)
    channels = sum(len(stream.channels) for stream in record.streams)
    n, steps = record.streams[0].grid.n, {_step(stream) for stream in record.streams}
    step = max(steps)
    length = max(_VALUES // channels // step, 1) * step
    return Division(
        place=place,
        samples=n,
        stretches=tuple((start, min(start + length, n)) for start in range(0, n, length)),
        source=record.source,
        findings=record.findings,
        grids={stream.name: describe_sampling(stream) for stream in record.streams},
    )


def sum_stretch(place: str, reading: Mapping[str, Any], start: int, stop: int) -> dict[str, GappedSums]:
    """Compute the sums of a stretch, by channel."""
    sums: dict[str, GappedSums] = {}
    for stream in _unread(place, reading).streams:
        sizes = strided_sizes(cluster_sizes("half", n=stream.grid.n, tau0=stream.grid.tau0))
        for channel in stream.channels:
            new = functools.partial(_accumulator, channel, stream.quantity, stream.unit, stream.grid.tau0, sizes)
            sums[channel] = GappedSums(new, start)
        for first in range(start, stop, _PIECE):
            for k, channel in enumerate(stream.channels):
                sums[channel].push(stream.samples.read(k, first, min(first + _PIECE, stop)))
    return sums


def analyze_sums(division: Division, sums: Mapping[str, GappedSums], *, method: str) -> Analysis:
    """Build the result from the sums of all stretches.

    Raises
    ------
    DataError
        If no channel has a curve.
    """
    findings = [
        *division.findings,
        Finding(details=InStretches(stretches=len(division.stretches), samples=division.samples), severity="warning"),
    ]
    curves: dict[str, DeviationCurve] = {}
    fitted: dict[str, DeviationCurve] = {}
    for channel, channel_sums in sums.items():
        try:
            curve = channel_sums.snapshot()
        except RecordTooShortError as error:
            raise DataError(f"{channel}: {error}") from None
        curves[channel] = curve
        if curve.missing:
            fitted[channel] = as_complete(curve)
            pairs = PairsAcrossGaps(
                missing=curve.missing,
                samples=curve.n,
                longest=float(curve.tau[-1]),
                fitted=0.0 if method == "read-off" else float(fitted[channel].tau.max(initial=0.0)),
            )
            findings.append(Finding(details=pairs, severity="warning", channels=(channel,)))
    return of_curves(
        curves,
        source=division.source,
        findings=findings,
        grids=division.grids,
        method="read-off" if method == "read-off" else "gls",
        fitted_on=fitted,
    )


def as_complete(curve: DeviationCurve) -> DeviationCurve:
    """Replace a curve with gaps by that of a complete, shorter record with as many pairs.

    It keeps the sizes with 9 of 10 pairs or more; without such sizes, the curve is empty.
    """
    starts = curve.n_pairs if curve.stride is None else curve.n_pairs * curve.stride
    share = starts / np.maximum(curve.n + 1 - 2 * curve.m, 1)
    incomplete = np.flatnonzero(share < _COMPLETE)
    sizes = curve.m[: incomplete[0]] if incomplete.size else curve.m
    if not sizes.size:
        return replace(curve.at(curve.m[:1]), missing=curve.missing)
    shortened = curve.at(sizes)
    complete = int((starts[: len(sizes)] + 2 * sizes - 1).min())
    return replace(shortened, n=min(complete, curve.n), missing=0)


def _unread(place: str, reading: Mapping[str, Any]) -> Unread:
    from sigmatau.io.read.stretches import unread

    return unread(place, **reading)


def _step(stream: Stream) -> int:
    """Number of samples that are stored together."""
    columns: list[object] = [*stream.samples.raw]
    return max((column.step for column in columns if isinstance(column, FileColumn)), default=1)


def _accumulator(
    channel: str, quantity: str, unit: str, tau0: float, sizes: np.ndarray[Any, np.dtype[np.int64]], start: int
) -> Accumulator:
    made = Accumulator(channel, rate=1 / tau0, taus=sizes * tau0, long="strided", start=start)
    made._quantities, made._units, made.tau0 = [quantity], [unit], tau0
    return made


def merge_sums(first: dict[str, GappedSums], second: Mapping[str, GappedSums]) -> None:
    """Add the sums of the next stretch to the sums of the previous ones."""
    for channel, sums in second.items():
        first[channel].merge(sums)
