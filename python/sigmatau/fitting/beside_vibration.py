"""Intervals of the random walk beside vibration: what lines may have taken of it, and its changes along the record."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from sigmatau._native.likelihood import ChannelFit
from sigmatau.findings.reasons import CrowdedLines
from sigmatau.fitting.disturbance import is_narrow, vibration_share
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.observed import limit_of

# Lines, and their part of the band, from which they may be noise that they were taken from. Of the quiet real records only
# ch104.mat has both; noise whose level changes 5 to 30 times has 7 to 550 lines and 0.07 to 0.8 of the band, and not one
# true line: see docs/study/disturbed.md.
_MANY_LINES, _CROWDED = 10, 0.05

# The share of vibration in the power, and the p-value of a level that is the same in all eighths of the record, from which
# the interval has the levels of its eighths: of 132 such axes of parked vehicles it then holds the random walk in 93 %,
# without in 87 %.
_SHAKEN, _UNSTEADY = 0.1, 1e-3


def crowded_share(lines: Sequence[tuple[float, float]], *, spacing: float, highest: float) -> float:
    """Part of the band that lines leave out if they are many and it is much; 0 otherwise.

    Parameters
    ----------
    lines : sequence of (float, float)
        Ends of what each leaves out. [Hz]
    spacing : float
        Distance of the densities. [Hz]
    highest : float
        Top of the band. [Hz]
    """
    share = sum(min(high, highest) - low + spacing for low, high in lines if low < highest) / highest
    return share if len(lines) >= _MANY_LINES and share > _CROWDED else 0.0


def with_lines_as_noise(fitted: NoiseFit, plain: ChannelFit, share: float, *, highest: float) -> NoiseFit:
    """The fit with the interval of the random walk joined with that of the model `plain`, in which no line is left out.

    Narrow resonances of that model stand for lines: their power in the band up to `highest` is noise as well. [Hz]
    """
    walk, term = fitted.terms.get("random_walk"), dict(plain.terms).get("random_walk")
    interval = None if term is None else term.profile
    if walk is None or interval is None or interval.low is None or interval.high is None:
        return fitted
    shaken = sum(variance for variance, frequency, width in plain.resonances if is_narrow(frequency, width))
    low, high = interval.low, math.sqrt(interval.high**2 + shaken / (2 * highest))
    if walk.value is None or walk.low is None or walk.high is None:
        limit = None if walk.upper_limit is None else max(walk.upper_limit, high)
        joined = replace(walk, upper_limit=limit)
    else:
        joined = replace(walk, low=min(walk.low, low), high=max(walk.high, high))
    reason = CrowdedLines(lines=len(fitted.sinusoid), share=share, highest=high)
    return replace(_with_walk(fitted, joined), verdict="widened", reasons=(reason, *fitted.reasons))


def as_wide(fitted: NoiseFit, other: FittedTerm, reason: CrowdedLines) -> NoiseFit:
    """A joint fit whose random walk has an interval at least as wide, relative, as that of a run with crowded lines."""
    walk = fitted.terms.get("random_walk")
    if walk is None or not walk.observed:
        return fitted
    low, high = _relative(other)
    value, ends = walk.value or 0.0, _relative(walk)
    joined = replace(walk, low=value * min(low, ends[0]), high=value * max(high, ends[1]))
    reasons = fitted.reasons if reason in fitted.reasons else (reason, *fitted.reasons)
    return replace(_with_walk(fitted, joined), verdict="widened", reasons=reasons)


def _relative(term: FittedTerm) -> tuple[float, float]:
    """The ends of the interval of an observed term over its value; of any other, an interval that begins at 0."""
    if term.value is None or term.low is None or term.high is None:
        return 0.0, 1.0
    return term.low / term.value, term.high / term.value


def allowing_for_changes(fitted: NoiseFit, unsteadiness: tuple[float, float]) -> NoiseFit:
    """The fit with the levels of the eighths of the record in the interval of the random walk, if vibration changes it.

    `unsteadiness`: standard deviation of the white level over eighths, relative, and p-value of none.
    """
    spread, p_value = unsteadiness
    walk = fitted.terms.get("random_walk")
    if p_value >= _UNSTEADY or walk is None or vibration_share(fitted) < _SHAKEN:
        return fitted
    if walk.value is None or walk.low is None or walk.high is None:
        return fitted
    low, high = walk.value * math.sqrt(max(1 - spread, 0.0)), walk.value * math.sqrt(1 + spread)
    return _with_walk(fitted, replace(walk, low=min(walk.low, low), high=max(walk.high, high)))


def _with_walk(fitted: NoiseFit, walk: FittedTerm) -> NoiseFit:
    """The fit with another random walk, which is a limit if its interval begins at 0."""
    unclear = fitted.unclear
    if walk.observed and not (walk.low or 0.0) > 0:
        walk, unclear = limit_of(walk), tuple(dict.fromkeys((*unclear, "random_walk")))
    return replace(fitted, terms={**fitted.terms, "random_walk": walk}, unclear=unclear)
