"""Spectra: scale, law, gaps; see known.seed_of for the seeds."""

import json
import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.errors import OptionError, RecordTooShortError
from sigmatau.noise import terms
from sigmatau.spectrum.estimate import psd
from sigmatau.spectrum.tapers import good_length

RATE = 50.0
TAU0 = 1 / RATE


def record_of(seed, n=200_000, **coefficients):
    model = st.NoiseModel(channels={"gyro_x": coefficients})
    return st.simulate(model, duration=n / RATE, rate=RATE, rng=known.seed_of(seed))


def gyro(y, rate=RATE):
    return st.Record.from_arrays(rate=rate, gyro_x=y)


CASES = {
    "random_walk": 5e-3,
    "quantization": 1e-4,
    "bias_instability": 2e-3,
    "rate_random_walk": 1e-3,
}


@pytest.mark.parametrize("method", ["welch", "multitaper"])
@pytest.mark.parametrize("term", CASES)
def test_density_is_that_of_the_term(term, method):
    """Each bin of a third of an octave against the exact sampled spectrum, three standard errors and 2 % for the taper."""
    spectrum = psd(record_of(f"psd {term}", **{term: CASES[term]}), method=method)["gyro_x"]
    # The taper sees a few bins at once: the steepest spectra are compared from the eighth on.
    first = np.searchsorted(spectrum.frequency, 6 * spectrum.resolution)
    f = spectrum.frequency[first:]
    ratio = spectrum.density[first:] / terms.psd(term, CASES[term], f, tau0=TAU0)
    edges = np.unique(np.searchsorted(f, f[0] * 2.0 ** np.arange(0, 12, 1 / 3)))
    edges = edges[edges < len(f)]
    count = np.diff(np.append(edges, len(f)))
    means = np.add.reduceat(ratio, edges) / count
    # Neighbours are correlated: a mean of n has at least n/2 (Hann) or n/tapers independent ones.
    shared = 2 if method == "welch" else spectrum.segments
    error = np.sqrt(2 / spectrum.dof[0] * np.minimum(shared, count) / count)
    # 30 bins: the largest of them is within 3.7 errors in 99.3 % of all records.
    assert np.all(np.abs(means - 1) < 3.7 * error + 0.02)
    assert np.mean(ratio) == pytest.approx(1.0, abs=3 * math.sqrt(2 / spectrum.dof[0] * shared / len(ratio)) + 0.01)


def test_parseval():
    """The density over both signs of the frequency is the variance; exact but for the mean and the edges of segments."""
    y = np.random.default_rng(known.seed_of("parseval")).standard_normal(100_000) * 3
    spectrum = psd(gyro(y), segment=100_000 / RATE)["gyro_x"]
    tapered = (y - y.mean()) * (0.5 - 0.5 * np.cos(2 * np.pi * np.arange(len(y)) / len(y)))
    # One segment, its slope taken off: mean square of the tapered samples over that of the taper (3/8).
    expected = np.mean(tapered**2) / 0.375
    step = spectrum.frequency[1] - spectrum.frequency[0]
    total = step * (2 * spectrum.density[:-1].sum() + spectrum.density[-1])
    # Of 100 000 frequencies three are not in the sum, each with an expected share of 1e-5.
    assert total == pytest.approx(expected, rel=1e-4)


def test_law_of_chi_squared():
    """Over its expectation a density has the variance 2/dof; 95 % intervals hold in 95 %."""
    spectrum = psd(record_of("law", n=400_000, random_walk=1.0))["gyro_x"]
    density = spectrum.density[:-1]
    assert density.var() == pytest.approx(2 / spectrum.dof[0], rel=3 * math.sqrt(2 * 2 / len(density)))
    low, high = spectrum.interval()
    held = np.mean((low <= 1) & (high >= 1))
    assert held == pytest.approx(0.95, abs=3 * math.sqrt(0.95 * 0.05 * 2 / len(low)))
    binned = spectrum.binned(per_octave=8)
    z = (binned.density - 1) / np.sqrt(2 / binned.dof)
    assert z.var() == pytest.approx(1.0, abs=3 * math.sqrt(2 / len(z)))


