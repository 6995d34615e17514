"""Words of findings about time stamps and missing samples: rate, gaps, jitter, clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import stamps as kinds
from sigmatau.findings.wording.phrases import Words, clock, factor_text
from sigmatau.results import seconds, two_digits

_SURE = 1e-3  # relative error of a rate that is not worth stating
_LEAST_SHARE = 0.01  # share of the intervals that is stated [%]
_WITHOUT_STAMPS = "--channels time=none --rate HZ"
_CLOCK_ERROR = 0.05  # relative difference of rates that no clock explains: RC oscillators are within 2 %


def _count(finding: Finding) -> int:
    return int(finding.size or 0)


def _implausible_rate(_: Finding, found: kinds.ImplausibleRate) -> Words:
    return Words(
        f"the time stamps give {found.rate:.4g} Hz if they are in {found.unit}, {found.other_rate:.4g} Hz if they are in"
        f" {found.other_unit}; {found.unit} is used",
        f"Give --unit time={found.other_unit} if the sensor's rate is {found.other_rate:.4g} Hz",
    )


def _rate_not_nominal(_: Finding, found: kinds.RateNotNominal) -> Words:
    off = found.rate / found.nominal - 1
    return Words(
        f"the time stamps give {found.rate:.6g} Hz, {100 * abs(off):.2g} % {'less' if off < 0 else 'more'} than"
        f" {found.nominal:g} Hz; the rate of the time stamps is used",
        f"Give --rate {found.nominal:g} only if the sensor's clock is more accurate than the time stamps",
    )


def _rate_mismatch(finding: Finding, found: kinds.RateMismatch) -> Words:
    if found.stated:
        return Words(f"the file states {found.other:g} Hz; the given rate of {found.used:g} Hz is used")
    message = f"{found.used:.6g} Hz is used, but the time stamps give {found.other:.6g} Hz"
    factor = dict(finding.factors).get("random_walk")
    if factor is None:
        return Words(f"{message}; all times and coefficients are affected")
    action = "Omit --rate unless it is more accurate than the time stamps"
    if abs(found.used / found.other - 1) > _CLOCK_ERROR:
        action = f"Omit --rate; if the time stamps are wrong, use --channels time=none --rate {found.used:.6g}"
    return Words(f"{message}: {factor_text('random_walk', factor)} if the time stamps are right", action)


def _clock_off(_: Finding, found: kinds.ClockOff) -> Words:
    half = two_digits((found.high - found.low) / 2)
    return Words(
        f"its clock is off: {found.marks} lines and corners are at {found.factor:.4g} ± {half} times their frequency in"
        f" {found.others} other records",
        f"Check its clock and its rate; {1 / found.factor:.4g} times this rate agrees with the other records",
    )


def _rate_drift(finding: Finding, found: kinds.RateDrift) -> Words:
    return Words(
        f"the sampling rate varies by {two_digits(100 * (finding.size or 0.0))} %, from {found.lowest:.6g} to"
        f" {found.highest:.6g} Hz; largest deviation from t = {clock(finding.spans[0][0])}",
        "Look for lost samples if the rate changes abruptly",
    )


def _rate_change(finding: Finding, found: kinds.RateChange) -> Words:
    return Words(
        f"the sampling rate changes from {found.before:.4g} to {found.after:.4g} Hz at t ="
        f" {clock(finding.spans[0][0])}{found.place and f' ({found.place})'}; all of it is analysed at {found.grid:.6g} Hz",
        "Split the log there, and analyse the parts separately",
    )


def _gaps(finding: Finding, found: kinds.Gaps) -> Words:
    lost = _count(finding)
    if found.even_rate is not None:
        return Words(
            f"samples at {found.rate:.6g} Hz are missing in a pattern of {found.period} rows; evenly spaced"
            f" samples at {found.even_rate:.6g} Hz have the same time stamps",
            f"Give the rate of the sensor: --rate {found.even_rate:.6g} or --rate {found.rate:.6g}",
        )
    longest = found.longest[0]
    many = found.gaps > 1
    return Words(
        f"{'about ' if found.estimated else ''}{lost} of {found.samples} samples ({100 * lost / found.samples:.2g} %)"
        f" missing in {found.gaps} gap{'s' if many else ''}{', the longest' if many else ''} of {seconds(longest.length)} s"
        f" at t = {clock(longest.start)}; not filled in",
        "Look for lost packets or a full buffer" if finding.severity == "warning" else "",
    )


def _long_pauses(_: Finding, found: kinds.LongPauses) -> Words:
    several = "s" if found.pauses > 1 else ""
    return Words(
        f"{found.pauses} long pause{several} or clock step{several}, the longest {seconds(found.longest)} s before"
        f" {found.place}; {found.used} of {found.total} samples used",
        f"Analyse each piece separately; if only the clock was set, use {_WITHOUT_STAMPS}",
    )


def _irregular_stamps(_: Finding, found: kinds.IrregularStamps) -> Words:
    if found.longest is None:
        return Words(
            f"{found.leaps} intervals between time stamps are negative or exceed 20 samples; samples treated as consecutive"
        )
    return Words(
        f"the time stamps are irregular (longest interval {seconds(found.longest)} s, before {found.place});"
        " samples treated as evenly spaced",
        "Give --rate HZ if the sensor did not pause; otherwise select a part without pauses with --window",
    )


def _coarse_stamps(_: Finding, found: kinds.CoarseStamps) -> Words:
    whole = abs(found.step - 1) < _SURE
    resolution = "time stamps are whole seconds" if whole else f"time stamps have a resolution of {found.step:.3g} s"
    if found.period:
        faster = f"{1 / found.step:.6g}"
        return Words(
            f"{resolution}; they fit {found.rate:.6g} Hz without losses and {faster} Hz with {found.lost} of"
            f" {found.period} samples lost",
            f"Give --rate {faster} if that is the sensor's rate",
        )
    single = " (single precision)" if found.single_precision else ""
    unsure = found.rate_error is None or found.rate_error > _SURE
    action = "Log the time stamps with more digits, or give --rate HZ" if single or unsure else ""
    if found.rate_error is None:
        return Words(f"{resolution}{single}, too coarse to confirm the given {found.rate:.6g} Hz", action)
    if unsure:
        return Words(
            f"{resolution}{single}; the rate is {found.rate:.6g} Hz ± {two_digits(100 * found.rate_error)} %", action
        )
    return Words(
        f"{resolution}{single} at {found.rate:.6g} Hz; fewer than {found.hidden} consecutive lost samples cannot"
        " be detected",
        action,
    )


def _host_stamps(finding: Finding, found: kinds.HostStamps) -> Words:
    share = 100 * (finding.size or 0.0)
    what = "the time stamps do not lie on an even grid"
    if share >= _LEAST_SHARE:
        what = f"the time stamps are bunched ({two_digits(share)} % of the intervals too short)"
    return Words(
        f"{what}; samples treated as evenly spaced at {found.rate:.6g} Hz",
        "Compare this rate with the sensor's, or log the time stamps or the counter of the sensor",
    )


def _jitter(_: Finding, found: kinds.Jitter) -> Words:
    share = two_digits(100 * found.sigma / found.interval)
    scatter = f"time stamps scatter by {_short_time(found.sigma)}, {share} % of the interval"
    if found.added is None:
        return Words(f"{scatter}; no effect on rates of a sensor at rest")
    return Words(f"{scatter}; if sampling times do too, they add {found.added:.2g} {found.unit} of quantization noise")


def _short_time(value: float) -> str:
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value / 1e-9:.3g} ns"


_BAD = {
    "missing": ("without a time stamp", "skipped", f"If their samples are good, run again with {_WITHOUT_STAMPS}"),
    "wrong": ("with time stamps far from their neighbours", "skipped", "Find the cause if many rows are affected"),
    "repeated": (
        "with the time stamp of the row before",
        "skipped",
        "Check the logging program: it may write rows twice",
    ),
    "late": ("out of time order", "sorted by time", "Check the link and the logging program: samples come late"),
}  # what is wrong with the rows, what became of them, what to do


def _bad_stamps(finding: Finding, found: kinds.BadStamps) -> Words:
    wrong, done, action = _BAD[found.what]
    return Words(f"{_count(finding)} of {found.rows} rows {wrong}, the first at {found.place}; {done}", action)


def _counter_overflows(finding: Finding, it: kinds.CounterOverflows) -> Words:
    count = _count(finding)
    times = "once" if count == 1 else f"{count} times"
    return Words(
        f"time stamps in column {it.column} begin again after {it.period:.10g} {times}, first at {it.place}; counted on"
    )


def _missing_values(finding: Finding, found: kinds.MissingValues) -> Words:
    equal = len(set(found.counts)) == 1
    count = (
        f"{_count(finding)} of {found.total} {found.unit}"
        if equal
        else f"up to {_count(finding)} of {found.total} {found.unit} ({found.strongest})"
    )
    run = f", the longest run {found.longest} from {found.longest_place}" if found.longest > 1 else ""
    first = "" if found.longest > 1 and found.longest_place == found.place else f", the first at {found.place}"
    return Words(
        f"{count} without a number{first}{run}; {'not analysed' if found.dropped else 'treated as missing'}",
        "" if finding.severity == "info" else "Check the sensor, the link or the converter",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kinds.ImplausibleRate: _implausible_rate,
    kinds.RateNotNominal: _rate_not_nominal,
    kinds.RateMismatch: _rate_mismatch,
    kinds.ClockOff: _clock_off,
    kinds.RateDrift: _rate_drift,
    kinds.RateChange: _rate_change,
    kinds.Gaps: _gaps,
    kinds.LongPauses: _long_pauses,
    kinds.IrregularStamps: _irregular_stamps,
    kinds.CoarseStamps: _coarse_stamps,
    kinds.HostStamps: _host_stamps,
    kinds.Jitter: _jitter,
    kinds.BadStamps: _bad_stamps,
    kinds.CounterOverflows: _counter_overflows,
    kinds.MissingValues: _missing_values,
}
