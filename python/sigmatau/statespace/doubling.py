"""Linear Gauss-Markov systems over many steps at once, by doubling.

For x' = F·x + w, cov w = W, n steps are x → Fⁿ·x + wₙ with Fᵃ⁺ᵇ = Fᵇ·Fᵃ and W₍ₐ₊ᵦ₎ = Fᵇ·Wₐ·Fᵇᵀ + Wᵦ. So n steps take
2·log₂(n) products, and are as accurate as single steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from sigmatau.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class RepeatedStep:
    """Transition and noise of some steps of a linear system.

    Attributes
    ----------
    transition : ndarray, shape (n_states, n_states)
        Transition matrix of all steps together. [SI units of the states]
    noise : ndarray, shape (n_states, n_states)
        Covariance of the noise that the steps add. [SI units of the states, squared]
    """

    transition: Floats
    noise: Floats

    def then(self, later: RepeatedStep) -> Self:
        """These steps, followed by the `later` ones.

        Parameters
        ----------
        later : RepeatedStep
            Steps of the same states.

        Returns
        -------
        RepeatedStep
            Both together.
        """
        noise = later.transition @ self.noise @ later.transition.T + later.noise
        return type(self)(later.transition @ self.transition, (noise + noise.T) / 2)

    def times(self, n: int) -> RepeatedStep:
        """These steps `n` times in a row.

        Parameters
        ----------
        n : int
            How many times, from 0.

        Returns
        -------
        RepeatedStep
            All of them together, made by doubling.
        """
        size = len(self.transition)
        result, power = RepeatedStep(np.eye(size), np.zeros((size, size))), self
        while n:
            if n & 1:
                result = result.then(power)
            n >>= 1
            if n:
                power = power.then(power)
        return result

    def covariance(self, before: Floats) -> Floats:
        """Covariance of the state after these steps.

        Parameters
        ----------
        before : ndarray, shape (n_states, n_states)
            Covariance before them. [SI units of the states, squared]

        Returns
        -------
        ndarray, shape (n_states, n_states)
            [SI units of the states, squared]
        """
        return np.asarray(self.transition @ before @ self.transition.T + self.noise)
