"""Choice of the shortest averaging time of a fit, and of a Gauss-Markov process."""

from __future__ import annotations

from sigmatau.fitting.attempt import Attempt, Data, attempt
from sigmatau.fitting.gauss_markov import best_time

LEAST_TIMES = 8  # Smallest number of averaging times: four terms, and four degrees of freedom for the goodness of fit
LEAST_P = 0.002  # Smallest p-value of the goodness of fit with all averaging times for the model to be adequate
LEAST_P_LATER = 0.01  # The same once shorter averaging times are left out, which are then known to deviate
PROCESS_P = 0.3
"""Largest p-value of the terms alone for a process to be tried. It misses 1 of 256 that were worth their price."""

LARGEST_START = 128
"""Largest shortest averaging time: an internal low-pass filter has no effect beyond it in practice. [samples]"""


def best_attempt(data: Data, *, level: float) -> tuple[Attempt | None, Attempt | None]:
    """The adequate attempt or None, and the attempt with the largest p-value."""
    starts = [k for k, m in enumerate(data.m) if m <= LARGEST_START and len(data.m) - k >= LEAST_TIMES]
    if data.first is not None or not starts:
        starts = [data.first or 0]
    tried: list[Attempt] = []
    for first in starts:
        found = attempt(data, first, level)
        if found is not None and first == starts[0]:
            found = _with_process(data, found, level)
        if found is None:
            continue
        if found.p_value > (LEAST_P if first == starts[0] else LEAST_P_LATER):
            return (found if first == starts[0] else _an_octave_later(data, found, level)), found
        tried.append(found)
    # A process at later starts only now: it could stand for what is left of a filter.
    for later in [one for one in tried if one.first != starts[0] and data.m[one.first].bit_count() == 1]:
        found = _with_process(data, later, level)
        if found.p_value > LEAST_P_LATER:
            return found, found
        tried.append(found)
    return None, max(tried, key=lambda one: one.p_value, default=None)


def _with_process(data: Data, found: Attempt, level: float) -> Attempt:
    """The fit with a Gauss-Markov process if it is worth its price, otherwise the fit as it is."""
    if found.p_value >= PROCESS_P:
        return found
    time = best_time(data, found, level=level)
    return (None if time is None else attempt(data, found.first, level, time)) or found


def _an_octave_later(data: Data, found: Attempt, level: float) -> Attempt:
    """The fit from twice the averaging time on, where a deviation that was just not significant is half as large."""
    later = next((k for k, m in enumerate(data.m) if m >= 2 * data.m[found.first]), None)
    if later is None or len(data.m) - later < LEAST_TIMES:
        return found
    again = attempt(data, later, level)
    return again if again is not None and again.p_value > LEAST_P_LATER else found
