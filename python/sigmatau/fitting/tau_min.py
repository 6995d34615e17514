"""Choice of the shortest averaging time, the ramp and the sixth term of a fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sigmatau.estimators.gaps import Gaps
from sigmatau.findings.kinds.fit import ShortTimesDeviate
from sigmatau.fitting import sixth_term
from sigmatau.fitting.components import LINEAR, Components
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.masked_components import components_with_gaps
from sigmatau.fitting.ramp import Ramp, estimate_ramp
from sigmatau.fitting.sixth_term import Extension

Floats = NDArray[np.float64]

LONGEST_SHARE = 3  # The longest averaging time is the record over this; a longer one has hardly two degrees of freedom
LEAST_TIMES = 8  # Smallest number of averaging times: four terms, and four degrees of freedom for the goodness of fit
LEAST_P = 0.002  # Smallest p-value of the goodness of fit with all averaging times for the model to be adequate
LEAST_P_LATER = 0.01  # The same once shorter averaging times are left out, which are then known to deviate
LEAST_P_EXTENDED = 0.05  # The same with a sixth term, which is the best of hundreds
# A sixth term is tried only if five terms fit worse than this: the best of hundreds always fits a little better
_SIXTH_TERM_P = 1e-4

# Largest shortest averaging time: an internal low-pass filter has no effect beyond it in practice. [samples]
LARGEST_START = 128
QUANTIZATION = LINEAR.index("quantization")
_FAILURES = (FloatingPointError, np.linalg.LinAlgError)


@dataclass(frozen=True, slots=True, eq=False)
class Data:
    """The data of a fit, in samples and in a unit that makes the variances near 1."""

    n: int
    m: tuple[int, ...]
    avar: Floats  # shape (n_tau,); allan variances, and the ramps per sample from the mean second differences
    ramps: Floats
    candidates: tuple[int, ...]  # Indices in `LINEAR` of the terms that are fitted
    with_ramp: bool  # Whether a ramp is fitted
    first: int | None = None  # Index of the shortest averaging time, if that is given
    gaps: Gaps | None = None  # Missing samples

    def parts(self, extra: Extension | None = None) -> Components:
        """Components at all averaging times."""
        return components_with_gaps(self.n, self.m, self.gaps, **({} if extra is None else extra.arguments()))

    def gls(self, first: int, extra: Extension | None = None) -> Gls:
        """The least squares problem from one averaging time on."""
        parts = self.parts(extra).from_index(first)
        also = tuple(range(len(LINEAR), len(parts.names)))
        return Gls(parts, self.avar[first:], (*self.candidates, *also))


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """The best θ from one averaging time on, and how well it fits."""

    first: int  # Index of that averaging time
    gls: Gls  # The least squares problem; with the ramp removed if it is significant
    theta: Floats
    p_value: float  # Of the goodness of fit
    ramp: Ramp | None
    still: tuple[Gls, Floats] | None  # The problem with the ramp removed, significant or not, and its θ
    extra: Extension | None = None

    def expected(self, data: Data) -> Floats:
        """Allan variances of the model at all averaging times, including those left out."""
        slope = 0.0 if self.ramp is None else self.ramp.used
        parts = data.parts(self.extra)
        return np.asarray(parts.design @ self.theta + 0.5 * slope**2 * parts.squares)

    def reasons(self, data: Data) -> tuple[ShortTimesDeviate, ...]:
        """Why the shortest averaging times were left out; empty if they were not."""
        if self.first == 0 or data.first is not None:
            return ()
        ratios = np.sqrt(data.avar / self.expected(data))[: self.first]
        worst = int(np.argmax(np.abs(np.log(ratios))))
        return (ShortTimesDeviate(cluster_size=data.m[worst], ratio=float(ratios[worst])),)


def best_attempt(data: Data, *, level: float) -> tuple[Attempt | None, Attempt | None]:
    """The adequate attempt or None, and the attempt with the largest p-value."""
    starts = [k for k, m in enumerate(data.m) if m <= LARGEST_START and len(data.m) - k >= LEAST_TIMES]
    if data.first is not None or not starts:
        starts = [data.first or 0]
    five, nearest = _five_terms(data, starts, level)
    if five is not None and five.first == starts[0]:
        return five, five
    with_all = _attempt(data, starts[0], level)
    if with_all is not None and with_all.p_value > _SIXTH_TERM_P:
        return five, nearest
    extended = _extended(data, starts, five, level)
    return (extended if extended is not None else five), nearest


def _attempt(data: Data, first: int, level: float, extra: Extension | None = None) -> Attempt | None:
    """The fit from one averaging time on; None if it fails."""
    attempt = _with_candidates(data, first, level, extra)
    if attempt is None or first == 0:
        return attempt
    # Quantization noise that exceeds the measured variance at the times left out is not quantization noise. The other terms
    # may exceed it, because they may be filtered there.
    phase = attempt.theta[QUANTIZATION] * data.parts().design[:first, QUANTIZATION]
    if np.any(phase > data.avar[:first]):
        others = tuple(p for p in data.candidates if p != QUANTIZATION)
        return _with_candidates(replace(data, candidates=others), first, level, extra) if others else None
    return attempt


def _with_candidates(data: Data, first: int, level: float, extra: Extension | None) -> Attempt | None:
    try:
        gls = data.gls(first, extra)
        theta = gls.fit()
        tangent = None if extra is None else theta[-1] * extra.tangent(gls.parts.m, data.gaps)
        gls = Gls(gls.parts, gls.avar, gls.candidates, tangent)
        if not data.with_ramp:
            return Attempt(first, gls, theta, gls.p_value(theta), None, None, extra)
        ramp, still, theta_still = estimate_ramp(gls, theta, data.ramps[first:], level=level)
        if ramp.used:
            gls, theta = still, theta_still
        return Attempt(first, gls, theta, gls.p_value(theta), ramp, (still, theta_still), extra)
    except _FAILURES:
        return None


def _five_terms(data: Data, starts: Sequence[int], level: float) -> tuple[Attempt | None, Attempt | None]:
    """The attempt from the shortest averaging time with an acceptable p-value, and the one with the largest p-value."""
    nearest: Attempt | None = None
    for first in starts:
        attempt = _attempt(data, first, level)
        if attempt is None:
            continue
        if attempt.p_value > (LEAST_P if first == starts[0] else LEAST_P_LATER):
            return (attempt if first == starts[0] else _an_octave_later(data, attempt, level)), attempt
        if nearest is None or attempt.p_value > nearest.p_value:
            nearest = attempt
    return None, nearest


def _an_octave_later(data: Data, found: Attempt, level: float) -> Attempt:
    """The fit from twice the averaging time on, where a deviation that was just not significant is half as large."""
    later = next((k for k, m in enumerate(data.m) if m >= 2 * data.m[found.first]), None)
    if later is None or len(data.m) - later < LEAST_TIMES:
        return found
    attempt = _attempt(data, later, level)
    return attempt if attempt is not None and attempt.p_value > LEAST_P_LATER else found


def _extended(data: Data, starts: Sequence[int], five: Attempt | None, level: float) -> Attempt | None:
    """The fit with a sixth term, if it begins at a much shorter averaging time than the one without."""
    limit = data.m[five.first] / sixth_term.GAIN_IN_REACH if five is not None else data.m[starts[-1]]
    for first in starts:
        if data.m[first] > limit:
            return None
        best: Attempt | None = None
        for candidate in sixth_term.candidates(data.gls(first)):
            attempt = _attempt(data, first, level, candidate)
            if attempt is None or attempt.p_value <= LEAST_P_EXTENDED or attempt.theta[-1] <= 0:
                continue
            if best is None or attempt.p_value > best.p_value:
                best = attempt
        if best is not None:
            return best
    return None
