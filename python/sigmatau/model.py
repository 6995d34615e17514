"""Noise models: coefficients by channel, from a model file or by hand, and records simulated from them.

A model file is TOML; each value says its unit, and a term that is absent is absent, not zero:

.. code-block:: toml

    [channels.gyro_x]
    random_walk = "0.3 deg/sqrt(h)"       # or noise_density = "0.005 deg/s/sqrt(Hz)", sided = "one"
    bias_instability = "12 deg/h"
    rate_random_walk = "20 deg/h/sqrt(h)"
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau import _kernels, terms, units
from sigmatau.errors import DataError, OptionError
from sigmatau.record import MIN_SAMPLES, Provenance, Record, stream_name
from sigmatau.results import Printed
from sigmatau.streams import Columns, Grid, Stream, Transform

__all__ = ["NoiseModel", "simulate", "value_in_si"]

_QUANTITY = {"gyro": "angular_rate", "accel": "acceleration"}
_RATE_UNIT = {"gyro": "rad/s", "accel": "m/s^2"}
_VALUE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s.].*?)\s*")


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseModel(Printed):
    """Coefficients of the five terms, in SI, by channel.

    Attributes
    ----------
    channels : mapping of str to mapping of str to float
        ``{"gyro_x": {"random_walk": 8.7e-5}}``; channels are named ``gyro_…`` or ``accel_…``, terms as in
        `sigmatau.terms.TERMS`. Coefficients are positive, a ramp may be negative.
    """

    channels: Mapping[str, Mapping[str, float]]

    def __post_init__(self) -> None:
        if not self.channels:
            raise DataError("the model has no channel; give at least one, e.g. [channels.gyro_x]")
        for channel, coefficients in self.channels.items():
            if stream_name(channel) not in _QUANTITY:
                raise DataError(f"channel {channel!r}: names begin with gyro_ or accel_")
            if not coefficients:
                raise DataError(f"channel {channel!r} has no term; terms: {', '.join(terms.TERMS)}")
            for term, value in coefficients.items():
                if term not in terms.TERMS:
                    raise DataError(f"channel {channel!r}: unknown term {term!r}; terms: {', '.join(terms.TERMS)}")
                if not math.isfinite(value) or (value < 0 and term != "rate_ramp"):
                    raise DataError(f"channel {channel!r}: {term} must be a positive number, not {value!r}")

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """The model of a TOML file.

        Raises
        ------
        DataError
            If the file cannot be read or understood: which channel, which key, what was got.
        """
        path = Path(path)
        try:
            content = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise DataError(f"{path}: {error.strerror or error}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise DataError(f"{path}: no TOML file: {error}") from None
        try:
            return cls.from_dict(content)
        except ValueError as error:
            raise DataError(f"{path}: {error}") from None

    @classmethod
    def from_dict(cls, content: Mapping[str, Any]) -> Self:
        """The model of a parsed model file: ``{"channels": {"gyro_x": {"random_walk": "0.3 deg/sqrt(h)"}}}``."""
        unknown = sorted(set(content) - {"channels"})
        if unknown:
            raise DataError(f"unknown key {unknown[0]!r}; a model file has tables [channels.NAME]")
        channels = content.get("channels", {})
        if not isinstance(channels, Mapping) or not all(isinstance(c, Mapping) for c in channels.values()):
            raise DataError("a model file has tables [channels.NAME], e.g. [channels.gyro_x]")
        return cls(channels={name: _coefficients(name, table) for name, table in channels.items()})

    def avar(self, channel: str, *, m: ArrayLike, tau0: float) -> NDArray[np.float64]:
        """Expected Allan variance of a channel, exact for sampled data; see `sigmatau.terms.avar`. [(rate unit)²]"""
        sizes = np.atleast_1d(np.asarray(m))
        total = np.zeros(sizes.shape)
        for term, value in self.channels[channel].items():
            total += terms.avar(term, value, m=sizes, tau0=tau0)
        return total

    def __repr__(self) -> str:
        lines = []
        for channel, coefficients in self.channels.items():
            quantity = _QUANTITY[stream_name(channel)]
            values = []
            for term, value in coefficients.items():
                text, factor = terms.display_units(term, quantity, "")[0]
                values.append(f"{terms.TERMS[term].label(quantity)} {value / factor:.6g} {text}")
            lines.append(f"{channel}: {', '.join(values)}")
        return "\n".join(lines)


def simulate(model: NoiseModel, *, duration: float, rate: float, rng: int | np.random.Generator) -> Record:
    """A record with the model's noise, by exact generators.

    Every term is drawn as the sampled process whose Allan variance `NoiseModel.avar` states: quantization as differences
    of white phase, the random walk as white noise, bias instability as discrete flicker noise by circulant embedding of
    its first differences (Davies and Harte), the rate random walk as a sampled walk, the ramp as a line.

    Parameters
    ----------
    model : NoiseModel
    duration : float
        Length of the record. [s]
    rate : float
        Sampling rate. [Hz]
    rng : int or numpy.random.Generator
        Seed, or a generator that one is drawn from. The same seed gives the same record; a channel's noise does not
        depend on which other channels and terms the model has.

    Returns
    -------
    Record
        Rates in SI, one stream for the gyros, one for the accelerometers.

    Raises
    ------
    OptionError
        For a rate or duration that is not positive, or fewer than 4 samples.
    """
    if not (math.isfinite(rate) and rate > 0):
        raise OptionError(f"the rate must be a positive number of hertz, not {rate!r}", option="rate")
    if not (math.isfinite(duration) and duration > 0):
        raise OptionError(f"the duration must be a positive number, not {duration!r} s", option="hours")
    n = round(duration * rate)
    if n < MIN_SAMPLES:
        raise OptionError(f"{duration:g} s at {rate:g} Hz are {n} samples; at least {MIN_SAMPLES} are needed")
    if n > _LARGEST:
        raise OptionError(
            f"{duration:g} s at {rate:g} Hz are {n} samples; at most {_LARGEST} can be simulated in memory"
        )
    if isinstance(rng, np.random.Generator):
        seed = int(rng.integers(1 << 63))
    elif isinstance(rng, int | np.integer) and not isinstance(rng, bool) and 0 <= rng < 1 << 64:
        seed = int(rng)
    else:
        raise OptionError(f"the seed must be an integer from 0 to 2^64 - 1, not {rng!r}", option="seed")
    by_stream: dict[str, dict[str, NDArray[np.float64]]] = {}
    for channel, coefficients in model.channels.items():
        y = _kernels.simulate(n, 1 / rate, coefficients, seed=seed, stream=_stream_number(channel))
        y.setflags(write=False)
        by_stream.setdefault(stream_name(channel), {})[channel] = y
    streams = tuple(
        Stream(
            name=name,
            quantity=_QUANTITY[name],
            unit=_RATE_UNIT[name],
            channels=tuple(columns),
            grid=Grid(n=n, tau0=1 / rate, source="simulated"),
            samples=Columns(tuple(columns.values()), (Transform(),) * len(columns), 1 / rate),
        )
        for name, columns in by_stream.items()
    )
    return Record(
        streams=streams,
        provenance=Provenance(format="simulation", rows=n, conversions=(f"simulated with seed {seed}",)),
    )


_LARGEST = 1 << 30


def _stream_number(channel: str) -> int:
    """FNV-1a hash of the name, so that a channel's noise depends on its own name alone."""
    value = 0x811C9DC5
    for byte in channel.encode():
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return value


