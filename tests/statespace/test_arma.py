"""Noise models as ARIMA processes: known answers, spectra, the steady Kalman filter."""

import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.statespace.arma import arma
from sigmatau.statespace.flicker import flicker_poles
from sigmatau.statespace.spectral_factor import RationalSpectrum
from sigmatau.statespace.state_space import state_space

DT = 0.01
N_K = {"random_walk": 0.005, "rate_random_walk": 1e-4}


def test_random_walk_and_rate_random_walk():
    """ARIMA(0, 1, 1); known_answers.json, all digits."""
    found = arma(ChannelModel(terms=N_K), dt=DT)
    assert (found.p, found.d, found.q) == (0, 1, 1)
    assert -found.ma[1] == pytest.approx(0.9998000199994974, rel=1e-12)
    assert 1 + found.ma[1] == pytest.approx(0.00019998000050258646, rel=1e-11)  # eps/1.99980e-4
    assert found.variance == pytest.approx(0.005**2 / DT / 0.9998000199994974, rel=1e-12)
    assert "ARIMA(0, 1, 1) every 0.01 s" in repr(found)


def test_quantization_too():
    """ARIMA(0, 1, 2) against its three autocovariances: g0 = 6q + 2w + k, g1 = −4q − w, g2 = q."""
    q, n, k = 2.8e-4, 1.7e-3, 5.5e-6
    found = arma(ChannelModel(terms={"quantization": q, "random_walk": n, "rate_random_walk": k}), dt=DT)
    assert (found.p, found.d, found.q) == (0, 1, 2)
    q, n, k = q**2 / DT**2, n**2 / DT, k**2 * DT
    covariances = found.variance * np.correlate(found.ma, found.ma, "full")[2:]
    # k shows in their sum alone, 1e-10 of them.
    np.testing.assert_allclose(covariances, [6 * q + 2 * n + k, -4 * q - n, q], rtol=1e-12)
    # Computed before by others for this tactical-grade unit, to the digits printed.
    assert found.ma[1:] == pytest.approx([-1.54977665, 0.54979121], abs=5e-9)
    assert found.variance == pytest.approx(1.42599588e-3, abs=5e-12)
    assert found.variance * math.prod(1 - found.ma_roots.real) ** 2 == pytest.approx(k, rel=1e-8)


def test_gauss_markov_process_and_random_walk():
    """ARMA(1, 1) against its autocovariances: s²(1 + θ² + 2θφ)/(1 − φ²) = σ² + N²/dt, lag 1: φσ²."""
    model = ChannelModel(terms={"random_walk": 0.005}, gauss_markov=(GaussMarkov(sigma=0.1, time=0.05),))
    found = arma(model, dt=DT)
    assert (found.p, found.d, found.q) == (1, 0, 1)
    phi, theta = -found.ar[1], found.ma[1]
    assert phi == pytest.approx(math.exp(-0.2), rel=1e-14)
    r0 = found.variance * (1 + theta**2 + 2 * theta * phi) / (1 - phi**2)
    assert r0 == pytest.approx(0.01 + 0.005**2 / DT, rel=1e-12)
    assert phi * r0 + theta * found.variance == pytest.approx(phi * 0.01, rel=1e-12)


SPECTRA = {
    "quantization": (ChannelModel(terms={"quantization": 1e-4}), (0, 0, 1), 1e-13),
    "rate random walk": (ChannelModel(terms={"rate_random_walk": 1e-4}), (0, 1, 0), 1e-13),
    "quantization, complex pair": (
        ChannelModel(terms={"rate_random_walk": 1.0, "quantization": 1e-5}),
        (0, 1, 2),
        1e-12,
    ),
    "flicker": (ChannelModel(terms={"bias_instability": 0.0028}), (8, 0, 7), 1e-8),
    "all": (
        ChannelModel(
            terms={**N_K, "quantization": 1e-5, "bias_instability": 0.0028},
            gauss_markov=(GaussMarkov(sigma=1e-3, time=10.0), GaussMarkov(sigma=1.0, time=1e-4)),
        ),
        (9, 1, 11),  # the second process is white
        1e-8,
    ),
    "bandwidth": (ChannelModel(terms=N_K, bandwidth=LowPass(order=2, corner=30.0)), (2, 1, 2), 1e-12),
    "bandwidth 5": (ChannelModel(terms=N_K, bandwidth=LowPass(order=5, corner=30.0)), (5, 1, 5), 1e-10),
}


