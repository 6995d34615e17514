"""Rounding of the samples: widening of the intervals of a fit by a step that is similar to the noise or larger."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from sigmatau._native.distributions import normal_below
from sigmatau.arrays import Floats
from sigmatau.findings.reasons import CoarseValues
from sigmatau.fitting.adjustment import Adjustment, Change, Ends
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter

_SIGMAS = np.linspace(0.02, 1.2, 237)  # tested sizes of the noise before rounding [steps]
_COARSE = (
    0.01  # difference of slow changes above which the fit counts as widened: observed noise below 0.53 steps [steps]
)
_LEVELS = 8  # number of values on either side of the mean that rounded noise takes: six standard deviations at least


@frozen(kw_only=False)
class Rounding:
    """Bounds of the noise before rounding, given the noise of the rounded values. Both in steps.

    The rounded noise depends on the position of the mean within a step: with the mean halfway between two values, even
    very small noise flips between them; with the mean at a value, noise much smaller than a step is not visible.
    """

    rounded: float

    @property
    def smallest(self) -> float:
        """Smallest noise before rounding: the mean is halfway between two values."""
        return float(np.interp(self.rounded, _rounded(0.5), _SIGMAS, left=0.0, right=self.rounded))

    @property
    def largest(self) -> float:
        """Largest noise before rounding: the mean is at a value."""
        return float(np.interp(self.rounded, _rounded(0.0), _SIGMAS, right=self.rounded))

    @property
    def white(self) -> tuple[float, float]:
        """Smallest and largest factor on the random walk of the log if its mean moves; any factor without noise."""
        if not self.rounded > 0:
            return 0.0, math.inf
        low = float(np.interp(self.smallest, _SIGMAS, _rounded(0.0), left=0.0, right=self.rounded))
        high = float(np.interp(self.largest, _SIGMAS, _rounded(0.5), right=self.rounded))
        return min(low / self.rounded, 1.0), max(high / self.rounded, 1.0)

    @property
    def dither(self) -> float:
        """exp(−2π²σ²): 1 if the noise is too small for slow changes to pass the rounding, 0 if it is large enough."""
        return math.exp(-2 * (math.pi * self.smallest) ** 2)

    @property
    def slow_error(self) -> float:
        """Largest difference of a slow change before and after rounding. [steps]"""
        return min(0.5, self.dither / math.pi)


def _rounded(phase: float) -> Floats:
    """Standard deviation of rounded normal noise with the mean at a value (0) or halfway between two values (0.5).
    [steps]
    """
    levels = np.arange(-_LEVELS, _LEVELS + 1) - phase
    edges = (np.append(levels, levels[-1] + 1) - 0.5) / _SIGMAS[:, None]
    shares = np.diff(normal_below(edges), axis=1)
    return np.asarray(np.sqrt(shares @ levels**2 - (shares @ levels) ** 2))


def rounding_adjustment(fitted: NoiseFit, *, step: float, noise: float) -> Adjustment | None:
    """Compute intervals and limits that hold for any position of the mean within a step. The values remain those of the log.

    The random walk is that of the log, including rounding: per sample the square root of σ² + step²/12, averaged over the
    positions of the mean. Slow changes before and after rounding differ by at most `Rounding.slow_error`, and in slope
    by twice `dither`.

    Parameters
    ----------
    fitted : NoiseFit
    step : float
        Step of the samples. [rate unit]
    noise : float
        Standard deviation of the white part of the samples in the log. [rate unit]
    """
    rounding = Rounding(noise / step)
    coarse = fitted.quantified and rounding.slow_error > _COARSE
    error, slope = rounding.slow_error * step, 2 * rounding.dither
    duration = fitted.n * fitted.tau0
    # The standard deviation of the term's noise in the record equals the largest difference: for B in all octaves, for
    # K in the first mode, and for a ramp between two values.
    errors = {
        "quantization": error * fitted.tau0 / math.sqrt(2),
        "bias_instability": error * math.sqrt(math.pi / math.log(fitted.n / 2)),
        "rate_random_walk": error * math.pi / math.sqrt(duration),
        "rate_ramp": 3 * error / duration,
    }

    def ends(low: float, high: float, limit: float) -> tuple[float, float]:
        """Ends of the interval of a non-negative number."""
        top = min(limit, high * slope / (1 - slope)) if slope < 1 else limit
        return max(low - min(limit, low * slope), 0.0), high + top

    def widened_white(high: float) -> float:
        """Widen the interval for a record without visible noise, whose mean may be halfway between two values."""
        top = rounding.white[1]
        return high * top if top < math.inf else high + step / 2 * math.sqrt(fitted.tau0)

    def widened(name: str, before: Ends) -> Ends:
        if before.low is None or before.high is None:
            limit = before.upper_limit
            if limit is None:
                return before
            higher = widened_white(limit) if name == "random_walk" else ends(0.0, limit, errors[name])[1]
            return replace(before, upper_limit=higher)
        if name == "random_walk":
            return replace(before, low=before.low * rounding.white[0], high=widened_white(before.high))
        if name == "rate_ramp":
            return replace(before, low=before.low - errors[name], high=before.high + errors[name])
        low, high = ends(before.low, before.high, errors.get(name, error))
        return replace(before, low=low, high=high)

    numbers = [(Parameter(name), Ends.of(term)) for name, term in fitted.terms.items()]
    numbers += [(Parameter("gauss_markov", k, "sigma"), Ends.of(p.sigma)) for k, p in enumerate(fitted.gauss_markov, 1)]
    numbers += [(Parameter("resonance", k, "sigma"), Ends.of(p.sigma)) for k, p in enumerate(fitted.resonance, 1)]
    changes = [Change.widening(each, before, widened(each.part, before)) for each, before in numbers]
    changes = [change for change in changes if change.after != change.before]
    if not changes and not coarse:
        return None
    return Adjustment(
        cause="rounding",
        findings=("coarse_resolution",),
        changes=tuple(changes),
        verdict="widened" if coarse else None,
        reason=CoarseValues() if coarse else None,
    )
