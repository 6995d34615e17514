"""Drifts with a cause: warm-up after power-on, and temperature.

Both checks are regressions on block means with the noise estimated at the same time (`sigmatau.quality.drift.block_means`).
An ordinary correlation would find a drift in nearly every record, because a rate random walk or flicker noise looks like a
drift and correlates with any slow signal by chance. A ramp is always among the regressors: it is a term of the noise model,
and the straight part of a drift cannot be told from it. The effect on the coefficients is found by a fit without the drift.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.estimators.allan import channel_curve
from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.drift import LateDrift, TemperatureDrift, WarmUp
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.quality.drift.block_means import BlockMeans, Problem, Regression, block_means
from sigmatau.quality.drift.block_temperature import temperature_of
from sigmatau.quality.effects import Change, compared, factors, severity, vanished
from sigmatau.quality.samples.motion import LevelChange, level_changes, summary
from sigmatau.quality.samples.shocks_and_steps import level_finding
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream

__all__ = ["from_the_end", "settling", "temperature", "warm_up"]

_TIME_CONSTANTS = 2.0 ** -np.arange(2.0, 7.01, 0.5)
"""Time constants tried, over the record's length: longer ones look like a ramp, shorter ones span only two blocks."""

_REFINEMENT = 2.0 ** np.linspace(-0.75, 0.75, 31)  # factors on the best of `_TIME_CONSTANTS` that are tried next

# A warm-up needs both: Student's ratio with the noise estimated beside the drift has the power, but heavy tails where the
# rate random walk is poorly known; with the noise estimated without the drift the ratio is never much too large. Of 20,793
# clean channels of any mixture of the five terms, p < 1e-4 and a ratio above 3 for any time constant, from either end, hold
# in 0.05 ± 0.02 %; p < 1e-3 in 0.36 %.
MAX_P_SETTLING = 1e-4  # largest p-value of a warm-up or late drift, with the noise estimated beside it
MIN_RATIO_SETTLING = 3.0  # smallest Student's ratio of a warm-up or late drift, with the noise estimated without it

TEMPERATURE_THRESHOLDS = ((2.5, 1e-5), (3.0, 1e-3), (3.5, 1e-2))
"""Pairs of a smallest ratio and a largest p-value, one of which a temperature drift must meet.

A temperature that walks makes a walk of the rate; then few slow modes determine the noise, and p alone is weak. Of 12,000
clean channels of six mixtures, each with a walk, a warming and a cycle of the temperature, 4 of 36,000 pass (with a ratio of
3 and p < 1e-3).
"""

_MOST_UNKNOWN = 0.25  # share of the blocks without a temperature; the check is left out if there are more
_MAX_ITERATIONS = 4  # of the search for drift and steps of the level beside each other

_PREFER_END = 1.1
"""Ratio of the ratios from which on a drift is a late drift: one that bends the whole record shows at both ends."""

SETTLED_TIME_CONSTANTS = 5.0  # time constants after which a warm-up is over: 0.7 % of it is left
_SMALLEST_SPREAD = 1e-100  # spreads outside this and its inverse have squares that overflow or vanish


def warm_up(
    stream: Stream,
    fits: Mapping[str, NoiseFit],
    *,
    max_p: float = MAX_P_SETTLING,
    min_ratio: float = MIN_RATIO_SETTLING,
) -> list[Finding]:
    """Exponential drifts at the beginning or the end of the record, beside level, ramp and noise.

    ``"warm_up"``, or ``"late_drift"`` if the drift is clearer at the end; at most one for each channel. A warning if it
    changes a coefficient by more than 10 %. With steps of the level beside the drift, ``"not_static"`` for these.

    Parameters
    ----------
    stream : Stream
    fits : mapping of str to NoiseFit
        Fits to the whole record, for the effect only; channels without a fit are checked too.
    max_p, min_ratio : float
        Thresholds, see `MAX_P_SETTLING` and `MIN_RATIO_SETTLING`.
    """
    findings = []
    for channel in stream.channels:
        data = block_means(stream, channel)
        if data is None or _constant(data):
            continue
        found, steps = _beside_steps(stream, channel, data, max_p, min_ratio)
        if found is None:
            continue
        curve = found.curve(stream)
        levels = _levels(stream.grid.n, steps)
        changes = _changes(stream, channel, curve + levels, fits.get(channel))
        findings.append(_exponential_finding(stream, channel, found, changes, with_steps=bool(steps)))
        if steps:  # they are told beside what would hide them
            still = stream.only(channel).with_rates([stream.column(channel) - curve])
            findings.append(level_finding(still, channel, steps, beside_drift=True))
    return findings


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drift:
    """An exponential from the beginning on, or towards the end."""

    time: float
    regression: Regression
    at_the_end: bool

    def curve(self, stream: Stream) -> Floats:
        seconds = np.arange(stream.grid.n) * stream.grid.tau0
        exponent = -(seconds[::-1] if self.at_the_end else seconds) / self.time
        return np.asarray(-self.regression.value * np.exp(exponent))


