"""Compiled generators of noise; see `sigmatau._native.kernels`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sigmatau import _core


class Generator:
    """Generator of the noise of one channel. The samples do not depend on the sizes of the pieces.

    Parameters
    ----------
    n : int
        Samples in all.
    tau0 : float
        [s]
    seed : int

    Raises
    ------
    ValueError
        For a `tau0` that is not positive.
    """

    __slots__ = ("_made",)

    def __init__(self, n: int, tau0: float, *, seed: int) -> None:
        self._made = _core.Generator(n, tau0, seed)

    def add_term(self, term: str, value: float, *, channel: int, poles: bool = False) -> None:
        """Add one of the five terms, bias instability exact or as poles; `channel` numbers its random stream."""
        self._made.add_term(term, value, channel, poles)

    def add_filtered(
        self,
        scale: float,
        transition: NDArray[np.float64],
        noise: NDArray[np.float64],
        start: NDArray[np.float64],
        *,
        channel: int,
    ) -> None:
        """Add the first state of x' = A·x + L·w, scaled; w is the white noise of the random walk.

        `transition` is A. `noise` is L, where L·Lᵀ is the covariance that a step adds. `start` is this factor of
        the covariance of the initial state. Each has shape (n_states, n_states).
        """
        self._made.add_filtered(
            scale, transition.ravel().tolist(), noise.ravel().tolist(), start.ravel().tolist(), channel
        )

    def add_gauss_markov(self, sigma: float, time: float, *, index: int, channel: int) -> None:
        """Add a first-order Gauss-Markov process, number `index` of the channel."""
        self._made.add_gauss_markov(sigma, time, index, channel)

    def add_sinusoid(self, amplitude: float, frequency: float, *, index: int, channel: int) -> None:
        """Add a sinusoid of random phase, number `index` of the channel."""
        self._made.add_sinusoid(amplitude, frequency, index, channel)

    def fill(self, rate: NDArray[np.float64]) -> None:
        """Fill a contiguous array with the next samples; raises ValueError if fewer are left."""
        self._made.fill(rate)


def flicker_poles(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Poles p whose sum approximates flicker noise of `n` samples: 1 − p and weights, each of shape (n_poles,)."""
    return _core.flicker_poles(n)
