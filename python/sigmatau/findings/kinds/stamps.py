"""Kinds of findings about time stamps and missing samples: rate, gaps, jitter, clock."""

from __future__ import annotations

from typing import Literal

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class ImplausibleRate(Details, code="implausible_rate"):
    """The stamps of a gyro or accelerometer give less than 1 Hz: a log of averages, or of another unit of time.

    Attributes
    ----------
    rate, other_rate : float
        Rate by the stamps in use, and in the other unit. [Hz]
    unit, other_unit : str
        The units of time.
    """

    rate: float
    unit: str
    other_rate: float
    other_unit: str


@frozen
class RateNotNominal(Details, code="rate_not_nominal"):
    """The rate by the stamps is close to a nominal rate, but differs from it significantly.

    Attributes
    ----------
    rate, nominal : float
        Rate by the stamps, and the nearest rate as datasheets state them. [Hz]
    """

    rate: float
    nominal: float


@frozen
class RateMismatch(Details, code="rate_mismatch"):
    """The rate in use differs from the rate by the stamps, or from the rate that the file states.

    Attributes
    ----------
    used, other : float
        [Hz]
    stated : bool
        Whether the other one is stated by the file.
    """

    used: float
    other: float
    stated: bool = False


@frozen
class RateDrift(Details, code="rate_drift"):
    """The sampling rate changes over the record, by the mean rates of ten equal parts.

    Attributes
    ----------
    lowest, highest : float
        Of the ten rates. [Hz]
    """

    lowest: float
    highest: float


@frozen
class RateChange(Details, code="rate_change"):
    """The sampling rate changes abruptly, once.

    Attributes
    ----------
    before, after : float
        [Hz]
    grid : float
        Rate in use. [Hz]
    place : str
        The row behind the change, as the file counts it; empty in a live log.
    """

    before: float
    after: float
    grid: float
    place: str = ""


@frozen
class ClockOff(Details, code="clock_off"):
    """Lines and filter corners differ from those of other records of the unit by a common factor; the size is the
    factor.

    Attributes
    ----------
    factor, low, high : float
        Of the frequencies, with its interval. [1]
    marks : int
        Number of lines, resonances and corners with this factor instead of 1.
    others : int
        Records that agree with each other.
    """

    factor: float
    low: float
    high: float
    marks: int
    others: int


@frozen
class Gap:
    """Consecutive missing samples.

    Attributes
    ----------
    samples : int
        How many.
    start, length : float
        From the beginning of the record. [s]
    place : str
        The row behind the gap, as the file counts it: ``"line 501"``.
    """

    samples: int
    start: float
    length: float
    place: str


@frozen
class Gaps(Details, code="gaps"):
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
    """

    samples: int
    gaps: int
    longest: tuple[Gap, ...]
    rate: float
    estimated: bool = False
    period: int = 0
    even_rate: float | None = None


@frozen
class LongPauses(Details, code="long_pauses"):
    """Pauses, or steps of the clock, that are longer than the recorded data; only the longest piece is analysed.

    Attributes
    ----------
    pauses : int
        How many.
    longest : float
        [s]
    place : str
        The row behind the longest pause.
    used, total : int
        Samples of that piece, and of the log.
    """

    pauses: int
    longest: float
    place: str
    used: int
    total: int


@frozen
class IrregularStamps(Details, code="irregular_stamps"):
    """The stamps do not fit a grid; the samples are treated as evenly spaced.

    Attributes
    ----------
    interval : float
        The sample interval in use. [s]
    longest : float or None
        The longest interval between stamps. [s]
    place : str
        The row behind it.
    leaps : int
        Number of intervals of a live log that are negative or longer than 20 samples.
    """

    interval: float
    longest: float | None = None
    place: str = ""
    leaps: int = 0


@frozen
class CoarseStamps(Details, code="coarse_stamps"):
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
        Smallest number of consecutive lost samples that can be detected.
    single_precision : bool
        Whether the resolution is that of single-precision numbers.
    period, lost : int
        The stamps would also fit a rate of one sample per step, with `lost` of every `period` samples missing; 0 if
        not.
    """

    step: float
    rate: float
    rate_error: float | None = 0.0
    hidden: int = 0
    single_precision: bool = False
    period: int = 0
    lost: int = 0


@frozen
class HostStamps(Details, code="host_stamps"):
    """The stamps are the times at which a host received the samples, in bunches; the samples are treated as evenly
    spaced.

    Attributes
    ----------
    rate : float
        Mean rate, in use. [Hz]
    median_rate : float or None
        Rate by the median interval; None if that is zero. [Hz]
    """

    rate: float
    median_rate: float | None


@frozen
class Jitter(Details, code="jitter"):
    """The stamps scatter about their grid.

    Attributes
    ----------
    sigma : float
        Standard deviation. [s]
    interval : float
        Sample interval. [s]
    added : float or None
        Quantization noise that jitter adds to an integrating channel through its mean, if the sampling times scatter
        as the stamps do. [`unit`]
    unit : str
        Its unit.
    """

    sigma: float
    interval: float
    added: float | None = None
    unit: str = ""


@frozen
class BadStamps(Details, code="bad_stamps"):
    """Rows that are left out because their stamp is missing, far from those before and after, or that of the row before;
    or rows that stand later in the log than their stamps say, and are moved to their place.

    Attributes
    ----------
    what : {"missing", "wrong", "repeated", "late"}
        What is wrong with the stamps.
    rows : int
        Rows of the log.
    place : str
        The first of them.
    """

    what: Literal["missing", "wrong", "repeated", "late"]
    rows: int
    place: str


@frozen
class CounterOverflows(Details, code="counter_overflows"):
    """The time stamps are of a counter or clock that begins again, and are counted on; the size is how often it does.

    Attributes
    ----------
    period : float
        After which it begins again. [units of the stamps]
    column : str
        Column of the stamps.
    place : str
        The first row after it, as the file counts it.
    """

    period: float
    column: str
    place: str


@frozen
class MissingValues(Details, code="missing_values"):
    """Rows or samples without a number in some channels; their places are left empty, or the channels are not read.

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
    unit : {"rows", "samples"}
        What is counted.
    dropped : bool
        Whether the channels are not read.
    """

    total: int
    counts: tuple[int, ...]
    strongest: str
    place: str
    runs: int
    longest: int
    longest_place: str
    unit: Literal["rows", "samples"] = "rows"
    dropped: bool = False
