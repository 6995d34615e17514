"""Straight lines between samples, however they are written."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, allan
from sigmatau.quality.samples.interpolation import interpolated, upsampling

N = 60_000


def stream_of(x, rate=200.0):
    return Record.from_arrays(rate=rate, signal=x).streams[0]


def line(name, ratio, n=N, shift=0.0):
    known = np.random.default_rng(seed_of(name)).normal(size=int(n / ratio) + 3)
    return np.interp(np.arange(n) / ratio + shift, np.arange(len(known)), known)


@pytest.mark.parametrize("write", [lambda x: x, lambda x: x * 1e-6 + 1000, lambda x: np.round(x, 3), np.float32])
@pytest.mark.parametrize(
    ("ratio", "aligned"), [(200 / 63, False), (2.7, False), (4.3, False), (2.0, True), (5.0, True)]
)
def test_ratio_and_pattern(ratio, aligned, write):
    found = upsampling(stream_of(np.asarray(write(line(f"ratio {ratio}", ratio)), dtype=float)), "signal")
    assert found is not None
    assert found.aligned == aligned
    assert found.factor == pytest.approx(ratio, rel=0.01)  # of 60,000 samples; what is straight by chance


@pytest.mark.parametrize(("ratio", "aligned"), [(200 / 63, False), (4.0, True)])
def test_sigma_at_one_sample(ratio, aligned):
    """0.16 at 63 → 200 Hz, which is what a depth camera's driver does; the noise before was white, with σ(τ₀) = √ratio."""
    x = line(f"sigma {ratio}", ratio, n=400_000, shift=0.0 if aligned else 0.31)
    found = upsampling(stream_of(x), "signal")
    measured = float(allan(Record.from_arrays(rate=200, signal=x), taus=[0.005])["signal"].adev[0]) / math.sqrt(ratio)
    # 100,000 slopes or more, squared: 0.5·√(3/100,000); and the factor itself.
    assert measured == pytest.approx(found.shortest, rel=3 * 0.5 * math.sqrt(3 / 100_000) + 1.5 * 0.02)


def test_the_finding():
    x = np.stack([line(f"axis {k}", 200 / 63) for k in range(3)], axis=1)
    (finding,) = interpolated(Record.from_arrays(rate=200, gyro=x).streams[0])
    assert (finding.code, finding.severity) == ("interpolated", "warning")
    assert finding.channels == ("gyro_x", "gyro_y", "gyro_z")
    made = finding.details.upsampled
    assert (made.sensor_rate, made.log_rate) == pytest.approx((63, 200), rel=0.01)
    assert made.sigma_one_sample == pytest.approx(0.16, abs=0.005)
    assert dict(finding.factors) == {"random_walk": pytest.approx(0.16, abs=0.005)}


@pytest.mark.parametrize("ratio", [0.7, 1.0, 2.0, 5.0])
def test_counts_with_a_slow_bias_taken_off(ratio):
    """As in the log of a flight controller: no common step is left, and many second differences are nearly zero."""
    x = np.round(np.random.default_rng(seed_of(f"bias {ratio}")).normal(size=N) * ratio)
    assert upsampling(stream_of(x + 0.3 * np.cumsum(np.sin(np.arange(N) / 5000)) / 1000), "signal") is None


@pytest.mark.parametrize("step", [0.0, 0.001, 0.1, 0.5, 1.0, 3.0])
def test_what_is_not_interpolated(step):
    """White noise, a walk, noise through a low-pass, repeated samples and a line; rounded or not."""
    rng = np.random.default_rng(seed_of(f"not {step}"))
    w = rng.normal(size=N)
    smooth = np.convolve(w, np.hanning(12), "same")
    for x in (w, np.cumsum(w), smooth, np.repeat(w[: N // 3], 3), np.arange(N) * 0.37):
        x = np.round(x / step) * step if step else x
        assert upsampling(stream_of(x), "signal") is None
