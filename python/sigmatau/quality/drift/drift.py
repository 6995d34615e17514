"""Drift that has a cause: warm-up after power-on, and temperature.

Both are regressions on block means with the noise estimated beside them (`sigmatau.quality.drift.block_means`), because
a rate random
walk or flicker noise looks like a drift and follows any slow signal by chance: an ordinary correlation finds something in
nearly every record. A ramp is always among the regressors: it is a term of the model, and what of a drift is straight cannot
be told from it. What a drift does to the coefficients is found by fitting again without it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.estimators.allan import channel_curve
from sigmatau.findings.finding import Finding
from sigmatau.fitting.fit import fit
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.noise.terms import display_units
from sigmatau.quality.drift.block_means import BlockMeans, Problem, Regression, block_means
from sigmatau.quality.drift.block_temperature import temperature_of
from sigmatau.quality.effects import Change, compared, effect_text, factors, severity, vanished
from sigmatau.quality.samples.motion import LevelChange, level_changes, summary
from sigmatau.quality.samples.shocks_and_steps import level_finding
from sigmatau.record.record import Record
from sigmatau.record.streams import Stream
from sigmatau.results import duration_text, two_digits

__all__ = ["BESIDE", "from_the_end", "settling", "temperature", "warm_up"]

Floats = NDArray[np.float64]

_TIMES = 2.0 ** -np.arange(2.0, 7.01, 0.5)
"""Time constants tried, over the record's length: a longer settling is nearly a ramp, of a shorter one two blocks tell."""

_FINER = 2.0 ** np.linspace(-0.75, 0.75, 31)

# Two conditions, each of which fails where the other is weak. Student's ratio with the noise estimated beside the drift has
# the power, but heavy tails where the rate random walk is hardly known. With noise estimated without the drift the ratio is
# never too large by much. Of 20,793 clean channels of any mixture of the five terms, p < 1e-4 and a ratio above 3 for any
# time constant, from either end, hold in 0.05 ± 0.02 %; p < 1e-3 in 0.36 %.
_P_SETTLING, _LARGEST_OF_ALL = 1e-4, 3.0

# Of one temperature, any of three pairs of a least ratio and a largest p will do: where a temperature that walks makes a
# walk of the rate, few slow modes know the noise beside it, and p alone is weak. Of 12,000 clean channels of six mixtures,
# each beside a walk, a warming and a cycle, 4 of 36,000 pass (a ratio of 3 and p < 1e-3; none the others).
_ENOUGH = ((2.5, 1e-5), (3.0, 1e-3), (3.5, 1e-2))

_ROUNDS = 4  # in which drift and changes of level are found beside each other

BESIDE = "beside this drift"
"""How a finding about changes of level begins that a drift would hide."""

_CLEARLY = 1.1
_SETTLED = 5.0  # time constants, after which 0.7 % of a warm-up is left
_SMALLEST = 1e-100


