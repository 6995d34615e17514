"""Flicker noise as a sum of a few Gauss-Markov processes, for filters and simulators.

Flicker noise of density B²/(2πf) is the sum of Gauss-Markov processes of all correlation times, with the variance B²/π for
each factor e of the correlation time. A few processes, evenly spaced on a logarithmic axis, are sufficient for a band of
averaging times. Their non-negative variances minimise the largest error of the Allan variance.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.model.processes import check_sample_interval, real
from sigmatau.results import Printed

LONGEST_BAND = 1e12  # The longest averaging time over the shortest
_POLES_PER_DECADE = (0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0)
_TIMES_PER_OCTAVE = 6  # averaging times per octave at which the Allan deviations are fitted
_FINER_BY = 8  # factor on the number of averaging times at which the error is measured
_DECADES_BEYOND = 0.5  # distance by which poles extend beyond the band at both ends [decades]


@frozen(eq=False)
class FlickerPoles(Printed):
    """Gauss-Markov processes that approximate flicker noise of B = 1."""

    times: Floats  # shape (n_poles,); correlation times. [s]
    variances: Floats  # shape (n_poles,); [B²]
    tau_min: float  # Averaging times for which the approximation holds. [s]
    tau_max: float
    error: float  # largest relative error of the Allan deviation at these times

    def __repr__(self) -> str:
        rows = (f"  {t:10.4g} s  {v:.4g} B²" for t, v in zip(self.times, self.variances, strict=True))
        head = (
            f"flicker noise as {len(self.times)} Gauss-Markov processes: Allan deviation within {100 * self.error:.2g} %"
            f" from {self.tau_min:.4g} s to {self.tau_max:.4g} s"
        )
        return "\n".join([head, *rows])


def flicker_poles(*, dt: float, tau_max: float, error: float = 0.01) -> FlickerPoles:
    """The fewest Gauss-Markov processes that approximate flicker noise, sampled every `dt`.

    Notes
    -----
    The processes minimise the relative error from the exact Allan variance of sampled flicker noise (N. J. Kasdin,
    Proc. IEEE 83, 1995, :doi:`10.1109/5.381848`) at six averaging times per octave; the stated error is measured at 48
    per octave.

    `dt` is the sample interval and shortest averaging time [s], `tau_max` the longest averaging time [s], and `error` the
    largest relative error of the Allan deviation, at least 0.0001.
    """
    check_sample_interval("dt", dt)
    if not (math.isfinite(real(tau_max)) and dt <= tau_max <= LONGEST_BAND * dt):
        raise OptionError(f"{{option}} must be {dt:g} s to {LONGEST_BAND * dt:g} s, not {tau_max!r}", option="tau_max")
    if not 1e-4 <= real(error) < 1:
        raise OptionError(f"{{option}} must be 0.0001 to 1, relative, not {error!r}", option="error")
    times, variances, reached = _poles(tau_max / dt, error)
    return FlickerPoles(times=dt * times, variances=variances.copy(), tau_min=dt, tau_max=tau_max, error=reached)


@functools.lru_cache(maxsize=32)
def _poles(band: float, error: float) -> tuple[Floats, Floats, float]:
    """Correlation times in samples, variances and the error reached."""
    octaves = max(math.log2(band), 0.0)
    sizes, fine = (
        np.unique(np.round(2 ** np.linspace(0, octaves, int(number * octaves) + 2)).astype(np.int64))
        for number in (_TIMES_PER_OCTAVE, _TIMES_PER_OCTAVE * _FINER_BY)
    )
    exact, finely = (kernels.term_avar("bias_instability", 1.0, m, 1.0) for m in (sizes, fine))
    best = np.empty(0), np.empty(0), math.inf
    for per_decade in _POLES_PER_DECADE:
        low, high = -_DECADES_BEYOND, math.log10(band) + _DECADES_BEYOND
        times = 10 ** np.linspace(low, high, math.ceil(per_decade * (high - low)) + 1)
        variances = _closest(_columns(times, sizes) / exact[:, None])
        reached = float(np.abs(np.sqrt(_columns(times, fine) @ variances / finely) - 1).max())
        positive = variances > 0
        if reached < best[2]:
            best = times[positive], variances[positive], reached
        if reached <= error:
            return best
    raise OptionError(
        f"{{option}}: {best[2]:.2g} is the smallest error of poles for flicker noise over this band", option="error"
    )


def _columns(times: Floats, sizes: NDArray[np.int64]) -> Floats:
    """Allan variances of processes of variance 1; shape (n_tau, n_poles)."""
    return np.stack([kernels.gauss_markov_avar(1.0, float(time), sizes, 1.0) for time in times], axis=1)


def _closest(columns: Floats) -> Floats:
    """Non-negative weights that minimise the largest distance of the weighted sum of the columns from 1; shape
    (n_poles,).
    """
    from scipy.optimize import linprog

    rows, poles = columns.shape
    # Minimise t with −t ≤ columns·weights − 1 ≤ t.
    bounds = np.block([[columns, -np.ones((rows, 1))], [-columns, -np.ones((rows, 1))]])
    limits = np.concatenate((np.ones(rows), -np.ones(rows)))
    solved = linprog(np.append(np.zeros(poles), 1.0), A_ub=bounds, b_ub=limits, bounds=(0, None), method="highs")
    if solved.x is None:
        raise FloatingPointError(f"weights of flicker poles: {solved.message}")
    return np.array(solved.x[:-1], dtype=np.float64)
