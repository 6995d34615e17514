"""What a joint fit says of its runs: their levels, their ramps and lines, and whether each belongs to the others."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from sigmatau._native.distributions import chi2_above, normal_quantile, student_below, student_quantile
from sigmatau._native.likelihood import Joint, Level
from sigmatau.fitting.joint_fit import RunOfJoint, Spread
from sigmatau.fitting.noise_fit import FittedTerm, Interval, NoiseFit, Sinusoid

_BISECTIONS = 60
_EXPLAINS = 0.5  # share of what a spectrum of its own gains, from which one term is the reason
_LEAST_RUNS = 4  # with which a level is compared with those of the others
_RAMP = 3.3  # standard errors from which the mean ramp counts, as in one run


def spreads_of(found: Joint) -> dict[str, Spread]:
    """How the terms that are not common differ from run to run, of those that the runs show."""
    shown = {name: one for name, one in found.levels.items() if _observed(found, name)}
    return {name: Spread(relative=0.5 * one.spread, p_value=one.p_value) for name, one in shown.items()}


def of_run(found: Joint, k: int, name: str, alone: NoiseFit, fitted: NoiseFit, *, level: float) -> RunOfJoint:
    """What a joint fit says of one run.

    Every test asks whether the data have a value of this run for itself: of each common term, of all that is common
    together, and of each level among those of the other runs. The p-value is the smallest, times the number of tests
    of all runs.
    """
    quantile = -float(normal_quantile((1 - level) / 2))
    values, own, tests = {}, {}, {}
    for term, one in found.levels.items():
        theta, error = one.runs[k]
        if not _observed(found, term) or not error < math.inf:
            continue
        factor = math.exp(0.5 * quantile * error)
        value = math.sqrt(theta)
        values[term] = Interval(value=value, low=value / factor, high=value * factor, unit=fitted[term].unit)
        if len(one.runs) >= _LEAST_RUNS:
            tests[term] = _among_others(one, k)
    falls = {}
    for term, (theta, error, _, fall) in found.others[k].terms.items():
        falls[term] = fall
        tests[term] = float(chi2_above(1, fall))
        high = math.sqrt(theta + quantile * error)
        low = math.sqrt(max(theta - quantile * error, 0.0))
        own[term] = Interval(value=math.sqrt(theta), low=low, high=high, unit=fitted[term].unit)
    fall, count = found.others[k].all
    if count:
        tests["all"] = float(chi2_above(count, fall))
    cause = min(tests, key=tests.__getitem__, default="all")
    p_value = min(len(tests) * len(found.others) * tests.get(cause, 1.0), 1.0)
    if cause == "all" and falls and (most := max(falls, key=falls.__getitem__)) and falls[most] > _EXPLAINS * fall:
        cause = most
    return RunOfJoint(
        name=name, fit=alone, values=values, own=own, p_value=p_value, cause=cause, factor=_factor(found, k, cause)
    )


def _observed(found: Joint, term: str) -> bool:
    return term in found.outcome.terms and found.outcome.terms[term].observed


def _among_others(level: Level, k: int) -> float:
    """P-value of the level of a run among those of the other runs."""
    logs = np.array([math.log(max(theta, 1e-300)) for theta, _ in level.runs])
    variances = np.array([error**2 for _, error in level.runs])
    rest = np.arange(len(logs)) != k
    mean, error2, spread2 = _mean(logs[rest], variances[rest])
    t = abs(logs[k] - mean) / math.sqrt(error2 + spread2 + variances[k])
    return float(2 * student_below(len(logs) - 2, -t))


def _mean(values: np.ndarray, variances: np.ndarray) -> tuple[float, float, float]:
    """Mean over runs, its variance, and the variance over runs by the method of Paule and Mandel."""

    def scatter(spread2: float) -> float:
        weights = 1 / (variances + spread2)
        mean = float(weights @ values / weights.sum())
        return float(weights @ (values - mean) ** 2)

    low, high = 0.0, 0.0
    freedom = len(values) - 1
    if scatter(0.0) > freedom:
        high = float(np.ptp(values)) ** 2
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2
            low, high = (middle, high) if scatter(middle) > freedom else (low, middle)
    weights = 1 / (variances + high)
    return float(weights @ values / weights.sum()), float(1 / weights.sum()), high


def _factor(found: Joint, k: int, cause: str) -> float | None:
    """Coefficient of a run over that of the others."""
    reduced = found.outcome.reduced.get(cause, 0.0)
    if cause in found.levels:
        own = found.levels[cause].runs[k][0]
    elif cause in found.others[k].terms:
        own, _, reduced, _ = found.others[k].terms[cause]
    else:
        return None
    return math.sqrt(own / reduced) if reduced > 0 else None


def ramp_of_runs(ramps: Sequence[tuple[float, float]], term: FittedTerm, *, level: float) -> FittedTerm:
    """The mean of the ramps of the runs, which differ: a ramp comes from the temperature or from the age."""
    known = np.array([one for one in ramps if math.isfinite(one[0]) and 0 < one[1] < math.inf]).reshape(-1, 2)
    if len(known) < 2:
        return FittedTerm(term="rate_ramp", unit=term.unit, observed=False, level=level, p_value=1.0)
    mean, variance, _ = _mean(known[:, 0], known[:, 1] ** 2)
    error = math.sqrt(variance)
    freedom = len(known) - 1
    half = error * float(student_quantile(freedom, (1 + level) / 2))
    p_value = float(2 * student_below(freedom, -abs(mean) / error))
    if abs(mean) > max(half, _RAMP * error):
        return FittedTerm(
            term="rate_ramp",
            unit=term.unit,
            observed=True,
            level=level,
            value=mean,
            low=mean - half,
            high=mean + half,
            p_value=p_value,
        )
    return FittedTerm(
        term="rate_ramp",
        unit=term.unit,
        observed=False,
        level=level,
        upper_limit=abs(mean) + half,
        p_value=max(p_value, 1 - level),
    )


def lines_of(fits: Sequence[NoiseFit]) -> tuple[Sinusoid, ...]:
    """Lines that at least half of the runs show: the median amplitude, with the range of the runs."""
    found: list[Sinusoid] = []
    reference = max(fits, key=lambda fit: len(fit.sinusoid))
    for line in reference.sinusoid:
        alike = [other for fit in fits if (other := _nearest(line, fit)) is not None]
        if 2 * len(alike) < len(fits):
            continue
        alike.sort(key=lambda one: one.amplitude.value)
        middle = alike[len(alike) // 2]
        ends = [end for one in alike for end in (one.amplitude.low, one.amplitude.high) if end is not None]
        amplitude = Interval(
            value=middle.amplitude.value,
            low=min(ends, default=None),
            high=max(ends, default=None),
            unit=line.amplitude.unit,
        )
        found.append(Sinusoid(amplitude=amplitude, frequency=line.frequency))
    return tuple(found)


def _nearest(line: Sinusoid, fit: NoiseFit) -> Sinusoid | None:
    """The line of another run at the same frequency."""
    low, high = _band(line)
    near = [one for one in fit.sinusoid if _band(one)[0] <= high and low <= _band(one)[1]]
    return min(near, key=lambda one: abs(one.frequency.value - line.frequency.value), default=None)


def _band(line: Sinusoid) -> tuple[float, float]:
    """Frequencies of a line, a width more on either side."""
    frequency = line.frequency
    low = frequency.value if frequency.low is None else frequency.low
    high = frequency.value if frequency.high is None else frequency.high
    return low - (high - low), high + (high - low)
