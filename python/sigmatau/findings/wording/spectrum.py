"""Words of findings about spectra: lines, filters, processes, aliasing, correlated axes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.spectrum import (
    Aliasing,
    BandLeftOut,
    CorrelatedAxes,
    GaussMarkovProcess,
    IdenticalAxes,
    Line,
    LowPassFilter,
    Resonance,
    SpectralLines,
)
from sigmatau.findings.wording.fit import filter_text
from sigmatau.findings.wording.phrases import Words, axes_text, factor_text, number
from sigmatau.noise.terms import display_units
from sigmatau.results import duration_text, two_digits

_QUANTITIES = {"rad/s": "angular_rate", "m/s^2": "acceleration"}


def _mains(line: Line) -> str:
    if line.mains is None:
        return ""
    multiple = f"{line.mains.multiple} × " if line.mains.multiple > 1 else ""
    return f", possibly {'aliased ' if line.mains.folded else ''}{multiple}{line.mains.frequency:g} Hz mains"


def _spectral_lines(finding: Finding, details: SpectralLines) -> Words:
    strongest = details.lines[0]
    unit, factor = display_units("bias_instability", _QUANTITIES.get(finding.unit, "signal"), finding.unit)[-1]
    what = f"{len(details.lines)} spectral lines, largest" if len(details.lines) > 1 else "spectral line"
    message = (
        f"{what} of {number(strongest.amplitude / factor)} {unit} at {strongest.frequency:.4g} Hz{_mains(strongest)}"
    )
    return Words(message, "No action needed: the coefficients are those without the lines")


def _low_pass_filter(_: Finding, details: LowPassFilter) -> Words:
    what = filter_text(details.shape, details.order)
    if details.shape == "uneven":
        what = "the spectrum is uneven, but does not fall as behind a low-pass filter"
    if details.corner is not None and details.low is not None and details.high is not None:
        what += f" at {details.corner:.3g} ± {two_digits((details.high - details.low) / 2)} Hz"
    return Words(what, "No action needed: it is part of the fit")


def _band_left_out(_: Finding, details: BandLeftOut) -> Words:
    return Words(
        f"the spectrum from {details.highest:.3g} Hz on fits no model and is left out",
        "No action needed, unless the noise at short times matters",
    )


def _gauss_markov(finding: Finding, details: GaussMarkovProcess) -> Words:
    known = details.low is not None and details.high is not None
    within = f" [{duration_text(details.low or 0.0)}, {duration_text(details.high or 0.0)}]" if known else ""
    return Words(
        f"Gauss-Markov process of {_sized(finding, details.quantity)},"
        f" correlation time {duration_text(details.time)}{within}",
        "No action needed: it is part of the model",
    )


def _resonance(finding: Finding, details: Resonance) -> Words:
    return Words(
        f"resonance of {_sized(finding, details.quantity)} at {details.frequency:.3g} Hz,"
        f" half width {two_digits(details.width)} Hz",
        "No action needed: it is part of the model",
    )


def _sized(finding: Finding, quantity: str) -> str:
    unit, factor = display_units("bias_instability", quantity, finding.unit)[-1]
    return f"{two_digits((finding.size or 0.0) / factor)} {unit}"


def _aliasing(finding: Finding, details: Aliasing) -> Words:
    times = f"sampled at {details.rate:.4g} Hz, {details.rate / details.bandwidth:.2g} times the"
    effect = factor_text(*finding.factors[0])
    order = "" if details.order is None else f" of order {details.order}"
    message = f"{times} stated bandwidth of {details.bandwidth:.4g} Hz{order}; {effect}"
    if details.second_order is not None:
        message += f", or {factor_text('', details.second_order).strip()} for order 2"
    action = f"Sample at {details.rate_needed:.3g} Hz or faster, or filter before sampling"
    return Words(message, action if finding.severity != "info" else "")


def _correlated_axes(finding: Finding, details: CorrelatedAxes) -> Words:
    strongest = details.pairs[0]
    of = f"means over {duration_text(strongest.mean_length)}" if strongest.mean_length else "sample-to-sample changes"
    several = f", the largest of {len(details.pairs)} pairs" if len(details.pairs) > 1 else ""
    shared = "a shared supply, temperature or motion" if strongest.mean_length else "a shared vibration or converter"
    pair = (strongest.first, strongest.second)
    which = "" if set(finding.channels) == set(pair) else f"{axes_text(pair)} are "
    return Words(
        f"{which}correlated, r = {strongest.coefficient:.2f} for {of}{several}",
        f"Look for {shared}; a Kalman filter needs the covariance of the axes",
    )


def _identical_axes(finding: Finding, details: IdenticalAxes) -> Words:
    return Words(
        f"identical in all {details.samples} samples: one column was read or logged twice",
        "Check --channels and the logging program",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    Aliasing: _aliasing,
    BandLeftOut: _band_left_out,
    CorrelatedAxes: _correlated_axes,
    GaussMarkovProcess: _gauss_markov,
    IdenticalAxes: _identical_axes,
    LowPassFilter: _low_pass_filter,
    Resonance: _resonance,
    SpectralLines: _spectral_lines,
}
