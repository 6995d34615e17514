"""Words of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.spectrum import Aliasing, CorrelatedAxes, Line, LowPassFilter, Resampled, SpectralLines
from sigmatau.findings.wording.phrases import Words, factor_text
from sigmatau.results import duration_text, option_seconds, seconds, two_digits

__all__ = ["WORDS"]

_SHAPES = {
    "first_order": "first order",
    "butterworth2": "second-order Butterworth",
    "butterworth3": "third-order Butterworth",
    "butterworth4": "fourth-order Butterworth",
    "mean": "running mean",
    "bartlett": "two cascaded running means",
    "digital1": "first order, digital",
    "digital2": "second-order digital Butterworth",
    "digital4": "fourth-order digital Butterworth",
}
_INTERPOLATION = {
    "held": " by repeating each sample",
    "linear": " by linear interpolation",
    "smooth": " by smooth interpolation",
    "empty": ", no noise above half that rate",
}


def _largest(finding: Finding) -> str:
    """The largest of the factors on the printed fit."""
    term, factor = max(finding.factors, key=lambda one: max(one[1], 1 / one[1]))
    return f"fitted {factor_text(term, factor)}"


def _on_walk(finding: Finding, share: float, tau0: float) -> str:
    """The effect on the printed fit if there is one, else on a random walk read off at one sample."""
    if finding.fit_effect is None:
        return f"; {factor_text(f'σ({seconds(tau0)} s)', share)}"
    if finding.factors:
        return f"; {_largest(finding)}"
    if "adequate" == finding.fit_effect.verdict == finding.fit_effect.verdict_without:
        return "; fit not affected"
    return "" if finding.fit_effect.hidden else "; effect on the fit unknown"


def _mains(line: Line) -> str:
    if line.mains is None:
        return ""
    multiple = f"{line.mains.multiple} × " if line.mains.multiple > 1 else ""
    return f", possibly {'aliased ' if line.mains.folded else ''}{multiple}{line.mains.frequency:g} Hz mains"


def _spectral_lines(finding: Finding, details: SpectralLines) -> Words:
    strongest = details.lines[0]
    what = f"{len(details.lines)} spectral lines, largest" if len(details.lines) > 1 else "spectral line"
    width = f", {two_digits(strongest.width)} Hz wide" if strongest.width else ""
    if finding.factors:
        effect = f"; {_largest(finding)}"
    elif details.tau is not None and finding.cause is None:
        effect = f"; {factor_text(f'σ({seconds(details.tau)} s)', details.factor)}"
    else:
        effect = ""
    action = "Record without the vibration or interference"
    if details.clear_from is None:
        action += "; the line affects all averaging times of this record"
    elif details.tau_min:
        action += f", or run analyze with --tau-min {option_seconds(details.tau_min)}"
    message = f"{what} of {strongest.amplitude:.3g} {finding.unit} at {strongest.frequency:.4g} Hz"
    return Words(message + (_mains(strongest) or width) + effect, action)


def _low_pass_filter(finding: Finding, details: LowPassFilter) -> Words:
    tau_min = details.tau_min or details.right_from
    return Words(
        f"low-pass filter at {details.corner:.3g} ± {two_digits(details.error)} Hz ({_SHAPES[details.shape]})"
        + _on_walk(finding, details.sigma_one_sample, details.tau0),
        f"Use only averaging times from {seconds(tau_min)} s: run analyze with --tau-min {option_seconds(tau_min)}",
    )


def _aliasing(finding: Finding, details: Aliasing) -> Words:
    times = f"sampled at {details.rate:.4g} Hz, {details.rate / details.bandwidth:.2g} times the"
    effect = factor_text(*finding.factors[0])
    order = "" if details.order is None else f" of order {details.order}"
    if details.stated:
        message = f"{times} stated bandwidth of {details.bandwidth:.4g} Hz{order}; {effect}"
        if details.second_order is not None:
            message += f", or {factor_text('', details.second_order).strip()} for order 2"
    else:
        message = f"{times} bandwidth of {details.bandwidth:.3g} Hz in the spectrum; {effect} if the filter is analog"
    action = f"Sample at {details.rate_needed:.3g} Hz or faster, or filter before sampling"
    return Words(message, action if finding.severity != "info" else "")


def _resampled(finding: Finding, details: Resampled) -> Words:
    return Words(
        f"resampled from about {details.rate:.4g} Hz{_INTERPOLATION[details.kind]}"
        + _on_walk(finding, details.sigma_one_sample, 1 / details.log_rate),
        f"Record the samples of the sensor, or use only averaging times from {seconds(details.right_from)} s",
    )


def _correlated_axes(finding: Finding, details: CorrelatedAxes) -> Words:
    strongest = details.pairs[0]
    of = f"means over {duration_text(strongest.mean_length)}" if strongest.mean_length else "sample-to-sample changes"
    several = f", the largest of {len(details.pairs)} pairs" if len(details.pairs) > 1 else ""
    shared = "a shared supply, temperature or motion" if strongest.mean_length else "a shared vibration or converter"
    return Words(
        f"{strongest.first} and {strongest.second} are correlated, r = {strongest.coefficient:.2f} for {of}{several}",
        f"Look for {shared}; a Kalman filter needs the covariance of the axes",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    Aliasing: _aliasing,
    CorrelatedAxes: _correlated_axes,
    LowPassFilter: _low_pass_filter,
    Resampled: _resampled,
    SpectralLines: _spectral_lines,
}
