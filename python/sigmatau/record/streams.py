"""Streams: the channels of one sensor on one uniform grid, read as rates in SI.

Rates, increments, accumulated angle or velocity; counts, volts or any unit: a `Transform` turns them into rates when they
are read. Samples are reached through `Stream.chunks` or `Stream.column`, so that a record need not fit in memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from typing import Any, Literal, cast, get_args

import numpy as np
from numpy.typing import NDArray

from sigmatau.arrays import column_counts
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.record.sampling import GIVEN_RATE, RateSource, Sampling

InputKind = Literal["rate", "increments", "accumulated"]

RATES = (1e-6, 1e9)
"""Range of sampling rates; times, phases and squares of rates outside overflow a double. [Hz]"""

PLAUSIBLE_RATES = (0.01, 5e4)
"""Sampling rates of inertial sensors. [Hz]"""

CHUNK = 1 << 16
"""Default number of samples of a chunk."""

# Largest size of the rates of a record that are in memory beside the numbers of its log. [bytes] Judgement: three hours of
# six axes at 400 Hz; an analysis of them takes more.
_MAX_CONVERTED = 1 << 28


def check_rate(rate: Any) -> float:  # noqa: ANN401  of the user
    """A sampling rate; raises `OptionError`. [Hz]"""
    number = isinstance(rate, int | float | np.integer | np.floating) and not isinstance(rate, bool)
    if not (number and RATES[0] <= rate <= RATES[1]):
        raise OptionError(
            f"{{option}} must be a positive number of hertz, {RATES[0]:g} to {RATES[1]:g}, not {rate!r}", option="rate"
        )
    return float(rate)


def check_rates(rate: Any) -> tuple[float | None, dict[str, float]]:  # noqa: ANN401  of the user
    """A sampling rate of all sensors, or None, and those of single sensors; raises `OptionError`. [Hz]"""
    if not isinstance(rate, Mapping):
        return (None if rate is None else check_rate(rate)), {}
    rates: dict[str, float] = {}
    for sensor, value in rate.items():
        if not isinstance(sensor, str):
            raise OptionError(f'{{option}} must be a number, or e.g. {{"gyro": 400}}, not {rate!r}', option="rate")
        name = sensor.strip().lower()
        if name.startswith(("gyro_", "accel_")):
            raise OptionError(
                f"{{option}} of {sensor}: the axes of a sensor have one rate; give {name.partition('_')[0]}",
                option="rate",
            )
        try:
            rates[sensor] = check_rate(value)
        except OptionError as error:
            raise error.named("rate", f"of {sensor}") from None
    return None, rates


def check_kind(kind: object) -> InputKind:
    """A kind of input; raises `OptionError`."""
    if kind not in get_args(InputKind):
        raise OptionError(f"{{option}} must be one of {', '.join(get_args(InputKind))}, not {kind!r}", option="input")
    return cast("InputKind", kind)


@frozen
class Grid:
    """A uniform grid in time.

    Attributes
    ----------
    n : int
        Number of rate samples.
    tau0 : float
        Sample interval. [s]
    start : float
        Time of the first sample in the log's own clock, after whole-second epochs have been taken off. [s]
    source : RateSource
        Where `tau0` comes from.
    lead : float
        Time of the first sample from the beginning of the whole record; 0 for the whole record. [s]
    epoch : float
        Whole seconds that were subtracted from time stamps that count from an epoch, such as 1970. [s]
    jitter : float or None
        Standard deviation of the time stamps about the grid; None without time stamps. [s]
    """

    n: int
    tau0: float
    start: float = 0.0
    source: RateSource = GIVEN_RATE
    jitter: float | None = None
    lead: float = 0.0
    epoch: float = 0.0

    @property
    def rate(self) -> float:
        """Sampling rate. [Hz]"""
        return 1.0 / self.tau0

    @property
    def duration(self) -> float:
        """Length of the record, n·tau0. [s]"""
        return self.n * self.tau0

    def time(self, sample: float) -> float:
        """Time of a sample from the beginning of the whole record, as findings and options count it.

        Parameters
        ----------
        sample : float
            Number of the sample, from 0; may be a fraction.

        Returns
        -------
        float
            [s]
        """
        return self.lead + sample * self.tau0

    def sample(self, time: float) -> int:
        """The sample nearest to a time; it may be beyond either end.

        Parameters
        ----------
        time : float
            Time from the beginning of the whole record. [s]

        Returns
        -------
        int
        """
        return round((time - self.lead) / self.tau0)


@frozen
class Transform:
    """Conversion of a number of the log to a rate in SI: ``(raw - offset) * scale * factor``, then the step for `kind`.

    Increments are divided by the sample interval; accumulated values are differenced first.

    Attributes
    ----------
    scale, offset : float
        Conversion of counts or volts to the stated unit. [stated unit per count; counts]
    factor : float
        Factor from the stated unit to SI.
    kind : {"rate", "increments", "accumulated"}
        Meaning of the numbers.
    """

    scale: float = 1.0
    offset: float = 0.0
    factor: float = 1.0
    kind: InputKind = "rate"


@frozen(eq=False, kw_only=False)
class Columns:
    """The samples of a stream: one raw array per channel (in memory or memory-mapped), converted when read.

    Attributes
    ----------
    raw : tuple of ndarray, shape (n,)
        Numbers of the log by channel; n + 1 of accumulated values.
    transforms : tuple of Transform
        By channel.
    tau0 : float
        Sample interval. [s]
    missing : ndarray of bool, shape (n, n_channels), or None
        True for rates that are treated as missing although the log has a number. It masks rates, because an accumulated
        value is part of two rates. The numbers of the log are not changed.
    rates : tuple of ndarray, shape (n,), or None
        The converted numbers, so that they are not converted in every `read`; see `converted`. [unit of the stream, SI]
    """

    raw: tuple[NDArray[Any], ...]
    transforms: tuple[Transform, ...]
    tau0: float
    missing: NDArray[np.bool_] | None = None
    rates: tuple[NDArray[np.float64], ...] | None = field(default=None, repr=False)

    def __len__(self) -> int:
        lost = 1 if self.transforms[0].kind == "accumulated" else 0
        return max(len(self.raw[0]) - lost, 0)

    def shrinks(self, channel: int) -> bool:
        """Whether the rates of a channel are never larger than its raw numbers.

        Parameters
        ----------
        channel : int
            Position of the channel.

        Returns
        -------
        bool
        """
        t = self.transforms[channel]
        return t.kind == "rate" and t.offset == 0 and abs(t.scale * t.factor) <= 1

    def read_stretches(self, channel: int, starts: Iterable[int], length: int) -> list[NDArray[np.float64]]:
        """Rates of one channel in stretches of equal length, as `read` gives them.

        Parameters
        ----------
        channel : int
            Position of the channel.
        starts : iterable of int
            First samples.
        length : int
            Samples of each stretch.

        Returns
        -------
        list of ndarray, shape (length,)
            [unit of the stream, SI]
        """
        return [self.read(channel, start, start + length) for start in starts]

    def read(self, channel: int, start: int, stop: int) -> NDArray[np.float64]:
        """Rates of one channel in SI, NaN where they are missing.

        Parameters
        ----------
        channel : int
            Position of the channel.
        start, stop : int
            Samples, from `start` to before `stop`.

        Returns
        -------
        ndarray, shape (stop - start,)
            [unit of the stream, SI]
        """
        x = self._convert(channel, start, stop) if self.rates is None else self.rates[channel][start:stop]
        return x if self.missing is None else np.where(self.missing[start:stop, channel], np.nan, x)

    def _convert(self, channel: int, start: int, stop: int) -> NDArray[np.float64]:
        """Convert the numbers of the log to rates in SI."""
        t = self.transforms[channel]
        extra = 1 if t.kind == "accumulated" else 0
        x = np.asarray(self.raw[channel][start : stop + extra])
        if x.dtype != np.float64:
            with np.errstate(invalid="ignore"):  # a damaged number may be a signalling NaN
                x = x.astype(np.float64)
        if t.kind == "accumulated":
            x = np.diff(x)  # an offset would cancel here
        elif t.offset:
            x = x - t.offset
        factor = t.scale * t.factor
        if t.kind != "rate":
            factor /= self.tau0
        return x if factor == 1.0 else x * factor


def converted(streams: Sequence[Stream]) -> tuple[Stream, ...]:
    """Convert the numbers of small streams in memory, which an analysis reads many times; others are converted when read."""
    in_memory = all(isinstance(raw, np.ndarray) for stream in streams for raw in stream.samples.raw)
    if rates_size(streams) > _MAX_CONVERTED or not in_memory:
        return tuple(streams)

    def with_conversion(samples: Columns) -> Columns:
        rates = [samples._convert(k, 0, len(samples)) for k in range(len(samples.raw))]
        for column in rates:
            column.flags.writeable = False
        return replace(samples, rates=tuple(rates))

    return tuple(replace(stream, samples=with_conversion(stream.samples)) for stream in streams)


@frozen(eq=False)
class Stream:
    """Channels of one sensor on one grid.

    Attributes
    ----------
    name : str
        ``"gyro"``, ``"accel"``, or the name of another signal.
    quantity : str
        ``"angular_rate"``, ``"acceleration"``, ``"temperature"`` or ``"signal"``.
    unit : str
        Unit of the rates, SI: ``"rad/s"``, ``"m/s^2"``; for a signal, its own unit.
    channels : tuple of str
        Names of the channels, e.g. ``("gyro_x", "gyro_y", "gyro_z")``.
    grid : Grid
    samples : Columns
    mask : ndarray of bool, shape (n, n_channels), or None
        True where a sample is missing; None if no sample is missing.

    See Also
    --------
    Record : streams and their origin.

    Examples
    --------
    >>> import numpy as np
    >>> from sigmatau import Record
    >>> (stream,) = Record.from_arrays(rate=100, unit={"gyro": "deg/s"}, gyro=np.ones((1000, 3))).streams
    >>> stream.channels, stream.unit, stream.grid.duration
    (('gyro_x', 'gyro_y', 'gyro_z'), 'rad/s', 10.0)
    >>> stream.column("gyro_x")[:2].round(6)
    array([0.017453, 0.017453])
    """

    name: str
    quantity: str
    unit: str
    channels: tuple[str, ...]
    grid: Grid
    samples: Columns = field(repr=False)
    mask: NDArray[np.bool_] | None = field(default=None, repr=False)

    def column(self, channel: str) -> NDArray[np.float64]:
        """All rates of one channel in SI; NaN where samples are missing.

        Parameters
        ----------
        channel : str
            Name of the channel.

        Returns
        -------
        ndarray, shape (n,)
            [unit of the stream]

        Raises
        ------
        KeyError
            For a channel that the stream does not have.
        """
        return self.samples.read(self._position(channel), 0, self.grid.n)

    def _position(self, channel: str) -> int:
        try:
            return self.channels.index(channel)
        except ValueError:
            raise KeyError(f"no channel {channel!r}; the stream has {', '.join(self.channels)}") from None

    def chunks(self, size: int = CHUNK) -> Iterator[NDArray[np.float64]]:
        """The rates in SI in consecutive pieces; may be called repeatedly.

        Parameters
        ----------
        size : int
            Samples of a piece, at most.

        Yields
        ------
        ndarray, shape (≤ size, n_channels)
            [unit of the stream]
        """
        for start in range(0, self.grid.n, size):
            stop = min(start + size, self.grid.n)
            yield np.stack([self.samples.read(c, start, stop) for c in range(len(self.channels))], axis=1)

    def with_rates(self, columns: Sequence[NDArray[np.float64]]) -> Stream:
        """The stream with the given rates in SI.

        Parameters
        ----------
        columns : sequence of ndarray, shape (n,)
            One a channel. [unit of the stream]

        Returns
        -------
        Stream
        """
        return replace(self, samples=Columns(tuple(columns), (Transform(),) * len(columns), self.grid.tau0))

    def only(self, channel: str) -> Stream:
        """A stream of one of the channels.

        Parameters
        ----------
        channel : str
            Name of the channel.

        Returns
        -------
        Stream

        Raises
        ------
        KeyError
            For a channel that the stream does not have.
        """
        return self.of([channel])

    def of(self, channels: Sequence[str]) -> Stream:
        """A stream of some of the channels.

        Parameters
        ----------
        channels : sequence of str
            Names of the channels.

        Returns
        -------
        Stream

        Raises
        ------
        KeyError
            For a channel that the stream does not have.
        """
        if tuple(channels) == self.channels:
            return self
        places = [self._position(channel) for channel in channels]
        samples = replace(
            self.samples,
            raw=tuple(self.samples.raw[k] for k in places),
            transforms=tuple(self.samples.transforms[k] for k in places),
            missing=None if self.samples.missing is None else self.samples.missing[:, places],
            rates=None if self.samples.rates is None else tuple(self.samples.rates[k] for k in places),
        )
        mask = None if self.mask is None else self.mask[:, places]
        missing = mask is not None and bool(mask.any())
        return replace(self, channels=tuple(channels), samples=samples, mask=mask if missing else None)

    def cut(self, start: int, stop: int) -> Stream:
        """The stream of some of the samples.

        Parameters
        ----------
        start, stop : int
            Samples, from `start` to before `stop`.

        Returns
        -------
        Stream
        """
        extra = 1 if self.samples.transforms[0].kind == "accumulated" else 0
        raw = tuple(r[start : stop + extra] for r in self.samples.raw)
        missing = None if self.samples.missing is None else self.samples.missing[start:stop]
        rates = None if self.samples.rates is None else tuple(x[start:stop] for x in self.samples.rates)
        before = start * self.grid.tau0
        grid = replace(self.grid, n=stop - start, start=self.grid.start + before, lead=self.grid.lead + before)
        mask = None if self.mask is None else self.mask[start:stop]
        return replace(
            self,
            samples=replace(self.samples, raw=raw, missing=missing, rates=rates),
            grid=grid,
            mask=mask if mask is not None and mask.any() else None,
        )

    def longest_run(self) -> Stream:
        """The longest run of samples in which no channel has a missing sample."""
        if self.mask is None:
            return self
        bad = np.flatnonzero(self.mask.any(axis=1))
        edges = np.concatenate(([-1], bad, [self.grid.n]))
        k = int(np.argmax(np.diff(edges)))
        return self.cut(int(edges[k]) + 1, int(edges[k + 1]))


def rates_size(streams: Iterable[Stream]) -> int:
    """Size of the rates of all channels as 64-bit numbers. [bytes]"""
    return sum(8 * stream.grid.n * len(stream.channels) for stream in streams)


def describe_sampling(stream: Stream) -> Sampling:
    """How a stream was sampled, and what is missing."""
    missing = () if stream.mask is None else tuple((column_counts(stream.mask) / stream.grid.n).tolist())
    grid = stream.grid
    return Sampling(channels=stream.channels, n=grid.n, rate=grid.rate, source=grid.source, missing=missing)
