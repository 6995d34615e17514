"""Kinds of findings about time stamps and missing samples: rate, gaps, jitter, clock."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from sigmatau.findings.finding import Details

__all__ = [
    "CoarseStamps",
    "DuplicateSamples",
    "EmptyChannel",
    "Gap",
    "Gaps",
    "HostStamps",
    "ImplausibleRate",
    "IrregularStamps",
    "Jitter",
    "LongPauses",
    "MissingStamps",
    "MissingValues",
    "RateDrift",
    "RateMismatch",
    "RateNotNominal",
    "RateOverruled",
    "RowsOutOfOrder",
    "Subsampled",
    "WrongStamps",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImplausibleRate(Details):
    """The stamps give a rate that no usual sensor has.

    Attributes
    ----------
    rate : float
        Rate by the stamps. [Hz]
    """

    code: ClassVar[str] = "implausible_rate"
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RateNotNominal(Details):
    """The rate by the stamps is close to a nominal rate, but differs from it significantly.

    Attributes
    ----------
    rate, nominal : float
        Rate by the stamps, and the nearest rate as datasheets state them. [Hz]
    """

    code: ClassVar[str] = "rate_not_nominal"
    rate: float
    nominal: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RateMismatch(Details):
    """The rate in use differs from the rate by the stamps.

    Attributes
    ----------
    used, by_stamps : float
        [Hz]
    """

    code: ClassVar[str] = "rate_mismatch"
    used: float
    by_stamps: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RateOverruled(Details):
    """The rate that was given differs from the rate that the file states.

    Attributes
    ----------
    given, stated : float
        [Hz]
    """

    code: ClassVar[str] = "rate_overruled"
    given: float
    stated: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RateDrift(Details):
    """The sampling rate changes over the record, by the mean rates of ten equal parts.

    Attributes
    ----------
    lowest, highest : float
        Of the ten rates. [Hz]
    """

    code: ClassVar[str] = "rate_drift"
    lowest: float
    highest: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Gap:
    """Consecutive missing samples.

    Attributes
    ----------
    samples : int
    start, length : float
        From the beginning of the record. [s]
    place : str
        The row behind the gap, as the file counts it: ``"line 501"``.
    """

    samples: int
    start: float
    length: float
    place: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Subsampled:
    """A stretch in which only every k-th sample is present.

    Attributes
    ----------
    every : int
        k.
    start, stop : float
        From the beginning of the record. [s]
    rate : float
        Rate in this stretch. [Hz]
    """

    every: int
    start: float
    stop: float
    rate: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Gaps(Details):
    """Samples are missing between the stamps; their places on the grid are left empty.

    Attributes
    ----------
    samples : int
        Places on the grid.
    gaps : int
        Number of gaps.
    longest : tuple of Gap
        The longest gaps, longest first.
    rate : float
        Rate of the grid. [Hz]
    estimated : bool
        Whether the number of missing samples is an estimate, from stamps of a host.
    period : int
        Rows after which the pattern of losses repeats; 0 if it does not.
    even_rate : float or None
        Rate of even samples that a coarse clock would stamp in the same pattern. [Hz]
    subsampled : Subsampled or None
    """

    code: ClassVar[str] = "gaps"
    samples: int
    gaps: int
    longest: tuple[Gap, ...]
    rate: float
    estimated: bool = False
    period: int = 0
    even_rate: float | None = None
    subsampled: Subsampled | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LongPauses(Details):
    """Pauses, or steps of the clock, that are longer than the recorded data; only the longest piece is analysed.

    Attributes
    ----------
    pauses : int
    longest : float
        [s]
    place : str
        The row behind the longest pause.
    first : str
        The first row of the analysed piece.
    used, total : int
        Samples of that piece, and of the log.
    """

    code: ClassVar[str] = "long_pauses"
    pauses: int
    longest: float
    place: str
    first: str
    used: int
    total: int


@dataclass(frozen=True, slots=True, kw_only=True)
class IrregularStamps(Details):
    """The stamps fit no grid; the samples are taken as evenly spaced.

    Attributes
    ----------
    interval : float
        The sample interval in use. [s]
    longest : float or None
        The longest interval between stamps. [s]
    place : str
        The row behind it.
    leaps : int
        Intervals of a live log that are negative or longer than 20 samples.
    """

    code: ClassVar[str] = "irregular_stamps"
    interval: float
    longest: float | None = None
    place: str = ""
    leaps: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseStamps(Details):
    """The stamps fit evenly spaced samples on a clock of low resolution.

    Attributes
    ----------
    step : float
        Resolution of the clock. [s]
    rate : float
        Rate in use. [Hz]
    rate_error : float or None
        Largest relative error of the rate; None if the stamps allow any higher rate.
    hidden : int
        Fewer consecutive lost samples than this cannot be seen.
    single_precision : bool
        Whether the resolution is that of single-precision numbers.
    period, lost : int
        The stamps would also fit a rate of one sample per step, with `lost` of every `period` samples missing; 0 if not.
    """

    code: ClassVar[str] = "coarse_stamps"
    step: float
    rate: float
    rate_error: float | None = 0.0
    hidden: int = 0
    single_precision: bool = False
    period: int = 0
    lost: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class HostStamps(Details):
    """The stamps say when a host received the samples, in bunches; the samples are taken as evenly spaced.

    Attributes
    ----------
    rate : float
        Mean rate, in use. [Hz]
    median_rate : float or None
        Rate by the median interval; None if that is zero. [Hz]
    longest : float
        The longest interval between stamps. [s]
    place : str
        The row behind it.
    """

    code: ClassVar[str] = "host_stamps"
    rate: float
    median_rate: float | None
    longest: float
    place: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Jitter(Details):
    """The stamps scatter about their grid.

    Attributes
    ----------
    sigma : float
        Standard deviation. [s]
    interval : float
        Sample interval. [s]
    mean : float or None
        Largest mean of the channels, times which the scatter is quantization noise of increments; in `unit` per second.
    strongest : str
        The channel with that mean.
    unit : str
        Unit of quantization noise.
    seen : float or None
        Quantization noise in the samples of an integrating channel, in `unit`; None for rates.
    share : float
        Share of the squared quantization noise that the scatter accounts for.
    """

    code: ClassVar[str] = "jitter"
    sigma: float
    interval: float
    mean: float | None = None
    strongest: str = ""
    unit: str = ""
    seen: float | None = None
    share: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingStamps(Details):
    """Rows without a time stamp, which are left out.

    Attributes
    ----------
    rows : int
        Rows of the log.
    place : str
        The first of them.
    """

    code: ClassVar[str] = "missing_stamps"
    rows: int
    place: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RowsOutOfOrder(Details):
    """Rows that stand later in the log than their stamps say, and are moved to their place.

    Attributes
    ----------
    rows : int
        Rows of the log.
    place : str
        The first of them.
    stamp : float
        Its time stamp, in the unit of the column.
    """

    code: ClassVar[str] = "rows_out_of_order"
    rows: int
    place: str
    stamp: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WrongStamps(Details):
    """Rows whose stamps are far from those before and after, which are left out.

    Attributes
    ----------
    rows : int
        Rows of the log.
    place : str
        The first of them.
    """

    code: ClassVar[str] = "wrong_stamps"
    rows: int
    place: str


@dataclass(frozen=True, slots=True, kw_only=True)
class DuplicateSamples(Details):
    """Rows that repeat the stamp of the row before, which are left out.

    Attributes
    ----------
    rows : int
        Rows of the log.
    place : str
        The first of them.
    same_samples : bool
        Whether all of them repeat the samples as well.
    factor : float
        Factor on the random walk if the rows were kept.
    """

    code: ClassVar[str] = "duplicate_samples"
    rows: int
    place: str
    same_samples: bool
    factor: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MissingValues(Details):
    """Rows or samples without a number in some channels; their places are left empty.

    Attributes
    ----------
    total : int
        Rows or samples of the channel.
    counts : tuple of int
        Missing numbers by channel, in the order of the finding's channels.
    strongest : str
        The channel with most of them.
    place : str
        The first of them.
    runs : int
        Runs of consecutive missing numbers, in the channel with most of them.
    longest : int
        Length of the longest run.
    longest_place : str
        Its beginning.
    interval : float
        Time from one row to the next. [s]
    unit : {"rows", "samples"}
        What is counted.
    """

    code: ClassVar[str] = "missing_values"
    total: int
    counts: tuple[int, ...]
    strongest: str
    place: str
    runs: int
    longest: int
    longest_place: str
    interval: float
    unit: Literal["rows", "samples"] = "rows"


@dataclass(frozen=True, slots=True, kw_only=True)
class EmptyChannel(Details):
    """A channel without a number in most rows, which is not analysed.

    Attributes
    ----------
    column : str
        The column, as the file names it.
    count, rows : int
        Rows without a number, and all rows.
    place : str
        The first of them.
    """

    code: ClassVar[str] = "empty_channel"
    column: str
    count: int
    rows: int
    place: str
