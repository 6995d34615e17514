"""Interval of the random walk in a spectrum with lines: leaving out the lines may remove part of the random walk."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from sigmatau._native.likelihood import ChannelFit
from sigmatau.findings.reasons import CrowdedLines
from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.disturbance import is_narrow
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter

# Above both limits, the lines may be noise. Of the quiet real records only ch104.mat exceeds both. Noise
# whose level changes by a factor of 5 to 30 gives 7 to 550 false lines in 0.07 to 0.8 of the band:
# docs/study/disturbed.md.
_MANY_LINES = 10  # number of lines that a fit left out
_CROWDED = 0.05  # share of the band that the lines cover


_WALK = Parameter("random_walk")


def crowded_lines(
    fitted: NoiseFit, *, native: ChannelFit, without_lines: Callable[[], ChannelFit], spacing: float
) -> Adjustment | None:
    """If lines crowd the band, extend the interval of the random walk by that of the model in which no line is left out.

    Narrow resonances of that model take the place of lines: their power in the band counts as noise too.

    Parameters
    ----------
    fitted : NoiseFit
    native : ChannelFit
        The same fit, from the core.
    without_lines : callable
        Makes the fit of the model without lines.
    spacing : float
        Distance of the densities. [Hz]
    """
    highest = native.highest or 0.5 / fitted.tau0
    share = _crowded_share(native.left_out, spacing=spacing, highest=highest)
    if not share or not fitted.quantified:
        return None
    plain = without_lines()
    walk, term = fitted.terms.get("random_walk"), dict(plain.terms).get("random_walk")
    interval = None if term is None else term.profile
    if walk is None or interval is None or interval.low is None or interval.high is None:
        return None
    shaken = sum(variance for variance, frequency, width in plain.resonances if is_narrow(frequency, width))
    high = math.sqrt(interval.high**2 + shaken / (2 * highest))
    reason = CrowdedLines(lines=len(fitted.sinusoid), share=share, highest=high)
    return _joined(walk, interval.low, high, reason=reason)


def _crowded_share(lines: Sequence[tuple[float, float]], *, spacing: float, highest: float) -> float:
    """Share of the band up to `highest` that is left out because of lines; 0 unless lines and share exceed the limits.

    `lines`: ends of the stretch that each line leaves out; `spacing`: distance of the densities. [Hz]
    """
    share = sum(min(high, highest) - low + spacing for low, high in lines if low < highest) / highest
    return share if len(lines) >= _MANY_LINES and share > _CROWDED else 0.0


def as_wide(fitted: NoiseFit, *, alone: FittedTerm, reason: CrowdedLines) -> Adjustment | None:
    """Widen the random walk of a joint fit, so that its relative interval is no narrower than that of a run with crowded
    lines.
    """
    walk = fitted.terms.get("random_walk")
    if walk is None or not walk.observed:
        return None
    low, high = _relative(alone)
    value, ends = walk.value or 0.0, _relative(walk)
    low, high = value * min(low, ends[0]), value * max(high, ends[1])
    return _changed(walk, Ends(low, high, None), reason=reason)


def _relative(term: FittedTerm) -> tuple[float, float]:
    """Interval of an observed term relative to its value; (0, 1) for any other term."""
    if term.value is None or term.low is None or term.high is None:
        return 0.0, 1.0
    return term.low / term.value, term.high / term.value


def _joined(walk: FittedTerm, low: float, high: float, *, reason: CrowdedLines) -> Adjustment:
    """Join the interval or limit of the random walk with another interval."""
    if walk.value is None or walk.low is None or walk.high is None:
        limit = None if walk.upper_limit is None else max(walk.upper_limit, high)
        return _changed(walk, Ends(walk.low, walk.high, limit), reason=reason)
    return _changed(walk, Ends(min(walk.low, low), max(walk.high, high), None), reason=reason)


def _changed(walk: FittedTerm, after: Ends, *, reason: CrowdedLines) -> Adjustment:
    return Adjustment(
        cause="crowded_lines",
        findings=("widened",),
        changes=(Change.widening(_WALK, Ends.of(walk), after),),
        verdict="widened",
        reason=reason,
    )
