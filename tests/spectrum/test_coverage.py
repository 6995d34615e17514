"""Do 95 % intervals of densities hold in 95 % of all records? By simulation; see known.seed_of for the seeds."""

import functools
import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.model.channel import ChannelModel
from sigmatau.noise import terms
from sigmatau.spectrum.estimate import psd
from sigmatau.spectrum.tapers import sine_correlation

TAU0 = 0.01
RECORDS = 30
SAMPLES = 4096

# Noise and what is added to it. The ramp is 40 standard deviations of the white noise long.
CASES = {
    "white": ({"random_walk": 1.0}, 0.0),
    "red": ({"rate_random_walk": 1.0}, 0.0),
    "white, red and a ramp": ({"random_walk": 1.0, "rate_random_walk": 8.0}, 0.1),
}


def truth(case, f):
    return sum(terms.psd(term, value, f, tau0=TAU0) for term, value in CASES[case][0].items())


@functools.cache
def spectra(case, method):
    """Of many records. A sampled walk is what its density is of, and it needs no generator but the normal one."""
    rng = np.random.default_rng(known.seed_of(f"coverage of {method} {case}"))
    noise, ramp = CASES[case]
    found = []
    for _ in range(RECORDS):
        y = ramp * np.arange(SAMPLES)
        if "random_walk" in noise:
            y = y + noise["random_walk"] / math.sqrt(TAU0) * rng.standard_normal(SAMPLES)
        if "rate_random_walk" in noise:
            y = y + noise["rate_random_walk"] * math.sqrt(TAU0) * np.cumsum(rng.standard_normal(SAMPLES))
        found.append(psd(st.Record.from_arrays(rate=1 / TAU0, gyro_x=y), method=method)["gyro_x"])
    return found


@pytest.mark.parametrize("per_octave", [None, 8, 1])
@pytest.mark.parametrize("method", ["welch", "multitaper"])
@pytest.mark.parametrize("case", CASES)
def test_coverage(case, method, per_octave):
    """From one resolution on, of red noise from `Spectrum.trusted` on: below, the taper lets through too much."""
    shares = []
    for spectrum in spectra(case, method):
        shown = spectrum if per_octave is None else spectrum.binned(per_octave=per_octave)
        low, high = shown.interval()
        there = shown.frequency > (spectrum.resolution if case == "white" else spectrum.trusted)
        expected = truth(case, shown.frequency)
        shares.append(np.mean(((low <= expected) & (expected <= high))[there]))
    error = np.std(shares, ddof=1) / math.sqrt(RECORDS)
    assert np.mean(shares) == pytest.approx(0.95, abs=3 * error)


@pytest.mark.parametrize("method", ["welch", "multitaper"])
def test_below_the_trusted_frequency_red_noise_is_wrong(method):
    """So that the exclusion is needed, and stays as narrow as it is."""
    held = []
    for spectrum in spectra("red", method):
        low, high = spectrum.interval()
        expected = truth("red", spectrum.frequency)
        held.append(((low <= expected) & (expected <= high))[spectrum.frequency < spectrum.trusted / 2])
    assert np.mean(held) < 0.92


def test_correlation_of_sine_tapers_is_that_of_their_products():
    """Against the sums written out; the closed form leaves out what is 1/n² of them."""
    tapers, n = 5, 2000
    t = np.arange(1, n + 1)
    v = np.array([math.sqrt(2 / (n + 1)) * np.sin(np.pi * k * t / (n + 1)) for k in range(1, tapers + 1)])
    apart = np.arange(14)
    expected = [np.sum(np.abs((v * np.exp(-2j * np.pi * d * t / (n + 1))) @ v.T) ** 2) / tapers for d in apart]
    assert sine_correlation(tapers, apart) == pytest.approx(expected, rel=20 / n**2, abs=20 / n**2)


@pytest.mark.parametrize("per_octave", [1, 3, 8])
def test_a_steep_density_is_where_its_bin_is(per_octave):
    """A density f⁻² without noise, in bins: the mean over an octave is 12 % above the value at its mean frequency."""
    spectrum = spectra("white", "welch")[0]
    f = spectrum.frequency
    steep = st.Spectrum(
        channel="x", quantity="signal", unit="V", frequency=f, density=f**-2, dof=0 * f + 10, resolution=0.1,
        segments=5, n=100, tau0=TAU0,
    )  # fmt: skip
    binned = steep.binned(per_octave=per_octave)
    assert np.abs(binned.density * binned.frequency**2 - 1)[2:-1].max() < 0.01


@pytest.mark.parametrize("method", ["welch", "multitaper"])
@pytest.mark.parametrize("case", CASES)
def test_ratios_to_the_true_model(case, method):
    """As with densities; and the worst of all bands is called wrong in 5 % of all records at most."""
    model = ChannelModel(terms=CASES[case][0])
    shares, called_wrong = [], 0
    for spectrum in spectra(case, method):
        compared = spectrum.over(model)
        low, high = compared.interval()
        shares.append(np.mean((low <= 1) & (high >= 1)))
        called_wrong += compared.p_value < 0.05
    assert np.mean(shares) == pytest.approx(0.95, abs=3 * np.std(shares, ddof=1) / math.sqrt(RECORDS))
    assert called_wrong <= RECORDS * 0.05 + 3 * math.sqrt(RECORDS * 0.05)


def test_a_wrong_model_is_called_wrong():
    """White noise 5 % too low in the deviation: 10 % in the density, which 4096 samples show."""
    low = ChannelModel(terms={"random_walk": 0.95})
    compared = spectra("white", "welch")[0].over(low)
    assert compared.p_value < 0.05
    assert "does not describe it" in repr(compared)
