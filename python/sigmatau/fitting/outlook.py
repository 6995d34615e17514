"""How long a record would have to be to show a term that was not observed."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sigmatau.fitting.attempt import LONGEST_SHARE
from sigmatau.fitting.components import LINEAR, components, power_of_interval
from sigmatau.fitting.gls import Gls
from sigmatau.fitting.inference import detectable_theta

__all__ = ["Outlook", "half_octaves"]

_SHOWN_IN_SHARE = 0.9  # of the records: power of the recommended record length
_LONGER = 4  # times the record, for the second length from which the recommended length is extrapolated
_LONGEST = math.log(1e15)  # samples


@dataclass(slots=True, eq=False)
class Outlook:
    """Length in seconds of a record that shows half the limit of a term, and that half; computed at the first call.

    The smallest θ that a least-squares fit finds falls as a power of the length, which is extrapolated from two lengths.
    """

    n: int  # samples of the record
    tau0: float
    first: int  # smallest cluster size
    term: int
    linear: tuple[int, ...]  # terms that are fitted
    others: NDArray[np.float64]  # θ of the other terms, in samples
    high: float  # limit of θ, in samples
    known: tuple[float | None, float | None] | None = None

    @classmethod
    def of_limit(cls, term: str, limit: float, squares: Mapping[str, float], *, n: int, tau0: float) -> Outlook:
        """From squared coefficients in SI: the limit of a term, and the others."""
        scales = {name: tau0 ** (power_of_interval(name) - 2) for name in LINEAR}
        others = np.array([squares.get(name, 0.0) * scales[name] * (name != term) for name in LINEAR])
        return cls(
            n=n,
            tau0=tau0,
            first=1,
            term=LINEAR.index(term),
            linear=tuple(range(len(LINEAR))),
            others=others,
            high=limit * scales[term],
        )

    def __call__(self) -> tuple[float | None, float | None]:
        if self.known is None:
            samples, theta = self._would_show()
            name = LINEAR[self.term]
            value = None if theta is None else math.sqrt(theta) * self.tau0 ** (1 - power_of_interval(name) / 2)
            self.known = None if samples is None else samples * self.tau0, value
        return self.known

    def _would_show(self) -> tuple[float | None, float | None]:
        if not math.isfinite(self.high) or not self.others.any():
            return None, None
        wanted = math.log(self.high / 4)
        lengths, least = [], []
        for times in (1, _LONGER):
            n = self.n * times
            parts = components(n, half_octaves(self.first, n // LONGEST_SHARE))
            problem = Gls(parts, parts.design @ self.others, self.linear)
            theta = detectable_theta(problem, self.term, self.others, level=0.95, power=_SHOWN_IN_SHARE)
            lengths.append(math.log(n))
            least.append(math.log(theta) if math.isfinite(theta) else math.inf)
        if not all(map(math.isfinite, least)) or least[0] <= wanted:
            return None, None
        slope = (least[1] - least[0]) / (lengths[1] - lengths[0])
        length = lengths[0] + (wanted - least[0]) / slope if slope < -1e-3 else math.inf
        return (math.exp(length), math.exp(wanted)) if length < _LONGEST else (None, None)


def half_octaves(smallest: int, largest: int) -> Sequence[int]:
    """Those of the cluster sizes 1, 2, 3, 4, 6, 8, 12 … that lie between two sizes."""
    sizes = {seed << j for seed in (1, 3) for j in range(largest.bit_length())}
    return tuple(sorted(size for size in sizes if smallest <= size <= largest))
