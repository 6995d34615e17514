"""The curves of a record, and findings about curves and about channels without a curve."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Counting, DeviationCurve, Overlap, curves_of_stream, refuse_missing
from sigmatau.estimators.deviation_kinds import TauGrid, cluster_sizes
from sigmatau.findings.curves import ConstantChannel, OutOfRange, Strided, TooFewSamples
from sigmatau.findings.finding import Finding
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

# Smallest Allan variance that can be analysed. [rate_unit²] Derived: a fit squares it, within the range of double
# precision.
_SMALLEST = 1e-120
# Largest Allan variance that can be analysed. [rate_unit²] Derived: see `_SMALLEST`.
_LARGEST = 1e120
# Largest deviation of a constant channel that rounding can cause, in units of the rounding of its largest value. [1]
# Judgement: three differences and a unit conversion are rounded.
_ROUNDING = 4


def rounding(stream: Stream, channel: str) -> float:
    """Largest deviation that rounding can cause in a channel that is constant or a straight line."""
    k = stream.channels.index(channel)
    raw, t = stream.samples.raw[k], stream.samples.transforms[k]
    first, last = 0, -1
    if stream.mask is not None:
        first, last = np.flatnonzero(~stream.mask[:, k])[[0, -1]]
    largest = max(abs(float(raw[first])), abs(float(raw[last]))) * abs(t.scale * t.factor)
    if t.kind != "rate":
        largest /= stream.grid.tau0
    return _ROUNDING * sys.float_info.epsilon * largest


def out_of_range(curve: DeviationCurve) -> Finding:
    """Report that the Allan variances of a channel overflow or vanish when they are squared."""
    details = OutOfRange(largest=float(curve.adev.max()), rate_unit=curve.unit)
    return Finding(details=details, severity="error", channels=(curve.channel,))


def constant_channel(stream: Stream, channel: str) -> Finding:
    """Report that a channel never changes."""
    k = stream.channels.index(channel)
    first = 0 if stream.mask is None else int(np.flatnonzero(~stream.mask[:, k])[0])
    value = float(stream.samples.read(k, first, first + 1)[0])
    details = ConstantChannel(samples=stream.grid.n, value=value, rate_unit=stream.unit)
    return Finding(details=details, severity="error", channels=(channel,))


def too_few_samples(stream: Stream, channel: str) -> Finding:
    """Report that too many samples of a channel are missing for an Allan variance."""
    missing = 0 if stream.mask is None else int(stream.mask[:, stream.channels.index(channel)].sum())
    details = TooFewSamples(missing=missing, samples=stream.grid.n)
    return Finding(details=details, severity="error", channels=(channel,))


def constant_channels(stream: Stream) -> list[Finding]:
    """Report channels of a sensor that never change or have no samples; their curves are not needed."""
    if stream.quantity == "temperature":
        return []
    findings = []
    for channel in stream.channels:
        x = stream.column(channel)
        low, high = float(np.fmin.reduce(x)), float(np.fmax.reduce(x))
        if np.isnan(low):
            findings.append(too_few_samples(stream, channel))
        elif high - low <= rounding(stream, channel):
            findings.append(constant_channel(stream, channel))
    return findings


def strided(
    curves: Mapping[str, DeviationCurve], stream: str | None = None, *, out_of_memory: bool = False
) -> list[Finding]:
    """Report the averaging time from which the clusters of a stream do not begin at every sample. The stream is given by
    its name and its curves by channel.
    """
    curve = next(iter(curves.values()))
    if curve.stride is None:
        return []
    first = float(curve.tau[curve.stride > 1][0])
    details = Strided(tau=first, samples=curve.n, out_of_memory=out_of_memory)
    return [Finding(details=details, severity="info", channels=() if stream is None else (stream,))]


def compute_curves(
    record: Record,
    *,
    taus: TauGrid | ArrayLike,
    overlap: Overlap,
    counting: Counting,
    long: str,
    bounded: Collection[str],
    threads: int | None,
) -> tuple[dict[str, DeviationCurve], dict[str, DeviationCurve], list[Finding]]:
    """Allan deviations by channel. Streams in `bounded` use bounded memory and the grid of a fit. Other channels get a
    finding.

    Raises
    ------
    DataError
        If samples are missing and `long` is "strided", or if there is not enough memory for the selected overlap.
    """
    curves: dict[str, DeviationCurve] = {}
    findings: list[Finding] = []
    available: Mapping[str, DeviationCurve]
    fitted_on: dict[str, DeviationCurve] = {}
    for stream in record.streams:
        # the temperature describes the drift of the sensors; its noise is not analysed
        if stream.quantity == "temperature":
            continue
        if stream.mask is not None and long == "strided":
            refuse_missing(stream, "bounded memory, `long` 'strided',", instead="take `long` 'exact'")
        if stream.name in bounded:
            if (overlap, counting) != ("full", "standard"):
                raise DataError(f"{stream.name}: there is not enough memory for this choice of overlap and counting")
            available, for_fit = _strided(stream, taus)
            fitted_on |= for_fit
            findings += strided(available, stream.name, out_of_memory=long != "strided")
        else:
            available, unavailable = _curves(stream, taus, overlap, counting, threads)
            findings += unavailable
        for channel, curve in available.items():
            if not _SMALLEST < curve.avar.max() < _LARGEST and curve.avar.max() > 0:
                findings.append(out_of_range(curve))
            elif curve.adev.max() > rounding(stream, channel):
                curves[channel] = curve
            else:
                findings.append(constant_channel(stream, channel))
    return curves, fitted_on, findings


def _curves(
    stream: Stream, taus: TauGrid | ArrayLike, overlap: Overlap, counting: Counting, threads: int | None
) -> tuple[Mapping[str, DeviationCurve], list[Finding]]:
    """Compute the curves, and report channels with too many missing samples for a curve."""
    curves = curves_of_stream(stream, taus=taus, overlap=overlap, counting=counting, threads=threads)
    return curves, [too_few_samples(stream, channel) for channel in stream.channels if channel not in curves]


def _strided(stream: Stream, taus: TauGrid | ArrayLike) -> tuple[dict[str, DeviationCurve], dict[str, DeviationCurve]]:
    """The requested curves and those for the fit, from one pass over the samples."""
    from sigmatau.estimators.accumulator import accumulate, strided_sizes

    if isinstance(taus, str) and taus == "all":
        raise OptionError("{option} 'all' needs the whole record in memory; take a grid", option="taus")
    n, tau0 = stream.grid.n, stream.grid.tau0
    wanted = strided_sizes(cluster_sizes(taus, n=n, tau0=tau0))
    half = strided_sizes(cluster_sizes("half", n=n, tau0=tau0))
    curves = accumulate(stream, taus=np.union1d(wanted, half) * tau0)
    only = [{channel: curve.at(sizes) for channel, curve in curves.items()} for sizes in (wanted, half)]
    return only[0], only[1]