def _coefficients(channel: str, table: Mapping[str, Any]) -> dict[str, float]:
    stream = stream_name(channel)
    if stream not in _QUANTITY:
        raise DataError(f"channel {channel!r}: names begin with gyro_ or accel_")
    quantity, unit = _QUANTITY[stream], _RATE_UNIT[stream]
    result: dict[str, float] = {}
    for key, text in table.items():
        if key == "sided":
            continue
        term = "random_walk" if key == "noise_density" else key
        if term not in terms.TERMS:
            listed = ", ".join((*terms.TERMS, "noise_density"))
            raise DataError(f"channel {channel!r}: unknown term {key!r}; terms: {listed}")
        if term in result:
            raise DataError(f"channel {channel!r}: random_walk and noise_density are the same coefficient; give one")
        value = _value(channel, key, text, terms.coefficient_unit(term, quantity, unit))
        result[term] = value * _two_sided(channel, table) if key == "noise_density" else value
    if "sided" in table and "noise_density" not in table:
        raise DataError(f"channel {channel!r}: `sided` belongs to noise_density, which is not given")
    return result


def _two_sided(channel: str, table: Mapping[str, Any]) -> float:
    sided = table.get("sided")
    if sided not in ("one", "two"):
        raise DataError(
            f'channel {channel!r}: noise_density needs sided = "one" or "two", because a one-sided density is √2 larger'
            " (most datasheets state it one-sided)"
        )
    return 1 / math.sqrt(2) if sided == "one" else 1.0


def value_in_si(text: str, si: str, what: str) -> float:
    """``"0.5 deg/h"`` in the SI unit `si`; raises `OptionError` that begins with `what`."""
    match = _VALUE.fullmatch(text)
    if match is None:
        raise OptionError(
            f'{what} {text!r}: want a value with its unit, e.g. "1 {units.known(si)[-1]}"', option="value"
        )
    return float(match[1]) * units.find(match[2], si=si).factor


def _value(channel: str, key: str, text: object, si: str) -> float:
    example = f'{key} = "1 {units.known(si)[-1]}"'
    match = _VALUE.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise DataError(f"channel {channel!r}: {key} = {text!r} is no value with a unit; write e.g. {example}")
    try:
        unit = units.find(match[2], si=si)
    except OptionError as error:
        raise DataError(f"channel {channel!r}: {key}: {error}") from None
    return float(match[1]) * unit.factor
