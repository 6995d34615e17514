"""Noise terms of a measured density: coverage, observed terms, and what cannot be used."""

import math

import numpy as np
import pytest

import known
import sigmatau as st
from sigmatau.noise.terms import psd

F = np.geomspace(1e-3, 50, 150)
TRUTH = {"random_walk": 1e-4, "bias_instability": 2e-4, "rate_random_walk": 1e-5}
DENSITY = sum(psd(name, value, F) for name, value in TRUTH.items())
DOF = 20
SETS = 24


def measured(density, name):
    return density * np.random.default_rng(known.seed_of(name)).chisquare(DOF, len(F)) / DOF


def test_intervals_and_limits_cover():
    covered = dict.fromkeys(TRUTH, 0)
    small = 0
    for k in range(SETS):
        fit = st.fit_psd(F, measured(DENSITY, f"psd fit {k}"), dof=DOF, sided="two")
        small += fit.p < 0.05
        for name, value in TRUTH.items():
            low, high = fit.model.intervals.get(name, (0.0, fit.model.limits.get(name, math.inf)))
            covered[name] += low <= value <= high
    for name, count in covered.items():
        assert count / SETS >= 0.95 - 3 * math.sqrt(0.95 * 0.05 / SETS), name
    assert small / SETS <= 0.05 + 3 * math.sqrt(0.95 * 0.05 / SETS)


def test_absent_terms_are_not_observed():
    seen = {"bias_instability": 0, "rate_random_walk": 0}
    for k in range(SETS):
        model = st.fit_psd(F, measured(1e-8 + 0 * F, f"psd fit white {k}"), dof=DOF, sided="two").model
        assert "random_walk" in model
        for name in seen:
            seen[name] += name in model
    assert max(seen.values()) / SETS <= 0.05 + 3 * math.sqrt(0.95 * 0.05 / SETS)


def test_a_density_of_no_term_is_told():
    fit = st.fit_psd(
        F, measured(1e-8 * (1 + 30 * np.exp(-(np.log(F) ** 2) * 20)), "psd fit peak"), dof=DOF, sided="two"
    )
    assert not fit.is_adequate
    assert "do not describe" in repr(fit)
    assert "[" not in repr(fit)
    assert (fit.model.adequate, dict(fit.model.intervals), dict(fit.model.limits)) == (False, {}, {})


def test_one_sided_and_the_exact_density():
    """Without scatter the terms come back, and one-sided densities are twice as large."""
    for sided, factor in (("two", 1), ("one", 2)):
        model = st.fit_psd(F, factor * DENSITY, dof=200, sided=sided).model
        assert dict(model) == pytest.approx(TRUTH, rel=1e-5)
        assert model.intervals["random_walk"][0] < 1e-4 < model.intervals["random_walk"][1]


def test_quantization_of_samples():
    truth = {"quantization": 1e-6, "random_walk": 1e-5}
    f = np.linspace(0.5, 50, 100)
    density = sum(psd(name, value, f, tau0=0.01) for name, value in truth.items())
    assert dict(st.fit_psd(f, density, dof=100, sided="two", tau0=0.01).model) == pytest.approx(truth, rel=1e-5)
    assert "quantization" not in st.fit_psd(f, density, dof=100, sided="two").model.limits


def test_from_an_analyser_to_a_filter(tmp_path):
    """A CSV with frequency and density: the Allan deviation of it, and the matrices of a Kalman filter that has it."""
    density = 2 * measured(psd("random_walk", 1e-4, F) + psd("bias_instability", 2e-4, F), "psd fit filter")
    np.savetxt(tmp_path / "density.csv", np.c_[F, density], delimiter=",", header="frequency,density", comments="")
    f, s = np.loadtxt(tmp_path / "density.csv", delimiter=",", skiprows=1, unpack=True)
    curve = st.avar_from_psd(f, s, [1.0, 10.0, 100.0], sided="one")
    model = st.fit_psd(f, s, dof=DOF, sided="one").model
    system = st.state_space(model, dt=0.1)
    m = np.round(curve.tau / 0.1).astype(int)
    # The model is smooth; the measured density scatters by √(2/20), over ten and more frequencies.
    np.testing.assert_allclose(np.sqrt(system.avar(m)), curve.adev, rtol=0.1)


@pytest.mark.parametrize(
    ("error", "message", "arguments"),
    [
        (st.DataError, "10 or more values above 0; it has 3", {"frequency": [1, 2, 3], "density": [1, 1, 1]}),
        (st.DataError, "it has 149", {"density": np.where(F > 40, DENSITY, np.where(F < 0.00101, 0, DENSITY))}),
        (st.DataError, "cannot be negative", {"density": -DENSITY}),
        (st.DataError, r"`density` must be 150 numbers", {"density": DENSITY[:-1]}),
        (st.OptionError, "`dof` must be positive", {"dof": 0}),
        (st.OptionError, "`dof` must be a number, or one for each", {"dof": [1, 2]}),
        (st.OptionError, "`sided`", {"sided": "2"}),
        (st.OptionError, "`unit` must be SI, rad/s, not deg/s", {"unit": "deg/s"}),
        (st.OptionError, "samples have densities up to 5 Hz", {"tau0": 0.1}),
        (st.OptionError, "`level`", {"level": 95}),
        (st.OptionError, "`terms`", {"terms": ["ramp"]}),
    ],
)
def test_what_cannot_be_used(error, message, arguments):
    with pytest.raises(error, match=message):
        st.fit_psd(**({"frequency": F, "density": DENSITY, "dof": DOF, "sided": "two"} | arguments))


def test_densities_of_any_size():
    """The squares of densities near the ends of doubles do not overflow."""
    f = np.geomspace(0.01, 50, 100)
    density = 1e-8 * np.random.default_rng(known.seed_of("sizes")).chisquare(80, 100) / 80
    sizes = [
        st.fit_psd(f, density * size, dof=80, sided="two").model["random_walk"] / size**0.5
        for size in (1, 1e-170, 1e170)
    ]
    assert sizes == pytest.approx([sizes[0]] * 3, rel=1e-9)
