"""Table of the estimators: names, units, requirements and averaging times.

References
----------
.. [1] W. J. Riley, "Handbook of Frequency Stability Analysis," NIST Special Publication 1065, 2008.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sigmatau._native import kernels
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.estimators.tau_grid import TauGrid, averaging_times, cluster_sizes

__all__ = ["KINDS", "Estimator", "Kind", "estimator", "sizes_for"]

_ALL = 20_000  # samples up to which every averaging time is done one by one

Kind = Literal["modified", "hadamard", "total", "time", "theo1", "mtie", "tie_rms"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimator:
    """An entry of `KINDS`."""

    label: str  # As it is printed
    kernel: str  # The estimator of the core that it is made of
    of_phase: bool = False  # Whether it is in the unit of the phase (rad, m/s), not of the rate
    tau_per_m: float = 1.0  # Averaging time over the cluster size in samples


KINDS: Mapping[str, Estimator] = {
    "modified": Estimator(label="modified Allan deviation", kernel="modified"),
    "hadamard": Estimator(label="Hadamard deviation", kernel="hadamard"),
    "total": Estimator(label="total deviation", kernel="total"),
    "time": Estimator(label="time deviation", kernel="modified", of_phase=True),
    "theo1": Estimator(label="Theo1 deviation", kernel="theo1", tau_per_m=0.75),
    "mtie": Estimator(label="MTIE", kernel="mtie", of_phase=True),
    "tie_rms": Estimator(label="TIE rms", kernel="tie_rms", of_phase=True),
}
"""Estimators by name; section 5.2 of [1]_."""


def estimator(kind: str) -> Estimator:
    """The estimator of a name; raises `OptionError` for an unknown one."""
    if not isinstance(kind, str) or kind not in KINDS:
        raise OptionError(f"unknown kind of deviation {kind!r}; kinds: {', '.join(KINDS)}", option="kind")
    return KINDS[kind]


def sizes_for(kind: str, taus: TauGrid | ArrayLike, *, n: int, tau0: float) -> NDArray[np.int64]:
    """Cluster sizes in samples for a record of `n` samples, increasing; see `sigmatau.deviation`."""
    chosen = estimator(kind)
    smallest, largest, least = kernels.deviation_limits(chosen.kernel, n)
    if largest < smallest:
        raise RecordTooShortError(
            f"{n} samples are too few for the {chosen.label}: at least {least} are needed", need=least, got=n
        )
    if isinstance(taus, str) and taus == "all" and n > _ALL:
        raise OptionError(
            f"{{option}} 'all' of {n} samples takes some N² steps for the {chosen.label}; it is done up to {_ALL}: take a"
            " grid such as 'eighth'",
            option="taus",
        )
    even = 2 if chosen.kernel == "theo1" else 1
    if isinstance(taus, str):
        # Beyond half the record the total deviation has fewer than three degrees of freedom: only if it is asked for.
        reach = min(largest, max(n // 2, 1)) if kind == "total" else largest
        sizes = cluster_sizes(taus, n=2 * reach, tau0=tau0)
        sizes = sizes[(sizes >= smallest) & (sizes % even == 0)]
        return sizes if sizes.size else np.array([smallest], dtype=np.int64)
    times = averaging_times(taus)
    rounded = even * np.rint(times / (even * chosen.tau_per_m * tau0))
    outside = times[(rounded < smallest) | (rounded > largest)]
    if outside.size:
        low, high = (size * chosen.tau_per_m * tau0 for size in (smallest, largest))
        raise OptionError(
            f"τ = {outside[0]:.6g} s is out of reach of the {chosen.label}: {n} samples at {1 / tau0:.6g} Hz give"
            f" {low:.6g} s to {high:.6g} s",
            option="taus",
        )
    return np.unique(rounded).astype(np.int64)
