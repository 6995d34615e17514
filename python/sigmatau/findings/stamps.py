"""Findings about time stamps and missing samples: gaps, jitter, rows out of order."""

from __future__ import annotations

from typing import ClassVar, Literal

from sigmatau.digits import two_digits
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.findings.phrases import clock
from sigmatau.frozen import frozen
from sigmatau.hints import RATE, WITHOUT_STAMPS, Hint
from sigmatau.results import seconds

_SURE = 1e-3  # relative error of a rate below which it is not stated
_MIN_SHARE = 0.01  # smallest share of the intervals that is stated [%]
_MAX_MISSING = 0.5  # share of missing samples up to which intervals cover the truth, see docs/study/gaps.md [1]
_BAD = {
    "missing": (
        "without a time stamp",
        "skipped",
        f"If these rows have good samples, use {WITHOUT_STAMPS}",
    ),
    "wrong": ("with time stamps far from their neighbours", "skipped", "Find the cause if many rows are affected"),
    "repeated": (
        "with the time stamp of the row before",
        "skipped",
        "Check the logging program: it may write rows twice",
    ),
    "late": ("out of time order", "sorted by time", "Check the link and the logging program: samples come late"),
}  # what is wrong with the rows, what became of them, what to do


@frozen
class Gap:
    """Consecutive missing samples.

    Attributes
    ----------
    samples : int
        Number of missing samples.
    start, length : float
        Start, from the beginning of the record, and length. [s]
    place : str
        The row after the gap, as numbered in the file: ``"line 501"``.
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
        Number of places on the grid.
    gaps : int
        Number of gaps.
    longest : tuple of Gap
        The longest gaps, longest first.
    rate : float
        Rate of the grid. [Hz]
    estimated : bool
        Whether the number of missing samples is estimated from stamps of a host.
    period : int
        Rows after which the pattern of losses repeats; 0 if it does not.
    even_rate : float or None
        Rate of evenly spaced samples that a coarse clock would stamp in the same pattern. [Hz]
    """

    samples: int
    gaps: int
    longest: tuple[Gap, ...]
    rate: float
    estimated: bool = False
    period: int = 0
    even_rate: float | None = None
    allowed_share: ClassVar[float] = _MAX_MISSING

    def words(self, finding: Finding) -> Words:
        lost = _count(finding)
        if self.even_rate is not None:
            even, all_places = (Hint("rate", value=f"{rate:.6g}") for rate in (self.even_rate, self.rate))
            return Words(
                f"samples at {self.rate:.6g} Hz are missing in a pattern of {self.period} rows; evenly spaced"
                f" samples at {self.even_rate:.6g} Hz have the same time stamps",
                f"Give the rate of the sensor: {even} or {all_places}",
            )
        longest = self.longest[0]
        many = self.gaps > 1
        return Words(
            f"{'about ' if self.estimated else ''}{lost} of {self.samples} samples ({100 * lost / self.samples:.2g} %)"
            f" missing in {self.gaps} gap{'s' if many else ''}{', the longest' if many else ''} of"
            f" {seconds(longest.length)} s"
            f" at t = {clock(longest.start)}; not filled in",
            "Look for lost packets or a full buffer" if finding.severity == "warning" else "",
        )


