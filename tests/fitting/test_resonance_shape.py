"""A bump that is no resonance: intervals do not depend on the shape that the model gives it."""

import numpy as np

import sigmatau as st
from known import seed_of

AXES, RATE, SAMPLES = 8, 50.0, 180_000
N = 1e-4


def test_line_that_drifts():
    rng = np.random.default_rng(seed_of("line from 5 to 8 Hz"))
    t = np.arange(SAMPLES) / RATE
    sigma = N * np.sqrt(RATE)
    inside = false = 0
    for _ in range(AXES):
        phase = 2 * np.pi * (5.0 * t + 1.5 * t**2 / t[-1] + rng.random())
        samples = sigma * (rng.standard_normal(SAMPLES) + 0.3 * np.sin(phase))
        fitted = st.fit_channel(st.Record.from_arrays(rate=RATE, gyro_x=samples), "gyro_x")
        walk, quantization = fitted["random_walk"], fitted.get("quantization")
        inside += walk.low <= N <= walk.high
        false += quantization is not None and quantization.observed and quantization.low > 0
    assert inside >= AXES * 0.95 - 3 * np.sqrt(AXES * 0.95 * 0.05)
    assert false <= AXES * 0.05 + 3 * np.sqrt(AXES * 0.05 * 0.95)
