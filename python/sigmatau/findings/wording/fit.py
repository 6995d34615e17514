"""Words of findings about curves and fits."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import fit as kinds
from sigmatau.findings.wording.phrases import Words, axes_text, number, percent
from sigmatau.noise.terms import display_units
from sigmatau.results import duration_text, seconds, two_digits

_SMALLEST_P = 1e-12  # smaller p-values are rounding errors

_REASONS: dict[type, Callable[[Any], str]] = {
    kinds.TooFewTimes: lambda r: (
        f"only {r.times} averaging time{'' if r.times == 1 else 's'} up to a third of {r.samples} samples;"
        f" a fit needs {r.needed}"
    ),
    kinds.ZeroVariance: lambda r: "an Allan variance is 0, which noise cannot cause",
    kinds.Misfit: lambda r: f"σ({seconds(r.tau)} s) is {_off(r.ratio)} the best fit{_p_text(r)}",
    kinds.NoCovariance: lambda r: "too few averaging times to compute the covariance of the coefficients",
    kinds.ShortTimesDeviate: lambda r: (
        f"σ at {r.cluster_size} sample{'s' if r.cluster_size > 1 else ''} is {_off(r.ratio)} the model,"
        f" {'as after a low-pass filter' if r.ratio < 1 else 'because of other noise or a disturbance'}"
    ),
    kinds.IncompleteRecord: lambda r: (
        f"{r.missing} of {r.samples} samples are missing, and "
        + ("least squares needs all" if r.suits_likelihood else "the others are too few for a fit")
    ),
    kinds.CoarseValues: lambda r: "the resolution is too coarse for the noise, so the rounding error is unknown",
    kinds.CoarseCounts: lambda r: (
        "the rounding of the increments hides the noise"
        if r.hidden
        else f"the rounding is white only in sums of {r.summed} increments, which are fitted"
    ),
    kinds.BandLeftOut: lambda r: f"the spectrum from {r.highest:.3g} Hz on fits no model and is left out",
    kinds.VibrationPower: lambda r: f"lines and resonances have {percent(r.share)} of the power",
    kinds.CrowdedLines: lambda r: (
        f"{count_text(r.lines)} spectral lines take {percent(r.share)} of the band and may be noise"
    ),
    kinds.BandsOff: lambda r: f"the density near {r.frequency:.2g} Hz is {_off(r.ratio)} the best model",
}


_ORDERS = {1: "first", 2: "second", 3: "third", 4: "fourth"}


def filter_text(shape: str, order: int | None) -> str:
    """A filter in words: ``"second-order Butterworth filter"``."""
    if shape == "butterworth" and order is not None:
        return "first-order filter" if order == 1 else f"{_ORDERS[order]}-order Butterworth filter"
    return {
        "smoothing": "exponential smoothing",
        "running_mean": f"running mean of {order} samples",
        "low_pass": "low-pass filter",
    }.get(shape, "uneven spectrum")


def count_text(count: int) -> str:
    """A number of lines or processes: ``"5"``, ``"at least 100"`` where more are not kept."""
    return f"at least {count}" if count >= kinds.MOST_LINES else str(count)


def beside_text(*, response: bool, lines: int, processes: int, resonances: int, warm_up: bool) -> str:
    """What was found beside the terms: ``" with a filter and 5 lines"``; empty for nothing."""
    kinds_found = (
        ("a filter", int(response)),
        ("a line", lines),
        ("a Gauss-Markov process", processes),
        ("a resonance", resonances),
        ("a warm-up", int(warm_up)),
    )
    named = [
        one if many == 1 else f"{count_text(many)} {one[2:]}{'es' if one.endswith('s') else 's'}"
        for one, many in kinds_found
        if many
    ]
    return f" with {axes_text(named)}" if named else ""


def verdict_text(verdict: str, beside: str = "") -> str:
    """The verdict on a fit: ``"the model fits with 5 lines"``, ``"the model fits roughly: wider intervals"``."""
    if verdict == "too_short":
        return "too short for a fit"
    if verdict == "descriptive":
        return "no model fits: values without intervals"
    if verdict == "disturbed":
        return f"disturbed{beside}: upper limits only"
    return f"the model fits{' roughly' if verdict == 'widened' else ''}{beside}" + (
        ": wider intervals" if verdict == "widened" else ""
    )


def reason_text(reason: kinds.Reason) -> str:
    """A reason of a fit in words: ``"an Allan variance is 0, which noise cannot cause"``."""
    return reason.text if isinstance(reason, kinds.StatedReason) else _REASONS[type(reason)](reason)


def reasons_text(reasons: Sequence[kinds.Reason]) -> str:
    """All reasons of a fit in words."""
    return "; ".join(reason_text(reason) for reason in reasons)


def _off(ratio: float) -> str:
    if ratio > 3:
        return f"{two_digits(ratio)} times"
    return f"{two_digits(100 * abs(ratio - 1))} % {'below' if ratio < 1 else 'above'}"


def _p_text(misfit: kinds.Misfit) -> str:
    p = misfit.p_value
    if p is None:
        return ""
    return f" (p = {p:.1g})" if p > _SMALLEST_P else f" (p < {_SMALLEST_P:g})"


def _too_short(finding: Finding, details: kinds.TooShort) -> Words:
    text = f"not fitted: {reason_text(details.reasons[0])}"
    if finding.size is not None:
        return Words(
            f"{text}; {percent(details.missing)} of the samples are missing",
            "Find the cause of the loss; a longer record with the same losses helps little",
        )
    reason = details.reasons[0]
    if isinstance(reason, kinds.IncompleteRecord):
        allowed = "Use --method likelihood, which allows for missing samples"
        return Words(
            text, allowed if reason.suits_likelihood else "Record longer, or use a part without missing samples"
        )
    return Words(text, "Record longer" if isinstance(details.reasons[0], kinds.TooFewTimes) else "")


def _no_adequate_model(finding: Finding, details: kinds.NoAdequateModel) -> Words:
    action = "Look for a spectral line, a filter or a disturbance; the values have no intervals"
    return Words(f"no model fits: {reason_text(details.reasons[0])}", action)


_MANY_LINES = 10  # from which they are more likely than all else what a model lacks


def _widened(finding: Finding, details: kinds.Widened) -> Words:
    if details.crowded:
        lines = f"{count_text(details.lines)} spectral lines take {percent(details.crowded)} of the band"
        action = "Look for a vibration, or for noise that changes, and record again without it"
        return Words(f"{lines} and may be noise; the interval of the random walk has both readings", action)
    off = f"the density near {details.frequency:.2g} Hz is {_off(details.ratio)} the best model; intervals are wider"
    if details.lines >= _MANY_LINES:
        action = "Look for a vibration or a supply with these frequencies, and record again without it"
        return Words(f"{count_text(details.lines)} spectral lines, and {off}", action)
    return Words(off, "Look for a cause near this frequency, or accept the wider intervals")


def _disturbed(finding: Finding, details: kinds.Disturbed) -> Words:
    text = f"vibration has {percent(details.share)} of the power; the coefficients are upper limits"
    part = f"{details.start:.4g}s:{details.stop:.4g}s"
    if details.start == details.stop:
        return Words(text, "Record again without the vibration")
    if details.quietest is None:
        return Words(
            f"{text}, which are least from {details.start:.4g} to {details.stop:.4g} s", "Record again without it"
        )
    unit, factor = display_units("random_walk", details.quantity, details.rate_unit)[-1]
    limit = f"{two_digits(details.quietest / factor)} {unit}"
    return Words(f"{text}, {limit} in the quietest part", f"Record again without it, or try --window {part}")


def _beyond_class(finding: Finding, details: kinds.BeyondClass) -> Words:
    unit, factor = ("deg/s", math.degrees(1.0)) if details.quantity == "angular_rate" else ("m/s^2", 1.0)
    size = number(factor * (finding.size or 0.0))
    sensors = "gyros" if details.quantity == "angular_rate" else "accelerometers"
    if details.frequency is None:
        fact = f"the mean changes by {size} {unit} per second"
    else:
        fact = f"noise of {size} ({unit})/√Hz at {number(details.frequency)} Hz"
    return Words(
        f"{fact}, {two_digits(details.times)} times that of the noisiest {sensors}",
        "Record the sensor at rest, and check the unit",
    )


def _few_degrees_of_freedom(finding: Finding, details: kinds.FewDegreesOfFreedom) -> Words:
    return Words(
        f"the random walk has {details.freedom:.2g} degrees of freedom in {duration_text(details.duration)}",
        "Record longer",
    )


def _short_times_left_out(finding: Finding, details: kinds.ShortTimesLeftOut) -> Words:
    why = f": {reason_text(details.reasons[0])}" if details.reasons else ""
    return Words(f"the fit starts at τ = {seconds(details.tau_min)} s{why}")


def _out_of_range(finding: Finding, details: kinds.OutOfRange) -> Words:
    size = "large" if details.largest > 1 else "small"
    return Words(
        f"Allan deviations up to {details.largest:.3g} {details.rate_unit} are too {size}; not analysed",
        "Check unit and scale",
    )


def _constant_channel(finding: Finding, details: kinds.ConstantChannel) -> Words:
    what = f"all {details.samples} samples are equal"
    if details.value is not None:
        what = f"{details.samples} samples of {details.value:.6g} {details.rate_unit} differ by no more than rounding"
    return Words(f"{what}; not analysed", "Check the wiring, the resolution and the column")


def _too_few_samples(finding: Finding, details: kinds.TooFewSamples) -> Words:
    return Words(f"{details.missing} of {details.samples} samples are missing; not analysed")


def _strided(finding: Finding, details: kinds.Strided) -> Words:
    why = f"{details.samples} samples do not fit in memory: " if details.out_of_memory else ""
    return Words(f"{why}from τ = {seconds(details.tau)} s, clusters start at every 64th sample or less often")


def _no_map(finding: Finding, details: kinds.NoMap) -> Words:
    return Words(f"no stability map: {details.samples} samples, at least {details.needed} are needed")


def _checked_in_part(finding: Finding, details: kinds.CheckedInPart) -> Words:
    return Words(
        f"only the first {duration_text(details.duration)} are checked for faults, {details.checked} of"
        f" {details.samples} samples",
        "Check another part with --window",
    )


def _checked_without_fit(finding: Finding, details: kinds.CheckedWithoutFit) -> Words:
    return Words(
        f"{details.samples} samples are too many for a quick fit: warm-up, temperature and changing noise not checked",
        "Run sigmatau analyze to check them",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kinds.TooShort: _too_short,
    kinds.NoAdequateModel: _no_adequate_model,
    kinds.Widened: _widened,
    kinds.Disturbed: _disturbed,
    kinds.BeyondClass: _beyond_class,
    kinds.FewDegreesOfFreedom: _few_degrees_of_freedom,
    kinds.ShortTimesLeftOut: _short_times_left_out,
    kinds.OutOfRange: _out_of_range,
    kinds.ConstantChannel: _constant_channel,
    kinds.TooFewSamples: _too_few_samples,
    kinds.Strided: _strided,
    kinds.NoMap: _no_map,
    kinds.CheckedInPart: _checked_in_part,
    kinds.CheckedWithoutFit: _checked_without_fit,
}
