"""White or flicker angle noise, told by the modified Allan deviation."""

import zlib

import numpy as np
import pytest

from sigmatau import NoiseModel, Record, allan, analyze, simulate
from sigmatau.fitting.channel import fit_channel
from sigmatau.quality.angle_noise import angle_noise


def codes(analysis):
    return [finding.code for finding in analysis.findings if finding.code.endswith("angle_noise")]


def told(record):
    """The code that the check gives a record of one channel, from the fit alone: the other checks take most of the time."""
    (curve,) = allan(record).values()
    finding = angle_noise(record, fit_channel(record, curve.channel))
    return None if finding is None else finding.code


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
        assert finding.details.quantity == ("angular_rate" if channel == "gyro_x" else "acceleration")
        assert finding.details.share > 0.9


def test_quantization_is_white():
    """None of 60 records is called flicker; of some, no model is adequate, and then nothing is said."""
    model = NoiseModel(channels={"gyro_x": {"quantization": 1e-5, "random_walk": 1e-5}})
    records = (simulate(model, duration=200, rate=100, rng=seed(f"white {k}")) for k in range(60))
    said = [told(record) for record in records]
    assert "flicker_angle_noise" not in said
    assert said.count("white_angle_noise") >= 56


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
    assert finding.details.tau == pytest.approx(0.32)


@pytest.mark.parametrize(("n", "walk"), [(3000, 0.0), (3000, 0.2), (10_000, 0.02), (10_000, 1.0), (30_000, 1.0)])
def test_short_records_and_random_walk(n, walk):
    """Where the Allan deviation alone gives an adequate model with a random walk that is not there."""
    rng = np.random.default_rng(seed(f"short {n} {walk}"))
    said = [
        told(Record.from_arrays(rate=100, a=flicker_angle(n, 1.0, rng) + walk * rng.standard_normal(n)))
        for _ in range(12)
    ]
    assert said.count("flicker_angle_noise") >= 11


def _filtered(x, pole):
    y = np.empty_like(x)
    held = 0.0
    for k, value in enumerate(x):
        held = pole * held + (1 - pole) * value
        y[k] = held
    return y


@pytest.mark.parametrize(("n", "times"), [(1500, 6), (20_000, 3)])
def test_what_is_no_flicker(n, times):
    """Filters, lines, a coarse last digit, a random walk of the rate: nothing is called flicker."""
    rng = np.random.default_rng(seed(f"no flicker {n}"))
    t = np.arange(n) / 100
    for _ in range(times):
        white, steps = rng.standard_normal(n), np.diff(rng.standard_normal(n + 1))
        for rates in (
            white,
            steps,
            steps + 0.1 * white,
            steps + 0.5 * white,
            _filtered(white, 0.8),
            _filtered(white, 0.8) + 0.3 * steps,
            _filtered(steps, 0.5),
            _filtered(steps, 0.9),
            0.02 * white + steps + 0.3 * np.sin(2 * np.pi * 7.3 * t),
            0.02 * white + steps + 0.3 * np.sin(2 * np.pi * 0.73 * t),
            np.round(0.3 * white),
            0.01 * np.cumsum(white) + steps,
        ):
            assert told(Record.from_arrays(rate=100, a=rates)) != "flicker_angle_noise"
