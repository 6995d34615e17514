"""Eq. (2): filters of known magnitude and phase are found again, within the error of the estimate."""

import functools
import json
import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau import DataError, OptionError
from sigmatau.spectrum.estimate import psd
from sigmatau.spectrum.transfer import _minimum_phase, transfer

TAU0 = 0.01
N = 0.3

# Denominators and numerators; all of minimum phase. The Butterworth filters have zeros at half the sampling rate.
FILTERS = {
    "autoregression": ([1.0], [1.0, -0.9, 0.5]),
    "with a zero": ([1.0, 0.5], [1.0, -0.6]),
    "Butterworth 1": (1, 0.3),
    "Butterworth 2": (2, 0.3),
}


def coefficients(name):
    from scipy.signal import butter

    b, a = FILTERS[name]
    return butter(b, a) if isinstance(b, int) else (np.array(b), np.array(a))


@functools.cache
def found(name):
    from scipy.signal import lfilter

    rng = np.random.default_rng(known.seed_of(f"filter {name}"))
    white = N / math.sqrt(TAU0) * rng.standard_normal(400_000)
    y = lfilter(*coefficients(name), white)[1000:]
    spectrum = psd(st.Record.from_arrays(rate=1 / TAU0, gyro_x=y))["gyro_x"]
    return spectrum, transfer(spectrum, random_walk=N)


def response(name, f):
    from scipy.signal import freqz

    _, h = freqz(*coefficients(name), 2 * np.pi * f * TAU0)
    return h


@pytest.mark.parametrize("name", FILTERS)
def test_magnitude(name):
    spectrum, got = found(name)
    there = (got.frequency > spectrum.frequency[0]) & (got.frequency < 45)
    truth = np.abs(response(name, got.frequency[there]))
    held = np.mean((got.low[there] <= truth) & (truth <= got.high[there]))
    # Neighbours are alike, see Hann's taper: there are half as many.
    assert held == pytest.approx(0.95, abs=3 * math.sqrt(0.95 * 0.05 * 2 / there.sum()))
    assert np.mean(got.magnitude[there] / truth) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("name", FILTERS)
def test_phase(name):
    """ln|H| has the variance 1/(2·dof), and so has its Hilbert transform, the phase."""
    spectrum, got = found(name)
    there = (got.frequency > 1) & (got.frequency < 25)
    off = np.angle(np.exp(1j * got.phase[there]) / response(name, got.frequency[there]))
    expected = math.sqrt(1 / (2 * spectrum.dof[0]))
    # A thousand frequencies, of which the neighbours are alike.
    assert np.sqrt(np.mean(off**2)) == pytest.approx(expected, rel=3 * math.sqrt(1 / there.sum()) + 0.05)


@pytest.mark.parametrize("name", FILTERS)
def test_impulse_response(name):
    """The error is spread over all taps: in all a share 1/dof of the power; at each tap that over their number."""
    from scipy.signal import lfilter

    spectrum, got = found(name)
    truth = lfilter(*coefficients(name), np.eye(1, len(got.impulse))[0])
    power = float(truth @ truth)
    error = got.impulse - truth
    share = float(error @ error) / power * spectrum.dof[0]
    # The mean of some 1e3 squares; a filter's zero at half the sampling rate, which a taper blurs, adds to it.
    assert share == pytest.approx(1.0, abs=0.3)
    one = math.sqrt(power / spectrum.dof[0] / len(truth))
    assert np.abs(error[:20]).max() < 6 * one


def test_a_filter_that_is_not_of_minimum_phase_is_taken_for_one():
    """As is said: the zero at 1/2 outside the circle, [0.5, 1], comes back as that inside, [1, 0.5]."""
    rng = np.random.default_rng(known.seed_of("maximum phase"))
    white = N / math.sqrt(TAU0) * rng.standard_normal(400_000)
    y = np.convolve(white, [0.5, 1.0])[1:]
    got = transfer(psd(st.Record.from_arrays(rate=1 / TAU0, gyro_x=y))["gyro_x"], random_walk=N)
    assert got.impulse[:2] == pytest.approx([1.0, 0.5], abs=0.01)
    assert "by assumption" in repr(got)


