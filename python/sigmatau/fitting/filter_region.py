"""All filters that explain the logs about as well as the best one, and whether one log contradicts the others."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from sigmatau._native.distributions import chi2_above
from sigmatau.arrays import Floats
from sigmatau.fitting.filter_fit import FilterFit, Logs, best_fits, corner_limits, limited
from sigmatau.fitting.sensor_filters import SensorFilter, all_filters
from sigmatau.frozen import frozen

_DIRECTIONS = 12  # directions from the best pair of numbers in which the edge of the region is searched
# fractions of the distance to the edge at which points inside the region are taken, for filters with two numbers
_INSIDE_TWO_PARAMETERS = (0.4, 0.75)
_INSIDE = (0.2, 0.4, 0.6, 0.8)  # fractions of the distance to the edge, for filters with one number
_BISECTIONS = 6  # halvings of the distance to the edge, whose error is then 2 %
_EXPANSION = 2.0  # factor by which a distance is increased until it reaches the edge
_MAX_EXPANSIONS = 14  # largest number of such increases
_SMALLEST_RATIO = 1e-12  # ratio of N² that replaces 0 for a log without white noise
_LARGEST_BANDWIDTH_ERROR = 0.1  # largest relative standard error at which the bandwidths of two logs are compared


@frozen(eq=False)
class Explanation:
    """A filter, with values of its parameters, that explains the logs.

    Attributes
    ----------
    filter : SensorFilter
    numbers : ndarray, shape (n_numbers,)
    density : float
        N². [(unit of the rate)²/Hz]
    spread : float
        Half width of the interval of ln N² that the deviance allows with these parameters.
    """

    filter: SensorFilter
    numbers: Floats
    density: float
    spread: float


def explanations(logs: Logs, fits: Sequence[FilterFit], rise: float) -> list[Explanation]:
    """List the filters of all forms whose cost is at most `rise` above the lowest cost, the best form first.

    Each form contributes points on the edge of its region, and points inside it.
    """
    region: list[Explanation] = []
    for fit in fits:
        if fit.cost <= fits[0].cost + rise:
            region += _region(logs, fit, fit.cost + rise)
    return region


def is_white(logs: Logs, fits: Sequence[FilterFit], rise: float) -> bool:
    """Whether white noise explains the logs: the cost of a bandwidth far above all rates is at most `rise` above that of
    the best filter.
    """
    highest = np.array([corner_limits(logs.spectra)[1]])
    form = replace(fits[0].form, filter=all_filters()[0])
    return logs.fit_levels(form, highest).deviance + form.price <= fits[0].cost + rise


def _region(logs: Logs, best: FilterFit, highest: float) -> list[Explanation]:
    def explanation(numbers: Floats) -> Explanation | None:
        """Fit the levels with these parameters; None beyond the edge of the region."""
        fit = logs.fit_levels(best.form, numbers, begin=best.fit.model)
        margin = highest - fit.deviance - best.form.price
        if margin < 0:
            return None
        error = logs.error_of_density(best.form, numbers, fit)
        if not error < fit.levels[0]:
            return None
        return Explanation(
            filter=best.filter,
            numbers=numbers,
            density=float(fit.levels[0]),
            spread=math.sqrt(margin) * error / float(fit.levels[0]),
        )

    centre = explanation(best.numbers)
    region = [] if centre is None else [centre]
    margin = max(highest - best.cost, 0.0)
    inside = _INSIDE if len(best.numbers) == 1 else _INSIDE_TWO_PARAMETERS
    for direction in _directions(logs, best):

        def along(way: float, direction: Floats = direction) -> Explanation | None:
            return explanation(limited(best.filter, best.numbers + way * direction, logs.spectra))

        edge, reached = _edge(along, math.sqrt(margin))
        region += reached
        region += filter(None, (along(part * edge) for part in inside))
    return region


def _edge(along: Callable[[float], Explanation | None], way: float) -> tuple[float, list[Explanation]]:
    """Find the distance to the edge along one direction, and the farthest explanation that was tried."""
    low, high, farthest = 0.0, way, []
    for _ in range(_MAX_EXPANSIONS):
        tried = along(high)
        if tried is None:
            break
        low, farthest = high, [tried]
        high *= _EXPANSION
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        tried = along(middle)
        low, high = (low, middle) if tried is None else (middle, high)
        farthest = farthest if tried is None else [tried]
    return low, farthest


def _directions(logs: Logs, best: FilterFit) -> list[Floats]:
    """Directions in the space of the parameters, each as long as one standard error."""
    errors = logs.errors_of_numbers(best)
    if len(errors) == 1:
        return [errors[:, 0], -errors[:, 0]]
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return [errors @ np.array([math.cos(a), math.sin(a)]) for a in angles]


@frozen(eq=False)
class Contradiction:
    """How one log contradicts the others.

    Attributes
    ----------
    name : str
        Name of the log.
    chi2, p_value : float
        Fall of the deviance if this log is fitted with a separate N and filter; the p-value is multiplied by the number
        of logs.
    freedom : int
    ratio : float
        Ratio of N of this log to that of the others, with the filter of the others. [1]
    bandwidth_ratio : float or None
        Ratio of the bandwidth of this log to that of the others; None if a bandwidth is not determined. [1]
    """

    name: str
    chi2: float
    freedom: int
    p_value: float
    ratio: float
    bandwidth_ratio: float | None

    def exceeds(self, n_change: float, bandwidth_change: float) -> bool:
        """Whether N or the bandwidth differs by more than its allowed factor."""
        ratios = ((self.ratio, n_change), (self.bandwidth_ratio or 1.0, bandwidth_change))
        return any(not 1 / limit <= ratio <= limit for ratio, limit in ratios)


def contradiction(logs: Logs, best: FilterFit, significant: float) -> Contradiction | None:
    """Find the log that contradicts the others most; None for a single log, or if the p-value is not below
    `significant`.
    """
    count, freedom = len(logs.spectra), 1 + best.filter.count + best.form.converter
    if count == 1:
        return None
    falls = []
    for k in range(count):
        single, remaining = _separated(logs, k)
        falls.append(best.fit.deviance - _refitted(single, best).fit.deviance - _refitted(remaining, best).fit.deviance)
    k = int(np.argmax(falls))
    p = min(count * float(chi2_above(freedom, max(falls[k], 0.0))), 1.0)
    if p >= significant:
        return None
    # To quantify the difference, this log is fitted with the filter of the other logs.
    single, remaining = _separated(logs, k)
    remaining_fit = best_fits(remaining)[0]
    level = float(single.fit_levels(remaining_fit.form, remaining_fit.numbers).levels[0] / remaining_fit.fit.levels[0])
    return Contradiction(
        name=logs.spectra[k].name, chi2=falls[k], freedom=freedom, p_value=p, ratio=math.sqrt(max(level, _SMALLEST_RATIO)),
        bandwidth_ratio=_ratio_of_bandwidths((single, _refitted(single, remaining_fit)), (remaining, remaining_fit)),
    )  # fmt: skip


def _separated(logs: Logs, k: int) -> tuple[Logs, Logs]:
    """Separate log k from the others."""
    return Logs.from_spectra([logs.spectra[k]]), Logs.from_spectra([*logs.spectra[:k], *logs.spectra[k + 1 :]])


def _ratio_of_bandwidths(*fits: tuple[Logs, FilterFit]) -> float | None:
    """Ratio of the first bandwidth to the second; None if the curvature does not determine one of them."""
    if any(float(logs.errors_of_numbers(fit)[0].max()) > _LARGEST_BANDWIDTH_ERROR for logs, fit in fits):
        return None
    return math.exp(float(fits[0][1].numbers[0] - fits[1][1].numbers[0]))


def _refitted(logs: Logs, best: FilterFit) -> FilterFit:
    """Fit the form of `best` to these logs only."""
    fit = logs.fit_levels(best.form, best.numbers)
    return logs.fit_numbers(FilterFit(form=best.form, numbers=best.numbers, fit=fit))
