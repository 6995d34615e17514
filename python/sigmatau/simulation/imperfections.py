"""Imperfections of simulated logs: levels, drifts, resolution, lost rows, wrong stamps."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import field
from typing import Any, get_args

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.model.processes import LARGEST, SMALLEST, real
from sigmatau.record.record import stream_name
from sigmatau.record.streams import InputKind
from sigmatau.results import Printed, plain

_DAY = 86400.0
_MAX_LOST = 0.5
_MAX_JITTER = 0.1  # largest jitter, over the sample interval
_ABSOLUTE_ZERO = -273.15  # °C


@frozen
class WarmUp:
    """A level that decays after turn-on: amplitude·exp(−t/time).

    Attributes
    ----------
    amplitude : float
        Amplitude at the start, of either sign. [unit of the rate]
    time : float
        Time constant. [s]

    Raises
    ------
    OptionError
        For an amplitude that is not finite, or a time that is not positive.
    """

    amplitude: float
    time: float

    def __post_init__(self) -> None:
        _finite("the amplitude of a warm-up", self.amplitude)
        _positive("the time of a warm-up", self.time)

    def at(self, t: Floats) -> Floats:
        """The level at some times.

        Parameters
        ----------
        t : ndarray, any shape
            Times since the start. [s]

        Returns
        -------
        ndarray, shape of `t`
            [unit of the rate]
        """
        return self.amplitude * np.exp(-t / self.time)


@frozen
class Temperature:
    """Temperature of the sensor, its effect on the channels, and the thermometer of the log.

    The temperature is end + (start − end)·exp(−t/time) + swing·sin(2πt/day). The record gets a channel
    ``temperature`` that shows it.

    Attributes
    ----------
    start, end : float
        Temperature when the sensor is turned on, and long afterwards. [°C]
    time : float
        Time constant of the change. [s]
    swing : float
        Half the difference between day and night. [K]
    resolution : float
        Step of the thermometer's numbers; 0 for none. [K]
    sensitivity : mapping of str to float
        Change of a channel or sensor (``"gyro"``) with the difference from the temperature at the start. [unit of the
        rate per K]

    Raises
    ------
    OptionError
        For a temperature below absolute zero, a time that is not positive, or a negative resolution.
    """

    start: float
    end: float
    time: float = 1200.0
    swing: float = 0.0
    resolution: float = 0.01
    sensitivity: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for where, value in (("start", self.start), ("end", self.end)):
            _finite(f"the temperature at the {where}", value)
            if value < _ABSOLUTE_ZERO:
                raise OptionError(f"the temperature at the {where} must be above {_ABSOLUTE_ZERO} °C, not {value!r}")
        _positive("the time of the temperature", self.time)
        _finite("the swing of the temperature", self.swing)
        _not_negative("the resolution of the thermometer", self.resolution)
        if not isinstance(self.sensitivity, Mapping):
            raise OptionError(
                f"{{option}} must be by channel or sensor, {{'gyro': 1e-6}}, not {self.sensitivity!r}",
                option="sensitivity",
            )
        for name, value in self.sensitivity.items():
            _finite(f"the sensitivity of {name} to temperature", value)

    def at(self, t: Floats) -> Floats:
        """The true temperature at some times.

        Parameters
        ----------
        t : ndarray, any shape
            Times since the start. [s]

        Returns
        -------
        ndarray, shape of `t`
            [°C]
        """
        settled = self.end + (self.start - self.end) * np.exp(-t / self.time)
        return np.asarray(settled + self.swing * np.sin(2 * math.pi * t / _DAY))

    def shown(self, t: Floats) -> Floats:
        """Reading of the thermometer at some times.

        Parameters
        ----------
        t : ndarray, any shape
            Times since the start. [s]

        Returns
        -------
        ndarray, shape of `t`
            [°C]
        """
        return rounded(self.at(t), self.resolution)


@frozen
class Outage:
    """A time in which no row is logged.

    Attributes
    ----------
    start : float
        Beginning, from the start of the log. [s]
    length : float
        [s]

    Raises
    ------
    OptionError
        For a negative start, or a length that is not positive.
    """

    start: float
    length: float

    def __post_init__(self) -> None:
        _not_negative("the start of an outage", self.start)
        _positive("the length of an outage", self.length)


@frozen(eq=False)
class Imperfections(Printed):
    """Imperfections of a simulated log besides the model's noise. Default: none.

    Mappings are by channel (``"accel_z"``) or sensor (``"accel"``); the value of a channel overrides that of its sensor.
    Level, warm-up and the effect of temperature are added to the noise. The sum is clipped at `saturation`, converted to
    the form of `output`, and rounded to steps of `lsb`.

    Attributes
    ----------
    level : mapping of str to float
        Constant offset, such as gravity on an axis. [unit of the rate]
    warm_up : mapping of str to WarmUp
    temperature : Temperature or None
    saturation : mapping of str to float
        Largest absolute rate that the sensor outputs. [unit of the rate]
    output : {"rate", "increments", "accumulated"}
        Content of the log, as `input` of `sigmatau.read`: rates; the angle (velocity) of one sample interval; or its
        running sum from 0, which has one more row. A model with signals other than gyros and accelerometers allows only
        rates.
    lsb : mapping of str to float
        Resolution of the numbers. Rates are rounded one by one. For the other outputs the running sum is rounded, and
        increments are differences of the rounded sum, as in an integrating sensor: quantization noise of lsb/√12.
        [unit of the rate; for increments and accumulated output rad or m/s]
    lost : float
        Share of rows that are lost at random and independently; 0 to 0.5. The first and the last row are never lost.
    outages : tuple of Outage
        Times in which all rows are lost, except the first and the last row of the log.
    jitter : float
        Standard deviation of the time stamps about the regular times of the samples; only the stamps are affected. At
        most a tenth of the sample interval, so that stamps stay in order. Normal, clipped at 4.5 standard deviations.
        [s]

    Raises
    ------
    OptionError
        For an invalid value; the message names the attribute.

    See Also
    --------
    sigmatau.simulate, sigmatau.simulate_to

    Examples
    --------
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"accel_z": {"random_walk": 1e-3}})
    >>> real = st.Imperfections(level={"accel_z": 9.80665}, lsb={"accel_z": 0.01}, lost=0.1)
    >>> record = st.simulate(model, duration=10, rate=100, rng=1, imperfections=real)
    >>> record.stream_of("accel_z").column("accel_z")[:4].round(2)
    array([9.79, 9.81, 9.81, 9.79])
    """

    level: Mapping[str, float] = field(default_factory=dict)
    warm_up: Mapping[str, WarmUp] = field(default_factory=dict)
    temperature: Temperature | None = None
    saturation: Mapping[str, float] = field(default_factory=dict)
    output: InputKind = "rate"
    lsb: Mapping[str, float] = field(default_factory=dict)
    lost: float = 0.0
    outages: tuple[Outage, ...] = ()
    jitter: float = 0.0

    def __post_init__(self) -> None:
        for what in ("level", "saturation", "lsb", "warm_up"):
            values = getattr(self, what)
            if not isinstance(values, Mapping):
                example = "WarmUp(…)" if what == "warm_up" else "0.1"
                raise OptionError(
                    f"{{option}} must be by channel or sensor, {{'gyro': {example}}}, not {values!r}", option=what
                )
        for name, warming in self.warm_up.items():
            if not isinstance(warming, WarmUp):
                raise OptionError(f"the warm-up of {name} must be a WarmUp(amplitude=…, time=…), not {warming!r}")
        if not isinstance(self.outages, tuple | list) or not all(isinstance(outage, Outage) for outage in self.outages):
            raise OptionError(
                f"{{option}} must be a tuple of Outage(start=…, length=…), not {self.outages!r}", option="outages"
            )
        object.__setattr__(self, "outages", tuple(self.outages))
        if not (self.temperature is None or isinstance(self.temperature, Temperature)):
            raise OptionError(
                f"{{option}} must be a Temperature(start=…, end=…), not {self.temperature!r}", option="temperature"
            )
        for name, value in self.level.items():
            _finite(f"the level of {name}", value)
        for name, value in self.saturation.items():
            _positive(f"the saturation of {name}", value)
        for name, value in self.lsb.items():
            _positive(f"the step (lsb) of {name}", value)
        if self.output not in get_args(InputKind):
            raise OptionError(
                f"{{option}} must be one of {', '.join(get_args(InputKind))}, not {self.output!r}", option="output"
            )
        if not (_is_number(self.lost) and 0 <= self.lost <= _MAX_LOST):
            raise OptionError(
                f"{{option}} must be a share of the rows, 0 to {_MAX_LOST}, not {self.lost!r}", option="lost"
            )
        _not_negative("the jitter of the stamps", self.jitter)

    def check(self, channels: Iterable[str], tau0: float, duration: float) -> None:
        """Check that the imperfections fit a simulation.

        Parameters
        ----------
        channels : iterable of str
            Names of the channels.
        tau0 : float
            Sample interval. [s]
        duration : float
            Length of the record. [s]

        Raises
        ------
        OptionError
            For an imperfection of an unknown channel, a thermometer with the name of a channel, an outage beyond the
            record or over all of it, or a jitter above a tenth of the sample interval.
        """
        names = list(channels)
        allowed = {*names, *map(stream_name, names)}
        sensitivity = {} if self.temperature is None else self.temperature.sensitivity
        named = {
            "level": self.level,
            "warm_up": self.warm_up,
            "saturation": self.saturation,
            "lsb": self.lsb,
            "sensitivity": sensitivity,
        }
        for what, values in named.items():
            for name in values:
                if name not in allowed:
                    raise OptionError(
                        f"{{option}} names {name!r}, which is not a channel; channels: {', '.join(names)}", option=what
                    )
        if self.temperature is not None and "temperature" in names:
            raise OptionError("the model has a channel `temperature`, so that there can be no thermometer of that name")
        for outage in self.outages:
            if outage.start >= duration:
                raise OptionError(f"an outage at {outage.start:g} s begins after the end of the record, {duration:g} s")
            if outage.start <= tau0 and outage.start + outage.length >= duration - tau0:
                raise OptionError(f"an outage of {outage.length:g} s covers the whole record of {duration:g} s")
        if self.jitter > _MAX_JITTER * tau0:
            raise OptionError(
                f"a jitter of {self.jitter:g} s is more than a tenth of the sample interval, {tau0:g} s; stamps would come"
                " out of order"
            )

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, without imperfections that are not set."""
        warm = self.temperature
        values = {
            "level": self.level,
            "warm_up": {name: plain(warm_up, "amplitude time_s=time") for name, warm_up in self.warm_up.items()},
            "temperature": warm
            and plain(
                warm, "start_degC=start end_degC=end time_s=time swing_K=swing resolution_K=resolution sensitivity"
            ),
            "saturation": self.saturation,
            "lsb": self.lsb,
            "lost": self.lost,
            "outages": [plain(warm_up, "start_s=start length_s=length") for warm_up in self.outages],
            "jitter_s": self.jitter,
        }
        return plain(self, "output", **{key: value for key, value in values.items() if value})

    def __repr__(self) -> str:
        lines = [f"level of {name}: {value:.6g}" for name, value in self.level.items()]
        lines += [f"warm-up of {n}: {w.amplitude:.4g}, gone to 1/e in {w.time:.4g} s" for n, w in self.warm_up.items()]
        if self.temperature is not None:
            t = self.temperature
            swing = f", ±{abs(t.swing):.3g} K by day and night" if t.swing else ""
            lines.append(f"temperature {t.start:.4g} °C to {t.end:.4g} °C in {t.time:.4g} s{swing}")
            lines += [f"sensitivity of {name}: {value:.4g} per K" for name, value in t.sensitivity.items()]
        lines += [f"saturation of {name}: ±{value:.4g}" for name, value in self.saturation.items()]
        lines += [f"step of {name}: {value:.4g}" for name, value in self.lsb.items()]
        lines += [f"rows lost: {100 * self.lost:.3g} %"] if self.lost else []
        lines += [f"outage of {o.length:.4g} s at {o.start:.4g} s" for o in self.outages]
        lines += [f"jitter of the stamps: {self.jitter:.3g} s"] if self.jitter else []
        return "\n".join([f"numbers of the log: {self.output} (SI)", *lines])


def rounded(values: Floats, step: float) -> Floats:
    """Values rounded to whole steps; unchanged if the step is 0."""
    # No instrument writes -0: the sum of -0 and 0 is 0.
    return np.asarray(np.rint(values / step) * step + 0.0) if step else values


def _is_number(value: object) -> bool:
    return abs(real(value)) <= LARGEST


def _finite(what: str, value: float) -> None:
    if not _is_number(value):
        raise OptionError(f"{what} must be a number of up to {LARGEST:g}, not {value!r}")


def _positive(what: str, value: float) -> None:
    if not (_is_number(value) and value >= SMALLEST):
        raise OptionError(f"{what} must be a positive number, {SMALLEST:g} to {LARGEST:g}, not {value!r}")


def _not_negative(what: str, value: float) -> None:
    if not (_is_number(value) and (value == 0 or value >= SMALLEST)):
        raise OptionError(f"{what} must be 0 or a positive number, {SMALLEST:g} to {LARGEST:g}, not {value!r}")
