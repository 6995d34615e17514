"""Identification of columns by their values: time stamps, gravity on three columns, a gyro.

A column is a time if it grows along a line, and a counter if it grows by 1. Three consecutive columns are an accelerometer
if their mean has the size of gravity and their noise is much smaller. They are a gyro if their mean is small relative
to their noise, or if they are the only other sensor. Constant and slow columns (attitude, temperature, position),
quaternions and unit vectors are none of these. Every noisy column must be explained: one unexplained triple makes the
whole result uncertain, and uncertain columns are not named.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.io.read.gravity import GRAVITY, MIN_ROWS, ROWS_TESTED
from sigmatau.io.read.table import Table, all_without_absurd

Kind = Literal["time", "counter", "constant", "slow", "noise", "unknown"]
Triple = tuple[int, int, int]
"""Columns of x, y and z, counted from 0."""

# largest number of columns of a table whose values are tested; a wider one is a matrix of other data
_MAX_COLUMNS = 100
_MAX_TILINGS = 500  # largest number of ways in which the noisy columns are divided into triples

_LINE = 0.02  # largest deviation of time stamps from a line, over their span: bunched stamps stay within it
_REPEATED = 0.6  # largest share of equal neighbours among time stamps: stamps in whole seconds have more
_COUNTED = 0.9  # smallest share of steps of exactly 1 of a counter, which may wrap

# Smallest ratio of the variance of differences to that of samples, in blocks: 1 for white noise, 0.012 for a random walk,
# 0.05 after a filter at a twentieth of the rate.
_WHITE = 0.02
_BLOCK = 256  # number of samples of a block for `_WHITE`

_M_S2 = GRAVITY[1]
_COUNTS_PER_G = (2048, 4096, 8192, 16384)  # whole numbers of 16 bits at 16, 8, 4 and 2 g: InvenSense, Bosch
# relative deviation of gravity in counts: the MPU-6050's datasheet allows a bias of 60 mg and 3 % of scale
_COUNTS_ROOM = 0.08

_SCATTER = 0.05  # largest standard deviation of an accelerometer's axis, over the size of gravity
_NOISE_OF_GRAVITY = 0.01  # largest noise of an axis, over the size of gravity; the MPU-6050 has 0.6 % at 260 Hz
_ALIKE = 6.0  # largest ratio of the noise of two axes of one sensor
_GYRO_MEAN = 40.0  # largest mean of a gyro over its noise, if there are other triples; magnetometers have 50 to 1000
_ONLY_OTHER_MEAN = 150.0  # largest mean of a gyro over its noise, if it is the only triple other than gravity
# Smallest and largest mean of a gyro over its noise, without an accelerometer: a rate without a bias may be an
# acceleration without gravity.
_ALONE_MEAN = (0.5, 20.0)
_ALONE_NOISE = 3e-3  # largest noise of a gyro without an accelerometer: that of a consumer gyro at 100 Hz [rad/s]
_MAGNETIC = (
    (0.2, 0.7),
    (20.0, 70.0),
    (200.0, 700.0),
    (2e4, 7e4),
    (0.8, 1.2),
)  # the Earth's field in G, uT, mG and nT, and normalised to 1
_ROUNDING = 2.0  # largest deviation of the length of a unit vector from 1, in steps of the last digit
_UNIT = 1e-4  # deviation of the length that is always allowed: values may have only four decimals


@frozen
class Identified:
    """The columns of a table that were found by their values. Columns are counted from 0."""

    time: int | None
    gyro: Triple | None
    accel: Triple | None
    gravity: float  # Size of the mean of the accelerometer's columns; 0 without one [unit of the file]
    gyro_mean: float  # Size of the mean of the gyro's columns; 0 without one [unit of the file]
    counts_per_g: int | None  # size of 1 g, if the accelerometer's columns are whole numbers


def load_columns(table: Table) -> dict[int, NDArray[Any]]:
    """Load the columns that are numbers, by index. If the table cannot be loaded as a whole, they are loaded one by one."""
    wanted = range(len(table.columns))
    if len(wanted) > _MAX_COLUMNS:
        return {}
    try:
        return dict(all_without_absurd(table.load(list(wanted), None).columns))
    except DataError:
        columns: dict[int, NDArray[Any]] = {}
    for index in wanted:
        try:
            columns |= all_without_absurd(table.load([index], None).columns)
        except DataError:  # text
            continue
    return columns


def identify(columns: Mapping[int, NDArray[Any]], *, time: int | None, excluded: frozenset[int]) -> Identified | None:
    """Identify sensors from the values of columns; None if no sensor is identified.

    Parameters
    ----------
    columns : mapping of int to array, shape (n,)
        By index; columns of text are left out.
    time : int or None
        The time column, if it is known by its name.
    excluded : frozenset of int
        Columns whose names show that they are not a sensor, or are already recognised.
    """
    data = {index: _Column.measure(values[:ROWS_TESTED]) for index, values in columns.items() if index not in excluded}
    if time is None:
        time = next((index for index, column in sorted(data.items()) if column.kind == "time"), None)
    vectors = _unit_vectors(data)
    noisy = [
        index
        for index, column in sorted(data.items())
        if column.kind == "noise" and index != time and index not in vectors
    ]
    sensors = {
        explained
        for tiles in _tilings(noisy)
        if (explained := _sensors([_Tile.measure(t, data) for t in tiles], singles=len(noisy) - 3 * len(tiles)))
        is not None
    }
    # An accelerometer explains a triple better than a magnetometer does.
    both = {explained for explained in sensors if None not in explained}
    sensors = both or sensors
    if len(sensors) != 1:
        return None
    gyro, accel = next(iter(sensors))
    return Identified(
        time=time,
        gyro=None if gyro is None else gyro.columns,
        accel=None if accel is None else accel.columns,
        gravity=0.0 if accel is None else accel.size,
        gyro_mean=0.0 if gyro is None else gyro.size,
        counts_per_g=None if accel is None else accel.counts_per_g,
    )


@frozen(eq=False)
class _Column:
    """A column and the properties of its values."""

    values: NDArray[np.float64]  # values that are present
    rows: NDArray[np.bool_]  # rows that have a value
    kind: Kind
    mean: float
    noise: float  # standard deviation of the white part of a sample
    scatter: float  # standard deviation
    whole: bool  # whether all values are whole numbers

    @classmethod
    def measure(cls, raw: NDArray[Any]) -> _Column:
        with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
            column = np.asarray(raw, dtype=np.float64)
        rows = np.isfinite(column)
        values = column[rows]
        steps = np.diff(values)
        return cls(
            values=values,
            rows=rows,
            kind=_kind(values, steps),
            mean=float(values.mean()) if len(values) else 0.0,
            noise=float(np.sqrt(np.mean(steps * steps) / 2)) if len(steps) else 0.0,
            scatter=float(values.std()) if len(values) else 0.0,
            whole=bool(np.all(values == np.rint(values))),
        )


def _kind(values: NDArray[np.float64], steps: NDArray[np.float64]) -> Kind:
    """The kind of a column, from its values alone."""
    if len(values) < MIN_ROWS:
        return "unknown"
    if not steps.any():
        return "constant"
    if float(np.mean(steps == 1)) > _COUNTED or float(np.mean(steps == -1)) > _COUNTED:
        return "counter"
    if np.all(steps >= 0):
        line = values[0] + (values[-1] - values[0]) * np.linspace(0, 1, len(values))
        straight = float(np.abs(values - line).max()) < _LINE * float(values[-1] - values[0])
        return "time" if straight and float(np.mean(steps == 0)) < _REPEATED else "slow"
    blocks = values[: len(values) // _BLOCK * _BLOCK].reshape(-1, _BLOCK) if len(values) >= _BLOCK else values[None]
    variance = float(blocks.var(axis=1).mean())
    return "noise" if float(np.mean(steps * steps)) / 2 > _WHITE * variance else "slow"


@frozen
class _Tile:
    """Three consecutive columns."""

    columns: Triple
    size: float  # length of the mean
    noise: float  # noise of the noisiest axis
    scatter: float
    alike: bool  # whether the axes have similar noise
    whole: bool

    @classmethod
    def measure(cls, columns: Triple, data: Mapping[int, _Column]) -> _Tile:
        axes = [data[index] for index in columns]
        noises = [axis.noise for axis in axes]
        return cls(
            columns=columns,
            size=float(np.linalg.norm([axis.mean for axis in axes])),
            noise=max(noises),
            scatter=max(axis.scatter for axis in axes),
            alike=max(noises) < _ALIKE * min(noises),
            whole=all(axis.whole for axis in axes),
        )

    @property
    def counts_per_g(self) -> int | None:
        """Counts of 1 g, if the columns are integers whose mean fits a known scale."""
        if not self.whole:
            return None
        return next((counts for counts in _COUNTS_PER_G if abs(self.size / counts - 1) < _COUNTS_ROOM), None)

    @property
    def is_gravity(self) -> bool:
        has_size = self.counts_per_g is not None or any(low <= self.size <= high for low, high in GRAVITY)
        return (
            has_size
            and self.alike
            and self.scatter < _SCATTER * self.size
            and self.noise < _NOISE_OF_GRAVITY * self.size
        )

    @property
    def is_magnetic(self) -> bool:
        has_size = any(low <= self.size <= high for low, high in _MAGNETIC)
        return has_size and self.alike and self.size > _GYRO_MEAN * self.noise

    def is_gyro(self, largest_mean: float) -> bool:
        return self.alike and self.size <= largest_mean * self.noise


Sensors = tuple[_Tile | None, _Tile | None]
"""The gyro and the accelerometer."""


def _sensors(tiles: Sequence[_Tile], *, singles: int) -> Sensors | None:
    """The sensors of triples that explain all noisy columns except some single ones; None if the explanation is missing or
    ambiguous.

    A single sensor is less certain: with an accelerometer, one more column may be noisy; with a gyro, none.
    """
    gravity = [tile for tile in tiles if tile.is_gravity]
    rest = [tile for tile in tiles if not tile.is_gravity]
    if len(gravity) > 1:
        return None
    if gravity and not rest:
        alone = _M_S2[0] <= gravity[0].size <= _M_S2[1]  # other sensors may have a mean of 1 or 1000 too
        return (None, gravity[0]) if alone and singles <= 1 else None
    if gravity and len(rest) == 1:
        return (rest[0], gravity[0]) if rest[0].is_gyro(_ONLY_OTHER_MEAN) else None
    gyros = [tile for tile in rest if tile.is_gyro(_GYRO_MEAN)]
    if len(gyros) != 1 or not all(
        tile.is_magnetic and tile.size > gyros[0].size for tile in rest if tile is not gyros[0]
    ):
        return None
    if gravity:
        return gyros[0], gravity[0]
    low, high = _ALONE_MEAN
    certain = low * gyros[0].noise < gyros[0].size < high * gyros[0].noise and gyros[0].noise < _ALONE_NOISE
    return (gyros[0], None) if certain and not singles else None


def _tilings(noisy: Sequence[int]) -> Iterator[tuple[Triple, ...]]:
    """All ways to divide runs of consecutive columns into triples, with as few single columns as possible."""
    starts = [k for k, index in enumerate(noisy) if k == 0 or noisy[k - 1] != index - 1]
    runs = [list(noisy[a:b]) for a, b in itertools.pairwise([*starts, len(noisy)])]
    ways = itertools.product(*(list(_tilings_of_run(run)) for run in runs))
    for tiles in itertools.islice(ways, _MAX_TILINGS):
        yield tuple(itertools.chain.from_iterable(tiles))


def _tilings_of_run(run: Sequence[int]) -> Iterator[tuple[Triple, ...]]:
    triples, singles = divmod(len(run), 3)
    for places in itertools.islice(itertools.combinations(range(triples + singles), singles), _MAX_TILINGS):
        tiles, start = list[Triple](), 0
        for place in range(triples + singles):
            if place in places:
                start += 1
            else:
                tiles.append((run[start], run[start + 1], run[start + 2]))
                start += 3
        yield tuple(tiles)


def _unit_vectors(data: Mapping[int, _Column]) -> frozenset[int]:
    """Columns of quaternions and unit vectors: four or three adjacent columns whose length is 1 to the last digit."""
    members: set[int] = set()
    for width in (4, 3):
        for first in data:
            columns = [data[index] for index in range(first, first + width) if index in data]
            if len(columns) == width and len({len(column.values) for column in columns}) == 1 and _is_unit(columns):
                members.update(range(first, first + width))
    return frozenset(members)


def _is_unit(columns: Sequence[_Column]) -> bool:
    if any(column.kind in ("time", "counter", "unknown") for column in columns):
        return False
    if all(column.kind == "constant" for column in columns):
        return False  # constant columns are not a sensor
    constant = sum(float(column.mean) ** 2 for column in columns if column.kind == "constant")
    length = np.sqrt(sum(column.values**2 for column in columns))
    if not 0.9 < length[0] < 1.1 or abs(constant - 1) < _UNIT:
        # most columns fail here; the last test rejects a constant column of ones among zeros
        return False
    steps = [np.abs(np.diff(column.values)) for column in columns]
    digit = min(float(step[step > 0].min()) for step in steps if step.any())
    return bool(np.abs(length - 1).max() <= max(_ROUNDING * digit, _UNIT))