@pytest.mark.parametrize("case", SPECTRA)
def test_spectrum_is_the_models(case):
    """Flicker against its poles' spectrum; the rounding of exp(−dt/τ) at τ = 1e6·dt leaves 1e-10 of it."""
    model, orders, tolerance = SPECTRA[case]
    found = arma(model, dt=DT)
    assert (found.p, found.d, found.q) == orders
    assert np.abs(found.ma_roots).max(initial=0) <= 1  # invertible
    terms, more = dict(model.terms), ()
    if level := terms.pop("bias_instability", 0.0):
        poles = flicker_poles(dt=DT, tau_max=3600.0)
        more = tuple(
            GaussMarkov(sigma=level * math.sqrt(v), time=float(t))
            for t, v in zip(poles.times, poles.variances, strict=True)
        )
    same = ChannelModel(terms=terms, gauss_markov=(*model.gauss_markov, *more), bandwidth=model.bandwidth)
    f = np.geomspace(1e-6, 49.9, 200)
    np.testing.assert_allclose(found.psd(f), same.psd(f, tau0=DT), rtol=tolerance)


FOLDED = {
    (2, 0.01): (0.999900009999, 1.00023753151e-12, 3.25980616371e-15),
    (3, 1): (0.999999000003, 1.00000148258e-6, 1.29263176963e-10),
    (5, 5): (0.9999999999, 0.000975609756416, 2.04426360742e-10),
    (5, 10): (1.0000000001, 0.500000000326, 2.09332570659e-7),
    (7, 30): (1.00000010489, 1.0000000126, 0.00163227647558),
    (9, 30): (1.0000000009, 1.00000000007, 0.000217182743096),
    (9, 400): (8.02564988798, 8.02877110949, 8.05487385177),
}
"""Of white noise of density 1 behind a filter of this order and corner, sampled at 100 Hz, at a tenth of the corner (400 Hz:
at 1 Hz), 10 Hz and 49 Hz: the sum over the poles of its autocovariance in 250 digits, mpmath 1.3; all digits printed."""


@pytest.mark.parametrize("case", FOLDED)
@pytest.mark.parametrize("walk", [0.0, 1e-6])
def test_spectrum_behind_a_sharp_filter(case, walk):
    """Twelve digits are printed; the poles' terms cancel to a part in 10⁹, which leaves seven."""
    order, corner = case
    terms = {"random_walk": 1.0, **({"rate_random_walk": walk} if walk else {})}
    found = arma(ChannelModel(terms=terms, bandwidth=LowPass(order=order, corner=corner)), dt=DT)
    f = np.array([corner / 10 if corner < 50 else 1.0, 10.0, 49.0])
    expected = np.array(FOLDED[case]) + walk**2 * DT**2 / (4 * np.sin(math.pi * f * DT) ** 2)
    np.testing.assert_allclose(found.psd(f), expected, rtol=1e-7)
    assert found.error < 1e-7  # of 1 − ϑ = K·dt/N = 1e-8, rounded
    assert (found.p, found.d, found.q) == (order, bool(walk), order if walk else order - 1)
    assert np.abs(found.ma_roots).max(initial=0) <= 1


@pytest.mark.parametrize("case", [(4, 1), (6, 0.01), (9, 0.01)])
def test_spectrum_that_cancels_is_refused(case):
    """The spectrum is 1e-14 to 1e-67 of its terms."""
    order, corner = case
    with pytest.raises(DataError, match="double precision; take its state space"):
        arma(ChannelModel(terms={"random_walk": 1.0}, bandwidth=LowPass(order=order, corner=corner)), dt=DT)


