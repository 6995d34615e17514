"""Mixtures of noise that the studies of the fit simulate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sigmatau.units import to_si

__all__ = ["ABSENT", "GRADES", "SHORT", "Mixture", "crb", "si"]


def si(**coefficients: str) -> dict[str, float]:
    """Convert ``si(random_walk="0.3 deg/sqrt(h)")`` to SI."""
    return {term: to_si(float(text.split()[0]), text.split()[1]) for term, text in coefficients.items()}


@dataclass(frozen=True)
class Mixture:
    """Terms of one channel, and the record: samples and rate."""

    n: int
    rate: float
    truth: Mapping[str, float] = field(default_factory=dict)
    channel: str = "gyro_x"


GRADES: dict[str, Mixture] = {
    "MEMS": Mixture(
        2**20,
        100.0,
        si(random_walk="0.3 deg/sqrt(h)", bias_instability="10.08 deg/h", rate_random_walk="21.6 deg/h/sqrt(h)"),
    ),
    "tactical": Mixture(
        2**19,
        100.0,
        si(
            quantization="1.008 arcsec",
            random_walk="0.102 deg/sqrt(h)",
            bias_instability="0.504 deg/h",
            rate_random_walk="1.188 deg/h/sqrt(h)",
        ),
    ),
    "navigation": Mixture(2**20, 200.0, si(quantization="0.972 arcsec", random_walk="0.0015 deg/sqrt(h)")),
}
"""Three grades of gyro; the last is the CIMU X of the paper (Table II)."""

_N = 2**15
# In units of the random walk and of samples: only the crossings of the terms matter, not their sizes.
SHORT: dict[str, Mixture] = {
    "N": Mixture(_N, 1.0, {"random_walk": 1.0}),
    "Q": Mixture(_N, 1.0, {"quantization": 1.0}),
    "B": Mixture(_N, 1.0, {"bias_instability": 1.0}),
    "K": Mixture(_N, 1.0, {"rate_random_walk": 1.0}),
    "N B": Mixture(_N, 1.0, {"random_walk": 1.0, "bias_instability": 0.1}),
    "N K": Mixture(_N, 1.0, {"random_walk": 1.0, "rate_random_walk": 3e-3}),
    "Q N": Mixture(_N, 1.0, {"quantization": 10.0, "random_walk": 1.0}),
    "Q B": Mixture(_N, 1.0, {"quantization": 30.0, "bias_instability": 0.1}),
    "Q K": Mixture(_N, 1.0, {"quantization": 30.0, "rate_random_walk": 1e-2}),
    "N B K": Mixture(_N, 1.0, {"random_walk": 1.0, "bias_instability": 0.1, "rate_random_walk": 5e-3}),
    "Q N B": Mixture(_N, 1.0, {"quantization": 2.0, "random_walk": 1.0, "bias_instability": 0.2}),
    "N R": Mixture(_N, 1.0, {"random_walk": 1.0, "rate_ramp": 2e-5}),
    "N B R": Mixture(_N, 1.0, {"random_walk": 1.0, "bias_instability": 0.1, "rate_ramp": 2e-4}),
}
"""Records of 2^15 samples, for cells of a thousand records."""

ABSENT = {name: mixture for name, mixture in SHORT.items() if len(mixture.truth) < 4}


def crb(spectra: NDArray[np.float64], modes: NDArray[np.float64], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cramér-Rao bound of the relative standard deviation of the coefficients √θ, with only the terms with θ > 0 in the
    model.

    From the Fisher information ½ Σ S_p S_q / S² of independent modes (`sigmatau.fitting.components`), into which the
    discrete cosine transform converts white noise and a random walk exactly; `tests/fitting/test_components.py` compares
    it with the information of the full covariance matrix.
    """
    active = np.flatnonzero(theta)
    ratio = spectra[active] / (theta @ spectra)
    information = 0.5 * (ratio * modes) @ ratio.T
    scale = np.sqrt(np.diag(information))
    covariance = np.linalg.inv(information / np.outer(scale, scale)) / np.outer(scale, scale)
    return np.asarray(np.sqrt(np.diag(covariance)) / (2 * theta[active]))
