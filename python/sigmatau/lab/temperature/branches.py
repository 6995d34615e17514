"""Temperature over a record: block means, rising and falling branches, soaks, and windows at one temperature."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from sigmatau import Record, Stream
from sigmatau.arrays import Floats, Ints, runs
from sigmatau.errors import DataError
from sigmatau.fitting import mean_temperatures
from sigmatau.frozen import frozen
from sigmatau.hints import Hint

# Number of blocks of a record. [1] Judgement: in a ramp of 125 K up and down, a block spans 1 K. The time of a fit grows
# with the third power.
_BLOCKS = 240
# Smallest number of blocks. [1] Judgement: a cubic polynomial, a hysteresis and three noises need as many.
_LEAST_BLOCKS = 60
# Smallest share of the samples of a block that must be present. [1] Judgement: its mean then has 1.4 times the error.
_LEAST_PRESENT = 0.5
# Smallest range of temperatures. [K] Judgement: ArduPilot refuses less than 10 K, and a room wanders by 2 K.
LEAST_RANGE = 5.0
# Reversal that ends a branch, as a share of the range. [1] Judgement: a chamber overshoots by less.
_TURN = 0.1
# Half the width of a soak, as a share of the range, but at least 1 K. [1], [K] Judgement: a chamber holds within 1 K.
_HELD, _LEAST_HELD = 0.01, 1.0
# Shortest soak, as a share of the record. [1] Judgement: shorter ones are pauses of a ramp.
_SHORTEST_SOAK = 0.04
# Smallest share of the record in soaks; below it, the record is a ramp. [1] Judgement.
_SOAKED = 0.4
# Number of windows of a branch of a ramp. [1] Judgement: in a ramp of 125 K, each spans 25 K.
_WINDOWS = 5


@frozen(eq=False)
class Blocks:
    """Blocks of equal length of a stream, and their temperatures.

    Attributes
    ----------
    samples : int
        Samples of a block.
    start, length : float
        Time of the first block from the beginning of the whole record, and length of a block. [s]
    temperature : ndarray, shape (n,)
        Mean temperature; NaN where the thermometer has no value. [°C]
    direction : ndarray of int, shape (n,)
        1 on a rising branch, -1 on a falling one.
    low, high : float
        Range of the observed temperatures. [°C]
    """

    samples: int
    start: float
    length: float
    temperature: Floats
    direction: Ints
    low: float
    high: float

    def means(self, stream: Stream, channel: str) -> Floats:
        """Mean of a channel in each block; NaN for a block with fewer than half of its samples, shape (n,). [unit]"""
        k, m = stream.channels.index(channel), self.samples
        values = np.full(len(self.temperature), np.nan)
        for i in range(len(values)):
            x = stream.samples.read(k, i * m, (i + 1) * m)
            present = x[np.isfinite(x)]
            if len(present) >= _LEAST_PRESENT * m:
                values[i] = present.mean()
        return values


@frozen
class Span:
    """Consecutive blocks at about one temperature.

    Attributes
    ----------
    first, stop : int
        Blocks, from `first` to before `stop`.
    direction : int
        1 on a rising branch, -1 on a falling one.
    held : bool
        Whether the temperature was held.
    """

    first: int
    stop: int
    direction: int
    held: bool


def find_thermometer(record: Record) -> Stream:
    """The thermometer of a record.

    Raises
    ------
    DataError
        If the record has none.
    """
    for stream in record.streams:
        if stream.quantity == "temperature":
            return stream
    raise DataError(f"the log has no temperature column. Name it: {Hint('channels', 'temperature', 'NAME')}")


def split_blocks(stream: Stream, thermometer: Stream) -> Blocks:
    """Blocks of a stream with their temperatures and directions.

    Raises
    ------
    DataError
        For a temperature that does not vary, or too few samples.
    """
    n, tau0 = stream.grid.n, stream.grid.tau0
    samples = max(n // _BLOCKS, 1)
    count = n // samples
    if count < _LEAST_BLOCKS:
        raise DataError(f"{stream.name} has {n} samples; a calibration needs {_LEAST_BLOCKS}. Record for longer")
    edges = np.arange(count + 1) * samples * tau0 + stream.grid.start
    temperature = mean_temperatures(np.asarray(edges, dtype=np.float64), thermometer)
    finite = temperature[np.isfinite(temperature)]
    if len(finite) < _LEAST_BLOCKS:
        raise DataError("the thermometer has too few values at the times of the samples. Check its time stamps")
    if np.ptp(finite) < LEAST_RANGE:
        raise DataError(
            f"the temperature varies by {np.ptp(finite):.2g} K; a calibration needs {LEAST_RANGE:g} K."
            " Heat or cool the sensor"
        )
    # The mean of a block at a turn lies inside the range, by up to one step.
    step = float(np.nanmax(np.abs(np.diff(temperature))))
    shown = thermometer.column(thermometer.channels[0])
    return Blocks(
        low=float(max(np.nanmin(shown), finite.min() - step)),
        high=float(min(np.nanmax(shown), finite.max() + step)),
        samples=samples,
        start=stream.grid.lead,
        length=samples * tau0,
        temperature=temperature,
        direction=_directions(temperature),
    )


def _directions(temperature: Floats) -> Ints:
    """Direction of each block: 1 if the temperature rises, -1 if it falls. A soak belongs to the branch that leads to it."""
    t = np.interp(
        np.arange(len(temperature)), np.flatnonzero(np.isfinite(temperature)), temperature[np.isfinite(temperature)]
    )
    turn, held = _TURN * float(np.ptp(t)), max(_HELD * float(np.ptp(t)), _LEAST_HELD)
    result = np.zeros(len(t), dtype=np.int64)
    begin, extreme, sign = 0, 0, 0
    for i in range(1, len(t)):
        if sign == 0:
            if abs(t[i] - t[0]) > turn:
                sign, extreme = (1 if t[i] > t[0] else -1), i
            continue
        if sign * (t[i] - t[extreme]) > 0:
            extreme = i
        elif sign * (t[extreme] - t[i]) > turn:
            # The branch ends with the last block of the soak at its extreme.
            end = max(j for j in range(extreme, i) if sign * (t[extreme] - t[j]) <= held) + 1
            result[begin:end] = sign
            begin, extreme, sign = end, i, -sign
    result[begin:] = sign
    return result


def find_spans(blocks: Blocks) -> list[Span]:
    """The soaks of a record; of a ramp, the windows of its branches, which have equal ranges of temperature."""
    t, n = blocks.temperature, len(blocks.temperature)
    held = max(_HELD * (blocks.high - blocks.low), _LEAST_HELD)
    soaks, i = [], 0
    while i < n:
        j = i + 1
        while j < n and np.nanmax(t[i : j + 1]) - np.nanmin(t[i : j + 1]) <= 2 * held:
            j += 1
        if j - i >= _SHORTEST_SOAK * n:
            # At both ends of a soak the temperature still settles.
            middle = float(np.median(t[i:j]))
            inside = [k for k in range(i, j) if abs(t[k] - middle) <= held]
            soaks.append(
                Span(first=inside[0], stop=inside[-1] + 1, direction=int(blocks.direction[(i + j) // 2]), held=True)
            )
            i = j
        else:
            i += 1
    if len(soaks) > 1 and sum(span.stop - span.first for span in soaks) >= _SOAKED * n:
        return soaks
    spans = []
    for sign in (1, -1):
        for first, stop in runs(blocks.direction == sign):
            spans += _windows(t, int(first), int(stop), sign)
    return sorted(spans, key=lambda span: span.first)


def _windows(t: Floats, first: int, stop: int, sign: int) -> list[Span]:
    """Windows of a branch between equally spaced temperatures."""
    branch = t[first:stop]
    if not np.isfinite(branch).any():
        return []
    low, high = float(np.nanmin(branch)), float(np.nanmax(branch))
    edges = np.linspace(low, high, _WINDOWS + 1)
    if sign < 0:
        edges = edges[::-1]
    crossings = [first]
    for edge in edges[1:-1]:
        beyond = np.flatnonzero(sign * (branch - edge) >= 0)
        crossings.append(first + int(beyond[0]))
    crossings.append(stop)
    return [
        Span(first=a, stop=b, direction=sign, held=False)
        for a, b in pairwise(crossings)
        if b - a >= _SHORTEST_SOAK * len(t) / 2
    ]
