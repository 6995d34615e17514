"""Internal low-pass filters, and aliasing: bandwidth against sampling rate."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from sigmatau.errors import OptionError
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.spectrum import Aliasing, LowPassFilter
from sigmatau.noise.terms import aliasing_inflation
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.spectrum.filter_fit import fit_low_pass, promising
from sigmatau.quality.spectrum.lines import find_lines
from sigmatau.quality.spectrum.pair_spectrum import by_pairs, is_torn
from sigmatau.quality.spectrum.upsampling import channel_spectrum, resampled
from sigmatau.record.streams import Stream

__all__ = ["aliasing", "low_pass", "low_passes"]

INFLATION_WARNED = 1.05
"""Factor on the random walk above which aliasing is a warning."""

SIGMA_WARNED = 0.90
"""Share of what the random walk makes of σ at one sample, below which a filter is a warning."""

RIGHT_FROM_WARNED = 1.0
"""Averaging time, at which the random walk is read off: a filter that reaches beyond it is a warning. [s]"""

_INFLATION_ADVISED = 1.02  # at the sampling rate that the action names
_ROUNDING = 4e-15  # of the largest sample: a few of the last digits of double precision
_WIDEST = 1e6  # [Hz] piezoelectric shock sensors resonate at some hundred kHz; no inertial sensor is faster


def low_passes(stream: Stream) -> dict[str, LowPassFilter]:
    """The filters in the spectra of the channels of a stream, by channel."""
    found = {channel: _fitted(stream, channel) for channel in stream.channels}
    return {channel: fitted for channel, fitted in found.items() if fitted is not None}


def low_pass(
    stream: Stream,
    *,
    fits: Mapping[str, LowPassFilter] | None = None,
    sigma_warned: float = SIGMA_WARNED,
    right_from_warned: float = RIGHT_FROM_WARNED,
) -> list[Finding]:
    """Findings ``low_pass_filter``: one for each channel whose spectrum shows a filter.

    Parameters
    ----------
    stream : Stream
        Static data.
    fits : mapping of str to LowPassFilter, optional
        From `low_passes`. Default: computed.
    sigma_warned : float
        A filter is a warning if σ at one sample is below this share of what the random walk makes.
    right_from_warned : float
        A filter is a warning if the curve is right only beyond this averaging time. [s]

    Returns
    -------
    list of Finding
        Warnings or infos. `factors` holds the random walk read off at one sample over the sensor's own.
    """
    filters = low_passes(stream) if fits is None else fits
    # One fit option is advised for all axes: that of the slowest filter.
    tau_min = max((fitted.right_from for fitted in filters.values()), default=0.0)
    return [
        Finding(
            details=replace(fitted, tau_min=tau_min),
            severity=(
                "warning" if fitted.sigma_one_sample < sigma_warned or fitted.right_from > right_from_warned else "info"
            ),
            channels=(channel,),
            size=fitted.corner,
            unit="Hz",
            factors=(("random_walk", fitted.sigma_one_sample),),
        )
        for channel, fitted in filters.items()
    ]


def aliasing(
    stream: Stream,
    *,
    bandwidth: tuple[float, int | None] | None = None,
    fits: Mapping[str, LowPassFilter] | None = None,
    inflation_warned: float = INFLATION_WARNED,
) -> list[Finding]:
    """Findings ``aliasing``: what sampling without an anti-alias filter adds to the random walk.

    Parameters
    ----------
    stream : Stream
    bandwidth : (float, int or None), optional
        The sensor's bandwidth from its data sheet, and the order of its filter if known: one finding for the stream, a
        warning above `inflation_warned`, otherwise an info. Without an order the finding states both the first and the
        second, and the first decides. Default: the filter in the spectrum, if it is one of the two and makes more than
        `inflation_warned`. [Hz]
    fits : optional
        See `low_pass`.
    inflation_warned : float
        Factor on the random walk above which aliasing is a warning.

    Raises
    ------
    OptionError
        For a bandwidth that is not positive, an order outside 1 … 8.
    """
    rate = stream.grid.rate
    if bandwidth is not None:
        return [_stated(stream, *bandwidth, inflation_warned)]
    found = []
    for channel, fitted in (low_passes(stream) if fits is None else fits).items():
        order = fitted.order
        if fitted.shape not in ("first_order", "butterworth2") or order is None:
            continue
        lowest = max(fitted.corner - 3 * fitted.error, 1e-3 * rate)
        least = aliasing_inflation(rate=rate, bandwidth=lowest, order=order)
        if least <= inflation_warned or fitted.alike:
            continue  # a spectrum that other filters make as well does not show how much is folded in
        details = Aliasing(
            rate=rate,
            bandwidth=fitted.corner,
            order=order,
            stated=False,
            error=fitted.error,
            rate_needed=_rate_needed(fitted.corner, order),
        )
        found.append(_aliased(details, (channel,), inflation_warned))
    return found


def _stated(stream: Stream, hertz: float, order: int | None, inflation_warned: float) -> Finding:
    if not 0 < hertz <= _WIDEST:
        raise OptionError(
            f"the bandwidth must be a positive number of hertz, at most {_WIDEST:g}, not {hertz!r}", option="bandwidth"
        )
    if order is not None and order not in range(1, 9):
        raise OptionError(f"the order of a filter must be 1 to 8, not {order!r}", option="bandwidth")
    rate = stream.grid.rate
    details = Aliasing(
        rate=rate,
        bandwidth=hertz,
        order=order,
        stated=True,
        second_order=aliasing_inflation(rate=rate, bandwidth=hertz, order=2) if order is None else None,
        rate_needed=_rate_needed(hertz, order or 1),
    )
    return _aliased(details, stream.channels, inflation_warned)


def _aliased(details: Aliasing, channels: tuple[str, ...], inflation_warned: float) -> Finding:
    inflation = aliasing_inflation(rate=details.rate, bandwidth=details.bandwidth, order=details.order or 1)
    return Finding(
        details=details,
        severity="warning" if inflation > inflation_warned else "info",
        channels=channels,
        size=inflation,
        factors=(("random_walk", inflation),),
    )


def _rate_needed(corner: float, order: int) -> float:
    """Sampling rate at which little is folded into the random walk. [Hz]"""
    low, high = 0.5 * corner, 64 * corner
    for _ in range(40):
        middle = math.sqrt(low * high)
        if aliasing_inflation(rate=middle, bandwidth=corner, order=order) > _INFLATION_ADVISED:
            low = middle
        else:
            high = middle
    return high


@channel_fact
def _fitted(stream: Stream, channel: str) -> LowPassFilter | None:
    spectrum = channel_spectrum(stream, channel)
    if stream.mask is not None:
        y = np.ascontiguousarray(stream.column(channel))
        there = int(np.count_nonzero(np.isfinite(y)))
        if there < len(y) and is_torn(spectrum, there):
            spectrum = by_pairs(y, stream, channel) or spectrum
    if spectrum is None or not promising(spectrum):
        return None
    # A record resampled to a higher rate has the spectrum of a running mean without a filter.
    if resampled(stream, channel) is not None:
        return None
    # A ramp alone leaves its rounding error, whose spectrum is not that of the sensor.
    if (
        spectrum.density.sum() * (spectrum.frequency[1] - spectrum.frequency[0])
        < (_ROUNDING * _largest(stream, channel)) ** 2
    ):
        return None
    found = find_lines(stream.only(channel))[channel]
    bands = [(each.low, each.high) for line in found for each in (line, *line.harmonics)]
    return fit_low_pass(spectrum, without=bands)


def _largest(stream: Stream, channel: str) -> float:
    y = stream.column(channel)
    return max(float(np.fmax.reduce(y)), -float(np.fmin.reduce(y)))
