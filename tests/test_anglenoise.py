"""White or flicker angle noise, told by the modified Allan deviation."""

import zlib

import numpy as np
import pytest

from sigmatau import NoiseModel, Record, analyze, simulate
from sigmatau.anglenoise import angle_noise


def codes(analysis):
    return [finding.code for finding in analysis.findings if finding.code.endswith("angle_noise")]


def flicker_angle(n, level, rng):
    """Rates whose integral has a density of 1/f, by shaping white noise over twice the record."""
    f = np.fft.rfftfreq(2 * n)
    shape = np.zeros_like(f)
    shape[1:] = 1 / np.sqrt(f[1:])
    spectrum = (rng.standard_normal(f.size) + 1j * rng.standard_normal(f.size)) * shape
    return level * np.diff(np.fft.irfft(spectrum)[: n + 1]) * np.sqrt(n)


def seed(name):
    return zlib.crc32(name.encode())


@pytest.mark.parametrize("channel", ["gyro_x", "accel_x"])
def test_flicker_is_called_so(channel):
    rng = np.random.default_rng(seed(f"flicker {channel}"))
    for white in (0.0, 1e-3):
        rates = flicker_angle(200_000, 1.0, rng) + white * rng.standard_normal(200_000)
        analysis = analyze(Record.from_arrays(rate=100, **{channel: 1e-3 * rates}))
        assert codes(analysis) == ["flicker_angle_noise"]
        (finding,) = [f for f in analysis.findings if f.code == "flicker_angle_noise"]
        assert finding.severity == "warning"
        assert ("angle" if channel == "gyro_x" else "velocity") + " noise, not quantization" in finding.message


def test_quantization_is_white():
    """None of 60 records is called flicker; of some, no model is adequate, and then nothing is said."""
    model = NoiseModel(channels={"gyro_x": {"quantization": 1e-5, "random_walk": 1e-5}})
    records = (simulate(model, duration=200, rate=100, rng=seed(f"white {k}")) for k in range(60))
    said = [codes(analyze(record)) for record in records]
    assert ["flicker_angle_noise"] not in said
    assert said.count(["white_angle_noise"]) >= 56


def test_nothing_is_said_where_quantization_does_not_rule():
    model = NoiseModel(channels={"gyro_x": {"quantization": 1e-7, "random_walk": 1e-3}})
    record = simulate(model, duration=200, rate=100, rng=1)
    analysis = analyze(record)
    assert codes(analysis) == []
    assert angle_noise(record, analysis.fits["gyro_x"]) is None


def test_the_longest_ruled_time_is_taken():
    """With a strong random walk behind it, only the shortest times tell."""
    model = NoiseModel(channels={"gyro_x": {"quantization": 1e-5, "random_walk": 3e-5}})
    analysis = analyze(simulate(model, duration=2000, rate=100, rng=seed("longest")))
    (finding,) = [f for f in analysis.findings if f.code == "white_angle_noise"]
    # Q²·3/τ² and N²/τ meet at τ = 3Q²/N² = 0.33 s; the last size before is 32 samples.
    assert "τ = 0.32 s" in finding.message
