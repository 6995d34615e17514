"""Kinds of findings about time stamps and missing samples: rate, gaps, jitter, clock."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class ImplausibleRate(Details, code="implausible_rate"):
    """The stamps give a rate that no usual sensor has."""

    rate: float  # rate by the stamps [Hz]


@frozen
class RateNotNominal(Details, code="rate_not_nominal"):
    """The rate by the stamps is close to a nominal rate, but differs from it significantly."""

    rate: float  # rate by the stamps, and the nearest rate as datasheets state them [Hz]
    nominal: float


@frozen
class RateMismatch(Details, code="rate_mismatch"):
    """The rate in use differs from the rate by the stamps."""

    used: float  # [Hz]
    by_stamps: float


@frozen
class RateOverruled(Details, code="rate_overruled"):
    """The rate that was given differs from the rate that the file states."""

    given: float  # [Hz]
    stated: float


@frozen
class RateDrift(Details, code="rate_drift"):
    """The sampling rate changes over the record, by the mean rates of ten equal parts."""

    lowest: float  # of the ten rates [Hz]
    highest: float


@frozen
class Gap:
    """Consecutive missing samples."""

    samples: int
    start: float  # from the beginning of the record [s]
    length: float
    place: str  # the row behind the gap, as the file counts it: ``"line 501"``


@frozen
class Subsampled:
    """A stretch in which only every k-th sample is present."""

    every: int  # k
    start: float  # from the beginning of the record [s]
    stop: float
    rate: float  # rate in this stretch [Hz]


@frozen
class Gaps(Details, code="gaps"):
    """Samples are missing between the stamps; their places on the grid are left empty."""

    samples: int  # places on the grid
    gaps: int  # number of gaps
    longest: tuple[Gap, ...]  # the longest gaps, longest first
    rate: float  # rate of the grid [Hz]
    estimated: bool = False  # whether the number of missing samples is an estimate, from stamps of a host
    period: int = 0  # rows after which the pattern of losses repeats; 0 if it does not
    even_rate: float | None = None  # rate of even samples that a coarse clock would stamp in the same pattern [Hz]
    subsampled: Subsampled | None = None


@frozen
class LongPauses(Details, code="long_pauses"):
    """Pauses, or steps of the clock, that are longer than the recorded data; only the longest piece is analysed."""

    pauses: int
    longest: float  # [s]
    place: str  # the row behind the longest pause
    first: str  # the first row of the analysed piece
    used: int  # samples of that piece, and of the log
    total: int


@frozen
class IrregularStamps(Details, code="irregular_stamps"):
    """The stamps fit no grid; the samples are taken as evenly spaced."""

    interval: float  # the sample interval in use [s]
    longest: float | None = None  # the longest interval between stamps [s]
    place: str = ""  # the row behind it
    leaps: int = 0  # intervals of a live log that are negative or longer than 20 samples


@frozen
class CoarseStamps(Details, code="coarse_stamps"):
    """The stamps fit evenly spaced samples on a clock of low resolution."""

    step: float  # resolution of the clock [s]
    rate: float  # rate in use [Hz]
    rate_error: float | None = 0.0  # largest relative error of the rate; None if the stamps allow any higher rate
    hidden: int = 0  # fewer consecutive lost samples than this cannot be seen
    single_precision: bool = False  # whether the resolution is that of single-precision numbers
    # the stamps would also fit a rate of one sample per step, with `lost` of every `period` samples missing; 0 if not
    period: int = 0
    lost: int = 0


@frozen
class HostStamps(Details, code="host_stamps"):
    """The stamps say when a host received the samples, in bunches; the samples are taken as evenly spaced."""

    rate: float  # mean rate, in use [Hz]
    median_rate: float | None  # rate by the median interval; None if that is zero [Hz]
    longest: float  # the longest interval between stamps [s]
    place: str  # the row behind it


@frozen
class Jitter(Details, code="jitter"):
    """The stamps scatter about their grid."""

    sigma: float  # standard deviation [s]
    interval: float  # sample interval [s]
    # largest mean of the channels, times which the scatter is quantization noise of increments; in `unit` per second
    mean: float | None = None
    strongest: str = ""  # the channel with that mean
    unit: str = ""  # unit of quantization noise
    seen: float | None = None  # quantization noise in the samples of an integrating channel, in `unit`; None for rates
    share: float = 0.0  # share of the squared quantization noise that the scatter accounts for


@frozen
class MissingStamps(Details, code="missing_stamps"):
    """Rows without a time stamp, which are left out."""

    rows: int  # rows of the log
    place: str  # the first of them


@frozen
class RowsOutOfOrder(Details, code="rows_out_of_order"):
    """Rows that stand later in the log than their stamps say, and are moved to their place."""

    rows: int  # rows of the log
    place: str  # the first of them
    stamp: float  # its time stamp, in the unit of the column


@frozen
class WrongStamps(Details, code="wrong_stamps"):
    """Rows whose stamps are far from those before and after, which are left out."""

    rows: int  # rows of the log
    place: str  # the first of them


@frozen
class DuplicateSamples(Details, code="duplicate_samples"):
    """Rows that repeat the stamp of the row before, which are left out."""

    rows: int  # rows of the log
    place: str  # the first of them
    same_samples: bool  # whether all of them repeat the samples as well
    factor: float  # factor on the random walk if the rows were kept


@frozen
class MissingValues(Details, code="missing_values"):
    """Rows or samples without a number in some channels; their places are left empty."""

    total: int  # rows or samples of the channel
    counts: tuple[int, ...]  # missing numbers by channel, in the order of the finding's channels
    strongest: str  # the channel with most of them
    place: str  # the first of them
    runs: int  # runs of consecutive missing numbers, in the channel with most of them
    longest: int  # length of the longest run
    longest_place: str  # its beginning
    interval: float  # time from one row to the next [s]
    unit: Literal["rows", "samples"] = "rows"  # what is counted


@frozen
class EmptyChannel(Details, code="empty_channel"):
    """A channel without a number in most rows, which is not analysed."""

    column: str  # the column, as the file names it
    count: int  # rows without a number, and all rows
    rows: int
    place: str  # the first of them
