"""Where the line of each fitted term can be laid: the averaging times at which the term makes most of the variance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from sigmatau.arrays import distinct
from sigmatau.noise.terms import avar

if TYPE_CHECKING:
    from sigmatau.fitting.noise_fit import NoiseFit

MOST = 0.5
"""Least share of the variance of the model: between the crossings with the lines of the other terms."""

_FILTERED = 1.25  # share above which the line is above the curve, because of a filter
_LONGEST = 4  # part of the record up to which a line is laid, as in the paper: an error by eq. (26) of 41 %
_PER_OCTAVE = 8
_SHORTEST = 2.0  # ratio of the longest to the shortest averaging time of a range

Span = tuple[float, float]


def line_ranges(fitted: NoiseFit) -> Mapping[str, Span | None]:
    """Range of averaging times of each observed term, in s; None if the term never makes half of the variance of the model
    over an octave, between the shortest averaging time that the model describes and a quarter of the record.
    """
    observed = fitted.observed if fitted.quantified else {}
    if not observed or fitted.tau_min is None:
        return {}
    octaves = np.log2(max(fitted.n / _LONGEST, 1))
    m = distinct(np.rint(2 ** np.arange(0, octaves + 1e-9, 1 / _PER_OCTAVE)).astype(np.int64))
    m = m[m * fitted.tau0 >= fitted.tau_min * (1 - 1e-9)]
    ranges: dict[str, Span | None] = dict.fromkeys(observed)
    if not len(m):
        return ranges
    total = fitted.avar(m=m)
    for name, value in observed.items():
        share = avar(name, value, m=m, tau0=fitted.tau0) / total
        inside = np.concatenate(([False], (share >= MOST) & (share <= _FILTERED), [False]))
        if not inside.any():
            continue
        first, last = np.flatnonzero(np.diff(inside)).reshape(-1, 2).T
        k = int(np.argmax(m[last - 1] / m[first]))
        span = float(m[first[k]] * fitted.tau0), float(m[last[k] - 1] * fitted.tau0)
        if span[1] >= _SHORTEST * span[0]:
            ranges[name] = span
    return ranges
