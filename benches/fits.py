"""Fits, which have no peer: the covariance of the Allan variances, and fits of curves in memory."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

from benches import text
from benches.measure import Settings
from benches.text import Gate
from sigmatau import NoiseModel, allan, fit, simulate
from sigmatau._native import kernels
from sigmatau.fitting.components import half_octaves
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov

_FITS = 50  # number of fits of each curve
_DEGREE = np.pi / 180
_WHITE = {"random_walk": 5e-3 * _DEGREE}
_CURVES = {
    "a random walk": ChannelModel(terms=_WHITE),
    "a random walk, bias instability, a rate random walk": ChannelModel(
        terms={**_WHITE, "bias_instability": 2.8e-3 * _DEGREE, "rate_random_walk": 1e-4 * _DEGREE}
    ),
    "a random walk, a Gauss-Markov process": ChannelModel(
        terms=_WHITE, gauss_markov=(GaussMarkov(sigma=0.02 * _DEGREE, time=100.0),)
    ),
}


def measure(settings: Settings) -> dict[str, Any]:
    """Time of Γ of 2 h at 100 Hz on half octaves, then of fits of curves of that length in a warm process."""
    n = settings.samples(720_000)
    sizes = np.array(half_octaves(1, n // 3))
    tensors = []
    for _ in range(settings.rounds):
        start = time.process_time()
        kernels.covariance_tensors(n, sizes, 1.0)
        tensors.append(time.process_time() - start)
    fits = {}
    for name, model in _CURVES.items():
        curve = allan(simulate(NoiseModel(channels={"gyro_x": model}), duration=n / 100, rate=100, rng=1))["gyro_x"]
        fit(curve)  # computes the components that curves of one length share
        rounds = []
        repeated = 1 if settings.is_trial else _FITS
        for _ in range(settings.rounds):
            start = time.process_time()
            for _ in range(repeated):
                fit(curve)
            rounds.append((time.process_time() - start) / repeated)
        fits[name] = statistics.median(rounds)
    return {"samples": n, "tensors": statistics.median(tensors), "fits": fits}


def write(measured: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """Text of the section of the page, and its targets."""
    lines = [
        "## Fits",
        "",
        *text.prose(
            f"Half octaves of {text.number(measured['samples'])} samples, in a warm process; the median of the CPU time.",
            "Other packages have no such fit. `make bench PARTS=fits`.",
        ),
        *text.table(
            ["", "CPU time"],
            [
                ["covariance tensors, four terms and the ramp, once a length", text.seconds(measured["tensors"])],
                *(
                    [f"a fit with intervals and limits from a curve in memory: {name}", text.seconds(seconds)]
                    for name, seconds in measured["fits"].items()
                ),
            ],
        ),
    ]
    return lines, []
