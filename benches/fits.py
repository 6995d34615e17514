"""The fit, which has no peer: the covariance of the Allan variances, and six fits with it."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

from benches import text
from benches.measure import Settings
from benches.text import Gate
from sigmatau import NoiseModel, allan, fit, simulate
from sigmatau.fitting.components import components


def measure(settings: Settings) -> dict[str, Any]:
    """Γ of N = 2^20 on half octaves, then six fits with it, in a process that is warm."""
    n = settings.samples(2**20)
    degree = np.pi / 180
    noise = {"random_walk": 5e-3 * degree, "bias_instability": 2.8e-3 * degree, "rate_random_walk": 1e-4 * degree}
    model = NoiseModel(channels={f"{s}_{a}": noise for s in ("gyro", "accel") for a in "xyz"})
    curves = allan(simulate(model, duration=n / 100, rate=100, rng=1))
    for curve in curves.values():
        fit(curve)
    tensors, six = [], []
    for _ in range(settings.rounds):
        components.cache_clear()
        start = time.perf_counter()
        components(n, tuple(int(m) for m in curves["gyro_x"].m if m <= n // 3))
        tensors.append(time.perf_counter() - start)
        for curve in curves.values():
            fit(curve)  # brings back what the limits need
        start = time.perf_counter()
        for curve in curves.values():
            fit(curve)
        six.append(time.perf_counter() - start)
    return {"samples": n, "tensors": statistics.median(tensors), "six": statistics.median(six)}


def write(found: dict[str, Any]) -> tuple[list[str], list[Gate]]:
    """The section of the page."""
    lines = [
        "## Fits",
        "",
        *text.prose(
            f"Half octaves of {text.number(found['samples'])} samples, in a warm process.",
            "Other packages have no such fit. `make bench PARTS=fits`.",
        ),
        *text.table(
            ["", "wall time"],
            [
                ["covariance tensors, four terms and the ramp", text.seconds(found["tensors"])],
                ["six fits with tests, intervals and limits", text.seconds(found["six"])],
            ],
        ),
    ]
    return lines, []
