"""Bandwidth of a sensor from records at several sampling rates, section IV-C and Fig. 12 of the paper.

White noise of density N² that passes the filter H of a sensor has the density N² Σ_k |H(f + k·rate)|² when it is sampled
without an anti-alias filter. Slow rates measure N² times the area of |H|², and fast rates measure the shape of |H|². All
logs together determine N, the bandwidth and the order, even if no rate is far above the bandwidth.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from sigmatau._native.distributions import chi2_quantile_above, normal_below
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting.filter_fit import FilterFit, Logs, best_fits, deviance_law
from sigmatau.fitting.filter_region import Contradiction, contradiction, explanations, is_white
from sigmatau.fitting.filter_summary import FilterSource, SensorVerdict, summary
from sigmatau.fitting.log_spectra import log_spectrum
from sigmatau.fitting.sensor_bandwidth import Bandwidths, SensorBandwidth
from sigmatau.record.record import Record

_SIGNIFICANT = 1e-3  # p-value of a difference between logs, a misfit of all filters, or a visible bandwidth
_TOLERATED_N = 1.05  # largest ratio of N between logs of one sensor: temperature changes N by a few percent
_TOLERATED_BANDWIDTH = 1.1  # largest ratio of the bandwidth between logs of one sensor
# spread of the deviance over that of χ²: with a known filter, errors were 1.06 times those stated (167 sensors)
_SPREAD = 1.1
_PAIR = 2  # number of logs without a majority if they disagree
_SAME_SAMPLES = 64  # number of consecutive equal samples that two records of noise cannot have in common


def bandwidth(
    records: Record | Sequence[Record] | Mapping[str, Record],
    *,
    channels: Sequence[str] | None = None,
    tolerance: float = 0.02,
    level: float = 0.95,
) -> Bandwidths:
    """Bandwidth and filter of a sensor, N without aliasing, and the rate to sample at.

    Parameters
    ----------
    records : Record, sequence of Record, or mapping of str to Record
        Records of one sensor at rest, at one or several sampling rates, without an anti-alias filter after the sensor.
        The rates may be equal, but the records must be recorded one after the other: a copy with every k-th sample adds
        no information and is not used.
    channels : sequence of str, optional
        Default: all but temperatures.
    tolerance : float
        Excess of N by aliasing that is allowed at the recommended rate. [1]
    level : float
        Confidence level of the intervals. [1]

    Returns
    -------
    Bandwidths
        `SensorBandwidth` by channel.

    Raises
    ------
    OptionError
        For a channel that no record has, or a tolerance or level out of range.
    TypeError
        If an argument is not a record.
    DataError
        If a log contradicts the others, for example because it is of another sensor or configuration; if there are no
        channels.
    RecordTooShortError
        If a log has too few samples without gaps.

    See Also
    --------
    sigmatau.analyze : finds the filter from a single log.

    Notes
    -----
    Slow noise of each log is in the model as 1/f and 1/f², rounding with step²/12, and white noise of the converter if
    the logs require it. Filters with one to six poles, running means and tapered FIR filters are compared by their
    deviance, with a penalty of 4 for each further parameter; digital filters too, if all records have one rate. The
    intervals contain all that explain the logs as well. See :doc:`/study/bandwidth-instrument` for the coverage.

    References
    ----------
    Section IV-C and Fig. 12 of :doi:`10.1109/TIM.2007.908635`.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": st.ChannelModel(
    ...     terms={"random_walk": 1e-4}, bandwidth=st.LowPass(order=1, corner=30.0))})
    >>> records = [st.simulate(model, duration=100, rate=rate, rng=k) for k, rate in enumerate((50, 500))]
    >>> result = st.bandwidth(records)["gyro_x"]
    >>> result.shape, result.bandwidth.low < 30 < result.bandwidth.high
    ('one pole', True)
    """
    for option, share in (("tolerance", tolerance), ("level", level)):
        if not (isinstance(share, int | float) and 0 < share < 1):
            raise OptionError(f"{{option}} must be between 0 and 1, not {share!r}", option=option)
    named = _records_by_name(records)
    available = dict.fromkeys(
        c for r in named.values() for s in r.streams if s.quantity != "temperature" for c in s.channels
    )
    if not available:
        raise DataError("no channel to use: the records have temperatures only")
    for channel in channels or ():
        if channel not in available:
            raise OptionError(f"{{option}} must be some of {', '.join(available)}, not {channel!r}", option="channels")
    return Bandwidths(
        {
            channel: _channel_bandwidth(channel, named, tolerance=tolerance, level=level)
            for channel in channels or available
        }
    )


def _records_by_name(records: Record | Sequence[Record] | Mapping[str, Record]) -> dict[str, Record]:
    """Name the records by the given name, the name of their file, or their rate."""
    named: dict[str, Record] = dict(records) if isinstance(records, Mapping) else {}
    unnamed = [] if named or isinstance(records, Mapping) else [records] if isinstance(records, Record) else records
    for record in (*named.values(), *unnamed):
        if not isinstance(record, Record):
            raise TypeError(f"`records` must be records, e.g. of sigmatau.read, not a {type(record).__name__}")
    for k, record in enumerate(unnamed, 1):
        name = record.provenance.path or f"{record.streams[0].grid.rate:.6g} Hz"
        named[f"{name} ({k})" if name in named else name] = record
    if not named:
        raise OptionError("{option} is empty; give at least one", option="records")
    return named


def _channel_bandwidth(channel: str, named: Mapping[str, Record], *, tolerance: float, level: float) -> SensorBandwidth:
    sources, repeated = _sources(channel, named)
    stream = sources[0].stream
    for source in sources:
        if (source.stream.quantity, source.stream.unit) != (stream.quantity, stream.unit):
            raise DataError(
                f"{source.name}: {channel} is in {source.stream.unit}, in {sources[0].name} in {stream.unit}. Give logs of"
                " one sensor"
            )
    logs = Logs.from_spectra(
        [log_spectrum(source.name, source.stream.grid.rate, source.y, channel) for source in sources]
    )
    fits = best_fits(logs)
    judgement = _judge(logs, fits[0], channel)
    quantile = _SPREAD * float(chi2_quantile_above(1, 1 - level))
    region = explanations(logs, fits, quantile * judgement.excess)
    if is_white(logs, fits, float(chi2_quantile_above(1, _SIGNIFICANT)) * judgement.excess):
        judgement = replace(judgement, verdict="rate too low")
    return summary(
        sources, logs, fits[0], region, judgement, deviate=math.sqrt(quantile), tolerance=tolerance, level=level,
        repeated=repeated,
    )  # fmt: skip


def _sources(channel: str, named: Mapping[str, Record]) -> tuple[list[FilterSource], tuple[str, ...]]:
    """Collect the logs with this channel by rate, and the names of those that are left out: a faster log contains their
    samples.
    """
    every = []
    for name, record in named.items():
        if channel in record.channels:
            stream = record.stream_of(channel).only(channel)
            every.append(FilterSource(name=name, stream=stream, y=stream.column(channel)))
    every.sort(key=lambda source: source.stream.grid.rate)
    repeated = [
        source.name for k, source in enumerate(every) if any(_contains_samples(fast, source) for fast in every[k + 1 :])
    ]
    return [source for source in every if source.name not in repeated], tuple(repeated)


def _contains_samples(fast: FilterSource, slow: FilterSource) -> bool:
    """Whether every k-th sample of a log equals a sample at the beginning of a slower log."""
    step = round(fast.stream.grid.rate / slow.stream.grid.rate)
    count = min(_SAME_SAMPLES, len(slow.y), len(fast.y) // step)
    begin = slow.y[:count]
    # Written values may differ by their last digit; equal constants are not copies.
    return bool(count and np.ptp(begin) > 0 and np.allclose(begin, fast.y[: count * step : step], rtol=1e-5, atol=0))


def _judge(logs: Logs, best: FilterFit, channel: str) -> SensorVerdict:
    """Test whether the logs agree, and whether a filter explains them."""
    mean, variance = deviance_law(logs.modes)
    p = float(normal_below((mean - best.fit.deviance) / math.sqrt(variance)))
    contradicts = contradiction(logs, best, _SIGNIFICANT)
    if contradicts is not None:
        if contradicts.exceeds(_TOLERATED_N, _TOLERATED_BANDWIDTH):
            raise DataError(_contradiction_text(contradicts, len(logs.spectra), channel))
        excess = max(1.0, contradicts.chi2 / contradicts.freedom)
        return SensorVerdict(verdict="logs differ", p_value=p, excess=excess, differing=contradicts.name)
    if p < _SIGNIFICANT:
        return SensorVerdict(verdict="not explained", p_value=p, excess=max(1.0, best.fit.deviance / mean))
    return SensorVerdict(verdict="adequate", p_value=p)


def _contradiction_text(contradicts: Contradiction, count: int, channel: str) -> str:
    ratio = contradicts.bandwidth_ratio
    difference = f"N is {contradicts.ratio:.3g} times"
    if ratio is not None and abs(math.log(ratio)) > abs(math.log(contradicts.ratio)):
        difference = f"bandwidth is {ratio:.3g} times"
    reference = "that of the other logs" if count > _PAIR else "that of the other log"
    return (
        f"{contradicts.name}: {channel} is of another sensor or configuration: its {difference} {reference}"
        f" (χ² = {contradicts.chi2:.0f}, {contradicts.freedom} degrees of freedom). Leave this log out, or record all logs"
        " with one configuration"
    )
