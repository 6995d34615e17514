"""Findings that are read from the fits: what was fitted beside the terms, and what no model describes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from sigmatau.findings.disturbances import NotStatic
from sigmatau.findings.drift import TemperatureDrift, WarmUp
from sigmatau.findings.finding import Finding, Severity
from sigmatau.findings.fit import (
    ChangingLevel,
    CountedAngle,
    Disturbed,
    FewDegreesOfFreedom,
    NoAdequateModel,
    SecondExplanation,
    ShortTimesLeftOut,
    TooShort,
    Widened,
)
from sigmatau.findings.reasons import BandsOff, CrowdedLines, LevelChange, VibrationPower
from sigmatau.findings.spectrum import (
    BandLeftOut,
    CorrelatedAxes,
    GaussMarkovProcess,
    Line,
    LowPassFilter,
    Mains,
    Resonance,
    SpectralLines,
)
from sigmatau.findings.values import CoarseResolution
from sigmatau.fitting.channel import TEMPERATURE, follows_temperature
from sigmatau.fitting.fitted_values import Sinusoid
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter
from sigmatau.quality.check import DISTURBANCES
from sigmatau.quality.drift.without_drifts import drifts
from sigmatau.record.record import Record


@frozen
class FitThresholds:
    """Thresholds of `fit_findings`."""

    least_freedom: float = 30.0
    """Degrees of freedom of the random walk from which on it is trusted. [1] Derived: its 95 % interval is then
    within 25 %."""

    much_larger: float = 1.2
    """Coefficient of another model over that of the fit, from which on it is another size. [1] Judgement: more than
    the usual interval of a slow term is of no use to tell them apart."""

    many_missing: float = 0.1
    """Share of missing samples from which on they are named as the cause of too few averaging times. [1] Judgement:
    fewer do not shorten the record."""

    longer_start: float = 1.5
    """Shortest averaging time of a fit over the sample interval, from which on short times are left out. [1]
    Derived: the next octave is 2."""

    mains: tuple[float, ...] = (50.0, 60.0)
    """Frequencies of the mains. [Hz] Standard: IEC 60196."""

    mains_error: float = 0.2
    """Half width of a line that may be the mains, at most. [Hz] Judgement: the mains wander by no more."""

    mains_from: float = 0.5
    """Frequency of a folded line of the mains, at least. [Hz] Judgement: slow noise has lines of its own below."""

    mains_wander: float = 0.05
    """Deviation of the mains and of each multiple, at most. [Hz] Judgement: usual deviations of large grids."""

    clock_error: float = 1e-4
    """Relative error of the clock of a log. [1] Judgement: crystals have 10⁻⁵ to 10⁻⁴."""

    part_of_base: float = 0.1
    """Distance of a harmonic from a multiple of the lowest line, over that line, at most. [1] Judgement: two tenths
    of all frequencies are then near a multiple."""

    highest_multiple: int = 16
    """Multiple of a line, at most. [1] Judgement: higher ones match weak lines by chance."""


THRESHOLDS = FitThresholds()


def fit_findings(
    fitted: NoiseFit,
    *,
    start: float = 0.0,
    missing: float = 0.0,
    beside: Sequence[Finding] = (),
    thresholds: FitThresholds = THRESHOLDS,
) -> list[Finding]:
    """What a fit says of its channel beside the coefficients.

    Parameters
    ----------
    fitted : NoiseFit
    start : float
        Time of the first sample from the beginning of the whole record. [s]
    missing : float
        Share of missing samples.
    beside : sequence of Finding
        Of the samples: held or interpolated samples have the spectrum of a filter, which is then not named. Where a
        disturbance is a warning, filters, processes and resonances are not named, and a poor fit is not another warning.
    """
    channels = (fitted.channel,)
    disturbed = any(
        one.code in DISTURBANCES and not one.left_out
        for one in beside
        if one.severity == "warning" and fitted.channel in one.channels
    )
    of_misfit: Severity = "info" if disturbed else "warning"
    if fitted.verdict == "too_short":
        size = missing if missing > thresholds.many_missing else None
        details = TooShort(reasons=fitted.reasons, missing=missing)
        return [Finding(details=details, severity="warning", channels=channels, size=size)]
    if fitted.verdict == "descriptive":
        return [Finding(details=NoAdequateModel(reasons=fitted.reasons), severity=of_misfit, channels=channels)]
    findings: list[Finding] = []
    if fitted.verdict == "disturbed":
        return [*disturbed_findings(fitted), *_lines(fitted, thresholds=thresholds)]
    if (freedom := walk_freedom(fitted)) < thresholds.least_freedom:
        short = FewDegreesOfFreedom(freedom=freedom, duration=fitted.n * fitted.tau0)
        findings.append(Finding(details=short, severity="warning", channels=channels, size=freedom))
    if fitted.verdict == "widened":
        findings.append(_widened(fitted, of_misfit))
    findings += _changing_level(fitted)
    between = {
        c for one in beside if one.code in ("interpolated", "repeated_samples") for c in one.channels or channels
    }
    response = fitted.response
    if response is not None and fitted.channel not in between and not disturbed:
        details_ = LowPassFilter(
            shape=response.shape, order=response.order, corner=response.corner, low=response.low, high=response.high
        )
        findings.append(Finding(details=details_, severity="info", channels=channels, size=response.corner, unit="Hz"))
    if fitted.highest is not None:
        band = BandLeftOut(highest=fitted.highest)
        findings.append(Finding(details=band, severity="info", channels=channels, size=fitted.highest, unit="Hz"))
    findings += _counted_angle(fitted, beside)
    findings += _lines(fitted, thresholds=thresholds)
    for process in () if disturbed else fitted.gauss_markov:
        time = process.time
        kind = GaussMarkovProcess(quantity=fitted.quantity, time=time.value, low=time.low, high=time.high)
        findings.append(_sized(kind, fitted, process.sigma.value))
    for one in () if disturbed else fitted.resonance:
        resonance = Resonance(quantity=fitted.quantity, frequency=one.frequency.value, width=one.width.value)
        findings.append(_sized(resonance, fitted, one.sigma.value))
    findings += _second_explanation(fitted, thresholds=thresholds)
    findings += _drifts(fitted, start)
    if fitted.method == "gls" and fitted.tau_min is not None and fitted.tau_min > thresholds.longer_start * fitted.tau0:
        late = ShortTimesLeftOut(tau_min=float(fitted.tau_min), reasons=fitted.reasons)
        findings.append(Finding(details=late, severity="info", channels=channels))
    return findings


def _counted_angle(fitted: NoiseFit, beside: Sequence[Finding]) -> list[Finding]:
    """Quantization noise by the step of a counted angle, against that of the fit."""
    term = fitted.terms.get("quantization")
    for finding in beside:
        steps = finding.details
        if term is None or fitted.channel not in finding.channels or not isinstance(steps, CoarseResolution):
            continue
        if steps.rounding == "quantization" and steps.added is not None:
            details = CountedAngle(
                quantity=fitted.quantity,
                rate_unit=fitted.rate_unit,
                step=steps.added * math.sqrt(12),
                by_step=steps.added,
                value=term.value if term.observed else None,
                low=term.low if term.observed else None,
                high=term.high if term.observed else None,
                limit=None if term.observed else term.upper_limit,
            )
            return [Finding(details=details, severity="info", channels=(fitted.channel,), size=steps.added)]
    return []


def _changing_level(fitted: NoiseFit) -> list[Finding]:
    changes = [reason for reason in fitted.reasons if isinstance(reason, LevelChange)]
    return [
        Finding(
            details=ChangingLevel(
                quantity=fitted.quantity,
                rate_unit=fitted.rate_unit,
                lowest=change.lowest,
                highest=change.highest,
                next_lowest=change.next_lowest,
                next_highest=change.next_highest,
                p_value=change.p_value,
            ),
            severity="info",
            channels=(fitted.channel,),
            size=change.highest / change.lowest,
        )
        for change in changes
    ]


def _second_explanation(fitted: NoiseFit, *, thresholds: FitThresholds) -> list[Finding]:
    """The first other model that explains the record as well, if each of the two has something that the other lacks."""
    processes = tuple((process.sigma.value, process.time.value) for process in fitted.gauss_markov)
    for explanation in fitted.second:
        if explanation.exponent is not None:
            return [_other_exponent(fitted, explanation.exponent, explanation.terms)]
        fewer = len(explanation.gauss_markov) < len(processes)
        lacking = tuple((name, value) for name, value in fitted.model.items() if name not in explanation.terms)
        added = tuple(
            (name, value)
            for name, value in explanation.terms.items()
            if name not in fitted.model or (fewer and value > thresholds.much_larger * fitted.model[name])
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
            return [Finding(details=details, severity="info", channels=(fitted.channel,))]
    return []


def _other_exponent(fitted: NoiseFit, exponent: float, terms: Mapping[str, float]) -> Finding:
    """A bias instability with another exponent in the place of what the fit has for it."""
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
    """Degrees of freedom of the square of the random walk by its standard error s, ½(N/s)²; inf if not observed."""
    walk, variance = fitted.terms.get("random_walk"), fitted.covariance.variance_of(Parameter("random_walk"))
    return walk.value**2 / (2 * variance) if walk is not None and walk.value and variance else math.inf


def disturbed_findings(fitted: NoiseFit) -> list[Finding]:
    """Vibration that hides the noise of a fit, and its quietest stretch."""
    details = [
        Disturbed(
            quantity=fitted.quantity,
            rate_unit=fitted.rate_unit,
            lines=reason.lines,
            resonances=reason.resonances,
            share=reason.share,
            start=reason.start,
            stop=reason.stop,
            quietest=reason.quietest,
        )
        for reason in fitted.reasons
        if isinstance(reason, VibrationPower)
    ]
    return [
        Finding(
            details=vibration,
            severity="warning",
            channels=(fitted.channel,),
            spans=((vibration.start, vibration.stop),),
            size=vibration.share,
        )
        for vibration in details
    ]


def _lines(fitted: NoiseFit, *, thresholds: FitThresholds) -> list[Finding]:
    if not fitted.sinusoid:
        return []
    groups = grouped(fitted.sinusoid, rate=1 / fitted.tau0, thresholds=thresholds)
    return [
        Finding(
            details=SpectralLines(lines=groups),
            severity="info",
            channels=(fitted.channel,),
            size=groups[0].amplitude,
            unit=fitted.rate_unit,
        )
    ]


def grouped(lines: Sequence[Sinusoid], *, rate: float, thresholds: FitThresholds = THRESHOLDS) -> tuple[Line, ...]:
    """Lines with their harmonics, strongest first: others at whole multiples of the lowest, folded at half the rate."""
    remaining = sorted(lines, key=lambda line: line.frequency.value)
    groups = []
    while remaining:
        first = remaining.pop(0)
        members = [other for other in remaining if _is_harmonic(other, first, rate, thresholds=thresholds)]
        remaining = [other for other in remaining if other not in members]
        harmonics = tuple(_line(harmonic, rate, thresholds=thresholds) for harmonic in members)
        groups.append(_line(first, rate, harmonics, thresholds=thresholds))
    return tuple(sorted(groups, key=lambda line: -line.amplitude))


def _is_harmonic(line: Sinusoid, first: Sinusoid, rate: float, *, thresholds: FitThresholds) -> bool:
    base, frequency = first.frequency.value, line.frequency.value
    order = max(round(frequency / base), 2)
    error = min((abs(_folded(k * base, rate) - frequency), k) for k in {order, 2, 3, 4, 5})
    return error[1] <= thresholds.highest_multiple and error[0] <= min(
        error[1] * _half_width(first), thresholds.part_of_base * base
    )


def _half_width(line: Sinusoid) -> float:
    low, high = line.frequency.low, line.frequency.high
    return 0.0 if low is None or high is None else (high - low) / 4  # the foot of the line is left out with it


def _line(line: Sinusoid, rate: float, harmonics: tuple[Line, ...] = (), *, thresholds: FitThresholds) -> Line:
    return Line(
        frequency=line.frequency.value,
        amplitude=line.amplitude.value,
        low=line.frequency.low or line.frequency.value,
        high=line.frequency.high or line.frequency.value,
        harmonics=harmonics,
        mains=_mains(line.frequency.value, rate, _half_width(line), thresholds=thresholds),
        weakest=line.amplitude.low,
        strongest=line.amplitude.high,
    )


def _mains(frequency: float, rate: float, half: float, *, thresholds: FitThresholds) -> Mains | None:
    if half > thresholds.mains_error:
        return None
    for multiple in (1, 2, 3):
        for mains in thresholds.mains:
            shown = _folded(multiple * mains, rate)
            if (
                shown > thresholds.mains_from
                and abs(frequency - shown)
                <= multiple * thresholds.mains_wander + thresholds.clock_error * multiple * mains + half
            ):
                return Mains(frequency=mains, multiple=multiple, folded=shown != multiple * mains)
    return None


def _folded(frequency: float, rate: float) -> float:
    return abs(frequency - rate * round(frequency / rate))


def _sized(details: GaussMarkovProcess | Resonance, fitted: NoiseFit, sigma: float) -> Finding:
    return Finding(details=details, severity="info", channels=(fitted.channel,), size=sigma, unit=fitted.rate_unit)


def _widened(fitted: NoiseFit, severity: Severity) -> Finding:
    walk = fitted.terms.get("random_walk")
    worst = max(fitted.discrepancy, key=lambda band_off: band_off[1], default=(0.0, 0.0))
    band = next((reason for reason in fitted.reasons if isinstance(reason, BandsOff)), None)
    details = Widened(
        frequency=worst[0] if band is None else band.frequency,
        ratio=1.0 if band is None else band.ratio,
        allowed=worst[1],
        lines=len(fitted.sinusoid),
        crowded=next((reason.share for reason in fitted.reasons if isinstance(reason, CrowdedLines)), 0.0),
        only_walk=fitted.is_misfit,
    )
    size = None
    if walk is not None and walk.value and walk.low is not None and walk.high is not None:
        size = (walk.high - walk.low) / (2 * walk.value)
    return Finding(details=details, severity=severity, channels=(fitted.channel,), size=size)


def _drifts(fitted: NoiseFit, start: float) -> list[Finding]:
    findings, channels = [], (fitted.channel,)
    if fitted.warm_up is not None:
        amplitude = fitted.warm_up.amplitude
        details = WarmUp(
            quantity=fitted.quantity,
            time_constant=fitted.warm_up.time,
            low=amplitude.low or 0.0,
            high=amplitude.high or 0.0,
        )
        span = (start, start + min(5 * fitted.warm_up.time, fitted.n * fitted.tau0))
        findings.append(
            Finding(
                details=details,
                severity="info",
                channels=channels,
                spans=(span,),
                size=amplitude.value,
                unit=fitted.rate_unit,
            )
        )
    if follows_temperature(fitted):
        kelvin = fitted.regressors[TEMPERATURE]
        drift = TemperatureDrift(
            quantity=fitted.quantity, rate_unit=fitted.rate_unit, low=kelvin.low or 0.0, high=kelvin.high or 0.0
        )
        unit = f"{fitted.rate_unit}/K"
        findings.append(Finding(details=drift, severity="info", channels=channels, size=kelvin.value, unit=unit))
    return findings


def by_channel(
    fits: Mapping[str, NoiseFit], beside: Sequence[Finding], record: Record, *, thresholds: FitThresholds = THRESHOLDS
) -> list[Finding]:
    """The findings of all fits of a record."""
    starts = {channel: stream.grid.lead for stream in record.streams for channel in stream.channels}
    return [
        finding
        for c, fitted in fits.items()
        for finding in fit_findings(fitted, start=starts[c], beside=beside, thresholds=thresholds)
    ]


def without_consequences(findings: Sequence[Finding], fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Findings of the samples, without what the drifts of the fits explain.

    Steps of the mean are left out: `sigmatau.quality.check.check_fits` looks for them beside the drift. Axes that share slow
    noise alone are an info.
    """
    drifting = {channel for channel, fitted in fits.items() if drifts(fitted)}
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
