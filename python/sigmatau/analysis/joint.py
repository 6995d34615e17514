"""Joint fit of several analysed records, in the form of a result for one record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import partial
from typing import Any

import numpy as np

from sigmatau.analysis.json import with_joint
from sigmatau.analysis.result import Analysis
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve
from sigmatau.findings.finding import Finding, Findings, ranked
from sigmatau.findings.joint import RunDiffers, RunLeftOut, RunsDiffer, Unfit
from sigmatau.findings.reasons import CoarseCounts
from sigmatau.findings.values import CoarseResolution
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.adjustment import Adjustment
from sigmatau.fitting.joint import COMMON, JointRun, Over, build_run, join, why_unfit
from sigmatau.fitting.joint_fit import ALPHA, JointChannel, JointFit
from sigmatau.fitting.known_biases import bias, walk_bias
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.overview import overview
from sigmatau.fitting.read_off import read_off
from sigmatau.fitting.rounding import rounding_adjustment
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS
from sigmatau.quality.fit_findings import disturbed_findings
from sigmatau.quality.samples.resolution import rounded
from sigmatau.record.mask import only_used
from sigmatau.record.record import Provenance, Record
from sigmatau.results import ByChannel, Printed, duration_text

_MIN_RUNS = 2  # smallest number of runs


@frozen(eq=False)
class AnalysedRun:
    """Contribution of an analysed record to joint fits."""

    name: str
    analysis: Analysis
    runs: Mapping[str, JointRun]  # contributions by channel
    findings: tuple[Finding, ...]  # findings about channels that cannot be used


@frozen(eq=False)
class JointAnalysis(Printed):
    """Several analysed records with their joint fit.

    Attributes
    ----------
    analysis : Analysis
        Its fits describe all runs; its curves are means of the variances of the runs, weighted by their numbers of pairs.
        Its findings concern the joint fit; `records` contain those of single runs.
    joint : JointFit
    records : mapping of str to Analysis
        The analyses of the single records, by name.
    over : {"runs", "axes"}
        Data to which one model is fitted.
    """

    analysis: Analysis
    joint: JointFit
    records: Mapping[str, Analysis] = field(repr=False)
    over: Over = "runs"

    def to_dict(self) -> dict[str, Any]:
        """The stable JSON form of an analysis, with a ``joint`` in each channel."""
        return with_joint(self.analysis, self.joint)

    def headline(self) -> str:
        """Describe the records in a line."""
        curves = list(self.analysis.curves.values())
        rates = dict.fromkeys(f"{1 / curve.tau0:.5g}" for curve in curves)
        together = duration_text(max(sum(joint.fit.runs) for joint in self.joint.values()))
        runs = max(len(joint.runs) for joint in self.joint.values())
        pooled = "axes of each sensor" if self.over == "axes" else "runs"
        axes = f"{len(curves)} {'channel' if len(curves) == 1 else 'channels'} at {' and '.join(rates)} Hz"
        return f"joint fit of {runs} {pooled}: {axes}, {together} together"

    def overview(self, *, width: int = 80, legend: bool = True) -> str:
        """Table of the analysis, with the variation of coefficients between the runs."""
        table = overview(self.analysis.fits, self.analysis.findings, width=width, legend=legend)
        return "\n".join([self.headline(), table, *self.spread_lines()])

    def spread_lines(self) -> list[str]:
        """Coefficients that differ from run to run, one line per term."""
        lines = []
        terms = dict.fromkeys(name for joint in self.joint.values() for name in joint.spreads)
        for term in terms:
            shown = {
                channel: joint.spreads[term].relative
                for channel, joint in self.joint.items()
                if term in joint.spreads and joint.spreads[term].p_value < ALPHA
            }
            if shown:
                sizes = ", ".join(f"{channel} {100 * size:.2g} %" for channel, size in shown.items())
                lines.append(f"{TERMS[term].label('signal')} differs from run to run by {sizes}")
        return lines

    def __repr__(self) -> str:
        return self.overview()


def analysed_run(record: Record, analysis: Analysis, *, name: str) -> AnalysedRun:
    """Summarise an analysed record for joint fits, without the samples that the analysis excluded.

    Raises
    ------
    DataError
        If the record has no fit.
    """
    fits = {channel: fit for channel, fit in analysis.fits.items() if fit.method == "likelihood"}
    if not fits:
        raise DataError(f"{name} is not in the joint fit: {_why_not(analysis)}")
    used = only_used(record, {channel: analysis.masks[channel] for channel in fits})
    thermometers = tuple(stream for stream in record.streams if stream.quantity == "temperature")
    stream_names = {stream.name for stream in used.streams}
    used = replace(
        used, streams=(*used.streams, *(stream for stream in thermometers if stream.name not in stream_names))
    )
    runs: dict[str, JointRun] = {}
    findings = []
    for channel in analysis.curves:
        unfit = _why_unfit(used, channel, fits.get(channel))
        if unfit is None:
            runs[channel] = build_run(used, channel, name=name, fit=fits[channel])
        else:
            findings.append(_run_left_out(name, unfit, channel))
    return AnalysedRun(name=name, analysis=analysis, runs=runs, findings=tuple(findings))


def _why_unfit(used: Record, channel: str, fitted: NoiseFit | None) -> Unfit | None:
    if fitted is None:
        return "too_few_samples"
    if any(isinstance(reason, CoarseCounts) for reason in fitted.reasons):
        return "coarse_counts"
    return why_unfit(used.stream_of(channel), channel)


def _run_left_out(run: str, reason: Unfit, channel: str) -> Finding:
    return Finding(details=RunLeftOut(run=run, reason=reason), severity="warning", channels=(channel,))


def _why_not(analysis: Analysis) -> str:
    if analysis.rest is None or analysis.rest.is_usable:
        return "it has too few samples"
    if analysis.rest.verdict == "not_at_rest":
        return "the sensor is not at rest"
    return "it is too short to tell rest from motion"


def fit_analysed(
    records: Sequence[AnalysedRun],
    *,
    over: Over = "runs",
    common: Sequence[str] = COMMON,
    terms: Sequence[str] | None = None,
) -> JointAnalysis:
    """Fit analysed records jointly; see `sigmatau.fit_jointly` for the options.

    Raises
    ------
    OptionError
        If every channel has fewer than two runs.
    DataError
        For runs with different rates or units, or the same samples twice.
    """
    findings = [finding for record in records for finding in record.findings]
    pools: dict[str, list[tuple[JointRun, Analysis]]] = {}
    for record in records:
        for channel, run in record.runs.items():
            if over == "axes":
                named = channel if len(records) == 1 else f"{record.name} {channel}"
                pools.setdefault(run.stream.name, []).append((replace(run, name=named), record.analysis))
            else:
                pools.setdefault(channel, []).append((run, record.analysis))
    joints: dict[str, JointChannel] = {}
    curves: dict[str, DeviationCurve] = {}
    for pool, members in pools.items():
        if len(members) < _MIN_RUNS:
            findings.append(_run_left_out(members[0][0].name, "only_run", pool))
            continue
        members, left_out = _without_disturbed(members, pool)
        findings += left_out
        joint = join([run for run, _ in members], pool, common=common, terms=terms)
        biases = [walk_bias(analysis.findings, run.channel) for run, analysis in members]
        rounding = partial(_coarsest_rounding, members=members)
        joint = replace(joint, fit=adjusted(joint.fit, rounding, partial(bias, biases=biases)))
        joints[pool] = joint
        curves[pool] = _pooled([analysis.curves[run.channel] for run, analysis in members], joint.fit)
        findings += _findings(joint)
    if not joints:
        what = "axes of a sensor" if over == "axes" else "logs with the same channel"
        raise OptionError(f"{{option}} needs at least two {what} that can be used", option="joint")
    names = [record.name for record in records]
    source = Provenance(
        path=names[0] if len(names) == 1 else f"{names[0]} … {names[-1]} ({len(names)} logs)",
        format="joint",
        rows=sum(record.analysis.source.rows for record in records),
        conversions=(f"joint fit of {len(names)} records: {', '.join(names)}",),
    )
    analysis = Analysis(
        source=source,
        findings=Findings(ranked(findings)),
        curves=Curves(curves),
        fits=Fits({channel: joint.fit for channel, joint in joints.items()}),
        read_off=ByChannel({channel: read_off(curve) for channel, curve in curves.items()}),
        grids={},
    )
    by_name = {record.name: record.analysis for record in records}
    return JointAnalysis(analysis=analysis, joint=JointFit(joints), records=by_name, over=over)


def _without_disturbed(
    members: list[tuple[JointRun, Analysis]], pool: str
) -> tuple[list[tuple[JointRun, Analysis]], list[Finding]]:
    """Remove the runs whose noise is hidden by vibration, and report them; keep all runs if fewer than two would remain."""
    quiet = [member for member in members if member[0].fit.verdict != "disturbed"]
    if len(quiet) < _MIN_RUNS:
        return members, []
    return quiet, [_run_left_out(run.name, "disturbed", pool) for run, _ in members if run.fit.verdict == "disturbed"]


def _findings(joint: JointChannel) -> list[Finding]:
    findings = disturbed_findings(joint.fit)
    findings += [
        Finding(
            details=RunsDiffer(runs=len(joint.runs), term=term, p_value=p_value),
            severity="warning",
            channels=(joint.channel,),
        )
        for term, p_value in joint.homogeneity.items()
        if p_value < ALPHA
    ]
    for run in joint.runs:
        if not run.belongs:
            term = run.cause if run.cause in TERMS else None
            details = RunDiffers(
                run=run.name, runs=len(joint.runs), term=term, factor=run.factor if term else None, p_value=run.p_value
            )
            findings.append(Finding(details=details, severity="warning", channels=(joint.channel,), size=run.factor))
    return findings


def _coarsest_rounding(fitted: NoiseFit, *, members: Sequence[tuple[JointRun, Analysis]]) -> Adjustment | None:
    """Widen the intervals to those of the coarsest run, which hold for any position of the mean within a step."""
    steps = [
        finding.details
        for run, analysis in members
        for finding in analysis.findings
        if finding.channel == run.channel and rounded(finding) and isinstance(finding.details, CoarseResolution)
    ]
    if not steps:
        return None
    coarsest = max(steps, key=lambda resolution: resolution.step / resolution.noise)
    return rounding_adjustment(fitted, step=coarsest.step, noise=coarsest.noise)


def _pooled(curves: Sequence[DeviationCurve], fitted: NoiseFit) -> DeviationCurve:
    """Mean of the variances of the runs at the averaging times of the longest run, weighted by their numbers of pairs."""
    longest = max(curves, key=lambda curve: curve.n)
    total, pairs, ramps = (np.zeros(len(longest.m)) for _ in range(3))
    for curve in curves:
        _, in_longest, in_curve = np.intersect1d(longest.m, curve.m, return_indices=True)
        weights = curve.n_pairs[in_curve].astype(float)
        total[in_longest] += weights * curve.avar[in_curve]
        ramps[in_longest] += weights * curve.ramp[in_curve]
        pairs[in_longest] += weights
    alone = fitted.degrees_of_freedom(m=longest.m)
    edf = None if alone is None else alone * pairs / longest.n_pairs
    return replace(
        longest,
        channel=fitted.channel,
        avar=total / pairs,
        ramp=ramps / pairs,
        n_pairs=pairs.astype(np.int64),
        edf=edf,
        missing=sum(curve.missing for curve in curves),
    )
