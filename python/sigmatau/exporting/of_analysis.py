"""Source of an export from the parts of an analysis: model, filters, variances of samples, and head of the file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import PurePath

from sigmatau.estimators.allan import DeviationCurve
from sigmatau.exporting.source import Sample, Source
from sigmatau.findings.finding import Finding, axes_text
from sigmatau.findings.spectrum import LowPassFilter
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.noise_model import NoiseModel
from sigmatau.record.record import Provenance, stream_name
from sigmatau.results import duration_text

_KINDS_IN_HEAD = 8  # largest number of kinds of findings in the head of a file
# shortest means; with shorter means the variance lacks the noise at the minimum of the curve [samples]
_SHORTEST_MEANS = 32


def source_of_analysis(
    model: NoiseModel,
    *,
    fits: Mapping[str, NoiseFit],
    curves: Mapping[str, DeviationCurve],
    findings: Iterable[Finding],
    origin: Provenance,
    version: str,
) -> Source:
    """Build the source of the model of an analysis; `version`: that of the program that wrote the analysis."""
    names = tuple(model.channels)
    every = tuple(findings)
    filters = [finding for finding in every if finding.code == LowPassFilter.code and finding.size is not None]
    corners = {name: f.size for f in filters for name in f.channels if name in model.channels and f.size}
    samples = {name: _sample_variance(curve) for name, curve in curves.items() if name in model.channels}
    topic = {"topic": origin.topics[0]} if len(origin.topics) == 1 and origin.topics[0].startswith("/") else {}
    chosen = {name: fits[name] for name in names}
    return Source(
        model=model,
        rates={name: channel.rate for name, channel in model.channels.items()},
        corners=corners,
        samples={name: sample for name, sample in samples.items() if sample is not None},
        names=topic,
        poor=tuple(name for name, fit in chosen.items() if fit.trust == "poor"),
        head=(_origin_line(origin, next(iter(chosen.values())), version), *_fit_lines(chosen), *_lines(every, chosen)),
    )


def _sample_variance(curve: DeviationCurve) -> Sample | None:
    """Variance of a sample, from the Allan variances up to the minimum of the curve; None if an octave is missing, or if
    the curve ends before means of 32 samples.

    A record minus its means of 2ᵏ samples is the sum of the differences of neighbouring means of 1, 2, 4 … 2ᵏ⁻¹ samples
    (Haar's decomposition), so its variance is half the sum of their Allan variances. It includes filtered noise, lines and
    quantization.
    """
    adev = {int(m): sigma for m, sigma in zip(curve.m.tolist(), curve.adev.tolist(), strict=True) if sigma == sigma}
    if 1 not in adev:
        return None
    lowest = max(min(adev, key=lambda m: adev[m]), _SHORTEST_MEANS)
    octaves = [2**k for k in range(lowest.bit_length())]
    if not all(m in adev for m in octaves) or not octaves[-1] >= _SHORTEST_MEANS:
        return None
    last = octaves[-1]
    means = adev[last] ** 2 / 2  # variance of the means if their noise is white
    time = 2 * last * float(curve.tau[0])
    return Sample(variance=sum(adev[m] ** 2 for m in octaves) / 2 + means, time=time)


def _origin_line(origin: Provenance, fit: NoiseFit, version: str) -> str:
    rate = 1 / fit.tau0
    parts = [
        f"from {PurePath(origin.path or 'samples in memory').name}",
        *(f"topic {topic}" for topic in origin.topics[:2]),
        f"{duration_text(fit.n / rate)} at {rate:.4g} Hz",
        f"analysed by sigmatau {version}",
    ]
    return ", ".join(parts)


def _fit_lines(fits: Mapping[str, NoiseFit]) -> list[str]:
    """Lines with the verdicts, and ``trust: gyro good, accel_x poor``. A sensor whose axes have the same trust is named
    once.
    """
    by_verdict: dict[str, list[str]] = {}
    sensors: dict[str, dict[str, str]] = {}
    for name, fit in fits.items():
        by_verdict.setdefault(fit.verdict_words, []).append(name)
        if fit.trust is not None:
            sensors.setdefault(stream_name(name), {})[name] = fit.trust
    grades: dict[str, str] = {}
    for sensor, by_axis in sensors.items():
        grades |= {sensor: next(iter(by_axis.values()))} if len(set(by_axis.values())) == 1 else by_axis
    lines = [f"{axes_text(names)}: {text}" for text, names in by_verdict.items()]
    return [*lines, *([f"trust: {', '.join(f'{name} {word}' for name, word in grades.items())}"] if grades else [])]


def _lines(findings: Iterable[Finding], fits: Mapping[str, NoiseFit]) -> list[str]:
    """Findings about the numbers, one line per kind: the largest finding, and the other axes."""
    kinds: dict[str, list[Finding]] = {}
    for finding in findings:
        channels = finding.channels
        if finding.severity != "info" and (
            not channels or any(name in fits and stream_name(name) in ("gyro", "accel") for name in channels)
        ):
            kinds.setdefault(finding.code, []).append(finding)
    lines = []
    for alike in [*kinds.values()][:_KINDS_IN_HEAD]:
        worst = max(alike, key=lambda finding: abs(finding.size or 0.0))
        lesser = dict.fromkeys(name for finding in alike for name in finding.channels if name not in worst.channels)
        about = f"{axes_text(list(worst.channels))}: " if worst.channels else ""
        also = f"; also {axes_text(list(lesser))}" if lesser else ""
        lines.append(f"{worst.severity}: {about}{worst.message}{also}")
    return lines