@frozen
class LongPauses(Details, code="long_pauses"):
    """Pauses or clock steps that are longer than the recorded data. Only the longest piece is analysed.

    Attributes
    ----------
    pauses : int
        How many.
    longest : float
        [s]
    place : str
        The row after the longest pause.
    used, total : int
        Samples of the analysed piece, and of the log.
    """

    pauses: int
    longest: float
    place: str
    used: int
    total: int

    def words(self, finding: Finding) -> Words:
        several = "s" if self.pauses > 1 else ""
        return Words(
            f"{self.pauses} long pause{several} or clock step{several}, the longest {seconds(self.longest)} s before"
            f" {self.place}; {self.used} of {self.total} samples used",
            f"Analyse each piece separately; if only the clock was set, use {WITHOUT_STAMPS}",
        )


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
        The row after this interval.
    leaps : int
        Number of intervals of a live log that are negative or longer than 20 samples.
    """

    interval: float
    longest: float | None = None
    place: str = ""
    leaps: int = 0

    def words(self, finding: Finding) -> Words:
        if self.longest is None:
            return Words(
                f"{self.leaps} intervals between time stamps are negative or exceed 20 samples;"
                " samples treated as consecutive"
            )
        return Words(
            f"the time stamps are irregular (longest interval {seconds(self.longest)} s, before {self.place});"
            " samples treated as evenly spaced",
            f"Give {RATE} if the sensor did not pause; otherwise select a part without pauses with {Hint('window')}",
        )


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
        Largest relative error of the rate; None if the stamps are compatible with any higher rate.
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

    def words(self, finding: Finding) -> Words:
        whole = abs(self.step - 1) < _SURE
        resolution = "time stamps are whole seconds" if whole else f"time stamps have a resolution of {self.step:.3g} s"
        if self.period:
            faster = f"{1 / self.step:.6g}"
            return Words(
                f"{resolution}; they fit {self.rate:.6g} Hz without losses and {faster} Hz with {self.lost} of"
                f" {self.period} samples lost",
                f"Give {Hint('rate', value=faster)} if that is the sensor's rate",
            )
        single = " (single precision)" if self.single_precision else ""
        unsure = self.rate_error is None or self.rate_error > _SURE
        action = f"Log the time stamps with more digits, or give {RATE}" if single or unsure else ""
        if self.rate_error is None:
            return Words(f"{resolution}{single}, too coarse to confirm the given {self.rate:.6g} Hz", action)
        if unsure:
            return Words(
                f"{resolution}{single}; the rate is {self.rate:.6g} Hz ± {two_digits(100 * self.rate_error)} %", action
            )
        return Words(
            f"{resolution}{single} at {self.rate:.6g} Hz; fewer than {self.hidden} consecutive lost samples cannot"
            " be detected",
            action,
        )


@frozen
class HostStamps(Details, code="host_stamps"):
    """The stamps are the times at which a host received the samples, in bunches; the samples are treated as evenly
    spaced.

    Attributes
    ----------
    rate : float
        Mean rate, in use. [Hz]
    median_rate : float or None
        Rate from the median interval; None if that is zero. [Hz]
    """

    rate: float
    median_rate: float | None

    def words(self, finding: Finding) -> Words:
        share = 100 * (finding.size or 0.0)
        what = "the time stamps do not lie on an even grid"
        if share >= _MIN_SHARE:
            what = f"the time stamps are bunched ({two_digits(share)} % of the intervals too short)"
        return Words(
            f"{what}; samples treated as evenly spaced at {self.rate:.6g} Hz",
            "Compare this rate with the sensor's, or log the time stamps or the counter of the sensor",
        )


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

    def words(self, finding: Finding) -> Words:
        share = two_digits(100 * self.sigma / self.interval)
        scatter = f"time stamps scatter by {_short_time(self.sigma)}, {share} % of the interval"
        if self.added is None:
            return Words(f"{scatter}; no effect on rates of a sensor at rest")
        return Words(
            f"{scatter}; if sampling times do too, they add {self.added:.2g} {self.unit} of quantization noise"
        )


@frozen
class BadStamps(Details, code="bad_stamps"):
    """Rows that are left out because their stamp is missing, repeats the previous stamp, or is far from neighbouring
    stamps; or rows that are moved because their stamps show that they are late in the log.

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

    def words(self, finding: Finding) -> Words:
        wrong, done, action = _BAD[self.what]
        return Words(f"{_count(finding)} of {self.rows} rows {wrong}, the first at {self.place}; {done}", action)


@frozen
class CounterOverflows(Details, code="counter_overflows"):
    """The stamps come from a counter or clock that starts again, and are unwrapped; the size is the number of
    overflows.

    Attributes
    ----------
    period : float
        Period of the counter. [units of the stamps]
    column : str
        Column of the stamps.
    place : str
        The first row after an overflow, as numbered in the file.
    """

    period: float
    column: str
    place: str

    def words(self, finding: Finding) -> Words:
        count = _count(finding)
        times = "once" if count == 1 else f"{count} times"
        return Words(
            f"time stamps in column {self.column} restart {times} after {self.period:.10g}, first at {self.place};"
            " unwrapped"
        )


@frozen
class MissingValues(Details, code="missing_values"):
    """Rows or samples without a number in some channels. Their places are left empty, or the channels are not read.

    Attributes
    ----------
    total : int
        Rows or samples of the channel.
    counts : tuple of int
        Missing numbers by channel, in the order of the finding's channels.
    strongest : str
        The channel with the most missing numbers.
    place : str
        Place of the first missing number.
    runs : int
        Number of runs of consecutive missing numbers, in the channel with the largest number.
    longest : int
        Length of the longest run.
    longest_place : str
        Beginning of the longest run.
    unit : {"rows", "samples"}
        What is counted.
    dropped : bool
        Whether the channels are left out of the record.
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
    allowed_share: ClassVar[float] = _MAX_MISSING

    def words(self, finding: Finding) -> Words:
        equal = len(set(self.counts)) == 1
        count = (
            f"{_count(finding)} of {self.total} {self.unit}"
            if equal
            else f"up to {_count(finding)} of {self.total} {self.unit} ({self.strongest})"
        )
        run = f", the longest run {self.longest} from {self.longest_place}" if self.longest > 1 else ""
        first = "" if self.longest > 1 and self.longest_place == self.place else f", the first at {self.place}"
        return Words(
            f"{count} without a number{first}{run}; {'not analysed' if self.dropped else 'treated as missing'}",
            "" if finding.severity == "info" else "Check the sensor, the link or the converter",
        )


def _count(finding: Finding) -> int:
    return int(finding.size or 0)


def _short_time(value: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"
