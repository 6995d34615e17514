"""MATLAB: ``gyroparams`` and ``accelparams`` of its IMU simulator, as a script.

``IMUSensorSimulator.m`` of R2023b with ``NoiseType`` single-sided generates white noise of NoiseDensity·√rate and a
random walk of RandomWalk/√rate per sample, so that the two-sided N and K are written unchanged. The default,
double-sided, uses √(rate/2) instead of √rate: the noise is √2 smaller and the walk √2 larger. BiasInstability drives the
filter ``BiasInstabilityCoefficients`` with B per sample. The default, ``fractalcoef`` with one pole, has a memory of two
samples and generates white noise; P poles generate 1/f noise with B of IEEE Std 952 up to P samples.
"""

from __future__ import annotations

import math

from sigmatau.digits import limit_text, two_digits
from sigmatau.errors import DataError, OptionError
from sigmatau.exporting.axes import by_axis, noises
from sigmatau.exporting.gauss_markov import find_exact_time
from sigmatau.exporting.statements import omitted_noise
from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.text import comment, joined, vector
from sigmatau.exporting.values import Number, Numbers
from sigmatau.hints import Hint
from sigmatau.noise.terms import SLOW, display_units
from sigmatau.results import seconds

_MAX_POLES = 100_000  # a minute at 100 Hz then takes 10 s per axis, at 1e9 multiplications per second

_SENSORS = (("gyro", "gyroparams", "rad/s"), ("accel", "accelparams", "m/s^2"))


def write(numbers: Numbers) -> str:
    """Text of the script; ``gyro`` and ``accel`` are the arguments of imuSensor."""
    present = [row for row in _SENSORS if numbers.has(row[0])]
    if not present:
        raise DataError("the model has neither gyros nor accelerometers; imuSensor needs one of them")
    lines = ["% Row vectors are x, y, z. NoiseType and fractalcoef are of R2023b and later."]
    for sensor, kind, unit in present:
        lines += [
            f"{sensor} = {kind};",
            f"{sensor}.NoiseType = 'single-sided';"
            "  % N and K unchanged; 'double-sided' makes the noise sqrt(2) smaller, the walk sqrt(2) larger",
            _row(f"{sensor}.NoiseDensity", noises(numbers, sensor), f"({unit})/sqrt(Hz), N, two-sided"),
            *_bias(numbers, sensor, unit),
            *_walk(numbers, sensor, unit),
            *(f"% {comment(sentence)}" for sentence in _omitted(numbers, sensor)),
        ]
    if numbers.known_rate() is not None and len(present) == 2:
        rate = numbers.rate_text()
        lines.append(
            f"imu = imuSensor('accel-gyro', 'SampleRate', {rate}, 'Gyroscope', gyro, 'Accelerometer', accel);  % Hz"
        )
    return "\n".join(lines) + "\n"


def _omitted(numbers: Numbers, sensor: str) -> list[str]:
    """Remark on the noise without a field; a walk that is correct at a horizon approximates all slow noise."""
    is_approximated = numbers.choices.walk.get(sensor) == "horizon"
    slow = SLOW if is_approximated else ("bias_instability", "rate_random_walk")
    return omitted_noise(numbers, sensor, written=("random_walk", *slow))


def _has_flicker(numbers: Numbers, sensor: str) -> bool:
    """Whether any axis has bias instability that is not replaced by a chosen random walk."""
    shown = any("bias_instability" in model for model in numbers.channels(sensor).values())
    return shown and numbers.choices.walk.get(sensor) != "horizon"


def _bias(numbers: Numbers, sensor: str, unit: str) -> list[str]:
    key = f"{sensor}.BiasInstability"
    channels = numbers.channels(sensor)
    if not _has_flicker(numbers, sensor):
        if numbers.choices.walk.get(sensor) == "horizon":
            return [f"% {key} stays 0: RandomWalk approximates it, as chosen"]
        kinds = {"Gauss-Markov bias": "gauss_markov", "resonances": "resonance"}
        omitted = [text for text, kind in kinds.items() if any(getattr(model, kind) for model in channels.values())]
        omitted_words = f"; no field for the {' and '.join(omitted)} of the model" if omitted else ""
        return [f"% {key} stays 0: not observed{_limit_remark(numbers, sensor, 'bias_instability')}{omitted_words}"]
    values = by_axis(numbers, sensor, lambda axis: _combine_bias(axis, sensor))
    poles, time = _poles(numbers, sensor)
    return [
        _row(key, values, f"{unit}, B of IEEE Std 952, 1/0.664 of the lowest point"),
        f"{sensor}.BiasInstabilityCoefficients = fractalcoef({poles});"
        f"  % 1/f noise, to 7 % up to {seconds(time)} s; fewer poles mean less work per sample and a shorter time",
    ]


