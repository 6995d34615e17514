"""Interpolation: samples on straight lines between other samples."""

from __future__ import annotations

import math

import numpy as np

from sigmatau.arrays import median
from sigmatau.findings.finding import Finding
from sigmatau.findings.values import FilledOutages, FilledSamples, Interpolated, Upsampled
from sigmatau.frozen import frozen
from sigmatau.quality.samples.common import SIGMAS, mask_of_runs, spans_of_runs, take_samples
from sigmatau.quality.samples.masking import MaskedFinding
from sigmatau.quality.samples.repeated_samples import runs_of_places
from sigmatau.quality.samples.straight_lines import TOO_COARSE, Filled, filled, tolerance
from sigmatau.record.streams import Stream

# Factor of the random walk, or of 1/σ at one sample, above which filled samples are a warning. [1] Judgement: the usual
# interval is 5 %.
_WARN_FACTOR = 1.02
# Smallest share of second differences that are zero, beyond three times that by chance. [1] Judgement: a resampled
# record has far more.
_MIN_SHARE = 0.05
# Share above which a channel is a straight line instead of interpolated. [1] Judgement: no sensor has 1/200 of the rate
# of its log.
_MAX_SHARE = 0.995
# Averaging time from which σ is correct. [samples of the sensor] Judgement: interpolation changes σ within a few
# samples.
_CORRECT_FROM = 8
# Number of samples used to judge a channel. [samples] Judgement: a share of 5 % then has an error of 0.1 %.
_EXAMINED = 1 << 15


@frozen
class Upsampling:
    """Interpolation of a channel."""

    factor: float  # rate of the log over the rate of the sensor
    aligned: bool  # whether the sensor's samples are among those of the log
    share: float  # share of the samples that are on the line through their neighbours

    @property
    def shortest(self) -> float:
        """σ(τ₀) over that of white noise with the same σ at long τ.

        The slopes s between independent samples of variance v, r apart, have variance 2v/r² and correlation −1/2. If the
        samples are not aligned, a share 1/r of the changes is divided between two slopes: σ²(τ₀) = (v/r²)(1 − 1/(2r)); if
        they are aligned it is v/r². White noise has v·r.
        """
        r = self.factor
        return math.sqrt((1.0 if self.aligned else 1 - 1 / (2 * r)) / r**3)


def upsampling(stream: Stream, channel: str) -> Upsampling | None:
    """Detect linear interpolation of a channel from second differences that are zero to rounding; None without
    interpolation.

    It is not detected for a ratio of rates below 2 without aligned samples, because no three samples are then on a line.
    """
    x = take_samples(stream, channel, count=_EXAMINED)
    zero = tolerance(stream, channel, x)
    if zero is None:
        return None
    first, second = np.diff(x), np.diff(x, n=2)
    is_present = np.isfinite(second)
    count = int(np.count_nonzero(is_present))
    # Counts with an added slow bias have no common step, but their changes are zero as often as those of lines.
    chance = max(zero.chance, float(np.count_nonzero(np.abs(first) <= zero.largest)) / count)
    if chance > TOO_COARSE:
        return None
    straight = (np.abs(second) <= zero.largest) & (np.abs(first[1:]) > zero.largest / 2)
    share = float(np.count_nonzero(straight)) / count
    if not _MIN_SHARE + 3 * chance + SIGMAS * math.sqrt(chance / count) < share < _MAX_SHARE:
        return None
    knots = np.flatnonzero(is_present & ~straight)
    runs = np.diff(np.concatenate(([-1], np.flatnonzero(np.diff(knots) > 1), [len(knots) - 1])))
    # A sample of the sensor bends the line at one sample of the log if both coincide, otherwise at two.
    samples = int(np.sum((runs + 1) // 2))
    return Upsampling(factor=count / samples, aligned=median(runs) < 1.5, share=share)


def filled_outages(stream: Stream) -> list[MaskedFinding]:
    """Report gaps that were filled with straight lines. At most one finding."""
    gaps = {c: f.outages for c in stream.channels if (f := filled(stream, c)) is not None and len(f.outages[0])}
    if not gaps:
        return []
    empty = np.empty(0, dtype=np.int64)
    masks = [mask_of_runs(stream.grid.n, *gaps.get(channel, (empty, empty))) for channel in stream.channels]
    strongest = max(gaps, key=lambda c: int(gaps[c][1].max()))
    first, lengths = gaps[strongest]
    spans, more_spans = spans_of_runs(stream, *runs_of_places(np.flatnonzero(np.any(masks, axis=0))))
    k, grid = int(np.argmax(lengths)), stream.grid
    outages = FilledOutages(count=len(first), start=grid.time(int(first[k])), longest=int(lengths[k]) * grid.tau0)
    finding = Finding(
        details=Interpolated(strongest=strongest, share=float(lengths.sum()) / stream.grid.n, outages=outages),
        severity="warning",
        channels=tuple(gaps),
        spans=spans,
        more_spans=more_spans,
        size=outages.longest,
        unit="s",
    )
    return [(finding, np.stack(masks, axis=1))]


def interpolated(stream: Stream) -> list[Finding]:
    """Report channels with linear interpolation: of all samples, from a lower rate, or in place of lost samples. One
    finding.

    If all samples come from a lower rate, `factors` is the ratio of the random walk read at one sample to that of the
    sensor; at long τ σ is correct.
    """
    gaps = {c: f for c in stream.channels if (f := filled(stream, c)) is not None}
    upsampled = {c: u for c in stream.channels if c not in gaps and (u := upsampling(stream, c)) is not None}
    if upsampled:  # an interpolation of all samples has priority over local ones
        return [_from_lower_rate(stream, upsampled)]
    singles = {c: f for c, f in gaps.items() if f.singles}
    return [_in_place_of_lost(stream, singles)] if singles else []


def _from_lower_rate(stream: Stream, upsampled: dict[str, Upsampling]) -> Finding:
    strongest, first = next(iter(upsampled.items()))
    rate = stream.grid.rate / first.factor
    how = Upsampled(
        sensor_rate=rate,
        log_rate=stream.grid.rate,
        aligned=first.aligned,
        sigma_one_sample=first.shortest,
        right_from=_CORRECT_FROM / rate,
    )
    details = Interpolated(strongest=strongest, share=first.share, upsampled=how)
    factors = (("random_walk", first.shortest),)
    return Finding(details=details, severity="warning", channels=tuple(upsampled), size=first.factor, factors=factors)


def _in_place_of_lost(stream: Stream, gaps: dict[str, Filled]) -> Finding:
    strongest = max(gaps, key=lambda c: gaps[c].singles)
    gap = gaps[strongest]
    spans, more_spans = spans_of_runs(stream, gap.first, gap.lengths)
    singles = FilledSamples(random_walk=gap.random_walk, sigma_one_sample=gap.short)
    return Finding(
        details=Interpolated(strongest=strongest, share=gap.singles, singles=singles),
        severity="warning" if max(gap.random_walk, 1 / gap.short) > _WARN_FACTOR else "info",
        channels=tuple(gaps),
        spans=spans,
        more_spans=more_spans,
        size=gap.singles,
        factors=(("random_walk", gap.random_walk),),
    )
