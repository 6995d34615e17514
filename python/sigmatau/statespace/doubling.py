"""Linear Gauss-Markov systems over many steps at once, by doubling.

For x' = F·x + w, cov w = W, n steps are x → Fⁿ·x + wₙ with Fᵃ⁺ᵇ = Fᵇ·Fᵃ and W₍ₐ₊ᵦ₎ = Fᵇ·Wₐ·Fᵇᵀ + Wᵦ. Therefore n steps
take 2·log₂(n) products, and are as accurate as single steps.
"""

from __future__ import annotations

import math
from typing import Self

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.frozen import frozen

_SERIES = 40
"""Terms of a power series in ‖a‖·t ≤ 1/2: those of order 9 begin with the 17th, and the last are below 1e-40."""


@frozen(kw_only=False, eq=False)
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

    @classmethod
    def of_continuous(cls, a: Floats, density: Floats, time: float) -> RepeatedStep:
        """One step of ẋ = a·x + white noise of a density: its power series over a short time, then doubled.

        Parameters
        ----------
        a : ndarray, shape (n_states, n_states)
            Rates of the states. [SI units of the states, per unit of time]
        density : ndarray, shape (n_states, n_states)
            Two-sided density of their noise. [SI units of the states, squared, per unit of time]
        time : float
            Length of the step, in the same unit of time, s for SI. [s]

        Returns
        -------
        RepeatedStep
            A step of this length.
        """
        fastest = float(np.abs(a).sum(axis=1).max(initial=0.0)) * time
        doublings = max(math.ceil(math.log2(2 * fastest)), 0) if fastest else 0
        short = time / 2**doublings
        power = transition = np.eye(len(a))
        term = noise = density * short
        for k in range(1, _SERIES):
            power = power @ a * (short / k)
            transition = transition + power
            term = (a @ term + term @ a.T) * (short / (k + 1))
            noise = noise + term
        return cls(transition, noise).times(2**doublings)

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
            Number of repetitions, 0 or more.

        Returns
        -------
        RepeatedStep
            All steps together, by doubling.
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
