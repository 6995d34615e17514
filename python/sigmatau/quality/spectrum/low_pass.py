"""Internal low-pass filters, and aliasing: bandwidth against sampling rate."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.finding import Finding
from sigmatau.noise.terms import aliasing_inflation
from sigmatau.quality.spectrum.filter_fit import LowPass, fit_low_pass, promising
from sigmatau.quality.spectrum.lines import find_lines
from sigmatau.quality.spectrum.pair_spectrum import by_pairs, is_torn
from sigmatau.quality.spectrum.upsampling import resampled
from sigmatau.record.streams import Stream
from sigmatau.results import option_seconds, seconds
from sigmatau.spectrum.estimate import welch
from sigmatau.spectrum.result import Spectrum

__all__ = ["aliasing", "low_pass", "low_passes"]

ALIASING = 1.05
"""Inflation of the random walk above which aliasing is a warning."""

NOTICEABLE = 0.90
"""A filter is a warning where σ at one sample is below this share of what the random walk makes."""

_AND_MORE = ": quantization after the filter adds more than that takes away"
_ROUNDING = 4e-15  # of the largest sample: a few of the last digits
_WIDEST = 1e6  # [Hz] no inertial sensor follows faster: piezoelectric shock sensors resonate at some hundred kHz
_LATE = 1.0  # [s] where the field reads the random walk


def low_passes(stream: Stream, *, spectra: Mapping[str, Spectrum] | None = None) -> dict[str, LowPass]:
    """The filters that the spectra of a stream's channels show, by channel; `spectra` as of `psd`, if at hand."""
    found = {channel: _fitted(stream, channel, spectra) for channel in stream.channels}
    return {channel: fitted for channel, fitted in found.items() if fitted is not None}


def low_pass(stream: Stream, *, fits: Mapping[str, LowPass] | None = None) -> list[Finding]:
    """Findings ``low_pass_filter``: one a channel whose spectrum shows a filter.

    Parameters
    ----------
    stream : Stream
        Static data.
    fits : mapping of str to LowPass, optional
        As of `low_passes`, where they are at hand. Default: computed.

    Returns
    -------
    list of Finding
        A warning where σ at one sample is low by a tenth or more, or where the curve is right only beyond τ = 1 s; else an
        info. `changes` holds the random walk read at one sample over the sensor's own.
    """
    found = []
    filters = low_passes(stream) if fits is None else fits
    # What is to be done is said once for all axes, so by the slowest of them.
    latest = max((fitted.right_from for fitted in filters.values()), default=0.0)
    for channel, fitted in filters.items():
        low = fitted.short < NOTICEABLE
        tau = fitted.right_from
        found.append(
            Finding(
                code="low_pass_filter",
                severity="warning" if low or tau > _LATE else "info",
                channel=channel,
                message=f"the spectrum falls as behind a low-pass filter: {fitted!r}",
                where=f"f = {fitted.corner:.4g} Hz",
                size=fitted.corner,
                unit="Hz",
                effect=(
                    f"σ at one sample, τ = {seconds(stream.grid.tau0)} s, is {fitted.short:.2f} of what the random walk"
                    f" makes, and so is a random walk read there{_AND_MORE if fitted.short > 1 else ''}; within 1 % from τ ="
                    f" {seconds(tau)} s on{', but for quantization' if fitted.short > 1 else ''}"
                ),
                changes=(("random_walk", fitted.short),),
                remedy=(
                    f"fit the random walk of {stream.name} from τ = {seconds(latest)} s on, analyze --tau-min"
                    f" {option_seconds(latest)}, or read it there; and model the filter if that is too late"
                ),
            )
        )
    return found


