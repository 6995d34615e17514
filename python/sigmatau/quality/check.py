"""All checks of the samples of a record together.

`check` uses the samples and their spectra and needs no fit; `check_fits` runs the checks that need a fit.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from sigmatau.arrays import Bools, runs
from sigmatau.errors import OptionError
from sigmatau.findings.curves import CheckedInPart
from sigmatau.findings.finding import DISTURBANCES, Finding, Span
from sigmatau.findings.reasons import CoarseCounts
from sigmatau.findings.units import ImplausibleUnit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.quality.beyond_class import beyond_class
from sigmatau.quality.drift.stationarity import non_stationary
from sigmatau.quality.drift.without_drifts import steps_beside_drifts, subtract_drifts
from sigmatau.quality.facts import forget, in_threads, keep_facts
from sigmatau.quality.fit_findings import other_axes_disturbed
from sigmatau.quality.motion.shocks_and_steps import between_steps
from sigmatau.quality.options import Bandwidth
from sigmatau.quality.samples.check import check as check_samples
from sigmatau.quality.samples.disturbances import CAUSES, disturbances, disturbances_outside, masked_by, without
from sigmatau.quality.samples.masking import bridged, mask_from_spans, masked
from sigmatau.quality.selection.exclusion import from_the_start
from sigmatau.quality.spectrum.aliasing import aliasing
from sigmatau.quality.spectrum.axis_correlation import cross_axis
from sigmatau.record.mask import Exclusion, exclusions
from sigmatau.record.record import Record, need_record
from sigmatau.record.streams import Stream

_PARTS = 2  # a bandwidth has a frequency and an order

LOOKED_AT = 1 << 24
"""Number of samples of a stream that are checked: 36 hours at 128 Hz, a few hundred megabytes per channel."""

LOOKED_AT_BOUNDED = 1 << 20
"""Number of samples of a stream that are checked if the record does not fit in memory."""


# Samples of the shortest stream that is checked. [samples] Judgement: the distributions of the checks are not known for
# fewer samples.
_MIN_SAMPLES = 64
# Largest size of a sample. [SI unit] Derived: its fourth power is within the range of double precision.
LARGEST = 1e60
# Smallest range of the samples of a channel. [SI unit] Derived: see `LARGEST`.
_SMALLEST = 1e-60


def check(record: Record, *, bandwidth: Bandwidth | None = None, looked_at: int = LOOKED_AT) -> tuple[Finding, ...]:
    """Find faults of a record in its samples and spectra, and their effects on the coefficients.

    Parameters
    ----------
    record : Record
        Samples may be missing.
    bandwidth : mapping of str to (float, int or None), optional
        Bandwidth of the sensors from their datasheets, by stream (``{"gyro": (30.0, 1)}``) or channel. Aliasing by
        sampling without an anti-alias filter is then checked too. [Hz]
    looked_at : int
        Number of samples that are checked, from the beginning of each stream; a finding reports longer streams. The
        memory needed is a few times that of these samples of one channel.

    Returns
    -------
    tuple of Finding
        Findings of the checks, without those of the record itself.

    Raises
    ------
    OptionError
        For a bandwidth that is not positive or is of an unknown stream, and if `looked_at` is below 64 samples.

    See Also
    --------
    inspect : the content of a file, and the findings about it.
    analyze : checks the record too, and leaves disturbances out.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> rates = 1e-3 * np.random.default_rng(1).standard_normal(10_000)
    >>> [finding.code for finding in st.check(st.Record.from_arrays(rate=100, gyro_x=np.round(rates, 3)))]
    ['coarse_resolution']
    """
    need_record(record)
    if isinstance(looked_at, bool) or not isinstance(looked_at, int | np.integer) or looked_at < _MIN_SAMPLES:
        raise OptionError(
            f"{{option}} must be a whole number of samples from {_MIN_SAMPLES} on, not {looked_at!r}",
            option="looked_at",
        )
    return examine(from_the_start(record), bandwidth=bandwidth, looked_at=looked_at).findings


@frozen(eq=False)
class Examination:
    """Result of `examine`: the record without its disturbances, the findings, and the samples excluded for each."""

    record: Record
    findings: tuple[Finding, ...]
    excluded: tuple[Exclusion, ...]


@keep_facts()
def examine(
    record: Record,
    *,
    bandwidth: Bandwidth | None = None,
    looked_at: int = LOOKED_AT,
    keep: Sequence[str] = (),
    keep_spans: Sequence[Span] = (),
    untouched: Collection[str] = (),
    threads: int | None = None,
) -> Examination:
    """Exclude the disturbances of a record, except for causes to `keep` and times to keep, and add the findings of `check`.

    The streams named in `untouched` keep all their samples.
    """
    stated = _by_stream(record, bandwidth or {})
    usable = {
        stream.name: part
        for stream in record.streams
        if stream.quantity != "temperature" and (part := _usable(_beginning(stream, looked_at))) is not None
    }
    disturbed_spans = in_threads(
        lambda name: _shared_disturbances(usable[name], keep, keep_spans), tuple(usable), threads
    )
    elsewhere = {name: _disturbed_elsewhere(part, disturbed_spans) for name, part in usable.items()}
    undisturbed = {
        name: masked(part, np.logical_or.reduce([*elsewhere[name].values()])) if elsewhere[name] else part
        for name, part in usable.items()
    }
    by_stream = in_threads(lambda name: _check_stream(undisturbed[name], stated.get(name)), tuple(usable), threads)
    streams, findings, excluded = [], list[Finding](), list[Exclusion]()
    for stream in record.streams:
        part = undisturbed.get(stream.name)
        if part is None:
            streams.append(stream)
            continue
        causes = tuple(CAUSES) if stream.name in untouched else keep
        without_it, findings_left_out = without(part, keep=causes, spans=keep_spans)
        if stream.name not in untouched:
            for disturbance in disturbances_outside(part, keep_spans):
                mask = None if disturbance.cause in keep else disturbance.mask
                excluded += exclusions(part, mask, disturbance.finding.code)
            for reason, samples in elsewhere[stream.name].items():
                excluded += exclusions(part, np.repeat(samples[:, None], len(part.channels), axis=1), reason)
            stream = _with_missing(stream, without_it)
        streams.append(stream)
        findings += [*findings_left_out, *(_trusting_file(finding, record) for finding in by_stream[stream.name])]
        if part.grid.n < stream.grid.n:
            findings.append(_checked_in_part(stream, part))
    return Examination(
        record=replace(record, streams=tuple(streams)), findings=tuple(findings), excluded=tuple(excluded)
    )


def _trusting_file(finding: Finding, record: Record) -> Finding:
    """Remove a guessed unit from a finding about a gyro whose unit the file states. The size and the reason remain."""
    details = finding.details
    if not isinstance(details, ImplausibleUnit) or details.evidence == "gravity":
        return finding
    if not set(finding.channels) <= set(record.provenance.units_stated):
        return finding
    return replace(finding, details=replace(details, likely="", by_file=True), factors=())


_SHARED_CAUSES = ("start", "shocks")  # causes that disturb all inertial sensors of a record at once


def _shared_disturbances(stream: Stream, keep: Sequence[str], keep_spans: Sequence[Span]) -> dict[str, list[Span]]:
    """Times of disturbances of a sensor that affect all sensors of the record, by code, in the clock of the log. [s]"""
    tau0, start = stream.grid.tau0, stream.grid.start
    causes = [cause for cause in _SHARED_CAUSES if cause not in keep]
    return {
        disturbance.finding.code: [(start + a * tau0, start + b * tau0) for a, b in runs(disturbance.mask[:, 0])]
        for disturbance in disturbances_outside(stream, keep_spans)
        if disturbance.cause in causes and disturbance.mask is not None
    }


def _disturbed_elsewhere(
    stream: Stream, disturbed_spans: Mapping[str, Mapping[str, Sequence[Span]]]
) -> dict[str, Bools]:
    """Samples of an inertial sensor that are disturbed according to other sensors only, by code; shape (n,)."""
    if stream.quantity not in ("angular_rate", "acceleration"):
        return {}
    n, tau0, start = stream.grid.n, stream.grid.tau0, stream.grid.start

    def samples(spans: Iterable[Span]) -> Bools:
        return mask_from_spans(n, [(round((a - start) / tau0), round((b - start) / tau0)) for a, b in spans])

    shown = samples(span for spans in disturbed_spans[stream.name].values() for span in spans)
    elsewhere: dict[str, Bools] = {}
    for name, spans_by_code in disturbed_spans.items():
        for code, spans in spans_by_code.items() if name != stream.name else ():
            elsewhere[code] = elsewhere.get(code, False) | (samples(spans) & ~shown)
    return {code: mask for code, mask in elsewhere.items() if mask.any()}


def _with_missing(stream: Stream, part: Stream) -> Stream:
    """Mark samples of a stream as missing if they are missing in `part`, the beginning of some of its channels."""
    if part.mask is None:
        return stream
    mask = np.zeros((stream.grid.n, len(stream.channels)), dtype=bool)
    mask[: part.grid.n, [stream.channels.index(channel) for channel in part.channels]] = part.mask
    return masked(stream, mask)


def check_fits(
    record: Record,
    fits: Mapping[str, NoiseFit],
    *,
    looked_at: int = LOOKED_AT,
    findings: Sequence[Finding] | None = None,
    threads: int | None = None,
) -> tuple[Finding, ...]:
    """Find faults of a record that only a fit shows: noise that changes, and steps of the mean in a drift.

    For findings of the fit itself, see `sigmatau.quality.fit_findings`.

    Parameters
    ----------
    record : Record
    fits : mapping of str to NoiseFit
        By channel.
    looked_at : int
        See `check`.
    findings : sequence of Finding, optional
        Findings of `check`. Stationarity is tested on the stretches without a disturbance. Default: disturbances are
        searched for.

    Returns
    -------
    tuple of Finding
    """
    sample_findings = tuple(findings or ())
    disturbed = findings is None or any(f.code in DISTURBANCES and not f.left_out for f in sample_findings)
    streams = {
        stream.name: stream
        for stream in record.streams
        if stream.quantity != "temperature"
        and stream.grid.n >= _MIN_SAMPLES
        and not fits.keys().isdisjoint(stream.channels)
    }

    def check_stream(name: str) -> list[Finding]:
        stream = _beginning(streams[name], looked_at)
        fitted = {channel: fits[channel] for channel in stream.channels if channel in fits}
        flat = subtract_drifts(record, stream, fitted)
        still = without(flat)[0] if disturbed else flat
        steps = steps_beside_drifts(still, fitted) if flat is not stream else []
        between = between_steps(still, [*sample_findings, *steps])
        steady = bridged(between)
        changing = non_stationary(steady, {c: fit for c, fit in fitted.items() if not _hidden_by_rounding(fit)})
        loud = (finding for fit in fitted.values() for finding in beyond_class(fit, findings=sample_findings))
        stream_findings = [*steps, *changing, *loud, *other_axes_disturbed(fitted.values())]
        if steady is not between:
            forget(steady)
        return stream_findings

    by_stream = in_threads(check_stream, tuple(streams), threads)
    return tuple(finding for stream_findings in by_stream.values() for finding in stream_findings)


def _hidden_by_rounding(fitted: NoiseFit) -> bool:
    """Whether counts of an angle hide the noise: the number of counts then varies with the position of the angle within a
    step.
    """
    return any(isinstance(reason, CoarseCounts) and reason.hidden for reason in fitted.reasons)


def _check_stream(stream: Stream, bandwidth: Bandwidth | None) -> list[Finding]:
    findings = check_samples(stream)
    undisturbed = masked_by(stream, disturbances(stream))
    still = bridged(undisturbed)
    for name, stated in (bandwidth or {}).items():
        findings += aliasing(still if name == stream.name else replace(still.only(name), name=name), stated)
    findings += cross_axis(bridged(between_steps(still, findings)))
    if still is not undisturbed:
        forget(still)
    return findings


def _beginning(stream: Stream, samples: int) -> Stream:
    return stream if stream.grid.n <= samples else stream.cut(0, samples)


def _checked_in_part(stream: Stream, part: Stream) -> Finding:
    details = CheckedInPart(checked=part.grid.n, samples=stream.grid.n, duration=part.grid.duration)
    return Finding(details=details, severity="info", channels=(stream.name,))


def _usable(stream: Stream) -> Stream | None:
    """The channels that can be checked: with enough samples, not constant, and within the range of double precision."""
    if stream.grid.n < _MIN_SAMPLES:
        return None
    channels = []
    for channel in stream.channels:
        x = stream.column(channel)
        low, high = np.fmin.reduce(x), np.fmax.reduce(x)
        if -LARGEST < low < high < LARGEST and high - low > _SMALLEST:
            channels.append(channel)
    return stream.of(channels) if channels else None


def _by_stream(record: Record, bandwidth: Bandwidth) -> dict[str, dict[str, tuple[float, int | None]]]:
    """Group the bandwidths of streams and channels by stream."""
    names = {stream.name: stream.name for stream in record.streams}
    names |= {channel: stream.name for stream in record.streams for channel in stream.channels}
    by_stream: dict[str, dict[str, tuple[float, int | None]]] = {}
    for name, value in bandwidth.items():
        if name not in names:
            raise OptionError(
                f"{{option}} names {name!r}; the record has {', '.join(dict.fromkeys(names.values()))}",
                option="bandwidth",
            )
        if not (isinstance(value, tuple | list) and len(value) == _PARTS):
            raise OptionError(
                f"{{option}} of {name} must be (hertz, order or None), e.g. (30.0, None), not {value!r}",
                option="bandwidth",
            )
        by_stream.setdefault(names[name], {})[name] = (value[0], value[1])
    return by_stream
