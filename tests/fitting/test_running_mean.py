"""Running means: the lobes between the zeros of the spectrum are neither lines nor vibration."""

import numpy as np
import pytest

from known import seed_of
from sigmatau import Record, analyze
from sigmatau.fitting.channel import fit_channel

WALK = 1e-3


def _mean(name, length, *, rate, seconds, slow=0.0):
    """White noise, and a rate random walk of `slow` times its size at 1 s, behind a mean of the last samples."""
    rng = np.random.default_rng(seed_of(name))
    n = int(rate * seconds) + length - 1
    x = WALK * np.sqrt(rate) * rng.standard_normal(n) + slow * WALK * np.cumsum(rng.standard_normal(n)) / np.sqrt(rate)
    return np.convolve(x, np.ones(length) / length, "valid")


def _holds(term, truth, *, beyond):
    low, high = (term.low, term.high) if term.observed else (0.0, term.upper_limit)
    return low / (1 + beyond) <= truth <= high * (1 + beyond)


@pytest.mark.parametrize(("length", "rate"), [*zip((3, 4, 5, 8, 13, 16, 20, 32, 50, 100), (100, 400) * 5, strict=True)])
def test_clean_sensor_behind_a_mean(length, rate):
    x = _mean(f"mean {length} {rate} 0", length, rate=rate, seconds=150)
    fitted = fit_channel(Record.from_arrays(rate=rate, gyro_x=x), "gyro_x")
    walk = fitted["random_walk"]
    assert fitted.response.shape == "running_mean"
    assert fitted.response.order == pytest.approx(length, abs=length / 80)  # exact up to 80 samples
    assert (fitted.sinusoid, fitted.resonance) == ((), ())
    assert fitted.verdict in ("adequate_with", "widened")
    assert _holds(walk, WALK, beyond=0.01), walk  # of a 95 % interval of 2 %
    assert walk.high < 1.2 * walk.low


@pytest.mark.parametrize("length", [100, 200])
def test_long_means(length):
    """The zeros are below the band of the periodogram too; a bin of it holds a whole lobe."""
    x = _mean(f"long mean {length} 0", length, rate=50, seconds=3600)
    fitted = fit_channel(Record.from_arrays(rate=50, gyro_x=x), "gyro_x")
    assert (fitted.response.order, fitted.sinusoid, fitted.resonance) == (length, (), ())
    assert _holds(fitted["random_walk"], WALK, beyond=0.005)


def test_line_where_the_mean_leaves_only_rounding():
    """Lobes below the floor of rounding are not fitted, but are searched for lines."""
    x = _mean("line above the lobes", 32, rate=200, seconds=200)
    x = x + 0.3 * x.std() * np.sin(2 * np.pi * 88.3 * np.arange(len(x)) / 200)
    step = 0.5 * x.std()
    fitted = fit_channel(Record.from_arrays(rate=200, gyro_x=np.round(x / step) * step), "gyro_x")
    assert fitted.response.order == 32
    assert [line.frequency.value for line in fitted.sinusoid] == pytest.approx([88.3], abs=0.2)
    assert _holds(fitted["random_walk"], WALK, beyond=0.02)


def test_slow_noise_and_a_line_in_front_of_the_mean():
    """They keep their numbers; a line between two zeros is found with its own amplitude."""
    length, rate = 16, 200
    x = _mean("line", length, rate=rate, seconds=300, slow=0.05)
    t = np.arange(len(x)) / rate
    x = x + 0.004 * np.sin(2 * np.pi * 20.3 * t)
    fitted = fit_channel(Record.from_arrays(rate=rate, gyro_x=x), "gyro_x")
    assert fitted.response.order == length
    (line,) = fitted.sinusoid
    assert line.frequency.value == pytest.approx(20.3, abs=0.2)
    assert line.amplitude.value == pytest.approx(0.004, rel=0.1)
    assert _holds(fitted["random_walk"], WALK, beyond=0.01)
    assert _holds(fitted["rate_random_walk"], 0.05 * WALK, beyond=0.1)


def test_rounding_behind_the_mean():
    """Integers: the floor of rounding fills the zeros."""
    x = _mean("integers", 16, rate=200, seconds=200)
    step = 0.3 * x.std()
    fitted = analyze(Record.from_arrays(rate=200, gyro_x=np.round(x / step) * step)).fits["gyro_x"]
    assert _holds(fitted["random_walk"], WALK, beyond=0.02)
    assert len(fitted.sinusoid) == 0


@pytest.mark.parametrize("missing", [0.001, 0.01])
def test_missing_samples(missing):
    rng = np.random.default_rng(seed_of(f"missing {missing}"))
    x = _mean(f"mean {missing}", 16, rate=200, seconds=200)
    x[rng.random(len(x)) < missing] = np.nan
    fitted = fit_channel(Record.from_arrays(rate=200, gyro_x=x), "gyro_x")
    assert _holds(fitted["random_walk"], WALK, beyond=0.02)
    assert fitted.verdict != "disturbed"


def test_model_has_the_density_of_the_mean():
    """Also at the zeros, and the curve from one sample on."""
    x = _mean("curve", 10, rate=100, seconds=300)
    record = Record.from_arrays(rate=100, gyro_x=x)
    fitted = fit_channel(record, "gyro_x")
    walk = fitted["random_walk"].value
    assert fitted.psd(np.array([0.01]))[0] == pytest.approx(walk**2, rel=1e-3)
    assert fitted.psd(np.array([10.0, 20.0]))[0] < 1e-9 * walk**2
    shortest, longer = fitted.avar(m=np.array([1, 100]))
    assert shortest == pytest.approx(np.mean(np.diff(x) ** 2) / 2, rel=0.05)
    assert longer == pytest.approx(walk**2, rel=0.1)


@pytest.mark.parametrize("sections", [2, 4])
def test_other_filters_keep_their_names(sections):
    """Several means in a row, and records without a filter, are no running mean."""
    rng = np.random.default_rng(seed_of(f"cascade {sections}"))
    x = WALK * 10 * rng.standard_normal(20_000)
    plain = fit_channel(Record.from_arrays(rate=100, gyro_x=x), "gyro_x")
    assert plain.response is None
    for _ in range(sections):
        x = np.convolve(x, np.ones(6) / 6, "valid")
    fitted = fit_channel(Record.from_arrays(rate=100, gyro_x=x), "gyro_x")
    assert fitted.response is None or fitted.response.shape != "running_mean" or fitted.response.order != 6


@pytest.mark.parametrize("slow", [0.0, 0.03])
def test_zeros_below_the_periodogram_with_samples_missing(slow):
    """The zeros lie among the lowest frequencies: the fit goes on."""
    x = _mean(f"zeros below, missing {slow:g}", 20, rate=10, seconds=2000, slow=slow)
    x[np.random.default_rng(seed_of("zeros below, missing")).choice(len(x), 4, replace=False)] = np.nan
    fitted = analyze(Record.from_arrays(rate=10, gyro_x=x), at_rest=True).fits["gyro_x"]
    assert fitted.response is not None
    assert _holds(fitted["random_walk"], WALK, beyond=0.0)