def warm_up(stream: Stream, fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Whether the rate settles at the beginning of the record, or moves away at its end: an exponential beside level, ramp
    and noise.

    Parameters
    ----------
    stream : Stream
        Missing samples are NaN.
    fits : mapping of str to NoiseFit
        The fits of the channels to the whole record; they are used for the effect alone, and channels without one are
        judged too.

    Returns
    -------
    list of Finding
        ``"warm_up"``, or ``"late_drift"`` where the end of the record shows more than its beginning; at most one a
        channel: a warning if a coefficient is more than 10 % too large because of it.
    """
    findings = []
    for channel in stream.channels:
        data = block_means(stream, channel)
        if data is None or _constant(data):
            continue
        found, steps = _beside_steps(stream, channel, data)
        if found is None:
            continue
        curve = found.curve(stream)
        levels = _levels(stream.grid.n, steps)
        changes = _changes(stream, channel, curve + levels, fits.get(channel))
        finding = _late_finding if found.at_the_end else _warm_up_finding
        findings.append(finding(stream, channel, found.time, found.regression, changes, beside=bool(steps)))
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


def _beside_steps(stream: Stream, channel: str, data: BlockMeans) -> tuple[_Drift | None, list[LevelChange]]:
    """The drift beside the changes of level that are left when it is taken off: each hides the other, or looks like it."""
    found = _drift(stream, data, [])
    if not level_changes(stream, summary(stream, channel)):
        return found, []
    told: list[LevelChange] = []
    for _ in range(_ROUNDS):
        one = stream if found is None else stream.with_rates(_less(stream, channel, found.curve(stream)))
        steps = [step for step in level_changes(one, summary(one, channel)) if not step.gradual]
        if found is not None:  # near its beginning, what no exponential makes of a drift may look like one
            near, n = found.time / stream.grid.tau0, stream.grid.n
            steps = [s for s in steps if (n - s.sample if found.at_the_end else s.sample) > near]
        if [s.sample for s in steps] == [s.sample for s in told]:
            break
        told = steps
        found = _drift(stream, data, [(s.sample - data.first) // data.length for s in steps])
    return (None, []) if found is None else (found, told)


def _less(stream: Stream, channel: str, curve: Floats) -> list[Floats]:
    return [stream.column(each) - (curve if each == channel else 0.0) for each in stream.channels]


def _levels(n: int, steps: Sequence[LevelChange]) -> Floats:
    """All changes of level, shape (n,)."""
    levels = np.zeros(n)
    for step in steps:
        levels[step.sample :] += step.size
    return levels


def _drift(stream: Stream, data: BlockMeans, steps: Sequence[int]) -> _Drift | None:
    """The drift that block means show from either end, beside changes of level in some blocks."""
    last = len(data.means) - 1
    begins = settling(data, steps=steps)
    ends = settling(from_the_end(data, stream.grid.n), steps=[last - k for k in steps])
    # One that bends the rate all over the record may show as both: then the beginning has it.
    if ends is not None and (begins is None or _ratio(ends[1]) > _CLEARLY * _ratio(begins[1])):
        return _Drift(time=ends[0], regression=ends[1], at_the_end=True)
    return None if begins is None else _Drift(time=begins[0], regression=begins[1], at_the_end=False)


def from_the_end(data: BlockMeans, n: int) -> BlockMeans:
    """The same blocks with time running backwards from the last of `n` samples: noise is the same both ways."""
    first = n - data.first - len(data.means) * data.length
    return replace(data, means=data.means[::-1], first=first)


def _ratio(regression: Regression) -> float:
    return abs(regression.value) / regression.error


def settling(data: BlockMeans, *, steps: Sequence[int] = ()) -> tuple[float, Regression] | None:
    """Time constant and regression of the exponential that the block means show; None if they show none.

    The level may change in the blocks `steps`.
    """
    edges = data.edges
    times = _TIMES * (edges[-1] - edges[0])
    try:
        problem = Problem(data, steps=steps)
        curves = np.stack([_settled(edges, time) for time in times], axis=1)
        ratios = np.abs(problem.quick(curves, problem.noise()))
        if not ratios.max() > _LARGEST_OF_ALL:
            return None
        tried = [problem.solve(curves[:, k]) for k in range(len(times))]
    except (np.linalg.LinAlgError, FloatingPointError):
        return None
    ratios = np.array([_ratio(one) for one in tried])
    k = int(np.argmax(ratios))
    if not tried[k].p_value < _P_SETTLING:
        return None
    # Between the grid's times with the noise of the best: for one noise the squared ratio is that of the likelihoods.
    near = times[k] * _FINER
    closer = np.stack([_settled(edges, time) for time in near], axis=1)
    time = float(near[int(np.argmax(np.abs(problem.quick(closer, tried[k].theta))))])
    return time, problem.solve(_settled(edges, time))


def _settled(edges: Floats, time: float) -> Floats:
    """Block means of 1 − exp(−t/T), t from the first sample of the record."""
    decay = np.exp(-edges / time)
    return np.asarray(1 + time * np.diff(decay) / np.diff(edges))


def _warm_up_finding(
    stream: Stream, channel: str, time: float, regression: Regression, changes: list[Change], *, beside: bool
) -> Finding:
    unit, factor = display_units("bias_instability", stream.quantity, stream.unit)[-1]
    size = two_digits(abs(regression.value) / factor)
    error = two_digits(regression.error / factor)
    settled = _SETTLED * time
    after = f"--window {_round_up(settled)}s: leaves it out"
    if settled > stream.grid.duration:
        after = f"record again, from {duration_text(settled)} after power-on; all of this record is within it"
    elif settled > stream.grid.duration / 2:
        after = (
            f"record again, from {duration_text(settled)} after power-on; --window {_round_up(settled)}s: leaves little"
        )
    return Finding(
        code="warm_up",
        severity=severity(changes),
        channel=channel,
        message=(
            f"the {_what(stream)} settles by {size} ± {error} {unit} with a time constant of {duration_text(time)} from the"
            " beginning on, beside ramp and noise"
        ),
        where=f"t = 0 s to {min(settled, stream.grid.duration):.0f} s",
        size=abs(regression.value),
        unit=stream.unit,
        effect=_with_steps(effect_text(changes, stream.quantity, "a warm-up is no noise"), beside=beside),
        changes=factors(changes),
        remedy=after,
    )


def _with_steps(effect: str, *, beside: bool) -> str:
    return f"with the changes of level: {effect}" if beside else effect


def _what(stream: Stream) -> str:
    return {"angular_rate": "rate", "acceleration": "acceleration"}.get(stream.quantity, "signal")


def _late_finding(
    stream: Stream, channel: str, time: float, regression: Regression, changes: list[Change], *, beside: bool
) -> Finding:
    unit, factor = display_units("bias_instability", stream.quantity, stream.unit)[-1]
    size = two_digits(abs(regression.value) / factor)
    error = two_digits(regression.error / factor)
    begins = max(stream.grid.duration - _SETTLED * time, 0.0)
    return Finding(
        code="late_drift",
        severity=severity(changes),
        channel=channel,
        message=(
            f"the {_what(stream)} moves by {size} ± {error} {unit} towards the end of the record, with a time constant of"
            f" {duration_text(time)}, beside ramp and noise"
        ),
        where=f"t = {begins:.0f} s to {stream.grid.duration:.0f} s",
        size=abs(regression.value),
        unit=stream.unit,
        effect=_with_steps(effect_text(changes, stream.quantity, "such a drift is no noise"), beside=beside),
        changes=factors(changes),
        remedy=(
            f"--window :{begins:.0f}s leaves it out; look what changed then"
            if begins > stream.grid.duration / 2
            else "look what changed, and record again"
        ),
    )


def temperature(stream: Stream, thermometer: Stream, fits: Mapping[str, NoiseFit]) -> list[Finding]:
    """Whether the channels follow a temperature, beside level, ramp and noise.

    Parameters
    ----------
    stream : Stream
        Gyros or accelerometers; missing samples are NaN.
    thermometer : Stream
        Of quantity ``"temperature"``, on a grid of its own in the same clock; of several channels the one with the largest
        range is taken. [K or °C]
    fits : mapping of str to NoiseFit
        The fits to the whole record, for the effect.

    Returns
    -------
    list of Finding
        ``"temperature_drift"``, at most one a channel: a warning if a coefficient is more than 10 % too large because of
        it.

    Notes
    -----
    The temperature is averaged over the sensor's blocks, or interpolated where it is sampled more slowly, and freed of the
    thermometer's own steps and noise, see `sigmatau.quality.drift.block_temperature`; the sensor's samples are not touched.
    """
    findings = []
    for channel in stream.channels:
        data = block_means(stream, channel)
        if data is None or _constant(data):
            continue
        degrees = temperature_of(data.edges + stream.grid.start, thermometer)
        unknown = np.isnan(degrees)
        if unknown.mean() > 0.25 or not np.ptp(degrees[~unknown]) > 0:
            continue
        degrees = degrees - degrees[~unknown][0]
        try:
            problem = Problem(data, unknown)
            filled = np.where(unknown, 0.0, degrees)
            ratio = abs(float(problem.quick(filled[:, None], problem.noise())[0]))
            if not ratio > _ENOUGH[0][0]:
                continue
            regression = problem.solve(filled)
        except (np.linalg.LinAlgError, FloatingPointError):
            continue
        if not any(ratio > least and regression.p_value < p for least, p in _ENOUGH):
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
    unit, factor = display_units("bias_instability", stream.quantity, stream.unit)[-1]
    value, half = regression.value / factor, regression.half_width() / factor
    span = float(np.nanmax(degrees) - np.nanmin(degrees))
    there = ~np.isnan(degrees) & ~np.isnan(data.means)
    m = max(int(there.sum()) // 8, 1)
    share = _avar(regression.value * degrees[there], m) / max(_avar(data.means[there], m), 1e-300)
    return Finding(
        code="temperature_drift",
        severity=severity(changes),
        channel=channel,
        message=(
            f"follows the temperature by {value:.3g} [{value - half:.3g}, {value + half:.3g}] {unit} per kelvin, over"
            f" {two_digits(span)} K; that makes {min(share, 1.0):.0%} of the Allan variance at"
            f" τ = {duration_text(m * data.step)}"
        ),
        size=regression.value,
        unit=f"{stream.unit}/K",
        effect=effect_text(changes, stream.quantity, "what follows the temperature is no noise"),
        changes=factors(changes),
        remedy="compensate the temperature before the analysis, or record at a constant one; --window takes a calm part",
    )


def _avar(levels: Floats, m: int) -> float:
    """Overlapped Allan variance of block means over m of them."""
    total = np.concatenate([[0.0], np.cumsum(levels - levels[0])])
    z = total[2 * m :] - 2 * total[m:-m] + total[: -2 * m]
    return float(np.mean(z * z)) / (2 * m * m)


def _changes(stream: Stream, channel: str, drift: Floats, fitted: NoiseFit | None) -> list[Change]:
    """What a drift, shape (n,), does to the coefficients: the fit with it against the fit without."""
    one = stream.only(channel)
    still = one.with_rates([one.column(channel) - drift])
    try:
        before, after = _fit(one, channel) if fitted is None else fitted, _fit(still, channel)
    except DataError:
        return []
    return [*compared(before, after), *vanished(before, after)]


def _fit(stream: Stream, channel: str) -> NoiseFit:
    return fit(channel_curve(Record(streams=(stream,)), channel, taus="half"))


def _constant(data: BlockMeans) -> bool:
    """Nothing to judge: no change beyond rounding, or one whose square is no number."""
    spread = float(np.nanmax(data.means) - np.nanmin(data.means))
    return not max(_SMALLEST, 1e-12 * float(np.nanmax(np.abs(data.means)))) < spread < 1 / _SMALLEST


def _round_up(seconds: float) -> int:
    """To two digits: a window is no number to be exact about."""
    unit = 10 ** max(int(np.floor(np.log10(seconds))) - 1, 0)
    return int(np.ceil(seconds / unit) * unit)
