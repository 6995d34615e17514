"""The interval of a filter's corner holds the true one, whatever the number of coefficients that describe the filter."""

import numpy as np
import pytest
from scipy.signal import butter, lfilter

import known
from sigmatau import Record
from sigmatau.fitting.channel import fit_channel

RATE, N, RECORDS = 100.0, 60_000, 8
DECAY = np.exp(-2 * np.pi * 0.08)
COSINE = (4 * DECAY - 1 - DECAY**2) / (2 * DECAY)  # of the angle at which smoothing has half the power
FILTERS = {
    "butterworth": (*butter(2, 2 * 31.5 / RATE), 31.5),
    "smoothing": ([1 - DECAY], [1, -DECAY], float(np.arccos(COSINE)) * RATE / (2 * np.pi)),
}


@pytest.mark.parametrize("name", FILTERS)
def test_the_interval_of_a_corner(name):
    """At least 92 %, less three standard errors; it was 58 % for smoothing, whose series is long."""
    b, a, corner = FILTERS[name]
    inside, halves = 0, []
    for k in range(RECORDS):
        rng = np.random.default_rng(known.seed_of(f"corner of {name} {k}"))
        y = lfilter(b, a, rng.standard_normal(N + 1000))[1000:] + 1e-4 * np.cumsum(rng.standard_normal(N))
        found = fit_channel(Record.from_arrays(rate=RATE, unit={"gyro": "deg/s"}, gyro_x=0.01 * y), "gyro_x").response
        if found is None or found.corner is None:  # told as uneven, without a corner
            continue
        halves.append((found.high - found.low) / 2)
        inside += found.low <= corner <= found.high
    assert np.median(halves) < 0.12 * corner
    assert len(halves) >= 0.9 * RECORDS
    assert inside / len(halves) >= 0.92 - 3 * np.sqrt(0.92 * 0.08 / RECORDS)