def test_multitaper_equals_its_definition():
    """The trick of one transform against every taper written out, for a record of a length that is used whole."""
    n = 499  # n + 1 = 500 has no prime factor above 5
    y = np.random.default_rng(known.seed_of("tapers")).standard_normal(n)
    spectrum = psd(gyro(y), method="multitaper", tapers=3)["gyro_x"]
    t = np.arange(n)
    rest = y - np.polyval(np.polyfit(t, y, 1), t)
    expected = np.zeros(len(spectrum.frequency))
    phase = np.exp(-2j * np.pi * np.outer(spectrum.frequency * TAU0, t + 1))
    for k in range(1, 4):
        taper = math.sqrt(2 / (n + 1)) * np.sin(np.pi * k * (t + 1) / (n + 1))
        expected += TAU0 * np.abs(phase @ (taper * rest)) ** 2 / 3
    assert spectrum.density == pytest.approx(expected, rel=1e-9)


def test_segments_with_a_missing_sample_are_left_out():
    y = np.array(record_of("gaps", random_walk=1.0).streams[0].column("gyro_x"))
    whole = psd(gyro(y), segment=10.24)["gyro_x"]
    y[[1000, 50_000, 120_345]] = np.nan
    gaps = psd(gyro(y), segment=10.24)["gyro_x"]
    assert 4 <= whole.segments - gaps.segments <= 6  # each sample is in two segments, at an end in one
    assert gaps.density.mean() == pytest.approx(1.0, abs=3 * math.sqrt(2 / (gaps.dof[0] * len(gaps.density) / 2)))


@pytest.mark.parametrize(("length", "last"), [(64, 0.5), (65, 1.0)])
def test_the_transform_at_half_the_rate_is_real(length, last):
    """It has half the degrees of freedom; a segment of odd length has no bin there."""
    spectrum = psd(gyro(np.random.default_rng(1).standard_normal(1000)), segment=length / RATE)["gyro_x"]
    assert (spectrum.frequency[-1] == RATE / 2) == (last < 1)
    assert spectrum.dof[-1] / spectrum.dof[0] == last


def test_segments_are_made_shorter_where_gaps_leave_too_few():
    rng = np.random.default_rng(known.seed_of("many gaps"))
    y = rng.standard_normal(100_000) * math.sqrt(RATE)
    y[rng.choice(len(y), 500, replace=False)] = np.nan
    spectrum = psd(gyro(y))["gyro_x"]
    assert spectrum.segments >= 15
    assert spectrum.density.mean() == pytest.approx(
        1.0, abs=4 * math.sqrt(4 / (spectrum.dof[0] * len(spectrum.density)))
    )
    y[::50] = np.nan
    with pytest.raises(RecordTooShortError, match="gyro_x"):
        psd(gyro(y))
    assert len(psd(gyro(rng.standard_normal(300)), method="multitaper")["gyro_x"].density) > 100


def test_a_ramp_does_not_leak():
    y = np.random.default_rng(known.seed_of("ramp")).standard_normal(100_000)
    plain = psd(gyro(y))["gyro_x"].density
    ramped = psd(gyro(y + 1e-2 * np.arange(len(y))))["gyro_x"].density
    assert ramped == pytest.approx(plain, rel=0.01)


def test_longest_and_wrong_options():
    record = record_of("options", n=10_000, random_walk=1.0)
    with pytest.raises(OptionError, match="segment"):
        psd(record, segment=1000)
    with pytest.raises(OptionError, match="method"):
        psd(record, method="periodogram")
    with pytest.raises(OptionError, match="tapers"):
        psd(record, method="multitaper", tapers=0)
    assert good_length(1_000_003) == 1_000_000
    assert good_length(127) == 125


def test_to_dict_and_plot():
    spectra = psd(record_of("dict", n=20_000, random_walk=1.0))
    plain = json.loads(json.dumps(spectra.to_dict(), allow_nan=False))["gyro_x"]
    assert plain["sided"] == "two"
    assert len(plain["frequency_hz"]) == len(plain["density"]) == len(plain["low"])
    ax = spectra["gyro_x"].plot().axes[0]
    assert "two-sided" in ax.get_ylabel()
    assert "two-sided" in repr(spectra)


@pytest.mark.parametrize("segment", [math.nan, math.inf, "1", True])
def test_segment_that_is_no_length(segment):
    with pytest.raises(OptionError, match="`segment` must be"):
        psd(gyro(np.arange(100.0)), segment=segment)


@pytest.mark.parametrize("per_octave", [-1, 0, 0.5, True])
def test_bins_that_are_none(per_octave):
    spectrum = psd(gyro(np.random.default_rng(known.seed_of("no bins")).standard_normal(2000)))["gyro_x"]
    for ask in (spectrum.binned, lambda **more: st.transfer(spectrum, **more)):
        with pytest.raises(OptionError, match="`per_octave` must be a whole number of bins"):
            ask(per_octave=per_octave)
