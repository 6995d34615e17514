"""Biases of the random walk that findings state, as part of its interval."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

from sigmatau._native.distributions import normal_quantile
from sigmatau.findings.disturbances import Spikes
from sigmatau.findings.finding import Finding
from sigmatau.fitting.fitted_values import FittedTerm
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.model.parameters import Parameter

_TERM = "random_walk"


def walk_factors(findings: Sequence[Finding], channel: str) -> tuple[float, float]:
    """Factors by which the random walk of a fit is larger than that of the sensor, by all findings that compute one: without
    the finding of spikes, and with it. Spikes of a continuous tail, which were left out, and small ones, which were not, may
    be noise of the sensor.

    The other findings are rounding near a step, samples that are held, repeated or filled in, saturation and aliasing.
    """
    certain, spikes = 1.0, 1.0
    for finding in findings:
        factor = finding.walk_factor
        if factor is None or channel not in finding.channels:
            continue
        if isinstance(finding.details, Spikes):
            spikes *= factor
        else:
            certain *= factor
    return certain, certain * spikes


def tail_error(findings: Iterable[Finding], channel: str) -> float:
    """Relative standard error of the random walk with the spikes that were left out of a continuous tail; 0 without one."""
    errors = (
        finding.details.tail_error
        for finding in findings
        if isinstance(finding.details, Spikes) and finding.left_out and channel in finding.channels
    )
    return max(errors, default=0.0)


def allowing_for_biases(fitted: NoiseFit, factors: Iterable[float], *, error: float = 0.0) -> NoiseFit:
    """A fit whose interval or limit of the random walk holds that of the log and that of the sensor; values stay those
    of the log.

    Parameters
    ----------
    fitted : NoiseFit
    factors : iterable of float
        Random walk of the log over that of the sensor; of a joint fit, those of its runs.
    error : float
        Relative standard error of the random walk by the smallest factor, in addition to that of the fit.
    """
    all_factors, walk = (1.0, *factors), fitted.terms.get(_TERM)
    largest, smallest = max(all_factors), min(all_factors)
    if walk is None or largest == smallest:
        return fitted
    low, high, limit = walk.low, walk.high, walk.upper_limit
    if high is not None and walk.value is not None and error > 0:
        added = float(normal_quantile(0.5 + 0.5 * walk.level)) * error * walk.value
        high = walk.value + math.hypot(high - walk.value, added)
    widened = replace(
        walk,
        low=None if low is None else low / largest,
        high=None if high is None else high / smallest,
        upper_limit=None if limit is None else limit / smallest,
    )
    before = _width(walk)
    scale = _width(widened) / before if before > 0 else 1.0
    return replace(
        fitted, terms={**fitted.terms, _TERM: widened}, covariance=fitted.covariance.scaled({Parameter(_TERM): scale})
    )


def _width(walk: FittedTerm) -> float:
    return 0.0 if walk.low is None or walk.high is None else walk.high - walk.low
