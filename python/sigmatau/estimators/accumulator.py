"""Allan variance of a record that arrives in pieces or does not fit in memory.

Cluster sizes up to 4096 samples are exact. For longer clusters there are two modes: "exact" keeps all samples; "strided"
has bounded memory, and clusters begin only at every 64th sample, every 4096th and so on, with at least 64 starts per
cluster. The loss of precision is negligible for white and slower noise. It is large for quantization noise, which is
observed at short times. The result contains the stride of each size.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.errors import NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.allan import Curves, DeviationCurve, refuse_missing
from sigmatau.estimators.deviation_kinds import TauGrid, cluster_sizes
from sigmatau.record.record import conversion, real_numbers
from sigmatau.record.streams import Stream
from sigmatau.results import Printed

Long = Literal["exact", "strided"]

_MAX_SAMPLES = 1 << 41  # 35 years at 2 kHz [samples]


class Accumulator(Printed):
    """Running Allan variances of the channels of one sensor.

    Parameters
    ----------
    *channels : str
        Names, in the order of the columns that will be pushed; ``gyro…`` are angular rates, ``accel…`` accelerations.
    rate : float
        Sampling rate. [Hz]
    unit : mapping, optional
        Unit by channel, or by ``"gyro"`` and ``"accel"``. Default: SI.
    input : {"rate", "increments"}
        Content of the samples: rates, or increments per sample.
    taus : {"octave", "half", "quarter", "eighth"} or array_like, shape (n_tau,)
        Averaging times, see `sigmatau.allan`; a snapshot omits those too long for the samples pushed. [s]
    long : {"exact", "strided"}
        Mode for clusters of more than 4096 samples. "exact" keeps all samples, 8 bytes each, and uses every pair.
        "strided" needs a few megabytes per channel for a record of any length, with at least 64 starts per cluster.
    start : int
        Index in the record of the first sample that will be pushed, for stretches that are to be merged.

    Raises
    ------
    OptionError
        For an impossible rate, unit, grid or start, or no channel.

    See Also
    --------
    allan : Allan variance of a record.

    References
    ----------
    .. [1] :doi:`10.1109/TIM.2007.908635`, eq. (10)

    Examples
    --------
    >>> import numpy as np
    >>> from sigmatau import Accumulator
    >>> stream = Accumulator("gyro_x", rate=100, unit={"gyro": "deg/s"}, taus=[0.01, 0.1, 1], long="strided")
    >>> rng = np.random.default_rng(1)
    >>> for _ in range(60):
    ...     stream.push(rng.standard_normal((100, 1)))
    >>> stream.snapshot()["gyro_x"].n_pairs
    array([5999, 5981, 5801])
    """

    __slots__ = ("_factors", "_quantities", "_sums", "_units", "channels", "long", "start", "tau0")

    def __init__(
        self,
        *channels: str,
        rate: float,
        unit: Mapping[str, str] | None = None,
        input: Literal["rate", "increments"] = "rate",  # noqa: A002  the word users know from --input
        taus: TauGrid | ArrayLike = "half",
        long: Long = "exact",
        start: int = 0,
    ) -> None:
        if not channels or len(set(channels)) < len(channels) or not all(isinstance(c, str) and c for c in channels):
            raise OptionError(f"{{option}} must be different names, not {channels!r}", option="channels")
        if not (isinstance(rate, int | float | np.integer | np.floating) and np.isfinite(rate) and rate > 0):
            raise OptionError(f"{{option}} must be a positive number of hertz, not {rate!r}", option="rate")
        if input not in ("rate", "increments"):
            raise OptionError(f"{{option}} must be 'rate' or 'increments', not {input!r}", option="input")
        if isinstance(start, bool) or not isinstance(start, int | np.integer) or not 0 <= start < 1 << 62:
            raise OptionError(f"{{option}} must be the index of a sample, not {start!r}", option="start")
        if unit is not None and not isinstance(unit, Mapping):
            raise TypeError(f"`unit` must be a mapping such as {{'gyro': 'deg/s'}}, not {unit!r}")
        self.channels: tuple[str, ...] = channels
        self.tau0: float = 1.0 / float(rate)
        if long not in ("exact", "strided"):
            raise OptionError(f"{{option}} must be 'exact' or 'strided', not {long!r}", option="long")
        self.long = long
        self.start: int = int(start)
        kinds = [conversion(channel, unit or {}, input) for channel in channels]
        unknown = set(unit or {}) - {name for channel in channels for name in (channel, channel.split("_")[0])}
        if unknown:
            raise OptionError(f"{{option}} names {min(unknown)!r}, which is not a channel", option="unit")
        self._quantities = [quantity for quantity, _, _ in kinds]
        self._units = [unit for _, unit, _ in kinds]
        self._factors = [factor / (self.tau0 if input == "increments" else 1.0) for _, _, factor in kinds]
        if isinstance(taus, str) and taus == "all":
            raise OptionError("{option} 'all' takes a whole record: see `sigmatau.allan`", option="taus")
        sizes = cluster_sizes(taus, n=_MAX_SAMPLES, tau0=self.tau0)
        if long == "strided":
            sizes = strided_sizes(sizes)
        self._sums = [
            kernels.RunningSums(sizes, strided=long == "strided", start=self.start, name=channel)
            for channel in channels
        ]

    @property
    def n(self) -> int:
        """Samples received of each channel."""
        return self._sums[0].samples

    def push(self, chunk: ArrayLike | Mapping[str, ArrayLike]) -> None:
        """Add the next samples. The result does not depend on the sizes of the pieces.

        Parameters
        ----------
        chunk : array_like, shape (n, n_channels) or (n,) for one channel; or a mapping from channel to (n,)
            Samples in the stated unit. [`unit`; SI by default]

        Raises
        ------
        NonFiniteError
            If a sample is missing, infinite or beyond 1e130. The chunk is then not added.
        ValueError
            For another shape, or other channels.
        """
        columns = [
            column if factor == 1.0 else column * factor
            for column, factor in zip(self._columns(chunk), self._factors, strict=True)
        ]
        for column, channel in zip(columns, self.channels, strict=True):
            row = kernels.RunningSums.first_unusable(column)
            if row is not None:
                index = self.start + self.n + row
                raise NonFiniteError(
                    f"`{channel}` is {column[row]:g} in SI at index {index} of the record, {row} of the chunk: a stream has"
                    " no gaps; begin a new one after it",
                    channel=channel,
                    index=index,
                )
        for column, sums in zip(columns, self._sums, strict=True):
            sums.push(column)

    def merge(self, later: Accumulator) -> None:
        """Add the samples of the accumulator of the following part of the record.

        Parameters
        ----------
        later : Accumulator
            Begins where this one ends. It is not changed.

        Raises
        ------
        TypeError
            If `later` is not an accumulator.
        ValueError
            If `later` has other channels, another rate or other averaging times, or does not begin where this one ends.
            Nothing has then changed.
        """
        if not isinstance(later, Accumulator):
            raise TypeError(f"only an Accumulator can be merged, not a {type(later).__name__}")
        if later is self:
            later = self.copy()
        mine, theirs = ((a.channels, a.tau0, a.long, a._units, a._quantities) for a in (self, later))
        if mine != theirs:
            raise ValueError("the two accumulators differ in channels, rate or `long`")
        if later.start != self.start + self.n:
            raise ValueError(
                f"the stretch to merge begins at sample {later.start}, this one ends before sample {self.start + self.n}"
            )
        try:
            for ours, later_sums in zip(self._sums, later._sums, strict=True):
                ours.merge(later_sums)
        except ValueError:
            raise ValueError("the two accumulators have different averaging times") from None

    def __copy__(self) -> Self:
        return self.copy()

    def __deepcopy__(self, memo: object) -> Self:
        return self.copy()

    def copy(self) -> Self:
        """An independent accumulator with the same sums."""
        twin = object.__new__(type(self))
        for name in Accumulator.__slots__:
            setattr(twin, name, getattr(self, name))
        twin._sums = [sums.copy() for sums in self._sums]
        return twin

    def snapshot(self) -> Curves:
        """Curves of the samples pushed so far; more samples may be pushed afterwards.

        Raises
        ------
        RecordTooShortError
            If fewer than two samples were pushed, or too few for any of the averaging times.
        """
        curves = {}
        for k, sums in enumerate(self._sums):
            m, avar, ramp, pairs, strides = sums.snapshot()
            if m.size == 0:
                raise RecordTooShortError(
                    f"{self.n} samples do not make two clusters of any size asked for", need=2, got=self.n
                )
            curves[self.channels[k]] = DeviationCurve(
                channel=self.channels[k],
                quantity=self._quantities[k],
                unit=self._units[k],
                m=m,
                tau=np.asarray(m * self.tau0, dtype=np.float64),
                avar=avar,
                n_pairs=pairs,
                ramp=ramp / self.tau0,
                n=self.n,
                tau0=self.tau0,
                stride=strides if (strides > 1).any() else None,
            )
        return Curves(curves)

    def __repr__(self) -> str:
        return (
            f"Accumulator of {', '.join(self.channels)}: {self.n} samples at {1 / self.tau0:.6g} Hz from sample"
            f" {self.start} on, long clusters {self.long}"
        )

    def _columns(self, chunk: ArrayLike | Mapping[str, ArrayLike]) -> list[NDArray[np.float64]]:
        if isinstance(chunk, Mapping):
            if set(chunk) != set(self.channels):
                raise ValueError(f"`chunk` has {', '.join(map(str, chunk))}; want {', '.join(self.channels)}")
            columns = [real_numbers(channel, chunk[channel]) for channel in self.channels]
            shapes = {column.shape for column in columns}
            if len(shapes) > 1 or columns[0].ndim != 1:
                raise ValueError(f"the channels of `chunk` must have one length, got shapes {sorted(shapes)}")
        else:
            array = real_numbers("chunk", chunk)
            if array.ndim == 1 and len(self.channels) == 1:
                array = array[:, np.newaxis]
            if array.ndim != 2 or array.shape[1] != len(self.channels):
                raise ValueError(f"`chunk` has shape {array.shape}; want (n, {len(self.channels)})")
            columns = list(array.T)
        return [np.ascontiguousarray(column) for column in columns]


def accumulate(stream: Stream, *, taus: TauGrid | ArrayLike, long: Long = "strided") -> Curves:
    """Compute the curves of a stream that is read in pieces; see `Accumulator`."""
    refuse_missing(stream, "a sum in bounded memory")
    if isinstance(taus, str) and taus == "all":
        raise OptionError("{option} 'all' needs the whole record in memory; take a grid", option="taus")
    sizes = cluster_sizes(taus, n=stream.grid.n, tau0=stream.grid.tau0)
    sums = Accumulator(*stream.channels, rate=stream.grid.rate, taus=sizes * stream.grid.tau0, long=long)
    sums._quantities = [stream.quantity] * len(stream.channels)
    sums._units = [stream.unit] * len(stream.channels)
    sums.tau0 = stream.grid.tau0
    for chunk in stream.chunks():
        sums.push(chunk)
    return sums.snapshot()


def strided_sizes(sizes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Cluster sizes rounded to multiples of their strides, without duplicates."""
    rounded = sizes
    for _ in range(2):  # rounding up may lead to the next stride
        strides = kernels.strides(rounded)
        rounded = np.rint(rounded / strides).astype(np.int64) * strides
    return np.unique(rounded)