def _beside_steps(
    stream: Stream, channel: str, data: BlockMeans, max_p: float, min_ratio: float
) -> tuple[_Drift | None, list[LevelChange]]:
    """The drift, and the steps of the level that are left without it: each can hide the other, or look like it."""
    found = _drift(stream, data, [], max_p, min_ratio)
    if not level_changes(stream, summary(stream, channel)):
        return found, []
    known: list[LevelChange] = []
    for _ in range(_MAX_ITERATIONS):
        one = stream.only(channel)
        if found is not None:
            one = one.with_rates([one.column(channel) - found.curve(stream)])
        steps = [step for step in level_changes(one, summary(one, channel)) if not step.gradual]
        if found is not None:  # where the drift is steep, its difference from an exponential may look like a step
            steep, n = found.time / stream.grid.tau0, stream.grid.n
            steps = [s for s in steps if (n - s.sample if found.at_the_end else s.sample) > steep]
        if [s.sample for s in steps] == [s.sample for s in known]:
            break
        known = steps
        found = _drift(stream, data, [(s.sample - data.first) // data.length for s in steps], max_p, min_ratio)
    return (None, []) if found is None else (found, known)


def _levels(n: int, steps: Sequence[LevelChange]) -> Floats:
    """Sum of all steps of the level, shape (n,)."""
    levels = np.zeros(n)
    for step in steps:
        levels[step.sample :] += step.size
    return levels


def _drift(stream: Stream, data: BlockMeans, steps: Sequence[int], max_p: float, min_ratio: float) -> _Drift | None:
    """The drift that block means show from either end, beside steps of the level in some blocks."""
    last = len(data.means) - 1
    reversed_data, reversed_steps = from_the_end(data, stream.grid.n), [last - k for k in steps]
    begins = settling(data, steps=steps, max_p=max_p, min_ratio=min_ratio)
    ends = settling(reversed_data, steps=reversed_steps, max_p=max_p, min_ratio=min_ratio)
    if ends is not None and (begins is None or _ratio(ends[1]) > _PREFER_END * _ratio(begins[1])):
        return _Drift(time=ends[0], regression=ends[1], at_the_end=True)
    return None if begins is None else _Drift(time=begins[0], regression=begins[1], at_the_end=False)


def from_the_end(data: BlockMeans, n: int) -> BlockMeans:
    """The blocks with time reversed from the last of `n` samples; the law of the noise is the same."""
    first = n - data.first - len(data.means) * data.length
    return replace(data, means=data.means[::-1], first=first)


def _ratio(regression: Regression) -> float:
    return abs(regression.value) / regression.error


def settling(
    data: BlockMeans, *, steps: Sequence[int] = (), max_p: float = MAX_P_SETTLING, min_ratio: float = MIN_RATIO_SETTLING
) -> tuple[float, Regression] | None:
    """Time constant and regression of an exponential in the block means, beside steps in some; None if not significant."""
    edges = data.edges
    times = _TIME_CONSTANTS * (edges[-1] - edges[0])
    try:
        problem = Problem(data, steps=steps)
        curves = np.stack([_settled(edges, time) for time in times], axis=1)
        ratios = np.abs(problem.quick(curves, problem.noise()))
        if not ratios.max() > min_ratio:
            return None
        tried = [problem.solve(curves[:, k]) for k in range(len(times))]
    except (np.linalg.LinAlgError, FloatingPointError):
        return None
    ratios = np.array([_ratio(one) for one in tried])
    k = int(np.argmax(ratios))
    if not tried[k].p_value < max_p:
        return None
    # Refined with the noise of the best time: for given noise the squared ratio is the likelihood ratio.
    refined = times[k] * _REFINEMENT
    curves = np.stack([_settled(edges, time) for time in refined], axis=1)
    time = float(refined[int(np.argmax(np.abs(problem.quick(curves, tried[k].theta))))])
    return time, problem.solve(_settled(edges, time))


def _settled(edges: Floats, time: float) -> Floats:
    """Block means of 1 − exp(−t/T) with t from the first sample of the record."""
    decay = np.exp(-edges / time)
    return np.asarray(1 + time * np.diff(decay) / np.diff(edges))


def _exponential_finding(
    stream: Stream, channel: str, found: _Drift, changes: list[Change], *, with_steps: bool
) -> Finding:
    duration, settled = stream.grid.duration, float(SETTLED_TIME_CONSTANTS * found.time)
    common: dict[str, Any] = {
        "error": float(found.regression.error),
        "time_constant": found.time,
        "duration": duration,
        "with_steps": with_steps,
        **_effect(stream, changes),
    }
    details = LateDrift(**common) if found.at_the_end else WarmUp(settled=settled, **common)
    span = (max(duration - settled, 0.0), duration) if found.at_the_end else (0.0, min(settled, duration))
    size, unit = float(abs(found.regression.value)), stream.unit
    told: dict[str, Any] = {"severity": severity(changes), "factors": factors(changes)}
    return Finding(details=details, channels=(channel,), spans=(span,), size=size, unit=unit, **told)


def _effect(stream: Stream, changes: list[Change]) -> dict[str, Any]:
    """Fields of `sigmatau.findings.kinds.drift.Drift`."""
    known = dict(factors(changes))
    return {
        "quantity": stream.quantity,
        "lower_bounds": tuple(c.term for c in changes if c.at_least and c.term in known),
        "undetermined": tuple(c.term for c in changes if c.term not in known),
    }


def temperature(
    stream: Stream,
    thermometer: Stream,
    fits: Mapping[str, NoiseFit],
    *,
    thresholds: Sequence[tuple[float, float]] = TEMPERATURE_THRESHOLDS,
) -> list[Finding]:
    """Drifts with the temperature, beside level, ramp and noise: at most one ``"temperature_drift"`` for each channel.

    A warning if the drift changes a coefficient by more than 10 %. The temperature is averaged over the sensor's blocks, or
    interpolated if it is sampled more slowly, see `sigmatau.quality.drift.block_temperature`.

    Parameters
    ----------
    stream, thermometer : Stream
        The thermometer has its own grid in the same clock; its channel with the largest range is used. [K or °C]
    fits : mapping of str to NoiseFit
        Fits to the whole record, for the effect.
    thresholds : sequence of (float, float)
        See `TEMPERATURE_THRESHOLDS`.
    """
    findings = []
    for channel in stream.channels:
        data = block_means(stream, channel)
        if data is None or _constant(data):
            continue
        degrees = temperature_of(data.edges + stream.grid.start, thermometer)
        unknown = np.isnan(degrees)
        if unknown.mean() > _MOST_UNKNOWN or not np.ptp(degrees[~unknown]) > 0:
            continue
        degrees = degrees - degrees[~unknown][0]
        try:
            problem = Problem(data, unknown)
            filled = np.where(unknown, 0.0, degrees)
            ratio = abs(float(problem.quick(filled[:, None], problem.noise())[0]))
            if not ratio > min(least for least, _ in thresholds):
                continue
            regression = problem.solve(filled)
        except (np.linalg.LinAlgError, FloatingPointError):
            continue
        if not any(ratio > least and regression.p_value < p for least, p in thresholds):
            continue
        centre = (data.edges[1:] + data.edges[:-1]) / 2
        seconds = (np.arange(stream.grid.n) + 0.5) * stream.grid.tau0
        drift = regression.value * np.interp(seconds, centre[~unknown], degrees[~unknown])
        changes = _changes(stream, channel, drift, fits.get(channel))
        findings.append(_temperature_finding(stream, channel, data, degrees, regression, changes))
    return findings


def _temperature_finding(
    stream: Stream, channel: str, data: BlockMeans, degrees: Floats, regression: Regression, changes: list[Change]
) -> Finding:
    value, half = float(regression.value), regression.half_width()
    known = ~np.isnan(degrees) & ~np.isnan(data.means)
    m = max(int(known.sum()) // 8, 1)
    share = _avar(value * degrees[known], m) / max(_avar(data.means[known], m), 1e-300)
    details = TemperatureDrift(
        rate_unit=stream.unit,
        low=value - half,
        high=value + half,
        temperature_range=float(np.nanmax(degrees) - np.nanmin(degrees)),
        share=min(share, 1.0),
        tau=m * data.step,
        **_effect(stream, changes),
    )
    told: dict[str, Any] = {"severity": severity(changes), "factors": factors(changes)}
    return Finding(details=details, channels=(channel,), size=value, unit=f"{stream.unit}/K", **told)


def _avar(levels: Floats, m: int) -> float:
    """Overlapped Allan variance of block means over m of them."""
    total = np.concatenate([[0.0], np.cumsum(levels - levels[0])])
    z = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
    return float(np.mean(z * z)) / (2 * m * m)


def _changes(stream: Stream, channel: str, drift: Floats, fitted: NoiseFit | None) -> list[Change]:
    """Effect of a drift, shape (n,), on the coefficients: the fit with it against the fit without."""
    one = stream.only(channel)
    without = one.with_rates([one.column(channel) - drift])
    try:
        before, after = _fit(one, channel) if fitted is None else fitted, _fit(without, channel)
    except DataError:
        return []
    return [*compared(before, after), *vanished(before, after)]


def _fit(stream: Stream, channel: str) -> NoiseFit:
    return fit(channel_curve(Record(streams=(stream,)), channel, taus="half"))


def _constant(data: BlockMeans) -> bool:
    """Whether the means change by no more than rounding, or by so much that squares overflow."""
    spread = float(np.nanmax(data.means) - np.nanmin(data.means))
    return not max(_SMALLEST_SPREAD, 1e-12 * float(np.nanmax(np.abs(data.means)))) < spread < 1 / _SMALLEST_SPREAD
