"""Biases of the random walk that findings report, included in its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sigmatau._native.distributions import normal_quantile
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding
from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter

_WALK = Parameter("random_walk")


@frozen
class WalkBias:
    """Biases of the random walk of a channel that findings report.

    Attributes
    ----------
    factors : tuple of (float, float)
        Ratio of the random walk of the fit to that of the sensor, without and with the effect of spikes. Spikes of a
        continuous tail were left out, and small spikes were not; both may be noise of the sensor. [1]
    tail_error : float
        Relative standard error of the random walk if the spikes that were left out belong to a continuous tail; otherwise 0.
    findings : tuple of str
        Codes of these findings: rounding near a step, samples that are held, repeated or filled in, saturation, aliasing,
        spikes.
    """

    factors: tuple[float, float]
    tail_error: float
    findings: tuple[str, ...]


def walk_bias(findings: Sequence[Finding], channel: str) -> WalkBias:
    """Bias of the random walk of a channel, from all findings that compute a bias."""
    certain, spikes, tail_error, codes = 1.0, 1.0, 0.0, []
    for finding in findings:
        if channel not in finding.channels:
            continue
        details, factor = finding.details, finding.walk_factor
        if isinstance(details, Spikes) and finding.left_out:
            tail_error = max(tail_error, details.tail_error)
        if factor is None:
            continue
        codes.append(finding.code)
        if isinstance(details, Spikes):
            spikes *= factor
        else:
            certain *= factor
    return WalkBias(factors=(certain, certain * spikes), tail_error=tail_error, findings=tuple(dict.fromkeys(codes)))


def bias(fitted: NoiseFit, *, biases: Sequence[WalkBias]) -> Adjustment | None:
    """Extend the interval or limit of the random walk so that it holds for the log and for the sensor. The value remains
    that of the log.

    `biases`: the biases of the channel, or of the runs of a joint fit.
    """
    factors, walk = (1.0, *(factor for each in biases for factor in each.factors)), fitted.terms.get("random_walk")
    largest, smallest = max(factors), min(factors)
    if walk is None or largest == smallest:
        return None
    error = max(each.tail_error for each in biases)
    low, high, limit = walk.low, walk.high, walk.upper_limit
    if high is not None and walk.value is not None and error > 0:
        added = float(normal_quantile(0.5 + 0.5 * walk.level)) * error * walk.value
        high = walk.value + math.hypot(high - walk.value, added)
    after = Ends(
        None if low is None else low / largest,
        None if high is None else high / smallest,
        None if limit is None else limit / smallest,
    )
    return Adjustment(
        cause="bias",
        findings=tuple(dict.fromkeys(code for each in biases for code in each.findings)),
        changes=(Change.widening(_WALK, Ends.of(walk), after),),
    )
