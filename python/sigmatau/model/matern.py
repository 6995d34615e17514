"""Matérn processes of a noise model: generalised Gauss-Markov processes, and the sums by which filters have them."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from sigmatau._native import kernels
from sigmatau.arrays import Floats
from sigmatau.errors import DataError
from sigmatau.frozen import frozen
from sigmatau.model.processes import GaussMarkov, positive, real

SMOOTHNESS = (0.02, 0.5)
"""Range of the smoothness, as in crates/core/src/matern.rs."""

_EXACT_STEP = 0.6  # step of the sum that is the process; the relative error is e^(−2π²/0.6) = 5e-15
_FILTER_STEP = 1.75  # step of the sum for filters; the relative error of the density is below 1e-4
_MAX_WHITE_TIME = 0.1  # correlation time below which a process is white noise, e^(−10) [samples]


@frozen
class Matern:
    """A Matérn process: a generalised Gauss-Markov process, the density of which falls with another power of f.

    Its two-sided density is S(0)·(1 + (2πfT)²)^(−ν − 1/2), its autocovariance σ²·2^(1−ν)/Γ(ν)·(t/T)^ν·K_ν(t/T) at the lag
    t. At times much shorter than T the Allan deviation rises as τ^ν.

    Attributes
    ----------
    sigma : float
        Standard deviation. [unit of the rate]
    time : float
        Correlation time T; the corner of the density is 1/(2πT). [s]
    smoothness : float
        ν, from 0.02 to 0.5. At 0.5 it is the Gauss-Markov process; towards 0 it is flicker noise above its corner, and the
        variance that belongs to a density grows without limit. A smoother process is not a sum of Gauss-Markov processes.
        [1]

    Raises
    ------
    DataError
        For a number that is not positive, or a smoothness outside its range.

    See Also
    --------
    ChannelModel.expand_matern : the process as a sum of Gauss-Markov processes, for filters.

    References
    ----------
    B. Matérn, "Spatial Variation," 1986, :doi:`10.1007/978-1-4615-7892-5`; docs/theory/matern.md derives the sum.

    Examples
    --------
    >>> from sigmatau import ChannelModel, Matern
    >>> process = Matern(sigma=2.0, time=100.0, smoothness=0.25)
    >>> ChannelModel(matern=(process,)).autocovariance([0, 100], tau0=1.0).round(4)
    array([4.    , 0.7992])
    """

    sigma: float
    time: float
    smoothness: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "sigma", positive("the standard deviation of a Matérn process", self.sigma))
        object.__setattr__(self, "time", positive("the correlation time of a Matérn process", self.time))
        smoothness = real(self.smoothness)
        if not SMOOTHNESS[0] <= smoothness <= SMOOTHNESS[1]:
            raise DataError(
                f"the smoothness of a Matérn process must be a number from {SMOOTHNESS[0]} to {SMOOTHNESS[1]},"
                f" not {self.smoothness!r}"
            )
        object.__setattr__(self, "smoothness", smoothness)

    def psd(self, f: Floats) -> Floats:
        """Two-sided density before sampling.

        Parameters
        ----------
        f : ndarray, shape (n_f,)
            Frequencies. [Hz]

        Returns
        -------
        ndarray, shape (n_f,)
            [(unit of the rate)²/Hz]
        """
        power = self.smoothness + 0.5
        level = 2 * math.sqrt(math.pi) * self.time * math.gamma(power) / math.gamma(self.smoothness)
        return np.asarray(self.sigma**2 * level * (1 + (2 * math.pi * f * self.time) ** 2) ** -power)

    def gauss_markov(self, tau0: float, *, step: float = _EXACT_STEP) -> list[GaussMarkov]:
        """The sum of Gauss-Markov processes that its samples are; the fastest one is white noise.

        Parameters
        ----------
        tau0 : float
            Sample interval. [s]
        step : float
            Step of the sum; the relative error of the density is e^(−2π²/step). Default: 1e-13.

        Returns
        -------
        list of GaussMarkov
        """
        variances, times = kernels.matern_processes(self.smoothness, self.time / tau0, step)
        return [
            GaussMarkov(sigma=self.sigma * math.sqrt(variance), time=time * tau0)
            for variance, time in zip(variances, times, strict=True)
        ]


def filter_processes(processes: Iterable[Matern], tau0: float) -> tuple[list[GaussMarkov], float]:
    """Gauss-Markov processes with the densities of Matérn processes up to 0.01 %, and the variance of white samples."""
    parts = [part for process in processes for part in process.gauss_markov(tau0, step=_FILTER_STEP)]
    slow = [part for part in parts if part.time >= _MAX_WHITE_TIME * tau0]
    return slow, sum(part.sigma**2 for part in parts if part.time < _MAX_WHITE_TIME * tau0)
