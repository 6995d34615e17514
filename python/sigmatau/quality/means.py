"""Mean of a channel over the analysed samples, and its standard error."""

from __future__ import annotations

import math

from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.noise.terms import SLOW
from sigmatau.quality.facts import channel_fact
from sigmatau.quality.samples.common import pieces, present
from sigmatau.record.streams import Stream
from sigmatau.results import Plain


@frozen
class ChannelMean(Plain):
    """Mean of a channel: the sum of bias, earth rate and gravity.

    Attributes
    ----------
    value : float
        Mean of the samples that were analysed. [unit]
    error : float or None
        Standard error by random walk, quantization and Gauss-Markov processes; None without a fit, or if the fit has a
        bias instability, a rate random walk or a ramp: the bias then has no single value during the record. [unit]
    unit : str
        SI.
    """

    value: float
    error: float | None
    unit: str


@channel_fact
def mean_value(stream: Stream, channel: str) -> float:
    """Mean of the present samples; NaN if there are none."""
    total, count = 0.0, 0
    for _, x in pieces(stream, channel):
        part = float(x.sum())
        samples = x if math.isfinite(part) else present(x)
        total, count = total + float(samples.sum()), count + len(samples)
    return total / count if count else math.nan


def channel_mean(stream: Stream, channel: str, fitted: NoiseFit | None) -> ChannelMean | None:
    """The mean of a channel with its error from the fitted noise; None if the mean is not finite."""
    value = mean_value(stream, channel)
    if not math.isfinite(value):
        return None
    return ChannelMean(value=value, error=None if fitted is None else _error(fitted), unit=stream.unit)


def _error(fitted: NoiseFit) -> float | None:
    """Standard deviation of a mean, for noise that averages out."""
    if not fitted.quantified or any(name in fitted.model for name in SLOW) or fitted.warm_up is not None:
        return None
    length = fitted.n * fitted.tau0
    variance = fitted.model.get("random_walk", 0.0) ** 2 / length
    variance += 2 * (fitted.model.get("quantization", 0.0) / length) ** 2
    for process in fitted.gauss_markov:
        share = process.time.value / length
        variance += 2 * process.sigma.value**2 * share * (1 + share * math.expm1(-1 / share))
    return math.sqrt(variance) if variance > 0 else None