def test_the_cepstrum_is_exact_for_a_filter_of_known_poles():
    """Without noise: the only error is that of the sampled frequencies, 0.95^4096."""
    from scipy.signal import freqz

    b, a = [1.0, 0.5], [1.0, -1.2, 0.72]
    w = np.linspace(0, np.pi, 2049)
    _, h = freqz(b, a, w)
    np.testing.assert_allclose(_minimum_phase(np.log(np.abs(h))), h, rtol=1e-11)


def test_smoothing():
    """Bins of a 24th of an octave leave less of the error in the impulse response."""
    from scipy.signal import lfilter

    spectrum, rough = found("autoregression")
    smooth = transfer(spectrum, random_walk=N, per_octave=24)
    truth = lfilter(*coefficients("autoregression"), np.eye(1, len(rough.impulse))[0])
    assert np.sum((smooth.impulse - truth) ** 2) < 0.5 * np.sum((rough.impulse - truth) ** 2)


def test_the_interval_of_a_smoothed_magnitude_is_its_own():
    """As wide as that of the bins, around the magnitude, and it holds; the spectrum's own would be several times wider."""
    spectrum, rough = found("autoregression")
    smooth = transfer(spectrum, random_walk=N, per_octave=8)
    there = (smooth.frequency > spectrum.frequency[0]) & (smooth.frequency < 45)
    assert ((smooth.low <= smooth.magnitude) & (smooth.magnitude <= smooth.high))[there].all()
    bins = spectrum.binned(per_octave=8)
    low, high = bins.interval()
    last = bins.frequency[-2]
    k = int(np.argmin(np.abs(smooth.frequency - last)))
    wide = smooth.high[k] / smooth.low[k] - 1
    assert wide == pytest.approx(math.sqrt(high[-2] / low[-2]) - 1, rel=0.1)
    assert wide < 0.2 * (rough.high[k] / rough.low[k] - 1)
    # At the bins' own frequencies, where it is no mean of two: these are independent but for the taper's neighbours.
    at = [int(np.argmin(np.abs(smooth.frequency - f))) for f in bins.frequency[4:-1]]
    truth = np.abs(response("autoregression", smooth.frequency[at]))
    held = np.mean((smooth.low[at] <= truth) & (truth <= smooth.high[at]))
    assert held >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / len(at))


def test_what_is_below_the_first_frequency_has_no_interval():
    spectrum, got = found("autoregression")
    below = got.frequency < spectrum.frequency[0] * (1 - 1e-9)
    assert below.sum() == 2
    assert got.measured_from == spectrum.frequency[0]
    np.testing.assert_array_equal(np.isnan(got.low), below)
    np.testing.assert_array_equal(np.isnan(got.high), below)
    plain = json.loads(json.dumps(got.to_dict(), allow_nan=False))
    assert plain["low"][:2] == plain["high"][:2] == [None, None]
    assert repr(got).count("not measured") == 1
    assert f"white input of {N**2:.4g} (rad/s)^2/Hz (two-sided)" in repr(got)


def test_without_an_input_the_gain_at_zero_is_one():
    spectrum, _ = found("Butterworth 2")
    got = transfer(spectrum)
    assert got.input_density == pytest.approx(N**2, rel=3 * math.sqrt(2 * 2 / (spectrum.dof[0] * 20)))
    assert got.corner == pytest.approx(15.0, rel=0.05)  # 0.3 of 50 Hz


def test_wrong_options():
    spectrum, _ = found("Butterworth 1")
    for how, what in (
        ({"random_walk": 0.0}, "random_walk"),
        ({"random_walk": math.nan}, "random_walk"),
        ({"taps": 0}, "taps"),
        ({"taps": 10**6}, "taps"),
    ):
        with pytest.raises(OptionError, match=what):
            transfer(spectrum, **how)
    y = np.random.default_rng(known.seed_of("wrong")).standard_normal(5000)
    tapered = psd(st.Record.from_arrays(rate=100, gyro_x=y), method="multitaper")["gyro_x"]
    with pytest.raises(OptionError, match="Welch"):
        transfer(tapered)
    with pytest.raises(DataError, match="density is 0"):
        transfer(psd(st.Record.from_arrays(rate=100, gyro_x=np.zeros(5000)))["gyro_x"])


def test_to_dict_and_plot():
    _, got = found("Butterworth 1")
    plain = json.loads(json.dumps(got.to_dict(), allow_nan=False))
    assert plain["phase"] == "minimum phase, by assumption"
    assert plain["sided"] == "two"
    _, lower = got.plot().axes
    assert "minimum phase assumed" in lower.get_ylabel()
