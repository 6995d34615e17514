"""A running mean whose zeros lie among the lowest frequencies, with samples missing: the fit goes on."""

import numpy as np
import pytest
from scipy.signal import lfilter

import sigmatau as st
from known import seed_of

LENGTH, SAMPLES = 20, 20_000


@pytest.mark.parametrize("walk", [0.0, 0.003])
def test_zeros_below_the_periodogram(walk):
    rng = np.random.default_rng(seed_of(f"running mean, missing, {walk:g}"))
    noise = rng.standard_normal(SAMPLES + LENGTH) + np.cumsum(walk * rng.standard_normal(SAMPLES + LENGTH))
    samples = 1e-4 * lfilter(np.ones(LENGTH) / LENGTH, [1.0], noise)[LENGTH:]
    samples[rng.choice(SAMPLES, 4, replace=False)] = np.nan
    record = st.Record.from_arrays(rate=10.0, gyro_x=samples, unit={"gyro": "rad/s"})
    fitted = st.analyze(record, at_rest=True).fits["gyro_x"]
    assert fitted.response is not None
    level = fitted["random_walk"]
    assert level.low <= 1e-4 / np.sqrt(10.0) <= level.high
