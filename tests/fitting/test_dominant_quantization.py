"""A random walk beside a quantization noise that is far larger, as of the CIMU's gyros: crossing at 351 s."""

import math

import numpy as np

import sigmatau as st
from known import seed_of

ARCSEC = math.pi / 180 / 3600
WALK, QUANTIZATION = 0.0015 * 60 * ARCSEC, 0.973 * ARCSEC  # rad/sqrt(s), rad
RATE, DURATION, AXES = 200.0, 7200, 5


def test_the_random_walk_is_not_low():
    """The ends of the record, where the periodogram is mirrored, add no more than the model expects: within 3 standard
    errors of the mean over the axes."""
    errors, inside = [], 0
    n = round(RATE * DURATION)
    for axis in range(AXES):
        rng = np.random.default_rng(seed_of(f"dominant quantization, axis {axis}"))
        rate = np.diff(QUANTIZATION * rng.standard_normal(n + 1)) * RATE
        rate += WALK * math.sqrt(RATE) * rng.standard_normal(n)
        record = st.Record.from_arrays(rate=RATE, unit={"gyro": "rad/s"}, gyro=rate)
        walk = st.fit_channel(record, "gyro")["random_walk"]
        errors.append(math.log(walk.value / WALK))
        inside += walk.low <= WALK <= walk.high
    assert abs(np.mean(errors)) <= 3 * np.std(errors, ddof=1) / math.sqrt(AXES)
    assert inside / AXES >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / AXES)
