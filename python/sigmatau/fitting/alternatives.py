"""Size of a term above which a record is not explained as well without it: the comparisons of the default fit, predicted.

The fit compares a bias instability with a Gauss-Markov process, and a ramp with a rate random walk. The expected rise of
the deviance, twice the negative logarithm of the likelihood, with such an explanation is twice the Kullback-Leibler
divergence of the densities at the cosine modes of the record, which are independent for white noise, quantization noise and
a rate random walk.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from sigmatau._native.distributions import chi2_quantile_above, normal_quantile
from sigmatau.arrays import Floats
from sigmatau.model.processes import GaussMarkov

_MODES = 200  # number of groups of modes, which are geometric above the first tens
_TIMES = 2.0  # number of correlation times per decade, as in the fit
_SHORTEST_TIME, _LONGEST_SHARE = 40, 12  # correlation times: from 40 samples to a twelfth of the record, as in the fit
_STEPS = 12  # largest number of steps of a fit of densities
_CONVERGED = 1e-3  # change of the deviance at which such a fit ends
_INTERVAL = float(chi2_quantile_above(1, 0.05))  # rise of the deviance at an end of a 95 % interval
_PARAMETER = 2.0  # price of a parameter in deviance (Akaike)
_BY_CHANCE = 2.6
"""Fall of the deviance that the best process owes to chance. It was fitted to the shares of 1200 records that showed a bias
instability, in four rows with other values than those of docs/study/planning.md, which tests it; single rows give 2 to 5.
"""

_RAMP_ERRORS = 3.3  # standard errors of an observed ramp, with the rate random walk at its upper limit, as in the fit
_SCATTER = 2.0
"""Rise of the deviance that is added at the upper limit of the rate random walk, which differs from record to record. Study:
docs/study/planning.md.
"""


class Modes:
    """Densities of unit noise at the cosine modes of a record, in groups of neighbouring modes.

    `tau_min` is the shortest averaging time that can be used; higher frequencies than 1/(2·tau_min) are left out. [s]
    """

    def __init__(self, n: int, tau0: float, tau_min: float) -> None:
        last = max(min(n, round(n * tau0 / tau_min)) if tau_min > 0 else n, 3)
        firsts = np.unique(np.round(np.geomspace(1, last - 1, _MODES)))
        self.count: Floats = np.diff(firsts, append=float(last))  # modes of each group
        self.number: Floats = np.where(self.count > 1, np.sqrt(firsts * (firsts + self.count - 1)), firsts)
        self.samples: int = n
        self.tau0: float = tau0
        self.frequency: Floats = self.number / (2 * n * tau0)
        self.chord: Floats = 4 * np.sin(np.pi * self.frequency * tau0) ** 2  # of the modes of differences

    def term(self, name: str) -> Floats:
        """Density of a noise term of coefficient 1."""
        if name == "quantization":
            return self.chord / self.tau0
        if name == "bias_instability":
            return 1 / (2 * np.pi * self.frequency)
        if name == "rate_random_walk":
            return self.tau0**2 / self.chord
        return np.ones_like(self.frequency)

    def process(self, time: float) -> Floats:
        """Density of a Gauss-Markov process of variance 1."""
        density: Floats = 2 * time / (1 + (2 * np.pi * self.frequency * time) ** 2)
        return density

    def ramp(self) -> Floats:
        """Squares of a ramp of slope 1, in place of densities; only odd modes contain it."""
        is_odd = np.where(self.count > 1, 0.5, self.number % 2)
        size = np.sqrt(2 / self.samples) * 2 * self.tau0 * np.sqrt(np.maximum(1 - self.chord / 4, 0)) / self.chord
        squares: Floats = is_odd * size**2 * self.tau0
        return squares

    def density(self, noise: Mapping[str, float], processes: Sequence[GaussMarkov]) -> Floats:
        """Density of noise [SI]."""
        total = np.zeros_like(self.frequency)
        for name, value in noise.items():
            if name != "rate_ramp":
                total += value**2 * self.term(name)
        for process in processes:
            total += process.sigma**2 * self.process(process.time)
        return total


def process_excluded(
    modes: Modes, noise: Mapping[str, float], processes: Sequence[GaussMarkov], value: float, power: float
) -> bool:
    """Whether a record distinguishes a bias instability from a Gauss-Markov process, with a probability of `power`.

    The rise of the deviance has a mean λ and a standard deviation 2√λ.
    """
    background = {name: size for name, size in noise.items() if size and name not in ("bias_instability", "rate_ramp")}
    density = modes.density(background | {"bias_instability": value}, processes)
    names = {"random_walk", "rate_random_walk"} | (set(background) & {"quantization"})
    columns = [modes.term(name) for name in sorted(names)] + [modes.process(g.time) for g in processes]
    # beside a rate random walk, slow noise of any kind resembles a bias instability
    tolerated = _PARAMETER if background.get("rate_random_walk") else _INTERVAL
    allowed_rise = tolerated - _PARAMETER + _BY_CHANCE
    z = float(normal_quantile(power))
    needed = (z + math.sqrt(z * z + allowed_rise)) ** 2
    shortest, longest = _SHORTEST_TIME * modes.tau0, modes.samples * modes.tau0 / _LONGEST_SHARE
    times = np.geomspace(shortest, longest, max(int(_TIMES * math.log10(max(longest / shortest, 1))) + 1, 2))
    return all(_divergence(density, [*columns, modes.process(time)], modes.count) >= needed for time in times)


def least_ramp_beside_walk(
    modes: Modes, noise: Mapping[str, float], processes: Sequence[GaussMarkov], power: float
) -> float:
    """The smallest ramp that a record shows with a probability of `power`, the rate random walk being at its upper limit."""
    density = modes.density(noise, processes)
    columns = [modes.term("random_walk")] + [modes.process(g.time) for g in processes]
    columns += [modes.term(name) for name in ("quantization", "bias_instability") if noise.get(name)]
    walk = modes.term("rate_random_walk")
    present = noise.get("rate_random_walk", 0.0) ** 2

    def rise(squared: float) -> float:
        return _divergence(density, columns, modes.count, fixed=squared * walk)

    low = high = max(present, float(np.min(density / walk)))
    while rise(high) < _INTERVAL + _SCATTER:
        low, high = high, 4 * high
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if rise(middle) > _INTERVAL + _SCATTER else (middle, high)
    information = np.sum(modes.count * modes.ramp() / (density + (high - present) * walk))
    return (_RAMP_ERRORS + float(normal_quantile(power))) / math.sqrt(float(information))


def _divergence(density: Floats, columns: Sequence[Floats], count: Floats, fixed: Floats | None = None) -> float:
    """Twice the smallest Kullback-Leibler divergence from sums of the columns with non-negative factors, and of `fixed`."""
    from scipy.optimize import nnls

    design = np.column_stack(columns)
    rest = np.zeros_like(density) if fixed is None else fixed
    fitted, smallest = density + rest, math.inf
    for _ in range(_STEPS):
        weight = np.sqrt(count) / fitted
        scaled = design * weight[:, None]
        size = np.linalg.norm(scaled, axis=0)
        factors, _ = nnls(scaled / size, (density - rest) * weight)
        new = design @ (factors / size) + rest
        if not (new > 0).all():
            break
        ratio = density / new
        fitted, last, smallest = new, smallest, float(np.sum(count * (ratio - 1 - np.log(ratio))))
        if abs(last - smallest) < _CONVERGED:
            break
    return smallest
