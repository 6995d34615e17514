"""Words of findings about sample values: held, repeated, lost, saturated, interpolated, coarse, in a wrong unit."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.values import (
    CoarseResolution,
    CopiedStretch,
    Dropout,
    Gravity,
    HeldRuns,
    ImplausibleUnit,
    Interpolated,
    MeanRate,
    RepeatedSamples,
    Saturation,
    StuckSamples,
)
from sigmatau.findings.wording.phrases import Words, clock, largest_factor_text, percent
from sigmatau.results import duration_text, seconds, two_digits
from sigmatau.units import STANDARD_GRAVITY


def _degrees_per_hour(rate: float) -> str:
    return _number(math.degrees(rate) * 3600)


def _number(value: float) -> str:
    """Three digits, without an exponent below a million."""
    return f"{float(f'{value:.3g}'):g}"


def _on(finding: Finding, strongest: str) -> str:
    """The channel that numbers are of, if the finding has several."""
    return strongest if len(finding.channels) > 1 else ""


def _joined(*parts: str) -> str:
    return "; ".join(part for part in parts if part)


def _held(details: HeldRuns, what: str) -> Words:
    share = percent(details.share)
    if details.samples == details.runs:
        if details.runs == 1:
            return Words(f"1 {what.removesuffix('s')} at {clock(details.start)} ({share})")
        return Words(f"{details.samples} single {what} ({share}), the first at {clock(details.start)}")
    longest = duration_text(details.longest)
    if details.runs == 1:
        return Words(f"a run of {what} at {clock(details.start)}, {longest} long ({share})")
    return Words(f"{details.runs} runs of {what} ({share}), the longest {longest} at {clock(details.start)}")


def _dropout(finding: Finding, details: Dropout) -> Words:
    return _held(details, "zeros")


def _stuck_samples(finding: Finding, details: StuckSamples) -> Words:
    return _held(details, "equal samples")


def _saturation(finding: Finding, details: Saturation) -> Words:
    ends = " and ".join(f"{end:.3g}" for end in (details.low, details.high) if end is not None)
    said = f"{percent(details.share)} of the samples at {'a limit' if None in (details.low, details.high) else 'the limits'}"
    said += f" of the range, {ends} {details.unit}"
    if not details.spread:
        return Words(_joined(said, f"the first at {clock(details.start)}"))
    effect = largest_factor_text(finding.factors, channel=_on(finding, details.strongest))
    return Words(_joined(said, effect), "Record again with a larger range, or select another part with --window")


def _copied_stretch(_: Finding, details: CopiedStretch) -> Words:
    return Words(
        f"the {details.rows} rows from {clock(details.copy)} on equal those from {clock(details.start)} on,"
        f" {seconds(details.duration)} s long",
        "Check how the log was written; leave the copy out with --leave-out",
    )


def _repeated_samples(finding: Finding, details: RepeatedSamples) -> Words:
    effect = largest_factor_text([one for one in finding.factors if one[0] == "random_walk"])
    if details.pattern == "rows":
        said = f"{details.copies} rows ({percent(details.share)}) equal the previous row"
        return Words(said)
    if details.pattern == "irregular":
        said = f"{percent(details.share)} of the samples equal the previous sample, at irregular intervals"
        return Words(_joined(said, effect), "Omit lost samples from the log instead of repeating the previous sample")
    rates = f"the sensor gives {details.sensor_rate:.4g} Hz, the log has {details.log_rate:.4g} Hz"
    effect = effect or f"σ at one sample {_number(1 / details.sigma_one_sample)} times too small"
    if details.shortest == details.longest > 1:
        return Words(
            f"each sample occurs {details.shortest} times: {rates}; {effect}",
            f"Keep one of each group of equal samples and give --rate {details.sensor_rate:.4g}",
        )
    return Words(
        f"samples occur {details.times:.3g} times on average: {rates}; {effect}",
        "Log at the sensor's rate, triggered by its data-ready signal, or use only long averaging times",
    )


def _interpolated(finding: Finding, details: Interpolated) -> Words:
    if details.upsampled is not None:
        made = details.upsampled
        said = f"interpolated from {made.sensor_rate:.4g} to {made.log_rate:.4g} Hz"
        times, right_from = _number(1 / made.sigma_one_sample), seconds(made.right_from)
        effect = f"σ at one sample {times} times too small, correct from τ = {right_from} s"
        return Words(_joined(said, effect), "Log the samples of the sensor with their time stamps")
    outages, said = details.outages, ""
    if outages is not None:
        longest = duration_text(outages.longest)
        said = f"a gap of {longest} at {clock(outages.start)} was filled with a straight line"
        if outages.count > 1:
            said = (
                f"{outages.count} gaps were filled with straight lines, the longest {longest} at {clock(outages.start)}"
            )
        return Words(said)
    if details.singles is not None:
        said = f"{percent(details.share)} of the samples are linear interpolations of lost samples"
    effect = largest_factor_text(finding.factors, channel=_on(finding, details.strongest))
    return Words(_joined(said, effect), "Leave lost samples empty in the log, or omit their rows")


def _coarse_resolution(finding: Finding, details: CoarseResolution) -> Words:
    noise = two_digits(details.noise / details.step)
    times = "equal to" if noise == "1" else f"{noise} times"
    said = f"the noise is {times} the resolution of {details.step:.3g} {details.unit}"
    finer = "Record again with a smaller range or more bits"
    if details.rounding == "unknown":
        return Words(_joined(said, "what rounding adds is unknown, and intervals allow for it"), finer)
    if details.summed is None or details.needed is not None:
        long = "Record longer" if details.needed is None else f"Record {duration_text(details.needed)} or more"
        return Words(_joined(said, "its rounding is not white and hides the random walk"), f"{long}, or more finely")
    if details.rounding == "quantization" and details.summed > 1:
        return Words(_joined(said, f"its rounding is white only in sums of {details.summed} samples"))
    if details.rounding == "quantization":
        added = f"{details.added:.3g} {_integrated(details.unit)}"
        return Words(_joined(said, f"adds up to {added} of quantization noise"))
    return Words(_joined(said, largest_factor_text(finding.factors)), finer if finding.severity == "warning" else "")


def _integrated(unit: str) -> str:
    """Unit of the angle or velocity."""
    return {"rad/s": "rad", "m/s^2": "m/s"}.get(unit, f"{unit}·s")


def _implausible_unit(finding: Finding, details: ImplausibleUnit) -> Words:
    noise = f"{_number(math.degrees(details.noise or 0))} (deg/s)/√Hz"
    if details.evidence == "gravity":
        said = f"mean acceleration of {details.mean:.3g} m/s^2"
    elif details.evidence == "step":
        said = f"the resolution is {details.step:.3g} rad/s (1 LSB of sensors with {details.sensitivity:.6g} LSB per deg/s)"
    elif details.evidence == "bias":
        said = f"the noise is that of an optical gyro, but the mean is {_degrees_per_hour(details.mean or 0)} deg/h"
    elif details.evidence == "quiet":
        said = f"white noise of {_small_noise(details)}, less than that of the quietest sensors"
    elif details.evidence == "earth":
        mean = f"{_degrees_per_hour(details.mean or 0)} deg/h"
        said = f"white noise of {_small_noise(details)}, but a mean of {mean} and not the Earth's rotation of 15 deg/h"
    else:
        said = f"white noise of {noise}, {two_digits(details.times or 1.0)} times that of the noisiest gyros"
    if details.by_file:
        stated = f" {details.stated}" if details.stated else " the unit"
        return Words(f"{said}; the file states{stated}", "Check that the sensor was at rest, and the unit in the file")
    if not details.likely and details.evidence in ("quiet", "earth"):
        return Words(said, "Check the unit and the scale")
    looks = f"the unit is probably {details.likely}" if details.likely else "the values may be raw counts"
    if not details.likely:
        return Words(f"{said}; {looks}", "Run with --scale for raw counts")
    factor = finding.factors[0][1] if finding.factors else 1.0
    wrong = f"{_number(factor)} times too large" if factor > 1 else f"{_number(1 / factor)} times too small"
    return Words(f"{said}; {looks}", f"Run with {details.option}; all coefficients are now {wrong}")


def _small_noise(details: ImplausibleUnit) -> str:
    noise = details.noise or 0.0
    if details.quantity == "angular_rate":
        return f"{_number(60 * math.degrees(noise))} deg/√h"
    return f"{_number(noise / (1e-9 * STANDARD_GRAVITY))} ng/√Hz"


def _gravity(finding: Finding, details: Gravity) -> Words:
    mean = f"mean acceleration of {details.mean:.3g} m/s^2"
    if details.cause == "bias_or_scale":
        off = f"{percent(abs(details.deviation))} {'more' if details.deviation > 0 else 'less'} than gravity"
        return Words(
            f"{mean} is {off}: bias or scale error; a scale error changes all coefficients",
            "Calibrate in six positions if the scale matters",
        )
    if details.cause == "removed":
        return Words(
            f"{mean}: gravity was subtracted, which may add the noise of an estimated attitude",
            "Record the raw output of the sensor if possible",
        )
    times = f"{1 + details.deviation:.3g} times the true values"
    said = f"{mean}, gravity is {details.low:g} to {details.high:g}; all coefficients may be {times}"
    return Words(said, "Check --unit, --scale and --channels")


def _mean_rate(_: Finding, details: MeanRate) -> Words:
    mean, usual = (_number(math.degrees(rate)) for rate in (details.mean, details.usual))
    return Words(
        f"mean rate of {mean} deg/s: the sensor turns, or has an offset beyond the {usual} deg/s of usual gyros",
        "Record it at rest, or check its offset in the datasheet",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    Dropout: _dropout,
    StuckSamples: _stuck_samples,
    Saturation: _saturation,
    CopiedStretch: _copied_stretch,
    RepeatedSamples: _repeated_samples,
    Interpolated: _interpolated,
    CoarseResolution: _coarse_resolution,
    ImplausibleUnit: _implausible_unit,
    Gravity: _gravity,
    MeanRate: _mean_rate,
}
