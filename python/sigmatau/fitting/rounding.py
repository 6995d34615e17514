"""Rounding of the samples: what a step near the noise or above it adds to the intervals of a fit."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.distributions import normal_below
from sigmatau.findings.reasons import CoarseValues
from sigmatau.fitting.fitted_values import FittedTerm, Interval
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.observed import limit_of
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter

Floats = NDArray[np.float64]

_SIGMAS = np.linspace(0.02, 1.2, 237)  # of the noise before rounding [steps]
_COARSE = (
    0.01  # difference of slow changes from which the fit says that it is widened: noise seen below 0.53 steps [steps]
)
_LEVELS = 8  # on either side of the mean that rounded noise takes: six standard deviations at least


@frozen(kw_only=False)
class Rounding:
    """What is known of the noise before rounding, from the noise that is seen. Both in steps.

    The rounded noise depends on where the mean lies between two steps: halfway between two levels it flips between them
    however small it is; at a level, noise much smaller than a step never leaves it.
    """

    seen: float

    @property
    def least(self) -> float:
        """Least noise before rounding: the mean is halfway between two levels."""
        return float(np.interp(self.seen, _rounded(0.5), _SIGMAS, left=0.0, right=self.seen))

    @property
    def most(self) -> float:
        """Most noise before rounding: the mean is at a level."""
        return float(np.interp(self.seen, _rounded(0.0), _SIGMAS, right=self.seen))

    @property
    def white(self) -> tuple[float, float]:
        """Factors of the random walk of the log, if its mean moves: least and most. Of no noise, any."""
        if not self.seen > 0:
            return 0.0, math.inf
        low = float(np.interp(self.least, _SIGMAS, _rounded(0.0), left=0.0, right=self.seen))
        high = float(np.interp(self.most, _SIGMAS, _rounded(0.5), right=self.seen))
        return min(low / self.seen, 1.0), max(high / self.seen, 1.0)

    @property
    def dither(self) -> float:
        """exp(−2π²σ²): 1 where the noise is too small to let slow changes through the rounding, 0 where it is not."""
        return math.exp(-2 * (math.pi * self.least) ** 2)

    @property
    def slow_error(self) -> float:
        """Largest difference of a slow change before and after rounding. [steps]"""
        return min(0.5, self.dither / math.pi)


def _rounded(phase: float) -> Floats:
    """Standard deviation of rounded normal noise with the mean at a level (0) or halfway between two (0.5). [steps]"""
    levels = np.arange(-_LEVELS, _LEVELS + 1) - phase
    edges = (np.append(levels, levels[-1] + 1) - 0.5) / _SIGMAS[:, None]
    shares = np.diff(normal_below(edges), axis=1)
    return np.asarray(np.sqrt(shares @ levels**2 - (shares @ levels) ** 2))


def allowing_for_rounding(fitted: NoiseFit, *, step: float, noise: float) -> NoiseFit:
    """A fit whose intervals and limits hold wherever between two steps the mean lies; values stay those of the log.

    The random walk is that of the log, rounding included: the square root of σ² + step²/12 a sample, on average over the
    mean. Slow changes differ before and after rounding by at most `Rounding.slow_error`, and in slope by twice `dither`.

    Parameters
    ----------
    fitted : NoiseFit
    step : float
        Step of the samples. [rate unit]
    noise : float
        Standard deviation of the white part of the samples in the log. [rate unit]
    """
    rounding = Rounding(noise / step)
    told = fitted.quantified and rounding.slow_error > _COARSE
    error, slope = rounding.slow_error * step, 2 * rounding.dither
    duration = fitted.n * fitted.tau0
    # The coefficient whose noise has the largest difference as its standard deviation in the record: of B in all octaves,
    # of K in the first mode; a ramp between two levels.
    errors = {
        "quantization": error * fitted.tau0 / math.sqrt(2),
        "bias_instability": error * math.sqrt(math.pi / math.log(fitted.n / 2)),
        "rate_random_walk": error * math.pi / math.sqrt(duration),
        "rate_ramp": 3 * error / duration,
    }

    def ends(low: float, high: float, most: float) -> tuple[float, float]:
        """The ends of an interval of a size ≥ 0."""
        more = min(most, high * slope / (1 - slope)) if slope < 1 else most
        return max(low - min(most, low * slope), 0.0), high + more

    def white_most(high: float) -> float:
        """Of no noise that is seen, that of a mean halfway between two levels."""
        most = rounding.white[1]
        return high * most if most < math.inf else high + step / 2 * math.sqrt(fitted.tau0)

    def term(name: str, one: FittedTerm) -> FittedTerm:
        found = widened_term(name, one)
        return limit_of(found) if found.observed and (found.low or 0.0) * (found.high or 0.0) <= 0 else found

    def widened_term(name: str, one: FittedTerm) -> FittedTerm:
        if one.low is None or one.high is None:
            return one if one.upper_limit is None else replace(one, upper_limit=limit(name, one.upper_limit))
        if name == "random_walk":
            return replace(one, low=one.low * rounding.white[0], high=white_most(one.high))
        if name == "rate_ramp":
            return replace(one, low=one.low - errors[name], high=one.high + errors[name])
        low, high = ends(one.low, one.high, errors[name])
        return replace(one, low=low, high=high)

    def limit(name: str, high: float) -> float:
        return white_most(high) if name == "random_walk" else ends(0.0, high, errors[name])[1]

    def wider(sigma: Interval) -> Interval:
        if sigma.low is None or sigma.high is None:
            return sigma
        low, high = ends(sigma.low, sigma.high, error)
        return replace(sigma, low=low, high=high)

    widened = replace(
        fitted,
        terms={name: term(name, one) for name, one in fitted.terms.items()},
        gauss_markov=tuple(replace(p, sigma=wider(p.sigma)) for p in fitted.gauss_markov),
        resonance=tuple(replace(p, sigma=wider(p.sigma)) for p in fitted.resonance),
    )
    before, after = _widths(fitted), _widths(widened)
    factors = {each: after[each] / before[each] for each in fitted.covariance.parameters if each in before}
    return replace(
        widened,
        verdict="widened" if told else fitted.verdict,
        reasons=(*fitted.reasons, CoarseValues()) if told else fitted.reasons,
        covariance=fitted.covariance.scaled(factors),
    )


def _widths(fitted: NoiseFit) -> dict[Parameter, float]:
    """Widths of intervals, by the parameters of the covariance."""
    widths = {Parameter(name): _width(term) for name, term in fitted.terms.items()}
    widths |= {
        Parameter("gauss_markov", k, "sigma"): _width(each.sigma) for k, each in enumerate(fitted.gauss_markov, 1)
    }
    return widths | {
        Parameter("resonance", k, "sigma"): _width(each.sigma) for k, each in enumerate(fitted.resonance, 1)
    }


def _width(term: FittedTerm | Interval) -> float:
    if term.low is None or term.high is None or not term.high > term.low:
        return 1.0
    return term.high - term.low
