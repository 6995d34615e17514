"""Samples of the noise terms as arrays, without a record."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sigmatau._native.generators import Generator
from sigmatau.noise.terms import NOISE, TERMS


def simulated(
    n: int, tau0: float, coefficients: Mapping[str, float], *, seed: int, stream: int = 1
) -> NDArray[np.float64]:
    """Rate samples, with the random numbers of a channel; the ramp is first, because a sum of floats depends on the
    order.
    """
    made, rate = Generator(n, tau0, seed=seed), np.empty(n)
    for term in sorted(TERMS, key=NOISE.__contains__):
        if coefficients.get(term, 0.0):
            made.add_term(term, coefficients[term], channel=stream)
    made.fill(rate)
    return rate
