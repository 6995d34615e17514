"""ROS: the covariances of ``sensor_msgs/Imu``, row by row, as YAML.

They are covariances of one sample: measured if the source is a record (see `Source.samples`), otherwise from the model.
Unfiltered white noise of density N² has the variance N²·rate; after a low-pass filter the variance is smaller and samples
are correlated, which the message cannot express. All zeros mean unknown; −1 as the first element means no such data.
"""

from __future__ import annotations

import functools

import numpy as np

from sigmatau.errors import DataError
from sigmatau.exporting.axes import by_axis
from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.text import joined, vector
from sigmatau.exporting.values import Number, Numbers
from sigmatau.findings.exporting import CorrelatedSamples
from sigmatau.findings.finding import Finding
from sigmatau.hints import Hint
from sigmatau.model.channel import ChannelModel
from sigmatau.noise.terms import SLOW, TERMS
from sigmatau.record.record import stream_name
from sigmatau.results import seconds
from sigmatau.statespace.state_space import state_space

_FIELDS = (
    ("gyro", "angular_velocity_covariance", "(rad/s)^2"),
    ("accel", "linear_acceleration_covariance", "(m/s^2)^2"),
)
_ABSENT = [-1.0, *[0.0] * 8]
_INDEPENDENT = "assumes independent samples"
_SAME_RATE = 1e-3  # largest relative difference of rates that count as equal
_INDEPENDENT_RATIO = 1.2  # largest ratio of the variance to N²·rate, or its inverse, for independent samples


def write(numbers: Numbers) -> str:
    """The text of the file, with the keys of the message."""
    if not any(numbers.has(sensor) for sensor, _, _ in _FIELDS):
        raise DataError("the model has neither gyros nor accelerometers; sensor_msgs/Imu needs one of them")
    slow = [TERMS[name].label("signal") for name in SLOW]
    lines = [
        "# sensor_msgs/Imu: covariance of one sample, row by row. [0] = -1: no such data.",
        f"# About a constant bias: without {', '.join(slow[:-1])} and {slow[-1]}.",
        f"orientation_covariance: {vector(_ABSENT)}  # no attitude in a noise model",
    ]
    for sensor, field, unit in _FIELDS:
        if not numbers.has(sensor):
            lines.append(f"{field}: {vector(_ABSENT)}  # not in the model")
            continue
        variances = by_axis(numbers, sensor, functools.partial(_variance, sensor=sensor))
        matrix = np.diag([variance.value for variance in variances])
        together = ""
        if numbers.choices.axes == "each" and _shared(numbers, sensor):
            names = [f"{sensor}_{axis}" for axis in "xyz"]
            for term, term_variance in (("random_walk", _white), ("quantization", _quantization)):
                deviation = np.sqrt([term_variance(numbers, name) for name in names])
                matrix += (numbers.model.of(names).correlation_matrix(term) - np.eye(3)) * np.outer(
                    deviation, deviation
                )
        elif _shared(numbers, sensor):
            each = Hint("axes", value="each")
            together = f"; correlated axes are treated as independent; {each} writes their covariance"
        lines.append(f"{field}: {vector(matrix.ravel())}  # {unit}; {joined(v.words for v in variances)}{together}")
    return "\n".join(lines) + "\n"


def _variance(numbers: Numbers, *, sensor: str) -> Number:
    """Variance of a sample, by `Choices.axes`."""
    variances = {name: _channel_variance(numbers, name) for name in numbers.channels(sensor)}
    if len(variances) == 1:
        return next(iter(variances.values()))
    if numbers.choices.axes == "mean":
        words = " | ".join(variance.words for variance in variances.values())
        value = sum(variance.value for variance in variances.values()) / len(variances)
        white = (
            f"; in the mean N^2*rate = {numbers.noise(sensor).value ** 2 * numbers.rate():.4g}"
            if any(_has_value_of_white_noise(numbers, name) for name in variances)
            else ""
        )
        return Number(value=value, words=f"mean of {', '.join(variances)} ({words}){white}")
    worst = max(variances.values(), key=lambda variance: variance.value)
    return Number(value=worst.value, words=f"worst of {len(variances)} axes, {worst.words}")


def _channel_variance(numbers: Numbers, name: str) -> Number:
    """Variance of a sample of one channel: measured if the source is a record, otherwise from the model."""
    measured = _measured(numbers, name)
    model = numbers.model.channels[name]
    if measured is None:
        return Number(
            value=_modelled(numbers, name), words=f"{name}: {_parts(numbers, name)}{_filtered(numbers, name)}"
        )
    factor = numbers.factor("random_walk", stream_name(name))
    value = factor**2 * measured
    words = f"{name}: measured, about the mean of {seconds(numbers.source.samples[name].time)} s"
    if factor != 1:
        words += f", {measured!r} times {factor:g}^2"
    if "random_walk" in model:
        independent = numbers.channel_noise(name).value ** 2 * numbers.rate()
        words += f"; N^2*rate = {independent:.4g} is for a filter that {_INDEPENDENT}"
        _correlated(numbers, name, value, independent)
    return Number(value=value, words=words + numbers.doubt(name))


