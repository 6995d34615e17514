"""Biases of the random walk that findings state, as part of its interval."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from sigmatau.findings.finding import Finding
from sigmatau.fitting.noise_fit import FittedTerm, NoiseFit

_TERM = "random_walk"


def walk_factor(findings: Iterable[Finding], channel: str) -> float:
    """Factor by which the random walk of a fit is larger than that of the sensor, by all findings that compute one.

    They are rounding near a step, samples that are held, repeated or filled in, saturation and aliasing.
    """
    factors = (finding.walk_factor for finding in findings if channel in finding.channels)
    return math.prod(factor for factor in factors if factor is not None)


def allowing_for_biases(fitted: NoiseFit, factors: Iterable[float]) -> NoiseFit:
    """A fit whose interval or limit of the random walk holds that of the log and that of the sensor; values stay those
    of the log.

    Parameters
    ----------
    fitted : NoiseFit
    factors : iterable of float
        Random walk of the log over that of the sensor; of a joint fit, those of its runs.
    """
    all_factors, walk = (1.0, *factors), fitted.terms.get(_TERM)
    largest, smallest = max(all_factors), min(all_factors)
    if walk is None or largest == smallest:
        return fitted
    low, high, limit = walk.low, walk.high, walk.upper_limit
    widened = replace(
        walk,
        low=None if low is None else low / largest,
        high=None if high is None else high / smallest,
        upper_limit=None if limit is None else limit / smallest,
    )
    names, covariance = fitted.covariance
    scale = np.ones(len(names))
    if _TERM in names and (before := _width(walk)) > 0:
        scale[names.index(_TERM)] = _width(widened) / before
    return replace(
        fitted, terms={**fitted.terms, _TERM: widened}, covariance=(names, covariance * np.outer(scale, scale))
    )


def _width(walk: FittedTerm) -> float:
    return 0.0 if walk.low is None or walk.high is None else walk.high - walk.low
