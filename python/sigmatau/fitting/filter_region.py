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

_DIRECTIONS = 12  # about the best of two numbers, in which the edge is searched
_INSIDE_OF_TWO = (0.4, 0.75)  # of the way to the edge
_INSIDE = (0.2, 0.4, 0.6, 0.8)
_BISECTIONS = 6  # of the way to the edge: 2 % of it
_WIDER = 2.0  # factor of a way that does not reach the edge
_WIDENINGS = 14
_NOTHING = 1e-12  # ratio of N² of a log without white noise
_KNOWN_BANDWIDTH = 0.1  # relative error up to which a log has a bandwidth to be compared


@frozen(eq=False)
class Explanation:
    """A filter with numbers that explain the logs.

    Attributes
    ----------
    filter : SensorFilter
    numbers : ndarray, shape (n_numbers,)
    density : float
        N². [(unit of the rate)²/Hz]
    spread : float
        Half the width of ln N² that the deviance leaves with these numbers.
    """

    filter: SensorFilter
    numbers: Floats
    density: float
    spread: float


def explanations(logs: Logs, fits: Sequence[FilterFit], rise: float) -> list[Explanation]:
    """Filters of all forms whose cost is at most `rise` above the least, the best first: of each form the edge of the region
    whose cost is at most `rise` above that of its best, and points inside it.
    """
    region: list[Explanation] = []
    for fit in fits:
        if fit.cost <= fits[0].cost + rise:
            region += _region(logs, fit, fit.cost + rise)
    return region


def is_white(logs: Logs, fits: Sequence[FilterFit], rise: float) -> bool:
    """Whether a bandwidth far above all rates has a cost of at most `rise` above the least."""
    highest = np.array([corner_limits(logs.spectra)[1]])
    form = replace(fits[0].form, filter=all_filters()[0])
    return logs.fit_levels(form, highest).deviance + form.price <= fits[0].cost + rise


def _region(logs: Logs, best: FilterFit, highest: float) -> list[Explanation]:
    def explanation(numbers: Floats) -> Explanation | None:
        """None beyond the edge."""
        fit = logs.fit_levels(best.form, numbers, begin=best.fit.model)
        room = highest - fit.deviance - best.form.price
        if room < 0:
            return None
        error = logs.error_of_density(best.form, numbers, fit)
        if not error < fit.levels[0]:
            return None
        return Explanation(
            filter=best.filter,
            numbers=numbers,
            density=float(fit.levels[0]),
            spread=math.sqrt(room) * error / float(fit.levels[0]),
        )

    centre = explanation(best.numbers)
    region = [] if centre is None else [centre]
    room = max(highest - best.cost, 0.0)
    inside = _INSIDE if len(best.numbers) == 1 else _INSIDE_OF_TWO
    for direction in _directions(logs, best):

        def along(way: float, direction: Floats = direction) -> Explanation | None:
            return explanation(limited(best.filter, best.numbers + way * direction, logs.spectra))

        edge, reached = _edge(along, math.sqrt(room))
        region += reached
        region += filter(None, (along(part * edge) for part in inside))
    return region


def _edge(along: Callable[[float], Explanation | None], way: float) -> tuple[float, list[Explanation]]:
    """How far explanations reach, and the farthest of them."""
    low, high, farthest = 0.0, way, []
    for _ in range(_WIDENINGS):
        tried = along(high)
        if tried is None:
            break
        low, farthest = high, [tried]
        high *= _WIDER
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        tried = along(middle)
        low, high = (low, middle) if tried is None else (middle, high)
        farthest = farthest if tried is None else [tried]
    return low, farthest


def _directions(logs: Logs, best: FilterFit) -> list[Floats]:
    """Directions of the numbers, with the length of one standard error."""
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
        Of the log.
    chi2, p_value : float
        Fall of the deviance if the log has an N and a filter for itself; p with the number of logs as a factor.
    freedom : int
    ratio : float
        N of this log over that of the others, behind their filter. [1]
    bandwidth_ratio : float or None
        Bandwidth of this log over that of the others; None if one of them does not show it. [1]
    """

    name: str
    chi2: float
    freedom: int
    p_value: float
    ratio: float
    bandwidth_ratio: float | None

    def exceeds(self, n_change: float, bandwidth_change: float) -> bool:
        """Whether N or the bandwidth differs by more than a factor."""
        ratios = ((self.ratio, n_change), (self.bandwidth_ratio or 1.0, bandwidth_change))
        return any(not 1 / limit <= ratio <= limit for ratio, limit in ratios)


def contradiction(logs: Logs, best: FilterFit, significant: float) -> Contradiction | None:
    """The log that contradicts the others the most; None of a single log, or if the p-value is not below `significant`."""
    count, freedom = len(logs.spectra), 1 + best.filter.count + best.form.converter
    if count == 1:
        return None
    falls = []
    for k in range(count):
        alone, rest = _separated(logs, k)
        falls.append(best.fit.deviance - _anew(alone, best).fit.deviance - _anew(rest, best).fit.deviance)
    k = int(np.argmax(falls))
    p = min(count * float(chi2_above(freedom, max(falls[k], 0.0))), 1.0)
    if p >= significant:
        return None
    # How it differs, behind the filter that the others have without it.
    alone, rest = _separated(logs, k)
    rest_fit = best_fits(rest)[0]
    level = float(alone.fit_levels(rest_fit.form, rest_fit.numbers).levels[0] / rest_fit.fit.levels[0])
    return Contradiction(
        name=logs.spectra[k].name, chi2=falls[k], freedom=freedom, p_value=p, ratio=math.sqrt(max(level, _NOTHING)),
        bandwidth_ratio=_ratio_of_bandwidths((alone, _anew(alone, rest_fit)), (rest, rest_fit)),
    )  # fmt: skip


def _separated(logs: Logs, k: int) -> tuple[Logs, Logs]:
    """One log, and the others."""
    return Logs.from_spectra([logs.spectra[k]]), Logs.from_spectra([*logs.spectra[:k], *logs.spectra[k + 1 :]])


def _ratio_of_bandwidths(*fits: tuple[Logs, FilterFit]) -> float | None:
    """The first over the second; None if the curvature of one does not show it."""
    if any(float(logs.errors_of_numbers(fit)[0].max()) > _KNOWN_BANDWIDTH for logs, fit in fits):
        return None
    return math.exp(float(fits[0][1].numbers[0] - fits[1][1].numbers[0]))


def _anew(logs: Logs, best: FilterFit) -> FilterFit:
    """The form fitted to some of the logs."""
    fit = logs.fit_levels(best.form, best.numbers)
    return logs.fit_numbers(FilterFit(form=best.form, numbers=best.numbers, fit=fit))
