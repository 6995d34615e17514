"""Test of which densities of a spectrum are independent: a window makes neighbouring frequencies similar."""

from __future__ import annotations

import numpy as np

from sigmatau.arrays import Floats

_LARGEST_STEP = 4  # largest distance of frequencies: windows correlate up to three neighbours (flat top)
_SIGMAS = 3.0  # smallest reduction of the scatter that counts as correlation [standard errors]
_ERROR = 2.2
"""Standard error of the ratio of mean squares in `independent_step` for independent values, times √n: 2.15 to 2.27 in
1500 sets of 100, 400 and 2000 logarithms of χ² with 2 and 100 degrees of freedom."""


def independent_step(density: Floats) -> int:
    """Smallest distance of frequencies with independent densities; 1 if all are independent.

    The second difference of adjacent logarithms is compared with that of every second logarithm. Neither depends on the
    level or the slope of the spectrum. For a Hann window the ratio of their mean squares is 0.44, and for independent
    values it is 1.
    """
    logarithms = np.log(density)
    for step in range(1, _LARGEST_STEP):
        x = logarithms[::step]
        n = len(x) - 4
        if n < 1:
            return step
        adjacent = float(np.mean((x[1:-3] - 2 * x[2:-2] + x[3:-1]) ** 2))
        spaced = float(np.mean((x[:-4] - 2 * x[2:-2] + x[4:]) ** 2))
        if not adjacent < (1 - _SIGMAS * _ERROR / np.sqrt(n)) * spaced:
            return step
    return _LARGEST_STEP
