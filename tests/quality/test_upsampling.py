"""Interpolated records: planted, found, the true rate, and what is said of σ against what it is."""

import gzip
import json
import math

import numpy as np
import pytest
from clean_records import pairs
from studies.bandwidth import filtered_white

import known
import sigmatau as st
from sigmatau.quality.spectrum import filter_models
from sigmatau.quality.spectrum.upsampling import upsampled

N = 2**18


def made(kind, true, rate, n=N):
    """White noise of random walk 1 at the true rate, interpolated to another."""
    rng = np.random.default_rng(known.seed_of(f"{kind} {true} {rate}"))
    samples = rng.standard_normal(int(n * true / rate) + 4) * math.sqrt(true)
    t = np.arange(n) * true / rate + 0.3
    if kind == "linear":
        return np.interp(t, np.arange(len(samples)), samples)
    if kind == "held":
        return samples[t.astype(int)]
    if kind == "cubic":
        from scipy.interpolate import CubicSpline

        return CubicSpline(np.arange(len(samples)), samples)(t)
    from scipy.signal import resample

    count = int(n * true / rate) // 4 * 4
    return resample(samples[:count], round(count * rate / true))


def stream_of(y, rate):
    return st.Record.from_arrays(rate=rate, gyro_x=y).streams[0]


CASES = [
    ("linear", 63.0, 200.0),
    ("linear", 50.0, 200.0),
    ("linear", 100.0, 200.0),
    ("linear", 63.0, 100.0),
    ("linear", 95.0, 100.0),
    ("held", 63.0, 200.0),
    ("held", 50.0, 200.0),
    ("held", 63.0, 100.0),
    ("cubic", 63.0, 200.0),
    ("cubic", 63.0, 100.0),
    ("fourier", 63.0, 200.0),
    ("fourier", 50.0, 200.0),
]


@pytest.mark.parametrize(("kind", "true", "rate"), CASES)
def test_found_with_its_rate_and_its_effect(kind, true, rate):
    y = made(kind, true, rate)
    (finding,) = upsampled(stream_of(y, rate))
    assert finding.code == "interpolated"
    assert finding.severity == "warning"
    assert finding.size == pytest.approx(true, rel=0.02)
    curve = st.allan(st.Record.from_arrays(rate=rate, gyro_x=y), taus=[1 / rate])["gyro_x"]
    share = math.sqrt(curve.avar[0] / rate)  # σ·√τ over N = 1
    # Where the spectrum tells the share its plateau has an error of 1 %, and it is not quite flat.
    assert dict(finding.factors)["random_walk"] == pytest.approx(share, rel=0.06)
    json.dumps(finding.to_dict(), allow_nan=False)


@pytest.mark.parametrize("kind", ["held", "linear"])
def test_running_means(kind):
    """White noise behind one or two running means over eight samples, averaged by numpy: σ at 4 to 64 samples."""
    shape, ones = ("mean", np.ones(8) / 8) if kind == "held" else ("bartlett", np.convolve(np.ones(8), np.ones(8)) / 64)
    # The autocovariance of a weighted mean is that of its weights; that of continuous time is within 3 %.
    r = np.correlate(ones, ones, "full")[len(ones) - 1 :] / np.sum(ones) ** 2
    sizes = np.array([4, 16, 64])
    lags = np.arange(2 * sizes.max())
    r = np.concatenate((r, np.zeros(len(lags) - len(r))))
    sums = [m * r[0] + 2 * sum((m - k) * r[k] for k in range(1, m)) for m in range(1, len(lags) + 1)]
    expected = np.array([(4 * sums[m - 1] - sums[2 * m - 1]) / (2 * m**2) * m for m in sizes])
    assert filter_models.relative_avar(shape, 8.0, sizes, 1.0) == pytest.approx(expected, rel=0.03)
    m = round(filter_models.right_from(shape, 8.0, 1.0))
    # Within 2 % in variance from there on, and not an octave before.
    assert filter_models.relative_avar(shape, 8.0, [m, 2 * m], 1.0) == pytest.approx([0.98, 0.99], abs=0.001)


