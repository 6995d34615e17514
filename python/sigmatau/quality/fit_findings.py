"""Findings of the fits: filters, lines, processes and drifts of a fitted model, and misfits."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace

from sigmatau.findings.disturbances import NotStatic
from sigmatau.findings.drift import TemperatureDrift, WarmUpDrift
from sigmatau.findings.finding import DISTURBANCES, Details, Finding, Severity, Span
from sigmatau.findings.fit import (
    ChangingLevel,
    CountedAngle,
    Disturbed,
    FewDegreesOfFreedom,
    NoAdequateModel,
    OtherAxesDisturbed,
    SecondExplanation,
    ShortTimesLeftOut,
    TooShort,
    Widened,
)
from sigmatau.findings.reasons import BandsOff, ChangingRandomWalk, CrowdedLines, Reason, VibrationPower
from sigmatau.findings.spectrum import (
    BandLeftOut,
    CorrelatedAxes,
    GaussMarkovProcess,
    LowPassFilter,
    Mains,
    ResonanceProcess,
    SpectralLine,
    SpectralLines,
)
from sigmatau.findings.values import CoarseResolution
from sigmatau.fitting.channel import TEMPERATURE, follows_temperature
from sigmatau.fitting.fitted_values import FittedSinusoid
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter
from sigmatau.quality.drift.without_drifts import has_drift
from sigmatau.record.record import Record

# Degrees of freedom above which a random walk is reliable. [1] Derived: its 95 % interval is then within 25 %.
_MIN_FREEDOM = 30.0
# Ratio above which the coefficients of two models count as different. [1] Judgement: more than the usual interval of a
# slow term.
_MUCH_LARGER = 1.2
# Share of missing samples above which they explain a lack of averaging times. [1] Judgement: fewer do not shorten the
# record.
_MANY_MISSING = 0.1
# Shortest averaging time of a fit, over the sample interval, above which short times count as left out. [1] Derived:
# the next octave is 2.
_LONGER_START = 1.5
# Frequencies of the mains. [Hz] Standard: IEC 60196.
_MAINS = (50.0, 60.0)
# Largest half width of a line that may be the mains. [Hz] Judgement: the mains frequency varies less.
_MAINS_ERROR = 0.2
# Lowest frequency of a folded line of the mains. [Hz] Judgement: slow noise has lines below.
_MAINS_FROM = 0.5
# Largest deviation of the mains frequency and of each multiple. [Hz] Judgement: usual deviations of large grids.
_MAINS_WANDER = 0.05
# Relative error of the clock of a log. [1] Judgement: crystals have 10⁻⁵ to 10⁻⁴.
_CLOCK_ERROR = 1e-4
# Largest distance of a harmonic from a multiple of the lowest line, over that line. [1] Judgement: two tenths of all
# frequencies are then close to a multiple.
_PART_OF_BASE = 0.1
# Highest multiple that is recognised as a harmonic. [1] Judgement: higher ones match weak lines by chance.
_HIGHEST_MULTIPLE = 16


def fit_findings(
    fitted: NoiseFit, *, start: float = 0.0, missing: float = 0.0, sample_findings: Sequence[Finding] = ()
) -> list[Finding]:
    """Findings of a fit about its channel.

    Parameters
    ----------
    fitted : NoiseFit
    start : float
        Time of the first sample from the beginning of the whole record. [s]
    missing : float
        Share of missing samples.
    sample_findings : sequence of Finding
        Findings about the samples. No filter is reported for held or interpolated samples, which have the spectrum of a
        filter. If a disturbance is a warning, filters, processes and resonances are not reported, and a poor fit is not a
        further warning.
    """
    disturbed = any(
        finding.code in DISTURBANCES and not finding.left_out
        for finding in sample_findings
        if finding.severity == "warning" and fitted.channel in finding.channels
    )
    severity_of_misfit: Severity = "info" if disturbed else "warning"
    if fitted.verdict == "too_short":
        size = missing if missing > _MANY_MISSING else None
        return [_finding(fitted, TooShort(reasons=fitted.reasons, missing=missing), "warning", size=size)]
    if fitted.verdict == "descriptive":
        return [_finding(fitted, NoAdequateModel(reasons=fitted.reasons), severity_of_misfit)]
    if fitted.verdict == "disturbed":
        return [*disturbed_findings(fitted), *_lines(fitted)]
    findings: list[Finding] = []
    if (freedom := walk_freedom(fitted)) < _MIN_FREEDOM:
        short = FewDegreesOfFreedom(freedom=freedom, duration=fitted.n * fitted.tau0)
        findings.append(_finding(fitted, short, "warning", size=freedom))
    if fitted.verdict == "widened":
        findings.append(_widened(fitted, severity_of_misfit))
    findings += _changing_level(fitted)
    if (
        (response := fitted.response) is not None
        and not disturbed
        and not _between_samples(fitted.channel, sample_findings)
    ):
        fields = {name: getattr(response, name) for name in ("shape", "order", "corner", "low", "high")}
        findings.append(_finding(fitted, LowPassFilter(**fields), size=response.corner, unit="Hz"))
    if fitted.highest is not None:
        findings.append(_finding(fitted, BandLeftOut(highest=fitted.highest), size=fitted.highest, unit="Hz"))
    findings += _counted_angle(fitted, sample_findings)
    findings += _lines(fitted)
    quantity, unit = fitted.quantity, fitted.rate_unit
    for process in () if disturbed else fitted.gauss_markov:
        time = process.time
        markov = GaussMarkovProcess(quantity=quantity, time=time.value, low=time.low, high=time.high)
        findings.append(_finding(fitted, markov, size=process.sigma.value, unit=unit))
    for band in () if disturbed else fitted.resonance:
        resonance = ResonanceProcess(quantity=quantity, frequency=band.frequency.value, width=band.width.value)
        findings.append(_finding(fitted, resonance, size=band.sigma.value, unit=unit))
    findings += _second_explanation(fitted)
    findings += _drifts(fitted, start)
    if fitted.method == "gls" and fitted.tau_min is not None and fitted.tau_min > _LONGER_START * fitted.tau0:
        findings.append(_finding(fitted, ShortTimesLeftOut(tau_min=float(fitted.tau_min), reasons=fitted.reasons)))
    return findings


def _finding(
    fitted: NoiseFit,
    details: Details,
    severity: Severity = "info",
    *,
    size: float | None = None,
    unit: str = "",
    spans: tuple[Span, ...] = (),
) -> Finding:
    """Build a finding about the channel of a fit."""
    return Finding(details=details, severity=severity, channels=(fitted.channel,), spans=spans, size=size, unit=unit)


def _between_samples(channel: str, sample_findings: Sequence[Finding]) -> bool:
    """Whether the samples of a channel are held or interpolated, so that they have the spectrum of a filter."""
    return any(
        finding.code in ("interpolated", "repeated_samples") and channel in (finding.channels or (channel,))
        for finding in sample_findings
    )


def _counted_angle(fitted: NoiseFit, sample_findings: Sequence[Finding]) -> list[Finding]:
    """Compare the quantization noise expected from the step of a counted angle with that of the fit."""
    term = fitted.terms.get("quantization")
    for finding in sample_findings:
        steps = finding.details
        if term is None or fitted.channel not in finding.channels or not isinstance(steps, CoarseResolution):
            continue
        if steps.rounding == "quantization" and steps.added is not None:
            observed = {name: getattr(term, name) for name in ("value", "low", "high")} if term.observed else {}
            details = CountedAngle(
                quantity=fitted.quantity,
                rate_unit=fitted.rate_unit,
                step=steps.added * math.sqrt(12),
                by_step=steps.added,
                limit=None if term.observed else term.upper_limit,
                **observed,
            )
            return [_finding(fitted, details, size=steps.added)]
    return []


def _changing_level(fitted: NoiseFit) -> list[Finding]:
    changes = [reason for reason in fitted.reasons if isinstance(reason, ChangingRandomWalk)]
    return [
        _finding(fitted, _copy_fields(change, ChangingLevel, fitted), size=change.highest / change.lowest)
        for change in changes
    ]


def _copy_fields(reason: Reason, kind: Callable[..., Details], fitted: NoiseFit) -> Details:
    """Make the details of a finding from the fields of a reason, with the quantity and the unit of the channel."""
    values = {field.name: getattr(reason, field.name) for field in fields(reason) if field.init}
    return kind(quantity=fitted.quantity, rate_unit=fitted.rate_unit, **values)


def _second_explanation(fitted: NoiseFit) -> list[Finding]:
    """Report the first other model that explains the record equally well, if each model has a part that the other lacks."""
    processes = tuple((process.sigma.value, process.time.value) for process in fitted.gauss_markov)
    for explanation in fitted.second:
        if explanation.exponent is not None:
            return [_other_exponent(fitted, explanation.exponent, explanation.terms)]
        fewer = len(explanation.gauss_markov) < len(processes)
        lacking = tuple((name, value) for name, value in fitted.model.items() if name not in explanation.terms)
        added = tuple(
            (name, value)
            for name, value in explanation.terms.items()
            if name not in fitted.model or (fewer and value > _MUCH_LARGER * fitted.model[name])
        )
        details = SecondExplanation(
            quantity=fitted.quantity,
            rate_unit=fitted.rate_unit,
            terms=lacking,
            processes=processes if fewer else (),
            other_terms=added,
            other_processes=() if fewer or explanation.warm_up is not None else explanation.gauss_markov,
            other_warm_up=explanation.warm_up,
            other_filter=explanation.filter,
        )
        if (lacking or details.processes) and (added or details.other_processes or explanation.warm_up is not None):
            return [_finding(fitted, details)]
    return []


def _other_exponent(fitted: NoiseFit, exponent: float, terms: Mapping[str, float]) -> Finding:
    """Report a bias instability with another exponent, in place of the terms of the fit."""
    replaced = ("bias_instability", "rate_random_walk")
    details = SecondExplanation(
        quantity=fitted.quantity,
        rate_unit=fitted.rate_unit,
        terms=tuple((name, fitted.model[name]) for name in replaced if name in fitted.model and name not in terms),
        processes=tuple((process.sigma.value, process.time.value) for process in fitted.gauss_markov),
        other_terms=(),
        other_processes=(),
        other_exponent=exponent,
    )
    return Finding(details=details, severity="info", channels=(fitted.channel,))


def walk_freedom(fitted: NoiseFit) -> float:
    """Degrees of freedom of the square of the random walk, from its standard error s: ½(N/s)²; inf if it is not observed."""
    walk, variance = fitted.terms.get("random_walk"), fitted.covariance.variance_of(Parameter("random_walk"))
    return walk.value**2 / (2 * variance) if walk is not None and walk.value and variance else math.inf


def disturbed_findings(fitted: NoiseFit) -> list[Finding]:
    """Report vibration that hides the noise of a fit, and the quietest stretch."""
    return [
        _finding(
            fitted,
            _copy_fields(reason, Disturbed, fitted),
            "warning",
            spans=((reason.start, reason.stop),),
            size=reason.share,
        )
        for reason in fitted.reasons
        if isinstance(reason, VibrationPower)
    ]


def _lines(fitted: NoiseFit) -> list[Finding]:
    if not fitted.sinusoid:
        return []
    groups = grouped(fitted.sinusoid, rate=1 / fitted.tau0)
    return [_finding(fitted, SpectralLines(lines=groups), size=groups[0].amplitude, unit=fitted.rate_unit)]


def grouped(lines: Sequence[FittedSinusoid], *, rate: float) -> tuple[SpectralLine, ...]:
    """Group lines with their harmonics, the strongest group first. Harmonics are multiples of the lowest line, folded at
    half the rate.
    """
    remaining = sorted(lines, key=lambda line: line.frequency.value)
    groups = []
    while remaining:
        first = remaining.pop(0)
        members = [line for line in remaining if _is_harmonic(line, first, rate)]
        remaining = [line for line in remaining if line not in members]
        harmonics = tuple(_line(harmonic, rate) for harmonic in members)
        groups.append(_line(first, rate, harmonics))
    return tuple(sorted(groups, key=lambda line: -line.amplitude))


def _is_harmonic(line: FittedSinusoid, first: FittedSinusoid, rate: float) -> bool:
    base, frequency = first.frequency.value, line.frequency.value
    order = max(round(frequency / base), 2)
    error, multiple = min((abs(_folded(k * base, rate) - frequency), k) for k in {order, 2, 3, 4, 5})
    allowed = min(multiple * _half_width(first), _PART_OF_BASE * base)
    return multiple <= _HIGHEST_MULTIPLE and error <= allowed


def _half_width(line: FittedSinusoid) -> float:
    low, high = line.frequency.low, line.frequency.high
    return 0.0 if low is None or high is None else (high - low) / 4  # the excluded band includes the foot of the line


def _line(line: FittedSinusoid, rate: float, harmonics: tuple[SpectralLine, ...] = ()) -> SpectralLine:
    return SpectralLine(
        frequency=line.frequency.value,
        amplitude=line.amplitude.value,
        low=line.frequency.low or line.frequency.value,
        high=line.frequency.high or line.frequency.value,
        harmonics=harmonics,
        mains=_mains(line.frequency.value, rate, _half_width(line)),
        weakest=line.amplitude.low,
        strongest=line.amplitude.high,
    )


def _mains(frequency: float, rate: float, half: float) -> Mains | None:
    if half > _MAINS_ERROR:
        return None
    for multiple in (1, 2, 3):
        for mains in _MAINS:
            shown = _folded(multiple * mains, rate)
            wander = multiple * (_MAINS_WANDER + _CLOCK_ERROR * mains) + half
            if shown > _MAINS_FROM and abs(frequency - shown) <= wander:
                return Mains(frequency=mains, multiple=multiple, folded=shown != multiple * mains)
    return None


def _folded(frequency: float, rate: float) -> float:
    return abs(frequency - rate * round(frequency / rate))


def _widened(fitted: NoiseFit, severity: Severity) -> Finding:
    walk = fitted.terms.get("random_walk")
    frequency, allowed = max(fitted.discrepancy, key=lambda band_off: band_off[1], default=(0.0, 0.0))
    band = next((reason for reason in fitted.reasons if isinstance(reason, BandsOff)), None)
    details = Widened(
        frequency=frequency if band is None else band.frequency,
        ratio=1.0 if band is None else band.ratio,
        allowed=allowed,
        lines=len(fitted.sinusoid),
        crowded=next((reason.share for reason in fitted.reasons if isinstance(reason, CrowdedLines)), 0.0),
        only_walk=fitted.is_misfit,
    )
    size = None
    if walk is not None and walk.value and walk.low is not None and walk.high is not None:
        size = (walk.high - walk.low) / (2 * walk.value)
    return _finding(fitted, details, severity, size=size)


def _drifts(fitted: NoiseFit, start: float) -> list[Finding]:
    findings, quantity, unit = [], fitted.quantity, fitted.rate_unit
    if (warm_up := fitted.warm_up) is not None:
        low, high = warm_up.amplitude.low or 0.0, warm_up.amplitude.high or 0.0
        details = WarmUpDrift(quantity=quantity, time_constant=warm_up.time, low=low, high=high)
        span = (start, start + min(5 * warm_up.time, fitted.n * fitted.tau0))
        findings.append(_finding(fitted, details, spans=(span,), size=warm_up.amplitude.value, unit=unit))
    if follows_temperature(fitted):
        kelvin = fitted.regressors[TEMPERATURE]
        low, high = kelvin.low or 0.0, kelvin.high or 0.0
        drift = TemperatureDrift(quantity=quantity, rate_unit=unit, low=low, high=high)
        findings.append(_finding(fitted, drift, size=kelvin.value, unit=f"{unit}/K"))
    return findings


def by_channel(fits: Mapping[str, NoiseFit], sample_findings: Sequence[Finding], record: Record) -> list[Finding]:
    """The findings of all fits of a record."""
    starts = {channel: stream.grid.lead for stream in record.streams for channel in stream.channels}
    by_fit = (
        fit_findings(fitted, start=starts[channel], sample_findings=sample_findings) for channel, fitted in fits.items()
    )
    return [finding for findings in by_fit for finding in findings]


def without_explained(findings: Sequence[Finding], fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Remove findings about samples that the drifts of the fits explain.

    Steps of the mean are removed, because `sigmatau.quality.check.check_fits` searches for them without the drift. A
    warning about axes that share only slow noise becomes an info.
    """
    drifting = {channel for channel, fitted in fits.items() if has_drift(fitted)}
    remaining = []
    for finding in findings:
        details = finding.details
        explained = bool(finding.channels) and drifting.issuperset(finding.channels)
        if explained and isinstance(details, NotStatic) and details.steps and not details.bursts:
            continue
        if explained and isinstance(details, CorrelatedAxes) and details.only_slow:
            finding = replace(finding, severity="info")
        remaining.append(finding)
    return remaining


def other_axes_disturbed(fits: Iterable[NoiseFit]) -> list[Finding]:
    """Report the quantified axes of a sensor that has other, disturbed axes: at most one finding.

    If all axes are shaken, chance decides which of them are too disturbed for a fit: see docs/study/rest.md.
    """
    fits = tuple(fits)
    disturbed = tuple(
        fitted.channel for fitted in fits if any(isinstance(reason, VibrationPower) for reason in fitted.reasons)
    )
    quantified = tuple(fitted.channel for fitted in fits if fitted.quantified and fitted.channel not in disturbed)
    if not disturbed or not quantified:
        return []
    return [Finding(details=OtherAxesDisturbed(disturbed=disturbed), severity="warning", channels=quantified)]