def test_quantization_alone_has_one_root_at_one():
    """Whatever its size: of 400 sizes and intervals 29 lost or doubled it."""
    draws = np.random.default_rng(seed_of("arma of quantization")).uniform((-8, -4), (0, 1), (100, 2))
    for q, dt in (10**draws).tolist():
        for other, d in ({}, 0), ({"rate_ramp": 1e-4}, 1), ({"random_walk": q, "rate_random_walk": q}, 1):
            found = arma(ChannelModel(terms={"quantization": q, **other}), dt=dt)
            assert (found.p, found.d, found.q) == (0, d, 1 + d)
            assert np.count_nonzero(found.ma_roots == 1) == (0 if "random_walk" in other else 1 + d)
            assert found.error < 1e-6
    one = arma(ChannelModel(terms={"quantization": 1.3271517125308805e-05}), dt=1.0)
    assert one.ma.tolist() == [1.0, -1.0]
    assert one.variance == pytest.approx(1.3271517125308805e-05**2, rel=1e-14)


def test_two_roots_that_are_one():
    """N⁴ = 4K²Q² makes w² + 2w + 1: the root −1 twice."""
    terms = {"quantization": DT, "rate_random_walk": DT**-0.5, "random_walk": math.sqrt(2 * DT)}
    found = arma(ChannelModel(terms=terms), dt=DT)
    theta = 1.5 - math.sqrt(1.25)  # (1 − ϑ)² = ϑ
    np.testing.assert_allclose(found.ma_roots, theta, rtol=1e-7)
    assert found.error < 1e-7


def test_what_rounding_would_change_is_refused(monkeypatch):
    """A pair that is 5e-6 from 1 has no coefficients; a factor that is wrong is not returned."""
    slow = ChannelModel(terms={"random_walk": 1.0}, bandwidth=LowPass(order=2, corner=1e-4))
    found = arma(slow, dt=DT)
    assert found.error < 1e-7
    with pytest.raises(DataError, match=r"`sections`.*take the state space"):
        _ = found.sections
    assert found.to_dict()["sections"] is None
    assert "take the state space" in repr(found)
    right = RationalSpectrum.factor
    monkeypatch.setattr(RationalSpectrum, "factor", lambda self: (right(self)[0], 1.001 * right(self)[1]))
    with pytest.raises(DataError, match=r"off by 0\.001"):
        arma(slow, dt=DT)


@pytest.mark.parametrize("gm", [(), (GaussMarkov(sigma=0.03, time=1.0), GaussMarkov(sigma=0.05, time=0.1))])
def test_innovations_of_the_steady_kalman_filter(gm):
    """The innovation variance is H·P·Hᵀ + R, P from the discrete Riccati equation; ma has the eigenvalues of F − K·H."""
    from scipy.linalg import solve_discrete_are

    model = ChannelModel(terms={"random_walk": 0.005, "rate_random_walk": 0.01}, gauss_markov=gm)
    system = state_space(model, dt=DT)
    p = solve_discrete_are(system.F.T, system.H.T, system.G @ system.Qd @ system.G.T, system.R)
    s = system.H @ p @ system.H.T + system.R
    closed = system.F - system.F @ p @ system.H.T @ np.linalg.inv(s) @ system.H
    found = arma(model, dt=DT)
    assert found.variance == pytest.approx(float(s[0, 0]), rel=1e-9)
    np.testing.assert_allclose(np.sort(found.ma_roots.real), np.sort(np.linalg.eigvals(closed).real), rtol=1e-8)