def test_the_example_of_the_field():
    """63 Hz interpolated to 200 Hz: N reads 0.16 … 1.0 by τ."""
    y = made("linear", 63.0, 200.0)
    (finding,) = upsampled(stream_of(y, 200.0))
    assert finding.details.sigma_one_sample == pytest.approx(0.16, abs=0.005)
    late = finding.details.right_from
    curve = st.allan(st.Record.from_arrays(rate=200.0, gyro_x=y), taus=[1 / 200, late])["gyro_x"]
    walk = np.sqrt(curve.avar * curve.tau)
    assert walk[0] == pytest.approx(0.16, abs=0.005)
    # 2^18 samples have 2400 clusters of that length.
    assert walk[1] == pytest.approx(0.99, abs=4 / math.sqrt(2 * 2400))


def test_with_gaps_and_flicker_and_offset():
    y = made("linear", 63.0, 200.0) + 9.8
    model = st.NoiseModel(channels={"gyro_x": {"bias_instability": 0.5}})
    slow = st.simulate(model, duration=N / 63.0, rate=63.0, rng=known.seed_of("slow")).streams[0].column("gyro_x")
    y = y + np.interp(np.arange(N) * 63 / 200 + 0.3, np.arange(N), slow)
    y[::7919] = np.nan
    (finding,) = upsampled(stream_of(y, 200.0))
    assert finding.size == pytest.approx(63, rel=0.02)


def test_filters_lines_and_coarse_steps_are_no_interpolation():
    rng = np.random.default_rng(known.seed_of("no interpolation"))
    t = np.arange(N) / 100.0
    white = rng.standard_normal(N)
    cases = {
        "white": white,
        "first order": filtered_white(N, rate=100.0, bandwidth=3.0, order=1, rng=rng),
        "second order": filtered_white(N, rate=100.0, bandwidth=3.0, order=2, rng=rng),
        "running mean": np.convolve(white, np.ones(8) / 8, "same"),
        "large line": white + 5 * np.sin(2 * np.pi * 23.3 * t),
        "line near half the rate": white + 20 * np.sin(2 * np.pi * 49.3 * t),
        "line with a varying amplitude": white + 10 * np.sin(2 * np.pi * 33.4 * t) * (1 + 0.3 * np.cumsum(white) / 500),
        "line in filtered noise": filtered_white(N, rate=100.0, bandwidth=3.0, order=2, rng=rng)
        + 0.5 * np.sin(2 * np.pi * 20.3 * t),
        "coarse": np.round(white / 2) * 2,
        "very coarse": np.round(white / 6) * 6,
        "spikes": white + 100 * (rng.random(N) < 1e-3),
        "walk": np.cumsum(white),
        "constant": np.ones(N),
        "short": white[:500],
    }
    for name, y in cases.items():
        assert upsampled(stream_of(y, 100.0)) == [], name


def test_false_alarms():
    """A swing of 0.25 is twelve standard errors of the largest by chance: in 60 channels of clean mixtures not one."""
    for stream in pairs("false alarms of interpolation", 30):
        assert upsampled(stream) == []


def test_field_data_are_not_interpolated(field_data):
    record = st.read(field_data / "adis16405_static.csv.gz", rate=100)
    for stream in record.streams:
        assert upsampled(stream) == []
    # 40 Hz, with a strong line at 13.4 Hz that comes and goes.
    with gzip.open(field_data / "vn100" / "live_capture.txt.gz", "rt") as file:
        rows = [line.split("*")[0].split(",")[7:13] for line in file if line.startswith("$VNYMR")]
    for column in np.array(rows, dtype=float).T:
        assert upsampled(stream_of(column, 40.0)) == []
