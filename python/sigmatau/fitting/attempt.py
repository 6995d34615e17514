"""One attempt at a fit: from one averaging time on, with or without a Gauss-Markov process."""

from __future__ import annotations

from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.findings.kinds.fit import ShortTimesDeviate
from sigmatau.fitting.components import LINEAR, Components, components
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.goodness import p_value
from sigmatau.fitting.ramp import Ramp, estimate_ramp
from sigmatau.frozen import frozen

Floats = NDArray[np.float64]

LONGEST_SHARE = 3  # The longest averaging time is the record over this; a longer one has hardly two degrees of freedom
QUANTIZATION = LINEAR.index("quantization")
FAILURES = (FloatingPointError, np.linalg.LinAlgError)

_STEP = 1e-4  # of the logarithm of a correlation time, for a derivative


@frozen(eq=False, kw_only=False)
class Data:
    """The data of a fit, in samples and in a unit that makes the variances near 1."""

    n: int
    m: tuple[int, ...]
    avar: Floats  # shape (n_tau,); Allan variances, and the ramps per sample from the mean second differences
    ramps: Floats
    candidates: tuple[int, ...]  # Indices in `LINEAR` of the terms that are fitted
    with_ramp: bool  # Whether a ramp is fitted
    first: int | None = None  # Index of the shortest averaging time, if that is given

    def at(self, indices: NDArray[np.int64]) -> Self:
        """The data at some of the averaging times."""
        sizes = tuple(self.m[k] for k in indices)
        return replace(self, m=sizes, avar=self.avar[indices], ramps=self.ramps[indices], first=None)

    def parts(self, time: float | None = None) -> Components:
        """Components at all averaging times; `time`: correlation time of a Gauss-Markov process [samples]."""
        return components(self.n, self.m, correlation_time=time)

    def gls(self, first: int, time: float | None = None) -> Gls:
        """The least squares problem from one averaging time on."""
        parts = self.parts(time).from_index(first)
        also = tuple(range(len(LINEAR), len(parts.names)))
        return Gls(parts, self.avar[first:], (*self.candidates, *also))

    def by_time(self, first: int, time: float) -> Floats:
        """Derivative of the variances of a process of variance 1 by the logarithm of its correlation time [samples]."""
        sizes = np.array(self.m[first:])

        def avar(step: float) -> Floats:
            return kernels.gauss_markov_avar(1.0, time * np.exp(step), sizes, 1.0)

        return np.asarray((avar(_STEP) - avar(-_STEP)) / (2 * _STEP))


@frozen(eq=False, kw_only=False)
class Attempt:
    """The best θ from one averaging time on, and how well it fits."""

    first: int  # Index of that averaging time
    gls: Gls  # The least squares problem; with the ramp removed if it is significant
    theta: Floats
    p_value: float  # Of the goodness of fit
    ramp: Ramp | None
    still: tuple[Gls, Floats] | None  # The problem with the ramp removed, significant or not, and its θ
    time: float | None = None  # Correlation time of the Gauss-Markov process [samples]

    def expected(self, data: Data) -> Floats:
        """Allan variances of the model at all averaging times, including those left out."""
        slope = 0.0 if self.ramp is None else self.ramp.used
        parts = data.parts(self.time)
        return np.asarray(parts.design @ self.theta + 0.5 * slope**2 * parts.squares)

    def reasons(self, data: Data) -> tuple[ShortTimesDeviate, ...]:
        """Why the shortest averaging times were left out; empty if they were not."""
        if self.first == 0 or data.first is not None:
            return ()
        ratios = np.sqrt(data.avar / self.expected(data))[: self.first]
        worst = int(np.argmax(np.abs(np.log(ratios))))
        return (ShortTimesDeviate(cluster_size=data.m[worst], ratio=float(ratios[worst])),)


def attempt(data: Data, first: int, level: float, time: float | None = None) -> Attempt | None:
    """The fit from one averaging time on; None if it fails."""
    found = _with_candidates(data, first, level, time)
    if found is None or first == 0:
        return found
    # Quantization noise that exceeds the measured variance at the times left out is not quantization noise. The other terms
    # may exceed it, because they may be filtered there.
    phase = found.theta[QUANTIZATION] * data.parts().design[:first, QUANTIZATION]
    if np.any(phase > data.avar[:first]):
        others = tuple(p for p in data.candidates if p != QUANTIZATION)
        return _with_candidates(replace(data, candidates=others), first, level, time) if others else None
    return found


def _with_candidates(data: Data, first: int, level: float, time: float | None) -> Attempt | None:
    try:
        gls = data.gls(first, time)
        theta = gls.fit()
        if time is not None:
            gls = Gls(gls.parts, gls.avar, gls.candidates, theta[-1] * data.by_time(first, time))
        if not data.with_ramp:
            return Attempt(first, gls, theta, p_value(gls, theta), None, None, time)
        ramp, still, theta_still = estimate_ramp(gls, theta, data.ramps[first:], level=level)
        if ramp.used:
            gls, theta = still, theta_still
        return Attempt(first, gls, theta, p_value(gls, theta), ramp, (still, theta_still), time)
    except FAILURES:
        return None
