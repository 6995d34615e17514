"""Linear Gauss-Markov systems over many steps at once, by doubling.

For x' = F·x + w, cov w = W, n steps are x → Fⁿ·x + wₙ with Fᵃ⁺ᵇ = Fᵇ·Fᵃ and W₍ₐ₊ᵦ₎ = Fᵇ·Wₐ·Fᵇᵀ + Wᵦ. So n steps take
2·log₂(n) products, and are as accurate as single steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """Transition and noise of some steps of a linear system."""

    transition: Floats  # shape (n_states, n_states)
    noise: Floats  # shape (n_states, n_states); covariance of the noise added by the steps

    def then(self, later: Steps) -> Self:
        """These steps, followed by the `later` ones."""
        noise = later.transition @ self.noise @ later.transition.T + later.noise
        return type(self)(later.transition @ self.transition, (noise + noise.T) / 2)

    def times(self, n: int) -> Steps:
        """These steps `n` times in a row; n ≥ 0."""
        size = len(self.transition)
        result, power = Steps(np.eye(size), np.zeros((size, size))), self
        while n:
            if n & 1:
                result = result.then(power)
            n >>= 1
            if n:
                power = power.then(power)
        return result

    def covariance(self, before: Floats) -> Floats:
        """Covariance of the state after these steps, from the covariance before; both of shape (n_states, n_states)."""
        return np.asarray(self.transition @ before @ self.transition.T + self.noise)
