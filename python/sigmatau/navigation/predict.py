"""Error growth of free inertial navigation at rest, by term of the sensors' noise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.numbers import changed_processes, difference_step, explanations
from sigmatau.model.parameters import Covariance, Parameter
from sigmatau.model.processes import check_sampling_rate, real
from sigmatau.navigation.error_covariance import Earth, Mechanisation, NoiseSource, mechanisations, source
from sigmatau.navigation.prediction import PredictedError, Prediction
from sigmatau.record.record import stream_name

_MAX_STEPS = 1e12


def predict(
    model: NoiseModel,
    *,
    after: ArrayLike,
    calibration: float | None = None,
    rate: float,
    earth: Earth = "round",
    turn_on: Mapping[str, float] | None = None,
    flicker_error: float = 0.01,
    level: float = 0.95,
) -> Prediction:
    """Errors of unaided inertial navigation at rest, from the noise of the sensors.

    The errors are the heading from gyro_z, roll and pitch from gyro_x and gyro_y, and velocity and position from each
    accelerometer. The errors of a level accelerometer include the tilt error of the gyro perpendicular to it, if the
    model has that gyro. Axes x and y are level, z is up.

    Parameters
    ----------
    model : NoiseModel
        Noise of the sensors.
    after : array_like, shape (n_times,)
        Times since the start, rounded to whole steps. [s]
    calibration : float, optional
        Time at rest before the start. The mean of each rate over this time is subtracted afterwards: it levels the
        level accelerometers and removes the bias of gyros. Default: no calibration; the state at the start is known,
        and walks and flicker noise begin at 0. [s]
    rate : float
        Sampling rate: steps per second. [Hz]
    earth : {"round", "flat"}
        Whether Schuler's feedback of the velocity into the tilt and the decrease of gravity with height are included.
    turn_on : mapping of str to float, optional
        Without a calibration: standard deviations of constant biases, by channel. [rad/s, m/s²]
    flicker_error : float
        Largest relative error of the Allan deviation of flicker noise.
    level : float
        Confidence level of the intervals, which follow from `ChannelModel.covariance`.

    Returns
    -------
    Prediction
        If another model explains the record equally well (`ChannelModel.alike_from`, `ChannelModel.alternatives`), the
        interval includes both; the rms is that of the model. Terms that the record did not show count as 0 in the rms; the
        interval and `PredictedError.at_most` include their limits. If the record shows that one of several terms is present
        but not which, `at_most` includes the limits of all of them, and the interval includes their errors.

    Raises
    ------
    OptionError
        For anything but a `NoiseModel`, times that are not positive, an unknown Earth, a turn-on bias of a channel that does
        not exist or is not an inertial sensor, or both a turn-on bias and a calibration, which removes it.
    DataError
        For a model with neither a gyro nor an accelerometer.

    See Also
    --------
    NoiseModel : the model of the sensors.
    fit : the model from a record.

    Notes
    -----
    The covariance of sensor states, subtracted means and errors is propagated exactly for sampled noise; see
    `sigmatau.navigation.error_covariance`. Only increments of flicker noise are defined. With a calibration only increments
    matter. Without one all its Gauss-Markov processes begin at 0, so that the angle error is 0.664·B·t, the smallest
    possible. In a record of `simulate` only the first sample of flicker noise is 0, so errors are larger, by the factor
    `Prediction.flicker_in_records`.

    References
    ----------
    docs/theory/prediction.md has the equations.

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_z": {"random_walk": 1e-4}})
    >>> float(st.predict(model, after=[60], rate=100)["heading"].rms[0].round(6))  # 1e-4·√60 rad
    0.000775
    """
    if not isinstance(model, NoiseModel):
        raise OptionError(
            "{option} must be a NoiseModel, NoiseModel(channels={'gyro_z': …}) or the one of an analysis, analysis.model;"
            f" not {type(model).__name__}",
            option="model",
        )
    predicted = partial(
        _predicted,
        after=after,
        calibration=calibration,
        rate=rate,
        earth=earth,
        turn_on=turn_on,
        flicker_error=flicker_error,
        level=level,
    )
    model = model.expand_matern(rate=check_sampling_rate(rate))
    made = predicted(model)
    for explanation in _other_explanations(model):
        also = predicted(explanation)
        made = replace(made, errors={name: _joined(made[name], also[name]) for name in made})
    alike = {name: channel.alike_from.time for name, channel in model.items() if channel.alike_from is not None}
    return replace(made, alike_from=alike)


def _other_explanations(model: NoiseModel) -> Iterator[NoiseModel]:
    """The models that explain the record as well: the first has the first alternative of each channel that has one, the
    second has the second …
    """
    alternatives = {name: explanations(channel) for name, channel in model.items()}
    for k in range(1, max(map(len, alternatives.values()))):
        channels = {name: several[min(k, len(several) - 1)] for name, several in alternatives.items()}
        correlation = {
            term: {pair: value for pair, value in pairs.items() if all(term in channels[name] for name in pair)}
            for term, pairs in model.correlation.items()
        }
        yield NoiseModel(channels=channels, correlation=correlation)


def _joined(error: PredictedError, second: PredictedError) -> PredictedError:
    """An error whose interval includes both explanations."""
    both = (error, second)
    low = np.minimum(*(each.rms if each.low is None else each.low for each in both))
    high = np.maximum(*(each.rms if each.high is None else each.high for each in both))
    limits = [each.at_most for each in both if each.at_most is not None]
    return replace(error, low=low, high=high, at_most=np.max([high, *limits], axis=0) if limits else None)


def _predicted(
    model: NoiseModel,
    *,
    after: ArrayLike,
    calibration: float | None,
    rate: float,
    earth: Earth,
    turn_on: Mapping[str, float] | None,
    flicker_error: float,
    level: float,
) -> Prediction:
    steps = _steps(after, rate)
    average = 0 if calibration is None else _whole_steps("calibration", calibration, rate)
    if earth not in ("round", "flat"):
        raise OptionError(f"{{option}} must be 'round' or 'flat', not {earth!r}", option="earth")
    if not 0 < real(level) < 1:
        raise OptionError(f"{{option}} must lie between 0 and 1, not {level!r}", option="level")
    turn_on = _checked({} if turn_on is None else turn_on, model, calibration)
    dt = 1 / rate
    errors: dict[str, PredictedError] = {}
    taken_as_exact: dict[tuple[str, str], None] = {}
    unobserved: dict[tuple[str, str], None] = {}
    undecided: dict[tuple[str, str], None] = {}
    ratios: list[Floats] = []
    recorded = min((channel.duration for channel in model.values() if channel.duration), default=0.0)
    reached = 0.0
    for equations in mechanisations(tuple(model.channels), earth=earth):
        sources: dict[tuple[str, str], tuple[Floats, Floats]] = {}
        made: dict[tuple[str, str], NoiseSource] = {}
        limited: dict[tuple[str, str], tuple[Floats, Floats]] = {}
        moved: dict[tuple[str, Parameter], Floats] = {}
        for k, channel in enumerate(equations.inputs):
            gains = np.eye(len(equations.inputs))[k]
            longest = (average + int(steps[-1])) * dt
            parts = {
                name: source(part, dt=dt, tau_max=longest, flicker_error=flicker_error, calibrated=average > 0)
                for name, part in model[channel].parts().items()
            }
            for parameter, changed in changed_processes(model[channel]).items():
                noise_source = source(
                    changed, dt=dt, tau_max=longest, flicker_error=flicker_error, calibrated=average > 0
                )
                moved[channel, parameter] = noise_source.errors(
                    equations, gains, dt=dt, calibration=average, steps=steps
                )[1]
            for name, limit in _limited(model[channel]).items():
                noise_source = source(
                    limit, dt=dt, tau_max=longest, flicker_error=flicker_error, calibrated=average > 0
                )
                limited[channel, name] = noise_source.errors(equations, gains, dt=dt, calibration=average, steps=steps)
                reached = max(reached, noise_source.flicker_error)
            if turn_on.get(channel):
                parts["turn_on"] = NoiseSource.constant(turn_on[channel])
            for name, part in parts.items():
                made[channel, name] = part
                sources[channel, name] = part.errors(equations, gains, dt=dt, calibration=average, steps=steps)
                reached = max(reached, part.flicker_error)
            if not average and "bias_instability" in parts:
                flicker = source(
                    model[channel].parts()["bias_instability"],
                    dt=dt,
                    tau_max=longest,
                    flicker_error=flicker_error,
                    calibrated=True,
                )
                rows = list(equations.rows.values())
                here = sources[channel, "bias_instability"][1][:, rows]
                by_steps = _as_simulated(flicker, equations, gains, dt, steps)[:, rows]
                ratios.append(np.where(here > 0, by_steps / np.where(here > 0, here, 1.0), 1.0))
        for key, variance in _correlated(model, equations, made, sources, dt, average, steps).items():
            sources[key] = np.zeros_like(variance), variance
        for name, row in equations.rows.items():
            error, exact_parts = _error(
                name,
                model,
                {key: (m[:, row], v[:, row]) for key, (m, v) in sources.items()},
                {key: (m[:, row], v[:, row]) for key, (m, v) in limited.items()},
                {key: v[:, row] for key, v in moved.items()},
                steps * dt,
                level,
            )
            errors[name] = replace(error, tilt_without=equations.without)
            taken_as_exact |= dict.fromkeys(exact_parts)
        unobserved |= dict.fromkeys(key for key in limited if key not in sources)
        undecided |= dict.fromkeys(key for key in limited if key in sources)
    if not errors:
        raise DataError("a prediction needs gyros (gyro_x …) or accelerometers (accel_x …), and the model has none")
    return Prediction(
        errors={name: errors[name] for name in sorted(errors, key=_order)},
        after=steps * dt,
        calibration=None if calibration is None else average * dt,
        rate=rate,
        earth=earth,
        turn_on=turn_on,
        level=level,
        flicker_error=reached,
        flicker_in_records=_range(ratios),
        as_known=tuple(taken_as_exact),
        not_seen=tuple(unobserved),
        undecided=tuple(undecided),
        duration=recorded or None,
        limit_level=min((model[channel].level for channel, _ in (*unobserved, *undecided)), default=0.95),
    )


def _as_simulated(flicker: NoiseSource, equations: Mechanisation, gains: Floats, dt: float, steps: Floats) -> Floats:
    """Variance from flicker noise whose first sample is 0, as in simulated records: the sample before the start is
    subtracted.
    """
    _, variance = flicker.errors(equations, gains, dt=dt, calibration=1, steps=np.maximum(steps - 1, 1))
    return np.asarray(np.where(steps[:, None] > 1, variance, 0.0))


def _range(ratios: Sequence[Floats]) -> tuple[float, float] | None:
    """Smallest and largest root of finite ratios."""
    finite = np.concatenate([ratio.ravel() for ratio in ratios]) if ratios else np.empty(0)
    finite = np.sqrt(finite[np.isfinite(finite)])
    return (float(finite.min()), float(finite.max())) if finite.size else None


def _steps(after: ArrayLike, rate: float) -> Floats:
    check_sampling_rate(rate)
    times = np.atleast_1d(np.asarray(after))
    times = times.astype(np.float64) if times.dtype.kind in "iuf" else np.empty(0)
    if times.ndim != 1 or not times.size:
        raise OptionError(f"{{option}} must be one or more times in s, not {after!r}", option="after")
    return np.unique([_whole_steps("after", float(time), rate) for time in times])


def _whole_steps(option: str, time: float, rate: float) -> int:
    """Number of whole steps of a time."""
    if not (math.isfinite(real(time)) and 0.5 <= time * rate <= _MAX_STEPS):
        raise OptionError(
            f"{{option}} must be {1 / rate:g} s, a step, to {_MAX_STEPS / rate:g} s, not {time!r}", option=option
        )
    return max(round(time * rate), 1)


def _checked(turn_on: Mapping[str, float], model: NoiseModel, calibration: float | None) -> dict[str, float]:
    if not isinstance(turn_on, Mapping):
        raise OptionError(
            f"{{option}} must be a mapping from channel to standard deviation, {{'gyro_z': 5e-5}}, not {turn_on!r}",
            option="turn_on",
        )
    for name, value in turn_on.items():
        if name not in model.channels:
            raise OptionError(
                f"{{option}}: no channel {name!r}; channels: {', '.join(model.channels)}", option="turn_on"
            )
        if stream_name(name) not in ("gyro", "accel"):
            raise OptionError(
                f"{{option}}: {name} is neither a gyro nor an accelerometer, and causes no navigation error",
                option="turn_on",
            )
        if not (math.isfinite(real(value)) and value >= 0):
            raise OptionError(
                f"{{option}} of {name} must be a standard deviation in SI, not {value!r}", option="turn_on"
            )
    if turn_on and calibration is not None:
        raise OptionError("{option}: a calibration removes a constant bias; give one of the two", option="turn_on")
    return dict(turn_on)


def _correlated(
    model: NoiseModel,
    equations: Mechanisation,
    made: Mapping[tuple[str, str], NoiseSource],
    sources: Mapping[tuple[str, str], tuple[Floats, Floats]],
    dt: float,
    average: int,
    steps: Floats,
) -> dict[tuple[str, str], Floats]:
    """Variance added by the correlation of a term between a gyro and the accelerometer perpendicular to it."""
    if len(equations.inputs) < 2:
        return {}
    first, second = equations.inputs
    correlated = {}
    for term, pairs in model.correlation.items():
        correlation = pairs.get((first, second), pairs.get((second, first), 0.0))
        if correlation:
            ratio = model.channels[second][term] / model.channels[first][term]
            gains = np.array([1.0, ratio])
            _, both = made[first, term].errors(equations, gains, dt=dt, calibration=average, steps=steps)
            apart = sources[first, term][1] + sources[second, term][1]
            correlated[f"{first} with {second}", term] = correlation * (both - apart)
    return correlated


def _limited(model: ChannelModel) -> dict[str, ChannelModel]:
    """For each term that was not observed, a model of the term at its limit.

    A term in the model without an interval is one of several that the record cannot distinguish: its coefficient is
    between 0 and its limit.
    """
    return {
        term: ChannelModel(terms={term: limit}, quantity=model.quantity, unit=model.unit)
        for term, limit in model.limits.items()
        if limit and term not in model.intervals
    }


def _square(
    parts: Mapping[tuple[str, str], tuple[Floats, Floats]], extra: Sequence[tuple[Floats, Floats]] = ()
) -> Floats:
    """Mean square of the sum of all parts; the means of `extra` have unknown signs and are added to its size."""
    variance = np.asarray(sum(v for _, v in (*parts.values(), *extra)))
    mean = np.abs(np.asarray(sum(m for m, _ in parts.values()))) + np.asarray(sum(np.abs(m) for m, _ in extra))
    return np.asarray(np.maximum(variance, 0.0) + mean**2)


def _known_covariance(model: NoiseModel, channel: str) -> Covariance:
    """Covariance of the parameters of a channel with known errors. Terms with only an interval count as independent."""
    from statistics import NormalDist

    if channel not in model:
        return Covariance()
    noise = model[channel]
    fitted = noise.covariance.parameters
    alone = [term for term in noise.intervals if Parameter(term) not in fitted and term in noise]
    total = np.zeros((len(fitted) + len(alone),) * 2)
    total[: len(fitted), : len(fitted)] = noise.covariance.matrix
    to_sd = 1 / (2 * NormalDist().inv_cdf(0.5 + noise.level / 2))
    for k, term in enumerate(alone, len(fitted)):
        low, high = noise.intervals[term]
        total[k, k] = ((high - low) * to_sd) ** 2
    return Covariance(parameters=(*fitted, *map(Parameter, alone)), matrix=total)


@np.errstate(over="ignore")  # an overflow by a poorly determined coefficient gives an interval without an end
def _error(
    name: str,
    model: NoiseModel,
    sources: Mapping[tuple[str, str], tuple[Floats, Floats]],
    limited: Mapping[tuple[str, str], tuple[Floats, Floats]],
    moved: Mapping[tuple[str, Parameter], Floats],
    after: Floats,
    level: float,
) -> tuple[PredictedError, list[tuple[str, str]]]:
    """One error of all sources, and the channels and terms whose errors are not known."""
    from statistics import NormalDist

    variance = np.asarray(sum(v for _, v in sources.values()))
    mean = np.asarray(sum(m for m, _ in sources.values()))
    square = np.maximum(variance, 0.0) + mean**2
    variances = {key: v + m * mean for key, (m, v) in sources.items()}
    shares = {
        key: np.divide(part, square, out=np.zeros_like(square), where=square > 0) for key, part in variances.items()
    }
    # The second omits undecided terms, which are largest at their limits.
    spread, observed_part, taken_as_exact, additional = np.zeros_like(square), np.zeros_like(square), [], []
    has_variance = False
    for channel in dict.fromkeys(channel for channel, _ in sources):
        covariance = _known_covariance(model, channel)
        # Each number of a process is a separate part in `moved`.
        parts = [
            (k, each)
            for k, each in enumerate(covariance.parameters)
            if (channel, each) in moved or (each.number is None and (channel, each.part) in sources)
        ]
        with_covariance = {each.part for each in covariance.parameters if each.number is None} | {
            each.part for _, each in parts
        }
        without = [
            key for key in sources if key[0] == channel and key[1] not in with_covariance and np.any(variances[key])
        ]
        taken_as_exact += [key for key in without if key not in limited]
        additional += [key for key in without if key in limited]
        has_variance |= bool(parts or additional)
        for rows in (parts, [(k, each) for k, each in parts if (channel, each.part) not in limited]):
            if not rows:
                continue
            # The mean square is quadratic in each coefficient: its derivative is twice the part over the coefficient.
            gradient = np.array(
                [
                    2 * variances[channel, each.part] / model.channels[channel][each.part]
                    if each.number is None
                    else (moved[channel, each] - sources[channel, each.part][1])
                    / difference_step(model.channels[channel], each)
                    for _, each in rows
                ]
            )
            index = [k for k, _ in rows]
            added = np.einsum("pt,pq,qt->t", gradient, covariance.matrix[np.ix_(index, index)], gradient)
            spread, observed_part = (
                (spread + added, observed_part) if rows is parts else (spread, observed_part + added)
            )
    z = NormalDist().inv_cdf(0.5 + level / 2)
    rms = np.sqrt(square)
    low = high = None
    size = rms
    if has_variance:
        wide = np.exp(_ratio_or_zero(z * np.sqrt(np.maximum(spread, 0)), 2 * square))
        # Undecided terms without a separate error range from all absent to all at their limits.
        smallest = _square({key: part for key, part in sources.items() if key not in additional})
        largest = _square({key: limited.get(key, part) if key in additional else part for key, part in sources.items()})
        low, high = np.sqrt(np.minimum(square, smallest)) / wide, np.sqrt(np.maximum(square, largest)) * wide
        size = high
    upper_limit = None
    if limited:
        observed = {key: part for key, part in sources.items() if key not in limited}
        undecided = [part for key, part in limited.items() if key in sources]
        if undecided:
            largest = _square(observed, undecided)
            size = np.maximum(
                size, np.sqrt(largest) * np.exp(_ratio_or_zero(z * np.sqrt(np.maximum(observed_part, 0)), 2 * largest))
            )
        unobserved = [part for key, part in limited.items() if key not in sources]
        drift = np.asarray(sum(np.abs(m) for m, _ in unobserved))
        excess = np.asarray(sum(v for _, v in unobserved))
        excess = excess + drift**2 + 2 * np.abs(mean) * drift
        upper_limit = np.sqrt(size**2 + excess)
        high = None if high is None else np.sqrt(high**2 + excess)
    error = PredictedError(
        name=name,
        unit="m/s" if name.startswith("velocity") else "m" if name.startswith("position") else "rad",
        after=np.array(after),
        rms=rms,
        std=np.sqrt(np.maximum(variance, 0.0)),
        mean=mean,
        low=low,
        high=high,
        shares=shares,
        at_most=upper_limit,
    )
    return error, taken_as_exact if has_variance else []


def _ratio_or_zero(error: Floats, size: Floats) -> Floats:
    """Relative error of a mean square; 0 without noise, which has no error."""
    return np.divide(error, size, out=np.zeros_like(size), where=size > 0)


def _order(name: str) -> tuple[int, str]:
    kind = 0 if name == "heading" else 2 if name.startswith("velocity") else 3 if name.startswith("position") else 1
    return kind, name