def _has_value_of_white_noise(numbers: Numbers, name: str) -> bool:
    """Whether the variance of white noise is also stated, because it differs from that of the samples."""
    model = numbers.model.channels[name]
    return "random_walk" in model if _measured(numbers, name) is not None else model.bandwidth is not None


def _measured(numbers: Numbers, name: str) -> float | None:
    """Measured variance of a sample; None if unknown, at another rate, or if a random walk was chosen."""
    chosen = stream_name(name) in numbers.choices.noise and "random_walk" not in numbers.model.channels[name]
    sample, rate = numbers.source.samples.get(name), numbers.source.rates.get(name, 0.0)
    if chosen or sample is None or abs(numbers.rate() - rate) > _SAME_RATE * rate:
        return None
    return sample.variance


def _parts(numbers: Numbers, name: str) -> str:
    """Contributions to the variance of the model."""
    model = numbers.model.channels[name]
    noise = numbers.channel_noise(name)
    parts = "N^2*rate" if model.bandwidth is None else "variance behind the low-pass filter"
    parts += " + 2*(Q*rate)^2" if "quantization" in model else ""
    parts += " + sigma^2 of the Gauss-Markov noise" if model.gauss_markov else ""
    parts += " + sigma^2 of the resonances" if model.resonance else ""
    parts += " + amplitude^2/2 of the sinusoids" if model.sinusoid else ""
    if model.bandwidth is not None:
        independent = noise.value**2 * numbers.rate()
        parts += f" of {model.bandwidth.corner:g} Hz: samples are correlated, and N^2*rate = {independent:.4g} is for"
        parts += f" a filter that {_INDEPENDENT}"
    return f"{parts}; {noise.words}"


def _correlated(numbers: Numbers, name: str, value: float, independent: float) -> None:
    """Add a finding if the variance of a sample differs from that of independent samples with the same random walk."""
    if 1 / _INDEPENDENT_RATIO <= value / independent <= _INDEPENDENT_RATIO:
        return
    corner = numbers.source.corners.get(name) if value < independent else None
    details = CorrelatedSamples(ratio=value / independent, independent_variance=independent, corner=corner)
    numbers.add_finding(Finding(severity="warning", channels=(name,), details=details))


def _filtered(numbers: Numbers, name: str) -> str:
    """Build the remark and the finding on a low-pass filter that the analysis detected and the model lacks."""
    model, corner = numbers.model.channels[name], numbers.source.corners.get(name)
    if corner is None or model.bandwidth is not None:
        return ""
    independent = numbers.channel_noise(name).value ** 2 * numbers.rate()
    details = CorrelatedSamples(ratio=None, independent_variance=independent, corner=corner)
    numbers.add_finding(Finding(severity="warning", channels=(name,), details=details))
    return f"; without the low-pass filter of {corner:.3g} Hz that the analysis found"


def _shared(numbers: Numbers, sensor: str) -> bool:
    """Whether white noise or quantization of two axes of a sensor is correlated."""
    pairs = (pair for term in ("random_walk", "quantization") for pair in numbers.model.correlation.get(term, {}))
    return any(set(pair) <= set(numbers.channels(sensor)) for pair in pairs)


def _quantization(numbers: Numbers, name: str) -> float:
    """Variance of quantization in one sample: the difference of two errors of the angle, over the interval."""
    q = numbers.factor("random_walk", stream_name(name)) * numbers.model.channels[name].get("quantization", 0.0)
    return 2 * (q * numbers.rate()) ** 2


def _white(numbers: Numbers, name: str) -> float:
    """Variance of the random walk in one sample."""
    model = numbers.model.channels[name]
    noise = numbers.channel_noise(name).value  # observed or chosen, including the factor
    alone = ChannelModel(
        terms={"random_walk": noise}, bandwidth=model.bandwidth, quantity=model.quantity, unit=model.unit
    )
    system = state_space(alone, dt=1 / numbers.rate())
    return float((system.H @ system.P0 @ system.H.T + system.R)[0, 0])


def _modelled(numbers: Numbers, name: str) -> float:
    """Variance of a sample of the model, without a constant bias."""
    model, square = numbers.model.channels[name], numbers.factor("random_walk", stream_name(name)) ** 2
    processes = sum(g.sigma**2 for g in model.gauss_markov) + sum(resonance.sigma**2 for resonance in model.resonance)
    processes += sum(line.amplitude**2 / 2 for line in model.sinusoid)
    return _white(numbers, name) + _quantization(numbers, name) + square * processes


TARGET = Target(
    name="ros",
    program="ROS (sensor_msgs/Imu)",
    columns=("N²·f", "`--filter-rate`"),
    aliases=("robot-localization",),
    summary="ROS sensor_msgs/Imu covariances of one sample, measured or N^2*rate of a model, by axis",
    ending=".yaml",
    write=write,
    sensors="either",
    needs_axes=True,
    needs_rate=True,
    per_axis=True,
    unused=(Unused(choices=("walk", "walk_factor"), why="the message has the noise of a sample only, no bias"),),
)
