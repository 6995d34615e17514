"""The curves of a record, and findings of channels that have none."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.accumulator import accumulate, strided_sizes
from sigmatau.estimators.allan import Counting, DeviationCurve, Overlap, curves_of_stream, refuse_missing
from sigmatau.estimators.deviation_kinds import TauGrid, cluster_sizes
from sigmatau.findings.finding import Finding
from sigmatau.quality.curve_checks import THRESHOLDS as CURVE_THRESHOLDS
from sigmatau.quality.curve_checks import (
    constant_channel,
    out_of_range,
    rounding,
    strided,
    too_few_samples,
)
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream


def curves_of(
    record: Record,
    *,
    taus: TauGrid | ArrayLike,
    overlap: Overlap,
    counting: Counting,
    long: str,
    bounded: Collection[str],
    threads: int | None,
) -> tuple[dict[str, DeviationCurve], dict[str, DeviationCurve], list[Finding]]:
    """Allan deviations by channel; those on the grid of a fit of streams in `bounded` memory; findings of other channels.

    Raises
    ------
    DataError
        If samples are missing and `long` is "strided", or memory does not suffice for the choice of overlap.
    """
    curves: dict[str, DeviationCurve] = {}
    findings: list[Finding] = []
    found: Mapping[str, DeviationCurve]
    fitted_on: dict[str, DeviationCurve] = {}
    for stream in record.streams:
        if stream.quantity == "temperature":  # used for the drift of the sensors; its noise is not analysed
            continue
        if stream.mask is not None and long == "strided":
            refuse_missing(stream, "bounded memory, `long` 'strided',", instead="take `long` 'exact'")
        if stream.name in bounded:
            if (overlap, counting) != ("full", "standard"):
                raise DataError(f"{stream.name}: there is not enough memory for this choice of overlap and counting")
            found, for_fit = _strided(stream, taus)
            fitted_on |= for_fit
            findings += strided(found, stream.name, out_of_memory=long != "strided")
        else:
            found, none_left = _curves(stream, taus, overlap, counting, threads)
            findings += none_left
        for channel, curve in found.items():
            if not CURVE_THRESHOLDS.smallest < curve.avar.max() < CURVE_THRESHOLDS.largest and curve.avar.max() > 0:
                findings.append(out_of_range(curve))
            elif curve.adev.max() > rounding(stream, channel):
                curves[channel] = curve
            else:
                findings.append(constant_channel(stream, channel))
    return curves, fitted_on, findings


def _curves(
    stream: Stream, taus: TauGrid | ArrayLike, overlap: Overlap, counting: Counting, threads: int | None
) -> tuple[Mapping[str, DeviationCurve], list[Finding]]:
    """The curves, and findings of channels without a curve because too many samples are missing."""
    curves = curves_of_stream(stream, taus=taus, overlap=overlap, counting=counting, threads=threads)
    return curves, [too_few_samples(stream, channel) for channel in stream.channels if channel not in curves]


def _strided(stream: Stream, taus: TauGrid | ArrayLike) -> tuple[dict[str, DeviationCurve], dict[str, DeviationCurve]]:
    """The requested curves and those for the fit, from one pass over the samples."""
    if isinstance(taus, str) and taus == "all":
        raise OptionError("{option} 'all' needs the whole record in memory; take a grid", option="taus")
    n, tau0 = stream.grid.n, stream.grid.tau0
    wanted = strided_sizes(cluster_sizes(taus, n=n, tau0=tau0))
    half = strided_sizes(cluster_sizes("half", n=n, tau0=tau0))
    curves = accumulate(stream, taus=np.union1d(wanted, half) * tau0)
    only = [{channel: curve.at(sizes) for channel, curve in curves.items()} for sizes in (wanted, half)]
    return only[0], only[1]
