"""Summary of a region of filters: intervals of the bandwidth, of N without aliasing, and of the rate to sample at."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sigmatau._native.distributions import normal_below
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.estimators.allan import allan
from sigmatau.fitting.filter_fit import FilterFit, Logs, deviance_law
from sigmatau.fitting.filter_region import Explanation
from sigmatau.fitting.fitted_values import Interval
from sigmatau.fitting.sensor_bandwidth import AliasingCurve, FilterResponse, LoggedRate, SensorBandwidth, Verdict
from sigmatau.fitting.sensor_filters import SensorFilter
from sigmatau.frozen import frozen
from sigmatau.noise.terms import coefficient_unit
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

_RESPONSE_FROM = 0.03  # lowest frequency of the response [bandwidths]
_RESPONSE_TO = 10.0  # highest frequency of the response [bandwidths]
_RESPONSES = 61  # number of frequencies of the response
_RATE_FROM = 0.25  # lowest rate of the aliasing curve [bandwidths]
_RATE_TO = 100.0  # highest rate of the aliasing curve [bandwidths]
_RATES = 27  # number of rates of the aliasing curve
_FASTEST = 1024.0  # rate over the noise-equivalent bandwidth, above which nothing is aliased
_RATE_STEP = 1.1  # factor from one rate of the search down to the next
_BISECTIONS = 12
_LARGEST_HALF_WIDTH = 20.0  # largest stated half width of ln N

Quantity = Callable[[SensorFilter, Floats], float]


@frozen(eq=False)
class FilterSource:
    """One channel of one log.

    Attributes
    ----------
    name : str
        Name of the log.
    stream : Stream
        Stream of this channel alone.
    y : ndarray, shape (n,)
        Rates of the channel; NaN for missing samples. [unit of the stream]
    """

    name: str
    stream: Stream
    y: Floats


@frozen
class SensorVerdict:
    """Whether the logs agree, and whether a filter explains them.

    Attributes
    ----------
    verdict : str
    p_value : float
        Goodness of the joint fit.
    excess : float
        Factor by which the largest rise of the deviance that is allowed to a filter is multiplied.
    differing : str
        Log that differs from the others.
    """

    verdict: Verdict
    p_value: float
    excess: float = 1.0
    differing: str = ""


def summary(
    sources: Sequence[FilterSource],
    logs: Logs,
    best: FilterFit,
    region: Sequence[Explanation],
    judgement: SensorVerdict,
    *,
    deviate: float,
    tolerance: float,
    level: float,
    repeated: tuple[str, ...],
) -> SensorBandwidth:
    """The result for one channel.

    Parameters
    ----------
    sources : sequence of FilterSource
        Sources in the order of the logs.
    logs : Logs
    best : FilterFit
    region : sequence of Explanation
    judgement : SensorVerdict
    deviate : float
        Half the width of an interval in standard errors.
    tolerance, level : float
    repeated : tuple of str
    """
    stream = sources[0].stream
    channel = stream.channels[0]
    if not region or best.fit.levels[0] == 0:
        raise DataError(f"{channel}: the logs have no white noise of the sensor. Record at a higher rate, or longer")
    is_open = judgement.verdict == "rate too low"

    def interval(quantity: Quantity, unit: str) -> Interval:
        """Interval of a quantity that grows with the bandwidth."""
        values = [quantity(each.filter, each.numbers) for each in region]
        high = None if is_open else max(values)
        return Interval(value=quantity(best.filter, best.numbers), low=min(values), high=high, unit=unit)

    densities = [each.density * math.exp(sign * each.spread) for each in region for sign in (-1, 1)]
    names = dict.fromkeys(each.filter.text for each in region)
    unit = coefficient_unit("random_walk", stream.quantity, stream.unit)
    logged = []
    for k, source in enumerate(sources):
        rate = source.stream.grid.rate

        def aliasing(family: SensorFilter, numbers: Floats, rate: float = rate) -> float:
            return family.aliasing(rate, numbers)

        logged.append(
            LoggedRate(
                name=source.name,
                rate=rate,
                duration=logs.spectra[k].duration,
                aliasing=interval(aliasing, "1"),
                random_walk=_random_walk_in_log(logs, best, k, deviate, unit),
                p_value=_goodness(logs, best, k),
                lines=logs.spectra[k].lines,
                curve=allan(Record(streams=(source.stream,)))[channel],
            )
        )
    return SensorBandwidth(
        channel=channel,
        quantity=stream.quantity,
        unit=stream.unit,
        shape=best.filter.text,
        order=best.filter.order,
        alternatives=tuple(name for name in names if name != best.filter.text),
        bandwidth=interval(lambda _, numbers: math.exp(numbers[0]), "Hz"),
        equivalent=interval(lambda family, numbers: family.equivalent(numbers), "Hz"),
        random_walk=Interval(
            value=math.sqrt(float(best.fit.levels[0])),
            low=None if is_open else math.sqrt(min(densities)),
            high=math.sqrt(max(densities)),
            unit=unit,
        ),
        rate_needed=interval(lambda family, numbers: _rate_needed(family, numbers, tolerance), "Hz"),
        tolerance=tolerance,
        logs=tuple(logged),
        response=_response(best, region),
        aliasing=_aliasing(best, region),
        level=level,
        p_value=judgement.p_value,
        verdict=judgement.verdict,
        differing=judgement.differing,
        repeated=repeated,
    )


def _random_walk_in_log(logs: Logs, best: FilterFit, k: int, deviate: float, unit: str) -> Interval:
    """Estimate N of the samples of one log, including aliased noise, with the fitted filter."""
    log = logs.spectra[k]
    # In a single log, converter noise can look like sensor noise, so its level is that of the joint fit.
    converter = float(best.fit.levels[-1]) / log.rate if best.form.converter else 0.0
    alone = Logs.from_spectra([replace(log, quantization=log.quantization + converter)])
    form = replace(best.form, converter=False)
    fit = alone.fit_levels(form, best.numbers)
    level = float(fit.levels[0])
    value = math.sqrt(level) * best.filter.aliasing(log.rate, best.numbers)
    if not level > 0:
        return Interval(value=value, low=None, high=None, unit=unit)
    error = alone.error_of_density(form, best.numbers, fit)
    spread = math.exp(min(0.5 * deviate * error / level, _LARGEST_HALF_WIDTH))
    return Interval(value=value, low=value / spread, high=value * spread, unit=unit)


def _goodness(logs: Logs, best: FilterFit, k: int) -> float:
    """P-value of the joint fit in the bins of one log."""
    place = logs.places[k]
    ratio = logs.density[place] / best.fit.model[place]
    deviance = float(np.sum(logs.modes[place] * (ratio - 1 - np.log(ratio))))
    mean, variance = deviance_law(logs.modes[place])
    return float(normal_below((mean - deviance) / math.sqrt(variance)))


def _rate_needed(family: SensorFilter, numbers: Floats, tolerance: float) -> float:
    """The lowest rate above which aliasing increases N by less than the tolerance. [Hz]"""
    return math.exp(numbers[0]) * _relative_rate_needed(family, tuple(numbers[1:].tolist()), tolerance)


@functools.lru_cache(maxsize=1024)
def _relative_rate_needed(family: SensorFilter, form: tuple[float, ...], tolerance: float) -> float:
    """Needed rate relative to the bandwidth, from the parameters after the first."""
    numbers = np.array([0.0, *form])
    high = _FASTEST * family.equivalent(numbers)
    # The search starts at high rates, because the images of a running mean vanish at some low rates.
    while family.aliasing(low := high / _RATE_STEP, numbers) < 1 + tolerance:
        high = low
    for _ in range(_BISECTIONS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if family.aliasing(middle, numbers) < 1 + tolerance else (middle, high)
    return high


def _response(best: FilterFit, region: Sequence[Explanation]) -> FilterResponse:
    frequency = math.exp(best.numbers[0]) * np.geomspace(_RESPONSE_FROM, _RESPONSE_TO, _RESPONSES)
    powers = np.array([each.filter.power(frequency, each.numbers) for each in region])
    return FilterResponse(
        frequency=frequency,
        power=best.filter.power(frequency, best.numbers),
        low=powers.min(axis=0),
        high=powers.max(axis=0),
    )


def _aliasing(best: FilterFit, region: Sequence[Explanation]) -> AliasingCurve:
    rates = math.exp(best.numbers[0]) * np.geomspace(_RATE_FROM, _RATE_TO, _RATES)
    factors = np.array([[each.filter.aliasing(rate, each.numbers) for rate in rates.tolist()] for each in region])
    return AliasingCurve(
        rate=rates,
        factor=np.array([best.filter.aliasing(rate, best.numbers) for rate in rates.tolist()]),
        low=factors.min(axis=0),
        high=factors.max(axis=0),
    )
