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
    """The rate in use differs from the rate by the stamps, or from the rate that the file states."""

    used: float  # [Hz]
    other: float
    stated: bool = False  # whether the other one is stated by the file


@frozen
class RateDrift(Details, code="rate_drift"):
    """The sampling rate changes over the record, by the mean rates of ten equal parts."""

    lowest: float  # of the ten rates [Hz]
    highest: float


@frozen
class RateChange(Details, code="rate_change"):
    """The sampling rate changes abruptly, once and for good."""

    before: float  # [Hz]
    after: float
    grid: float  # rate in use [Hz]
    place: str = ""  # the row behind the change, as the file counts it; empty in a live log


@frozen
class ClockOff(Details, code="clock_off"):
    """Lines and filter corners have a common factor to those of other records of the unit; the size is the factor."""

    factor: float  # of the frequencies, with its interval
    low: float
    high: float
    marks: int  # lines, resonances and corners that have the factor and not 1
    others: int  # records that agree with each other


@frozen
class Gap:
    """Consecutive missing samples."""

    samples: int
    start: float  # from the beginning of the record [s]
    length: float
    place: str  # the row behind the gap, as the file counts it: ``"line 501"``


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


@frozen
class LongPauses(Details, code="long_pauses"):
    """Pauses, or steps of the clock, that are longer than the recorded data; only the longest piece is analysed."""

    pauses: int
    longest: float  # [s]
    place: str  # the row behind the longest pause
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


@frozen
class Jitter(Details, code="jitter"):
    """The stamps scatter about their grid."""

    sigma: float  # standard deviation [s]
    interval: float  # sample interval [s]
    # quantization noise that it makes of the mean of an integrating channel, if the instants of sampling scatter so
    added: float | None = None
    unit: str = ""  # its unit


@frozen
class BadStamps(Details, code="bad_stamps"):
    """Rows that are left out because their stamp is missing, far from those before and after, or that of the row before;
    or rows that stand later in the log than their stamps say, and are moved to their place.
    """

    what: Literal["missing", "wrong", "repeated", "late"]
    rows: int  # rows of the log
    place: str  # the first of them


@frozen
class MissingValues(Details, code="missing_values"):
    """Rows or samples without a number in some channels; their places are left empty, or the channels are not read."""

    total: int  # rows or samples of the channel
    counts: tuple[int, ...]  # missing numbers by channel, in the order of the finding's channels
    strongest: str  # the channel with most of them
    place: str  # the first of them
    runs: int  # runs of consecutive missing numbers, in the channel with most of them
    longest: int  # length of the longest run
    longest_place: str  # its beginning
    unit: Literal["rows", "samples"] = "rows"  # what is counted
    dropped: bool = False  # whether the channels are not read