def aliasing(
    stream: Stream,
    *,
    bandwidth: tuple[float, int | None] | None = None,
    fits: Mapping[str, LowPass] | None = None,
) -> list[Finding]:
    """Findings ``aliasing``: what sampling without an anti-alias filter adds to the random walk.

    Parameters
    ----------
    stream : Stream
    bandwidth : (float, int or None), optional
        The sensor's own, by its data sheet, and the order of its filter if that is known: one finding for the stream, a
        warning above 5 %, otherwise an info. Without an order both the first and the second are named, and the first
        decides. Default: the filter that is seen in the spectrum, where that is one of the two and makes more than 5 %.
        [Hz]
    fits : optional
        See `low_pass`.

    Raises
    ------
    OptionError
        For a bandwidth that is not positive, an order outside 1 … 8.
    """
    rate = stream.grid.rate
    if bandwidth is not None:
        return [_stated(stream, *bandwidth)]
    found = []
    orders = {"first_order": 1, "butterworth2": 2}
    for channel, fitted in (low_passes(stream) if fits is None else fits).items():
        if fitted.shape not in orders:
            continue
        order = orders[fitted.shape]
        least = aliasing_inflation(rate=rate, bandwidth=max(fitted.corner - 3 * fitted.error, 1e-3 * rate), order=order)
        if least <= ALIASING or fitted.alike:
            continue  # a spectrum that other filters make as well does not tell how much is folded in
        inflation = aliasing_inflation(rate=rate, bandwidth=fitted.corner, order=order)
        found.append(
            Finding(
                code="aliasing",
                severity="warning",
                channel=channel,
                message=(
                    f"sampled at {rate:.4g} Hz, {rate / fitted.corner:.2g} times the bandwidth seen in the spectrum"
                    f" ({fitted!r}): if that filter is an analog one, noise from beyond {rate / 2:.4g} Hz is folded in"
                ),
                size=inflation,
                effect=f"the random walk is {_times(inflation)} the sensor's own, at all averaging times",
                changes=(("random_walk", inflation),),
                remedy=_remedy(fitted.corner, order),
            )
        )
    return found


def _stated(stream: Stream, hertz: float, order: int | None) -> Finding:
    rate = stream.grid.rate
    if not 0 < hertz <= _WIDEST:
        raise OptionError(
            f"the bandwidth must be a positive number of hertz, at most {_WIDEST:g}, not {hertz!r}", option="bandwidth"
        )
    if order is not None and order not in range(1, 9):
        raise OptionError(f"the order of a filter must be 1 to 8, not {order!r}", option="bandwidth")
    inflation = aliasing_inflation(rate=rate, bandwidth=hertz, order=order or 1)
    if order is None:
        second = aliasing_inflation(rate=rate, bandwidth=hertz, order=2)
        effect = (
            f"the random walk is {_times(inflation)} the sensor's own behind a first-order filter, {_times(second)}"
        )
        effect += " behind a second-order one, at all averaging times"
    else:
        effect = f"the random walk is {_times(inflation)} the sensor's own, at all averaging times"
    return Finding(
        code="aliasing",
        severity="warning" if inflation > ALIASING else "info",
        message=(
            f"{stream.name}: sampled at {rate:.4g} Hz, {rate / hertz:.2g} times the stated bandwidth of {hertz:g} Hz"
            f"{'' if order is None else f' of order {order}'}; the rule of thumb is 3 to 5 times"
        ),
        size=inflation,
        effect=effect,
        changes=(("random_walk", inflation),),
        remedy=_remedy(hertz, order or 1) if inflation > ALIASING else "",
    )


def _times(inflation: float) -> str:
    return f"{inflation:.3f} times" if inflation < 10 else f"{inflation:.3g} times"


def _remedy(corner: float, order: int) -> str:
    low, high = 0.5 * corner, 64 * corner
    for _ in range(40):
        middle = math.sqrt(low * high)
        if aliasing_inflation(rate=middle, bandwidth=corner, order=order) > 1.02:
            low = middle
        else:
            high = middle
    return (
        f"sample at {high:.3g} Hz or faster (2 % then), or filter before sampling; a navigation filter at this rate needs"
        " the value as it is"
    )


def _fitted(stream: Stream, channel: str, spectra: Mapping[str, Spectrum] | None) -> LowPass | None:
    y = None
    spectrum: Spectrum | None
    if spectra is not None and channel in spectra:
        spectrum = spectra[channel]
    else:
        y = np.ascontiguousarray(stream.column(channel))
        try:
            spectrum = welch(y, stream, channel)
        except DataError:
            spectrum = None
    if stream.mask is not None:
        y = np.ascontiguousarray(stream.column(channel)) if y is None else y
        there = int(np.count_nonzero(np.isfinite(y)))
        if there < len(y) and is_torn(spectrum, there):
            spectrum = by_pairs(y, stream, channel) or spectrum
    if spectrum is None or not promising(spectrum):
        return None
    # A record resampled to a higher rate has the spectrum of a running mean, and is no filtered sensor.
    if resampled(np.ascontiguousarray(stream.column(channel)) if y is None else y, spectrum) is not None:
        return None
    # A ramp alone leaves its rounding, which has a spectrum of its own.
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
