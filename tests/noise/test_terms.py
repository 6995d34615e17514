"""Closed forms against known answers, and against eq. (11) integrated."""

import math

import numpy as np
import pytest

import known
from sigmatau._native import kernels
from sigmatau.noise import terms
from sigmatau.units import to_si


@pytest.mark.parametrize(("term", "coefficient"), known.AVAR)
def test_avar(term, coefficient):
    got = terms.avar(term, coefficient, m=known.SIZES, tau0=0.01)
    assert got == pytest.approx(known.AVAR[term, coefficient], rel=1e-13)


def test_rate_random_walk_averaged():
    got = terms.avar("rate_random_walk", 1e-4, m=known.SIZES, tau0=0.01, averaged=True)
    assert got == pytest.approx(known.RATE_RANDOM_WALK_AVERAGED, rel=1e-14)


@pytest.mark.parametrize(
    ("averaged", "expected"), [(False, known.GAUSS_MARKOV_SAMPLED), (True, known.GAUSS_MARKOV_AVERAGED)]
)
def test_gauss_markov(averaged, expected):
    got = kernels.gauss_markov_avar(1e-3, 10.0, known.SIZES, 0.01, averaged=averaged)
    assert got == pytest.approx(expected, rel=1e-13)


def test_sinusoid():
    got = kernels.sinusoid_avar(1e-3, 0.37, known.SIZES, 0.01)
    # 37 whole periods fit in the last cluster: exactly nothing but rounding is left.
    assert got == pytest.approx(known.SINUSOID, rel=1e-12, abs=1e-30)


@pytest.mark.parametrize(("shape", "strength"), known.FILTERS)
def test_filters(shape, strength):
    # A first-order low-pass of white noise N has the variance N²/(2 Tc); Tc = 1/(2π·30 Hz) = 0.005305165 s.
    tc = 1 / (2 * math.pi * 30)
    n = 0.05 * math.sqrt(2 * tc) if "σ" in strength else 0.005
    got = kernels.band_limited_avar(n, shape, 30.0, known.SIZES, 0.01)
    assert got == pytest.approx(known.FILTERS[shape, strength], rel=5e-10)  # half a unit of the tenth digit


def test_flicker():
    sizes = list(known.FLICKER)
    got = terms.avar("bias_instability", 1.0, m=sizes, tau0=1.0)
    assert got == pytest.approx(list(known.FLICKER.values()), rel=1e-14)
    assert terms.avar("bias_instability", 1.0, m=[10**9], tau0=1.0) == pytest.approx(known.FLICKER_LIMIT, rel=1e-15)
    assert pytest.approx(known.FLICKER_LIMIT, rel=1e-15) == terms.BIAS_LEVEL**2
    assert round(terms.BIAS_LEVEL, 3) == 0.664  # the paper's figure


@pytest.mark.parametrize(("x", "expected"), known.CUTOFF.items())
def test_bias_instability_with_cutoff(x, expected):
    got = terms.avar("bias_instability", 1.0, m=[100], tau0=0.01, cutoff=x)
    assert got[0] == pytest.approx(expected, rel=1e-14)


def test_mixture():
    sizes = list(known.MIXTURE_AVAR)
    got = sum(terms.avar(t, c, m=sizes, tau0=1.0) for t, c in known.MIXTURE.items())
    assert got == pytest.approx(list(known.MIXTURE_AVAR.values()), rel=1e-14)


@pytest.mark.parametrize("m", [1, 2, 10, 100])
@pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk"])
def test_eq_11_sampled(term, m):
    """σ²(m) = 4 ∫ S(f) sin⁴(πf·m·τ₀) / (m² sin²(πf·τ₀)) df over 0 … 1/(2τ₀), the paper's eq. (11) for sampled data."""
    tau0 = 0.01
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0, math.pi / 2, 64 * m + 1)
    half = np.diff(edges) / 2
    u = (edges[:-1] + half)[:, None] + half[:, None] * nodes
    f = (u / (math.pi * tau0)).ravel()
    s = terms.psd(term, 0.3, f, tau0=tau0)
    integrand = s * (np.sin(m * u.ravel()) ** 4 / (m * np.sin(u.ravel())) ** 2)
    integral = 4 * np.sum(integrand.reshape(u.shape) * weights * half[:, None]) / (math.pi * tau0)
    assert terms.avar(term, 0.3, m=[m], tau0=tau0)[0] == pytest.approx(integral, rel=1e-10)


@pytest.mark.parametrize(("term", "ratio"), [("bias_instability", 1.0), ("rate_random_walk", 1.0)])
def test_psd_forms_agree_at_low_frequency(term, ratio):
    f = np.array([1e-4, 1e-3])
    sampled, continuous = terms.psd(term, 2.0, f, tau0=0.01), terms.psd(term, 2.0, f)
    assert sampled / continuous == pytest.approx(ratio, rel=1e-9)  # sin x = x to x²/6, x = π·1e-5


def test_psd_of_a_ramp_is_not_its_allan_variance():
    assert terms.psd("rate_ramp", 2.0, [1.0]) == pytest.approx(4 / (2 * math.pi) ** 3)


@pytest.mark.parametrize("term", [t for t in terms.TERMS if t != "bias_instability"])
@pytest.mark.parametrize("quantity", ["angular_rate", "acceleration"])
def test_read_off_points(term, quantity):
    """The continuous form at the read-off point equals the coefficient, whatever the unit."""
    t = terms.TERMS[term]
    value = terms.avar(term, 0.7, m=[1], tau0=t.read_at, averaged=term == "rate_random_walk")
    assert np.sqrt(value[0]) == pytest.approx(0.7, rel=1e-15)
    assert terms.display_units(term, quantity, "")[0][1] > 0


def test_letters_of_paper_and_standard():
    assert terms.TERMS["random_walk"].symbols == ("N", "Q")


def test_paper_unit_conversions():
    """Section IV: 1 deg/√h = 2.9e-4 rad/√s, 1 m/s/√h = 0.0167 m/s/√s, 0.0025 ft/s/√h = 0.00076 m/s/√h."""
    assert to_si(1, "deg/sqrt(h)") == pytest.approx(2.908882e-4, rel=2e-7)
    assert to_si(1, "m/s/sqrt(h)") == pytest.approx(1 / 60, rel=1e-15)
    assert to_si(0.0025, "ft/s/sqrt(h)") / to_si(1, "m/s/sqrt(h)") == pytest.approx(7.62e-4, rel=1e-12)
    assert to_si(1, "deg/h") == pytest.approx(to_si(1, "arcsec/s"), rel=1e-15)
    # A line of slope -1 read at √3 hours in deg/h gives degrees: 2.70e-4 deg = 0.973 arcsec.
    assert to_si(0.973, "arcsec") / to_si(1, "deg") == pytest.approx(2.7028e-4, rel=1e-5)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: terms.avar("arw", 1.0, m=[1], tau0=1.0), "unknown term 'arw'"),
        (lambda: terms.avar("random_walk", 1.0, m=[0], tau0=1.0), "at least 1"),
        (lambda: terms.avar("random_walk", 1.0, m=[1.5], tau0=1.0), "whole"),
        (lambda: terms.avar("random_walk", 1.0, m=[1], tau0=0.0), "positive"),
        (lambda: terms.avar("random_walk", 1.0, m=[1], tau0=1.0, cutoff=1.0), "cutoff"),
        (lambda: terms.psd("quantization", 1.0, [1.0]), "tau0"),
        (lambda: terms.psd("arw", 1.0, [1.0]), "unknown term"),
    ],
)
def test_wrong_arguments(call, words):
    with pytest.raises(ValueError, match=words):
        call()
