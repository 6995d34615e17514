"""Records simulated from a noise model."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sigmatau import _kernels
from sigmatau.errors import OptionError
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record import MIN_SAMPLES, Provenance, Record, stream_name
from sigmatau.streams import Columns, Grid, Stream, Transform

__all__ = ["simulate"]


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
            quantity=model.channels[next(iter(columns))].quantity,
            unit=model.channels[next(iter(columns))].unit,
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
