"""How far free inertial navigation at rest goes astray, from the noise of its sensors, and through which term."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau.errors import DataError, OptionError
from sigmatau.model.navigation import Earth, Mechanisation, Source, mechanisations, source
from sigmatau.model.noise_model import NoiseModel
from sigmatau.results import Printed, duration_text, interval_texts
from sigmatau.terms import TERMS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["PredictedError", "Prediction", "predict"]

Floats = NDArray[np.float64]

_STEPS = 1e12
_DISPLAY = {"rad": ("deg", math.pi / 180)}
_OTHER = {"gauss_markov": "Gauss-Markov process", "sinusoid": "sinusoid", "turn_on": "turn-on bias"}
_SHOWN = 0.01
"""The least share that is printed."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PredictedError(Printed):
    """One error against time.

    Attributes
    ----------
    name : str
        ``"heading"``, ``"roll"``, ``"pitch"``, ``"velocity_x"``, ``"position_x"`` …
    unit : str
        SI: rad, m/s, m.
    after : ndarray, shape (n_times,)
        [s]
    rms : ndarray, shape (n_times,)
        √(std² + mean²). [unit]
    std, mean : ndarray, shape (n_times,)
        What noise makes, and what ramps make, with its sign. [unit]
    low, high : ndarray or None, shape (n_times,)
        Interval of `rms`, as sure as the coefficients are; None if that of none is known. [unit]
    shares : mapping of (str, str) to ndarray, shape (n_times,)
        Parts of rms², by channel and term; they add up to 1.
    """

    name: str
    unit: str
    after: Floats
    rms: Floats
    std: Floats
    mean: Floats
    low: Floats | None
    high: Floats | None
    shares: Mapping[tuple[str, str], Floats]

    def __post_init__(self) -> None:
        for array in (self.after, self.rms, self.std, self.mean, self.low, self.high, *self.shares.values()):
            if array is not None:
                array.setflags(write=False)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns in SI."""
        shares: dict[str, dict[str, list[float]]] = {}
        for (channel, part), share in self.shares.items():
            shares.setdefault(channel, {})[part] = share.tolist()
        content: dict[str, Any] = {
            "unit": self.unit,
            "rms": self.rms.tolist(),
            "std": self.std.tolist(),
            "mean": self.mean.tolist(),
            "shares": shares,
        }
        if self.low is not None and self.high is not None:
            content |= {"low": self.low.tolist(), "high": self.high.tolist()}
        return content

    def rows(self) -> list[tuple[str, ...]]:
        """Time, rms, interval, unit, mean and shares of each time, as they are printed."""
        unit, factor = _DISPLAY.get(self.unit, (self.unit, 1.0))
        rows: list[tuple[str, ...]] = []
        for k, after in enumerate(self.after.tolist()):
            edges = (None, None) if self.low is None or self.high is None else (self.low[k], self.high[k])
            value, interval = interval_texts(
                self.rms[k] / factor, *(None if edge is None else float(edge) / factor for edge in edges)
            )
            made_of = sorted(((float(share[k]), key) for key, share in self.shares.items()), reverse=True)
            parts = [f"{channel} {_label(part)} {100 * s:.0f} %" for s, (channel, part) in made_of if s >= _SHOWN]
            if self.mean[k]:
                parts.append(f"mean {self.mean[k] / factor:+.3g} {unit}")
            rows.append((duration_text(after), value, interval, unit, ", ".join(parts)))
        return rows

    def __repr__(self) -> str:
        return "\n".join(_table([("", "after", "rms", "", "", ""), *_named(self)]))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Prediction(Mapping[str, PredictedError], Printed):
    """Errors of free inertial navigation at rest: a mapping from error to `PredictedError`.

    Attributes
    ----------
    errors : mapping of str to PredictedError
    after : ndarray, shape (n_times,)
        [s]
    calibration : float or None
        Length of time before the start whose mean rates are subtracted. [s]
    rate : float
        [Hz]
    earth : {"round", "flat"}
    turn_on : mapping of str to float
        Standard deviations of constant biases, by channel. [unit of the rate]
    level : float
        Probability of the intervals.
    flicker_error : float
        Largest relative error of the Allan deviation of the flicker noise.
    as_known : tuple of (str, str)
        Channels and parts whose errors are not known, or not in the model, and are taken for none in the intervals.
    """

    errors: Mapping[str, PredictedError]
    after: Floats
    calibration: float | None
    rate: float
    earth: Earth
    turn_on: Mapping[str, float] = field(default_factory=dict)
    level: float = 0.95
    flicker_error: float = 0.0
    as_known: tuple[tuple[str, str], ...] = ()

    def __getitem__(self, error: str) -> PredictedError:
        try:
            return self.errors[error]
        except KeyError:
            raise KeyError(f"no error {error!r}; predicted: {', '.join(self.errors)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self.errors)

    def __len__(self) -> int:
        return len(self.errors)

    def to_dict(self) -> dict[str, Any]:
        """Plain columns in SI, by error."""
        return {
            "after_s": self.after.tolist(),
            "calibration_s": self.calibration,
            "rate_hz": self.rate,
            "earth": self.earth,
            "turn_on": dict(self.turn_on),
            "level": self.level,
            "errors": {name: error.to_dict() for name, error in self.errors.items()},
        }

    def plot(self) -> Figure:
        """Draw the errors against time, a panel for angles, velocities and positions each."""
        from sigmatau.plot.prediction import draw_prediction

        return draw_prediction(self)

    def notes(self) -> list[str]:
        """What the numbers rest on."""
        if self.calibration is not None:
            lines = [
                f"The mean rates of the {duration_text(self.calibration)} before the start are subtracted, those of level"
                " accelerometers by levelling;",
                "roll and pitch are without what levelling leaves, an accelerometer's bias over g.",
            ]
        else:
            lines = ["The state at the start is taken as known: walks and flicker noise begin at 0."]
            lines.append(
                "Biases at turn-on: "
                + ", ".join(f"{name} {value:.3g}" for name, value in self.turn_on.items())
                + " (SI, standard deviations)."
                if self.turn_on
                else "A bias at turn-on, which no record at rest shows, is not in it: see `turn_on`, or calibrate."
            )
        if self.earth == "flat":
            lines.append("Flat Earth: without Schuler's feedback.")
        if self.flicker_error:
            lines.append(f"Flicker noise: Allan deviation within {100 * self.flicker_error:.2g} %.")
        if any(error.low is not None for error in self.errors.values()):
            known = ", ".join(f"{channel} {_label(part)}" for channel, part in self.as_known)
            lines.append(
                f"[ ]: {100 * self.level:g} % interval by the errors of the coefficients"
                + (f"; taken as known: {known}." if known else ".")
            )
        return lines

    def __repr__(self) -> str:
        head = f"error of free inertial navigation at rest, steps of {1 / self.rate:g} s"
        rows: list[tuple[str, ...]] = [("", "after", "rms", "", "", "of the mean square")]
        for error in self.errors.values():
            rows += _named(error)
        return "\n".join([head, *_table(rows), *self.notes()])


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
    """Errors of free inertial navigation at rest, from the noise of the sensors.

    Heading of gyro_z, roll and pitch of gyro_x and gyro_y, velocity and position of each accelerometer; those of a level
    accelerometer with the tilt that the gyro across it makes, if the model has it. Axes x, y level, z up. Angles alone of
    gyros alone.

    Parameters
    ----------
    model : NoiseModel
    after : array_like, shape (n_times,)
        Times since the start, rounded to whole steps. [s]
    calibration : float, optional
        Length of time at rest before the start; the mean of each rate over it is subtracted from then on. Of level
        accelerometers that is levelling, of gyros their bias. Default: no calibration; the state at the start is known,
        walks and flicker noise begin at 0. [s]
    rate : float
        Steps a second, the sampling rate. [Hz]
    earth : {"round", "flat"}
        Schuler's feedback of the velocity into the tilt, and gravity falling with height; or not.
    turn_on : mapping of str to float, optional
        Without a calibration: standard deviations of constant biases, by channel. [rad/s, m/s²]
    flicker_error : float
        What the Allan deviation of flicker noise may be off by, relative.
    level : float
        Probability of the intervals, which are as sure as the coefficients (`ChannelModel.covariance`).

    Returns
    -------
    Prediction

    Raises
    ------
    OptionError
        For times that are not positive, an unknown Earth, a turn-on bias of a channel that is not there, or both a turn-on
        bias and a calibration, which takes it away.
    DataError
        For a model with neither a gyro nor an accelerometer.

    Notes
    -----
    The covariance of sensor states, subtracted means and errors is propagated exactly for sampled noise; see
    `sigmatau.model.navigation`. Of flicker noise at the start nothing else but increments is defined: with a calibration
    only these count, without one it begins at 0, so that the angle error is 0.664·B·t.
    """
    steps = _steps(after, rate)
    average = 0 if calibration is None else _whole("calibration", calibration, rate)
    if earth not in ("round", "flat"):
        raise OptionError(f"`earth` must be 'round' or 'flat', not {earth!r}", option="earth")
    if not 0 < level < 1:
        raise OptionError(f"`level` must lie between 0 and 1, not {level!r}", option="level")
    turn_on = _checked(turn_on or {}, model, calibration)
    dt = 1 / rate
    found: dict[str, PredictedError] = {}
    as_known: dict[tuple[str, str], None] = {}
    reached = 0.0
    for equations in mechanisations(tuple(model.channels), earth=earth):
        sources: dict[tuple[str, str], tuple[Floats, Floats]] = {}
        made: dict[tuple[str, str], Source] = {}
        for k, channel in enumerate(equations.inputs):
            gains = np.eye(len(equations.inputs))[k]
            parts = {
                name: source(
                    part,
                    dt=dt,
                    tau_max=(average + int(steps[-1])) * dt,
                    flicker_error=flicker_error,
                    calibrated=average > 0,
                )
                for name, part in model.channels[channel].parts().items()
            }
            if turn_on.get(channel):
                parts["turn_on"] = Source.constant(turn_on[channel])
            for name, part in parts.items():
                made[channel, name] = part
                sources[channel, name] = part.errors(equations, gains, dt=dt, calibration=average, steps=steps)
                reached = max(reached, part.flicker_error)
        for key, variance in _correlated(model, equations, made, sources, dt, average, steps).items():
            sources[key] = np.zeros_like(variance), variance
        for name, row in equations.rows.items():
            found[name], known = _error(
                name, model, {key: (m[:, row], v[:, row]) for key, (m, v) in sources.items()}, steps * dt, level
            )
            as_known |= dict.fromkeys(known)
    if not found:
        raise DataError("a prediction needs gyros (gyro_x …) or accelerometers (accel_x …), and the model has none")
    return Prediction(
        errors={name: found[name] for name in sorted(found, key=_order)},
        after=steps * dt,
        calibration=None if calibration is None else average * dt,
        rate=rate,
        earth=earth,
        turn_on=turn_on,
        level=level,
        flicker_error=reached,
        as_known=tuple(as_known),
    )


def _steps(after: ArrayLike, rate: float) -> Floats:
    if not (math.isfinite(rate) and rate > 0):
        raise OptionError(f"`rate` must be a positive number of hertz, not {rate!r}", option="rate")
    times = np.atleast_1d(np.asarray(after, dtype=np.float64))
    if times.ndim != 1 or not times.size:
        raise OptionError("`after` must be one or more times in s", option="after")
    return np.unique([_whole("after", float(time), rate) for time in times])


def _whole(option: str, time: float, rate: float) -> int:
    """A time in whole steps."""
    if not (math.isfinite(time) and 0.5 <= time * rate <= _STEPS):
        raise OptionError(
            f"`{option}` must be {1 / rate:g} s, a step, to {_STEPS / rate:g} s, not {time!r}", option=option
        )
    return max(round(time * rate), 1)


def _checked(turn_on: Mapping[str, float], model: NoiseModel, calibration: float | None) -> dict[str, float]:
    for name, value in turn_on.items():
        if name not in model.channels:
            raise OptionError(
                f"`turn_on`: no channel {name!r}; channels: {', '.join(model.channels)}", option="turn_on"
            )
        if not (math.isfinite(value) and value >= 0):
            raise OptionError(
                f"`turn_on` of {name} must be a standard deviation in SI, not {value!r}", option="turn_on"
            )
    if turn_on and calibration is not None:
        raise OptionError("`turn_on`: a calibration takes a constant bias away; give one of the two", option="turn_on")
    return dict(turn_on)


def _correlated(
    model: NoiseModel,
    equations: Mechanisation,
    made: Mapping[tuple[str, str], Source],
    sources: Mapping[tuple[str, str], tuple[Floats, Floats]],
    dt: float,
    average: int,
    steps: Floats,
) -> dict[tuple[str, str], Floats]:
    """What the correlation of a term between a gyro and the accelerometer across it adds to the variance."""
    if len(equations.inputs) < 2:
        return {}
    first, second = equations.inputs
    found = {}
    for term, pairs in model.correlation.items():
        correlation = pairs.get((first, second), pairs.get((second, first), 0.0))
        if correlation:
            ratio = model.channels[second][term] / model.channels[first][term]
            gains = np.array([1.0, ratio])
            _, both = made[first, term].errors(equations, gains, dt=dt, calibration=average, steps=steps)
            apart = sources[first, term][1] + sources[second, term][1]
            found[f"{first} with {second}", term] = correlation * (both - apart)
    return found


def _error(
    name: str,
    model: NoiseModel,
    sources: Mapping[tuple[str, str], tuple[Floats, Floats]],
    after: Floats,
    level: float,
) -> tuple[PredictedError, list[tuple[str, str]]]:
    """One error of its sources, and which of them have no known error of their own."""
    from statistics import NormalDist

    variance = np.asarray(sum(v for _, v in sources.values()))
    mean = np.asarray(sum(m for m, _ in sources.values()))
    square = np.maximum(variance, 0.0) + mean**2
    of_parts = {key: v + m * mean for key, (m, v) in sources.items()}
    shares = {
        key: np.divide(part, square, out=np.zeros_like(square), where=square > 0) for key, part in of_parts.items()
    }
    spread, any_known, as_known = np.zeros_like(square), False, []
    for channel in dict.fromkeys(channel for channel, _ in sources):
        names, covariance = model.channels[channel].covariance if channel in model.channels else ((), None)
        parts = [(k, term) for k, term in enumerate(names) if (channel, term) in sources]
        as_known += [key for key in sources if key[0] == channel and key[1] not in names and np.any(of_parts[key])]
        if covariance is None or not parts:
            continue
        any_known = True
        # The mean square is quadratic in each coefficient: its derivative is twice its part over the coefficient.
        gradient = np.array([2 * of_parts[channel, term] / model.channels[channel][term] for _, term in parts])
        index = [k for k, _ in parts]
        spread = spread + np.einsum("pt,pq,qt->t", gradient, covariance[np.ix_(index, index)], gradient)
    rms = np.sqrt(square)
    low = high = None
    if any_known:
        wide = np.exp(NormalDist().inv_cdf(0.5 + level / 2) * np.sqrt(np.maximum(spread, 0)) / (2 * square))
        low, high = rms / wide, rms * wide
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
    )
    return error, as_known if any_known else []


def _order(name: str) -> tuple[int, str]:
    kind = 0 if name == "heading" else 2 if name.startswith("velocity") else 3 if name.startswith("position") else 1
    return kind, name


def _label(part: str) -> str:
    return TERMS[part].label("signal") if part in TERMS else _OTHER[part]


def _named(error: PredictedError) -> Iterable[tuple[str, ...]]:
    return [(error.name if k == 0 else "", *row) for k, row in enumerate(error.rows())]


def _table(rows: list[tuple[str, ...]]) -> list[str]:
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]) - 1)]
    return [
        ("  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[-1]])).rstrip()
        for row in rows
    ]
