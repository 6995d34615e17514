"""Stages of an analysis; `sigmatau.analysis.pipeline` has their order and their state."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from sigmatau.analysis.options import AnalysisOptions, parse_options
from sigmatau.analysis.result import WITHOUT_CURVE, Analysis
from sigmatau.analysis.state import State
from sigmatau.errors import DataError, OptionError
from sigmatau.estimators.allan import Curves, DeviationCurve, scale_by_pairs
from sigmatau.findings.curves import NoMap
from sigmatau.findings.finding import Finding, ranked
from sigmatau.findings.units import ImplausibleUnit
from sigmatau.findings.values import CoarseResolution
from sigmatau.fitting.adjust import adjusted
from sigmatau.fitting.channel import fit_channel
from sigmatau.fitting.coarse_counts import fit_sums
from sigmatau.fitting.known_biases import bias, walk_bias
from sigmatau.fitting.mean_stability import MeanStability, mean_stability
from sigmatau.fitting.noise_fit import Fits, NoiseFit
from sigmatau.fitting.read_off import ReadOff
from sigmatau.fitting.read_off_at import ReadOffAt
from sigmatau.fitting.rounding import rounding_adjustment
from sigmatau.options import stated
from sigmatau.quality.check import LOOKED_AT, LOOKED_AT_BOUNDED, check_fits, examine
from sigmatau.quality.curves import compute_curves
from sigmatau.quality.facts import in_threads
from sigmatau.quality.fit_findings import fit_findings, without_explained
from sigmatau.quality.means import channel_mean
from sigmatau.quality.samples import resolution
from sigmatau.quality.samples.resolution import MIN_SUMS
from sigmatau.quality.selection.exclusion import leave_out
from sigmatau.quality.selection.rest import at_rest_only, rest
from sigmatau.quality.selection.window import choose as choose_window
from sigmatau.record import memory
from sigmatau.record.mask import Exclusion, channel_masks, excluded_from
from sigmatau.record.on_disk import loaded
from sigmatau.record.record import Provenance, Record, TemperatureRange
from sigmatau.record.streams import Stream, converted, describe_sampling
from sigmatau.results import ByChannel

if TYPE_CHECKING:
    from sigmatau.estimators.stability import DynamicAllan


def read(source: object) -> Record:
    """Read the record of a path or a data frame. Raises `TypeError` for other types."""
    if isinstance(source, Record):
        return source
    if isinstance(source, str | Path):
        from sigmatau.io.read import read as read_file

        return read_file(source)
    is_table = hasattr(source, "columns") or hasattr(source, "coords") or isinstance(source, Mapping)
    if isinstance(source, Curves) or not is_table:
        hint = "; existing curves go to sigmatau.analysis.of_curves" if isinstance(source, Curves) else ""
        if hasattr(source, "ndim"):
            hint = "; an array has channels: sigmatau.Record.from_arrays(rate=100, gyro=x)"
        raise TypeError(
            f"`record` must be a Record, see sigmatau.read, a path or a data frame, not a {type(source).__name__}{hint}"
        )
    from sigmatau.io.read.frame import from_frame

    try:
        return from_frame(source)
    except OptionError as error:
        raise OptionError(f"{error.text}; arguments of sigmatau.from_frame", option=error.option) from None


def choose(state: State) -> State:
    """Select the part that the options state, and load it if it is analysed as a whole."""
    options, findings = state.options, list(state.findings)
    ReadOffAt(options.read_off_at).check(channel for stream in state.record.streams for channel in stream.channels)
    record, excluded = state.record, list[Exclusion]()
    if options.leave_out is not None:
        before = record
        record, stretches = leave_out(record, options.leave_out)
        findings += stretches
        excluded += excluded_from(before, record, "left_out")
    if options.window is not None:
        before = record
        record, chosen = choose_window(record, options.window)
        findings += chosen
        excluded += excluded_from(before, record, "window")
    if options.long != "strided":
        record = replace(record, streams=converted(loaded(record.streams, options.threads)))
    return replace(state, record=record, findings=tuple(findings), excluded=tuple(excluded))


def check(state: State) -> State:
    """Test whether the record is at rest, select its part at rest, and check the samples."""
    options = state.options
    resting = rest(state.record, threads=options.threads)
    record, motion = at_rest_only(state.record, resting, assumed=options.at_rest)
    bounded = frozenset(stream.name for stream in record.streams if _in_bounded_memory(stream, options))
    moved = excluded_from(state.record, record, "partly_at_rest")
    state = replace(
        state, record=record, rest=resting, bounded=bounded, findings=(*state.findings, *motion),
        excluded=(*state.excluded, *moved),
    )  # fmt: skip
    if state.moves and not resting.unit_in_doubt:
        return state
    examined = examine(
        record,
        bandwidth=options.bandwidth,
        looked_at=LOOKED_AT_BOUNDED if bounded else LOOKED_AT,
        keep=options.kept_causes,
        keep_spans=options.kept_spans,
        untouched=bounded,
        threads=options.threads,
    )
    if state.moves:
        return replace(state, findings=(*state.findings, *filter(_doubts_unit, examined.findings)))
    return replace(state, examined=examined, findings=(*state.findings, *examined.findings))


def mask(state: State) -> State:
    """Mark the samples of disturbances as missing."""
    if state.examined is None:
        return state
    excluded = (*state.excluded, *state.examined.excluded)
    return replace(state, record=state.examined.record, excluded=excluded, examined=None)


def curves(state: State) -> State:
    """Compute the curves. Raises `DataError` if no channel has a curve."""
    options = state.options
    computed, fitted_on, without_curve = compute_curves(
        state.record, taus=options.taus, overlap=options.overlap, counting=options.counting, long=options.long,
        bounded=state.bounded, threads=options.threads,
    )  # fmt: skip
    findings = (*state.findings, *without_curve)
    if not computed:
        lost = [finding for finding in findings if finding.code in WITHOUT_CURVE]
        reasons = (f"{', '.join(finding.channels)}: {finding.message}" for finding in lost)
        raise DataError("no channel is left to analyse: " + "; ".join(reasons))
    return replace(state, curves=computed, fitted_on=computed | fitted_on, findings=findings)


def fit(state: State) -> State:
    """Fit the coefficients of each channel, and compute the degrees of freedom of its curve; for the read-off, fit only
    the models.
    """
    options, record, findings = state.options, state.record, state.findings
    if state.moves:
        return state
    method: Literal["likelihood", "gls"] = "gls" if options.method == "gls" else "likelihood"
    coarse = {finding.channel: finding.details for finding in findings if isinstance(finding.details, CoarseResolution)}

    streams = _streams_by_channel(record)

    def fitted(channel: str) -> tuple[NoiseFit, NoiseFit, DeviationCurve]:
        curve, steps = state.curves[channel], coarse.get(channel)
        if steps is not None and steps.summed != 1 and method == "likelihood":
            first = fit_sums(
                record, channel, summed=steps.summed, smallest=MIN_SUMS,
                quantization=steps.added or 0.0, terms=options.terms,
            )  # fmt: skip
        else:
            lattice = resolution.resolution(streams[channel], channel)
            first = fit_channel(
                record, channel, method=method, curve=state.fitted_on[channel], tau_min=options.tau_min,
                terms=options.terms, step=0.0 if lattice is None else lattice.step, threads=options.threads,
            )  # fmt: skip
        if curve.overlap == "full":
            curve = add_degrees_of_freedom(curve, first)
        if steps is not None and steps.rounding != "quantization":
            return first, adjusted(first, partial(rounding_adjustment, step=steps.step, noise=steps.noise)), curve
        return first, first, curve

    fits, final_curves = {}, {}
    results = in_threads(fitted, tuple(state.curves), options.threads)
    if options.method == "read-off":
        return replace(state, models={channel: final for channel, (_, final, _) in results.items()})
    for channel, (first, final, curve) in results.items():
        fits[channel], final_curves[channel] = final, curve
        stream = streams[channel]
        missing = 0.0 if stream.mask is None else float(stream.mask[:, stream.channels.index(channel)].mean())
        findings += tuple(fit_findings(first, start=stream.grid.lead, missing=missing, sample_findings=findings))
    return replace(state, fits=fits, curves=final_curves, findings=findings)


def judge(state: State) -> State:
    """Check the noise against the fits; compute the read-off, the means and the dynamic deviations."""
    options, record, fits, findings = state.options, state.record, state.fits, state.findings
    channels = tuple(state.curves)
    if fits:
        lags = LOOKED_AT_BOUNDED if state.bounded else LOOKED_AT
        fit_faults = check_fits(record, fits, looked_at=lags, findings=findings, threads=options.threads)
        findings = (*without_explained(findings, fits), *fit_faults)
        fits = {
            name: adjusted(fitted, partial(bias, biases=[walk_bias(findings, name)])) for name, fitted in fits.items()
        }
        state = replace(state, fits=fits)
    if not state.moves:
        streams = _streams_by_channel(record)

        def compute_stability(name: str) -> tuple[MeanStability, ...]:
            return mean_stability(streams[name], name, fits.get(name))

        spreads = in_threads(compute_stability, channels, options.threads)
        means = {name: channel_mean(streams[name], name, fits.get(name)) for name in channels}
        state = replace(
            state,
            read_off=read_off_curves(
                state.curves, fits or state.models, ReadOffAt(options.read_off_at, force=options.force)
            ),
            mean_stability={name: spread for name, spread in spreads.items() if spread},
            means={name: mean for name, mean in means.items() if mean is not None},
        )
    if options.stability:
        maps, without_map = _maps(record, channels, options.threads)
        state, findings = replace(state, stability=maps), (*findings, *without_map)
    return replace(state, findings=findings)


def assemble(state: State) -> Analysis:
    """Build the result."""
    record = state.record
    return Analysis(
        source=_with_temperature(record),
        findings=ranked(state.findings),
        curves=Curves(state.curves),
        fits=Fits(state.fits),
        read_off=ByChannel(state.read_off),
        grids={stream.name: describe_sampling(stream) for stream in record.streams},
        stability=ByChannel(state.stability),
        mean_stability=state.mean_stability,
        rest=state.rest,
        masks=channel_masks(state.whole, state.excluded),
        means=state.means,
        options=parse_options(stated(state.options)),
        notes={str(name): str(text) for name, text in (state.options.notes or {}).items()},
    )


def _with_temperature(record: Record) -> Provenance:
    """The origin of a record, with the temperature during it."""
    warm = next((stream for stream in record.streams if stream.quantity == "temperature"), None)
    if warm is None:
        return record.provenance
    total, count, low, high = 0.0, 0, math.inf, -math.inf
    for chunk in warm.chunks():
        degrees = chunk[np.isfinite(chunk)]
        if len(degrees):
            total, count = total + float(degrees.sum()), count + len(degrees)
            low, high = min(low, float(degrees.min())), max(high, float(degrees.max()))
    if not count:
        return record.provenance
    return replace(record.provenance, temperature=TemperatureRange(mean=total / count, low=low, high=high))


def read_off_curves(
    curves: Mapping[str, DeviationCurve], fits: Mapping[str, NoiseFit], lines: ReadOffAt
) -> dict[str, ReadOff]:
    """Read the coefficients off each curve."""
    return {channel: lines.read(curve, fits.get(channel)) for channel, curve in curves.items()}


def add_degrees_of_freedom(curve: DeviationCurve, fitted: NoiseFit) -> DeviationCurve:
    """Add degrees of freedom from the model to a curve, in proportion to the remaining pairs if samples are missing."""
    edf = fitted.degrees_of_freedom(m=curve.m)
    return replace(curve, edf=None if edf is None else scale_by_pairs(curve, edf))


def _streams_by_channel(record: Record) -> dict[str, Stream]:
    return {channel: stream for stream in record.streams for channel in stream.channels}


def _doubts_unit(finding: Finding) -> bool:
    """Whether a finding reports a wrong unit, unless the file states the unit."""
    return isinstance(finding.details, ImplausibleUnit) and not finding.details.by_file


def _in_bounded_memory(stream: Stream, options: AnalysisOptions) -> bool:
    """Whether a stream is analysed in bounded memory: on request, or because it does not fit in memory."""
    if options.long == "auto":
        return stream.mask is None and not memory.fits(stream, options.threads)
    return options.long == "strided"


def _maps(
    record: Record, channels: tuple[str, ...], threads: int | None
) -> tuple[dict[str, DynamicAllan], list[Finding]]:
    """Compute the dynamic Allan deviations, and report channels that are too short."""
    from sigmatau.estimators.stability import MIN_SAMPLES_OF_MAP, dynamic_allan

    maps: dict[str, DynamicAllan] = {}
    without_map = []
    for channel in channels:
        samples = record.stream_of(channel).grid.n
        if samples >= MIN_SAMPLES_OF_MAP:
            maps[channel] = dynamic_allan(record, channel, threads=threads)
        else:
            no_map = NoMap(samples=samples, needed=MIN_SAMPLES_OF_MAP)
            without_map.append(Finding(details=no_map, severity="info", channels=(channel,)))
    return maps, without_map
