"""Search for the regions of a curve that have the slope of a term, for lines without a given range."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.gls import non_negative
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.fitting.read_off_lines import lay, thinned
from sigmatau.frozen import frozen
from sigmatau.noise.terms import TERMS, Term, avar
from sigmatau.results import plain

LARGEST_ERROR = 0.41
"""Largest error by eq. (26) of the averaging times that are used, which excludes those beyond a quarter of the record, as in
the paper.
"""


@frozen
class Rule:
    """Conditions for a region of a term.

    Attributes
    ----------
    tolerance : float
        Largest difference of the slope of the curve from that of the term. [1]
    slope_error : float
        Largest standard error of the slope by eq. (26). [1]
    span : float
        Smallest ratio of the longest to the shortest averaging time.
    scatter : float
        Error of a deviation of this noise over that by eq. (26). [1]
    gain : float
        Smallest reduction of the misfit per octave that the term must achieve. [squared errors, δ or 2 %]
    rest : float
        Largest standard error of the slope in the remainder after the lines of the other terms. [1]

    See Also
    --------
    sigmatau.read_off : uses one for each term.
    """

    tolerance: float = 0.1
    slope_error: float = 0.1
    span: float = 4.0
    scatter: float = 1.0
    gain: float = 6.0
    rest: float = 0.1


# From Monte Carlo: in each case an absent term is reported in at most 5 % of the records (studies/read_off.py, results
# in docs/study/read-off.md). The rule of the plateau is stricter, because the valley between a random walk and a rate
# random walk looks like a plateau; those of the rising terms are looser, because few other effects rise. In the
# remainder after other lines, slopes may be less certain: the curve is already known to have several terms.
RULES: Mapping[str, Rule] = {
    "quantization": Rule(scatter=0.3),
    "random_walk": Rule(rest=0.2),
    "bias_instability": Rule(tolerance=0.06, slope_error=0.06),
    "rate_random_walk": Rule(tolerance=0.15, rest=0.15, gain=2.0),
    "rate_ramp": Rule(slope_error=0.2, rest=0.2),
}

# A bend below the line of more than 0.1 in log σ cannot come from the five terms, whose sum is convex in the log-log plot.
_BEND = 0.1
# largest error by eq. (26) of a point below the line; with larger errors, low deviations are common by chance
_BEND_ERROR = 0.25
_SIGMAS = 2.5  # number of errors by eq. (26) that a point may deviate in addition
_SMALLEST_ERROR = 0.02  # smallest relative error of a deviation in the comparison with the other terms
SMALLEST_REST = 0.5  # share of the variance that the lines of other terms must leave in the region of a further line


@frozen
class Refusal:
    """A region that has the slope of a term but is not that term.

    Attributes
    ----------
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    tau_min, tau_max : float
        The region. [s]
    reason : str
        Why the region is not that of the term.
    hidden : bool
        Whether other noise hides the term at all averaging times.
    by_hand : bool
        Whether the range was given by hand.
    slope, slope_error : float or None
        Slope of the curve in a range that was given by hand; None for one point. [1]
    """

    term: str
    tau_min: float
    tau_max: float
    reason: str
    hidden: bool = False
    by_hand: bool = False
    slope: float | None = None
    slope_error: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values."""
        return plain(self, "term slope slope_error reason", tau_s=[self.tau_min, self.tau_max])


def regions(curve: DeviationCurve, rules: Mapping[str, Rule]) -> tuple[dict[str, NDArray[np.intp]], list[Refusal]]:
    """Find the regions of the terms that have a rule, as indices of the curve, and those that are refused.

    Regions are searched in the curve, and then one at a time in the remainder after the existing lines.
    """
    whole = Points.from_curve(curve)
    points = whole
    regions: dict[str, NDArray[np.intp]] = {}
    refused: dict[str, Refusal] = {}
    while True:
        rest = points is not whole
        new: dict[str, tuple[float, NDArray[np.intp]]] = {}
        for name, rule in rules.items():
            if name in regions or name in refused:
                continue
            term = TERMS[name]
            region = points.longest(term.slope, rule, rest=rest)
            if region is None:
                continue
            i, j = region
            ends = float(points.tau[i]), float(points.tau[j])
            reason = whole.bend(*ends, points.height(i, j, term.slope, rule.tolerance), term)
            gain = whole.gain(*ends, term)
            if reason is None and gain <= rule.gain:
                reason = "the other terms together explain it"
            if reason is None:
                new[name] = gain, points.indices[i : j + 1]
            else:
                refused[name] = Refusal(term=name, tau_min=ends[0], tau_max=ends[1], reason=reason)
        taken = [max(new, key=lambda name: new[name][0])] if rest and new else list(new)
        regions |= {name: new[name][1] for name in taken}
        if (rest and not new) or not regions:
            return regions, list(refused.values())
        lines, _ = lay(curve, regions)
        points = whole.without(curve, lines)