def _poles(numbers: Numbers, sensor: str) -> tuple[int, float]:
    """Number of poles of the 1/f filter, one per sample up to the longest accurate time, and this time."""
    time = numbers.choices.horizon
    if time is None:
        bottoms = [
            find_exact_time(numbers, name)[0] for name, m in numbers.channels(sensor).items() if "bias_instability" in m
        ]
        time = max((bottom for bottom in bottoms if bottom is not None), default=None)
    rate = numbers.known_rate()
    if time is None or rate is None:
        lacking = [Hint("filter_rate")] * (rate is None) + [Hint("horizon")] * (time is None)
        raise OptionError(
            f"{sensor}: MATLAB simulates bias instability with a filter of one pole per sample of the time up to which it"
            f" is accurate: give {', '.join(map(str, lacking))}",
            option="filter_rate" if time is not None else "horizon",
        )
    poles = max(math.ceil(time * rate - 1e-9), 1)
    if poles > _MAX_POLES:
        raise OptionError(
            f"{sensor}: bias instability up to {seconds(time)} s at {rate:g} Hz needs a filter of {poles} poles, more than"
            f" {_MAX_POLES}, which is too slow: give"
            f" {Hint('horizon', value=two_digits(_MAX_POLES / rate / 1.1))} or less, or"
            f" {Hint('walk', sensor, 'horizon')} to approximate it by a random walk",
            option="horizon",
        )
    return poles, time


def _combine_bias(numbers: Numbers, sensor: str) -> Number:
    """B of the channels with bias instability, by `Choices.axes`; 0 without such channels."""
    values = {n: m["bias_instability"] for n, m in numbers.channels(sensor).items() if "bias_instability" in m}
    factor = numbers.factor("rate_random_walk", sensor)
    if not values:
        return Number(value=0.0, words=f"{', '.join(numbers.channels(sensor))}: not observed, 0")
    times = "" if factor == 1 else f", times {factor:g}"
    doubts = next(filter(None, map(numbers.doubt, values)), "")
    if numbers.choices.axes == "mean":
        mean = (sum(value**2 for value in values.values()) / len(values)) ** 0.5
        return Number(value=factor * mean, words=f"root mean square of {', '.join(values)}{times}{doubts}")
    axis = max(values, key=lambda name: values[name])
    model = numbers.model.channels[axis]
    text, size = display_units("bias_instability", model.quantity, model.unit)[-1]
    worst = f"worst of {len(values)} axes, " if len(values) > 1 else ""
    return Number(
        value=factor * values[axis],
        words=f"{worst}{axis}: {values[axis] / size:.4g} {text}{times}{numbers.doubt(axis)}",
    )


def _walk(numbers: Numbers, sensor: str, unit: str) -> list[str]:
    key = f"{sensor}.RandomWalk"
    if not _has_walk(numbers, sensor):
        return [f"% {key} stays 0: not observed{_limit_remark(numbers, sensor, 'rate_random_walk')}"]
    return [_row(key, by_axis(numbers, sensor, lambda axis: _combine_walk(axis, sensor)), f"({unit})*sqrt(Hz), K")]


def _has_walk(numbers: Numbers, sensor: str) -> bool:
    observed = any("rate_random_walk" in model for model in numbers.channels(sensor).values())
    return observed or sensor in numbers.choices.walk


def _combine_walk(numbers: Numbers, sensor: str) -> Number:
    """K by `Choices.axes`; 0 for an axis without K if other axes have K and no value was chosen."""
    channels = numbers.channels(sensor)
    if not _has_walk(numbers, sensor):
        return Number(value=0.0, words=f"{', '.join(channels)}: not observed, 0")
    return numbers.walk(sensor)


def _limit_remark(numbers: Numbers, sensor: str, term: str) -> str:
    limits = [model.limits[term] for model in numbers.channels(sensor).values() if term in model.limits]
    if len(limits) < len(numbers.channels(sensor)):
        return ""
    unit = next(iter(numbers.channels(sensor).values())).unit_of(term)
    return comment(f", {limit_text(max(limits))} {unit}")


def _row(key: str, values: tuple[Number, Number, Number], unit: str) -> str:
    about = joined(value.words for value in values)
    return f"{key} = {vector(value.value for value in values)};  % {unit}; {about}"


def _is_without_flicker(numbers: Numbers) -> bool:
    return not any(_has_flicker(numbers, sensor) for sensor, _, _ in _SENSORS if numbers.has(sensor))


def _is_without_horizon(numbers: Numbers) -> bool:
    return _is_without_flicker(numbers) and "horizon" not in numbers.choices.walk.values()


def _is_without_slow_noise(numbers: Numbers) -> bool:
    walks = (_has_walk(numbers, sensor) for sensor, _, _ in _SENSORS if numbers.has(sensor))
    return _is_without_flicker(numbers) and not any(walks)


TARGET = Target(
    name="matlab",
    program="MATLAB (gyroparams, accelparams)",
    columns=("N, B, K", "`--filter-rate` for B and the sensor; `--horizon`, if the curve has no minimum"),
    summary="MATLAB gyroparams, accelparams: N, B, K, type of the densities, a filter that makes B, by axis",
    ending=".m",
    write=write,
    sensors="either",
    may_need_rate=True,  # for bias instability
    needs_axes=True,
    has_horizon=True,
    per_axis=True,
    unused=(
        Unused(choices=("horizon",), why="the model has no bias instability", when=_is_without_horizon),
        Unused(choices=("walk_factor",), why="the model has neither K nor B", when=_is_without_slow_noise),
    ),
)
