"""Noise coefficients of a window of a log, whose mean follows the temperature."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sigmatau import Record, Stream, fit_channel
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.fitting import QUANTIFIED, FittedTerm
from sigmatau.lab.temperature.result import TERMS
from sigmatau.noise.terms import NOISE

_TERMS = tuple(name for name in NOISE if name != "rate_ramp")  # the regressors model the drift
# Smallest range of temperature for which the model has regressors of temperature. [K] Judgement: a chamber holds 0.1 K.
_LEAST_SPAN = 0.1
# Smallest number of samples. [1] Judgement: the likelihood needs 256, and an error of 10 % needs a thousand.
_LEAST_SAMPLES = 1024


def window_terms(
    stream: Stream, temperature: Floats, start: int, stop: int, *, level: float
) -> Mapping[str, FittedTerm]:
    """Random walk, bias instability and rate random walk of a window; the effect of temperature on the mean is fitted too.

    Parameters
    ----------
    stream : Stream
        A stream with one channel.
    temperature : ndarray, shape (n,)
        Temperature at each sample of the stream. [°C]
    start, stop : int
        Samples, from `start` to before `stop`.
    level : float
        Confidence level.

    Returns
    -------
    mapping of str to FittedTerm
        Empty for a window that is too short, or whose noise no model fits.
    """
    t = temperature[start:stop]
    regressors = {}
    if np.ptp(t) > _LEAST_SPAN:
        u = (t - t.mean()) / float(np.ptp(t))
        regressors = {"temperature": u, "temperature squared": u * u}
    return noise_terms(stream.cut(start, stop), regressors, level=level)


def noise_terms(stream: Stream, regressors: Mapping[str, Floats], *, level: float) -> Mapping[str, FittedTerm]:
    """Random walk, bias instability and rate random walk of a stream with one channel; regressors are fitted too.

    Parameters
    ----------
    stream : Stream
    regressors : mapping of str to ndarray, shape (n,)
        See `sigmatau.fit_channel`.
    level : float
        Confidence level.

    Returns
    -------
    mapping of str to FittedTerm
        Empty for a stream that is too short, or whose noise no model fits.
    """
    if stream.grid.n < _LEAST_SAMPLES:
        return {}
    (channel,) = stream.channels
    try:
        fitted = fit_channel(Record(streams=(stream,)), channel, terms=_TERMS, regressors=regressors, level=level)
    except DataError:
        return {}
    if fitted.verdict not in QUANTIFIED:
        return {}
    return {name: fitted[name] for name in TERMS if name in fitted}