@pytest.mark.parametrize("case", SPECTRA)
def test_sections_are_the_process(case):
    """The gain of the cascade is the spectrum; first-order factors keep 1 − φ to eps/(1 − φ), 1e-10 at 1e6 samples."""
    from scipy.signal import sosfreqz

    found = arma(SPECTRA[case][0], dt=DT)
    sections = found.sections
    f = np.geomspace(1e-4, 49.0, 50)
    _, gain = sosfreqz(sections, worN=f, fs=1 / DT)
    np.testing.assert_allclose(DT * found.variance * np.abs(gain) ** 2, found.psd(f), rtol=1e-6)
    assert sum(np.count_nonzero(row[4:]) for row in sections) == found.p + found.d
    assert max(np.abs(np.roots(row[3:])).max(initial=0) for row in sections) <= 1


def test_flicker_is_filtered_without_end():
    """Its polynomial has a root outside the unit circle, of which nothing warned; the sections have none."""
    from scipy.signal import sosfilt

    found = arma(ChannelModel(terms={"random_walk": 8.7e-5, "bias_instability": 2e-5}), dt=DT)
    assert np.abs(np.roots(np.poly(found.ar_roots).real)).max() > 1  # what would be delivered
    for name in ("ar", "ma"):
        with pytest.raises(DataError, match=f"`{name}` has no coefficients.*filter with `sections`"):
            getattr(found, name)
    impulse = sosfilt(found.sections, np.eye(1, 720_000)[0])
    assert np.abs(impulse[360_000:]).max() < np.abs(impulse[1:360_000]).max()
    total = found.variance * float(impulse @ impulse)
    # White noise is nearly all of it; the flicker noise's slowest tail is left out.
    assert total == pytest.approx(8.7e-5**2 / DT, rel=1e-2)
    text = repr(found)
    assert "ar = 1" not in text
    assert "ar = Π(1 − φL), φ = 1 − " in text
    assert "filter with `sections`" in text
    content = found.to_dict()
    assert (content["ar"], content["ma"]) == (None, None)
    assert [complex(*root) for root in content["ar_roots"]] == found.ar_roots.tolist()
    assert len(content["sections"]) == found.p


def test_sections_are_the_polynomials_where_there_are_any():
    from scipy.signal import lfilter, sosfilt

    model = ChannelModel(terms={**N_K, "quantization": 1e-5}, bandwidth=LowPass(order=2, corner=30.0))
    found = arma(model, dt=DT)
    e = np.random.default_rng(seed_of("arma sections")).standard_normal(300)
    expected = lfilter(found.ma, np.convolve(found.ar, [1.0, -1.0]), e)
    np.testing.assert_allclose(sosfilt(found.sections, e), expected, rtol=1e-9, atol=1e-9)
    assert "filter with" not in repr(found)


def test_ramp_is_a_drift():
    found = arma(ChannelModel(terms={"random_walk": 0.005, "rate_ramp": -2.0}), dt=DT)
    assert (found.p, found.d, found.q) == (0, 1, 1)
    assert found.drift == -0.02
    assert found.ma.tolist() == [1.0, -1.0]
    gm = ChannelModel(terms={"rate_ramp": 1.0}, gauss_markov=(GaussMarkov(sigma=1.0, time=DT),))
    assert arma(gm, dt=DT).drift == pytest.approx(DT * (1 - math.exp(-1)), rel=1e-12)


def test_what_is_no_such_process():
    with pytest.raises(DataError, match="sinusoid"):
        arma(ChannelModel(sinusoid=(Sinusoid(amplitude=1.0, frequency=1.0),)), dt=DT)
    with pytest.raises(DataError, match="no noise"):
        arma(ChannelModel(terms={"rate_ramp": 1.0}), dt=DT)


def test_dictionary_and_print():
    found = arma(ChannelModel(terms={**N_K, "bias_instability": 1e-4}), dt=DT, tau_max=100.0)
    content = found.to_dict()
    assert (content["p"], content["d"], content["q"]) == (found.p, 1, found.p + 1)
    assert arma(ChannelModel(terms=N_K), dt=DT).to_dict()["ma"][0] == 1.0
    assert "up to 100 s" in repr(found)