@frozen(kw_only=False)
class Points:
    """The usable points of a curve: log τ, log σ and δ of eq. (26). A region i … j includes both points."""

    indices: NDArray[np.intp]  # indices in the curve
    m: NDArray[np.int64]
    tau0: float
    tau: NDArray[np.float64]
    lt: NDArray[np.float64]
    ls: NDArray[np.float64]
    delta: NDArray[np.float64]

    @classmethod
    def from_curve(cls, curve: DeviationCurve) -> Points:
        error = curve.error
        indices = thinned(curve, error <= LARGEST_ERROR)  # a list, because the search goes over all pairs
        tau = curve.tau[indices]
        return cls(indices, curve.m[indices], curve.tau0, tau, np.log(tau), np.log(curve.adev[indices]), error[indices])

    def without(self, curve: DeviationCurve, lines: Mapping[str, float]) -> Points:
        """Subtract lines from the curve where the remainder dominates the variance. Its error grows with the subtracted
        share.
        """
        taken = sum(
            (avar(name, value, m=self.m, tau0=self.tau0) for name, value in lines.items()), np.zeros(len(self.m))
        )
        share = 1 - taken / curve.avar[self.indices]
        is_rest = share >= SMALLEST_REST
        log_rest = 0.5 * np.log(share[is_rest])
        return Points(
            self.indices[is_rest], self.m[is_rest], self.tau0, self.tau[is_rest], self.lt[is_rest],
            self.ls[is_rest] + log_rest,
            self.delta[is_rest] / share[is_rest],
        )  # fmt: skip

    def octave_slopes(self, delta: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Slope over about an octave at each point, and its standard error."""
        n = len(self.lt)
        half = 0.5 * math.log(2) * 1.01
        i = np.searchsorted(self.lt, self.lt - half)
        j = np.searchsorted(self.lt, self.lt + half, side="right") - 1
        alone = j <= i
        positions = np.arange(n)
        i, j = np.where(alone, np.maximum(positions - 1, 0), i), np.where(alone, np.minimum(positions + 1, n - 1), j)
        length = self.lt[j] - self.lt[i]
        with np.errstate(divide="ignore", invalid="ignore"):  # a single point
            return (self.ls[j] - self.ls[i]) / length, np.hypot(delta[i], delta[j]) / length

    def longest(self, slope: float, rule: Rule, *, rest: bool) -> tuple[int, int] | None:
        """First and last point of the longest region of a slope; among equally long regions, the one at shorter τ."""
        delta = rule.scatter * self.delta
        octave_slope, octave_error = self.octave_slopes(delta)
        fits = np.abs(octave_slope - slope) <= rule.tolerance + 2 * octave_error
        length = self.lt[None, :] - self.lt[:, None]
        misses = np.cumsum(~fits)
        error = np.hypot(delta[:, None], delta[None, :])
        possible = (length > math.log(rule.span) - 1e-9) & (error <= (rule.rest if rest else rule.slope_error) * length)
        possible &= (misses[None, :] == misses[:, None]) & fits[:, None]
        i, j = np.nonzero(possible)
        for k in np.lexsort((i, -np.round(length[i, j], 9))):
            first, last = int(i[k]), int(j[k])
            fitted = self.slope(first, last, rule.tolerance)
            allowed = rule.tolerance + (error[first, last] / length[first, last] if rest else 0.0)
            if (
                abs(fitted - slope) <= allowed
                and self.straight(first, last, rule.tolerance, delta)
                and self.on_line(first, last, slope, rule.tolerance, delta)
            ):
                return first, last
        return None

    def slope(self, i: int, j: int, tolerance: float) -> float:
        """Slope of the line fitted to a region."""
        weights = 1 / (self.delta[i : j + 1] ** 2 + (tolerance / 5) ** 2)
        lt, ls = self.lt[i : j + 1], self.ls[i : j + 1]
        from_mean = lt - float(weights @ lt) / float(weights.sum())
        return float((weights * from_mean) @ ls) / float((weights * from_mean) @ from_mean)

    def straight(self, i: int, j: int, tolerance: float, delta: NDArray[np.float64]) -> bool:
        """Whether the slopes of the two halves of a region agree."""
        lt, ls = self.lt, self.ls
        k = int(np.argmin(np.abs(lt[i : j + 1] - (lt[i] + lt[j]) / 2))) + i
        if not i < k < j:
            return True
        first, second = lt[k] - lt[i], lt[j] - lt[k]
        change = (ls[j] - ls[k]) / second - (ls[k] - ls[i]) / first
        error = math.hypot(delta[i] / first, delta[k] * (1 / first + 1 / second), delta[j] / second)
        return bool(abs(change) <= 2 * tolerance + error)

    def height(self, i: int, j: int, slope: float, tolerance: float) -> float:
        """Log σ at τ = 1 s of the line of a given slope fitted to a region."""
        weights = 1 / (self.delta[i : j + 1] ** 2 + (tolerance / 5) ** 2)
        return float(np.average(self.ls[i : j + 1] - slope * self.lt[i : j + 1], weights=weights))

    def on_line(self, i: int, j: int, slope: float, tolerance: float, delta: NDArray[np.float64]) -> bool:
        """Whether every point lies on the line within its error and the tolerance in log σ."""
        off = self.ls[i : j + 1] - slope * self.lt[i : j + 1] - self.height(i, j, slope, tolerance)
        return bool((np.abs(off) <= tolerance + _SIGMAS * delta[i : j + 1]).all())

    def bend(self, first: float, last: float, height: float, term: Term) -> str | None:
        """Reason to refuse a region [s] if the curve lies below its line before or after it."""
        if term.name == "random_walk":
            return None  # white noise stays white after a filter
        below = height + term.slope * self.lt - self.ls > _SIGMAS * self.delta + _BEND
        below &= self.delta <= _BEND_ERROR
        if below[self.tau < first].any():
            return "the curve rises into it (filter, line or correlated noise)"
        if below[self.tau > last].any():
            return "the curve falls below it later (filter, line or correlated noise)"
        return None

    def gain(self, first: float, last: float, term: Term) -> float:
        """Improvement of the fit of all terms to a region [s] by this term; also detects a crossing of two lines.

        The variances of the region and of a factor of 8 on either side are fitted with and without the term, with weights
        from δ (at least 2 %). The result is the reduction of the squared errors per octave of points.
        """
        around_region = (self.tau >= 0.999 * first / 8) & (self.tau <= 1.001 * last * 8)
        ls = self.ls[around_region]
        m, variance = self.m[around_region], np.exp(2 * (ls - ls[0]))  # the result does not depend on the unit
        weight = 1 / (2 * variance * np.hypot(self.delta[around_region], _SMALLEST_ERROR))
        columns = {name: weight * avar(name, 1.0, m=m, tau0=self.tau0) for name in TERMS}
        rest_columns = [column for name, column in columns.items() if name != term.name]
        per_octave = max(len(m) - 1, 1) * math.log(2) / (self.lt[around_region][-1] - self.lt[around_region][0])
        less = _misfit(rest_columns, weight * variance) - _misfit(list(columns.values()), weight * variance)
        return float(less / per_octave)


def _misfit(columns: list[NDArray[np.float64]], target: NDArray[np.float64]) -> float:
    """Smallest sum of squares of ``target`` minus a non-negative combination of the columns."""
    design = np.stack(columns, axis=1)
    rest = target - design @ non_negative(design, target)
    return float(rest @ rest)
