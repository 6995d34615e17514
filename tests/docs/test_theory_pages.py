"""docs/theory and docs/glossary.md: formulas by integration of the densities, tables and numbers by calculation."""

import importlib
import math
import re

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from scipy.special import sici

import sigmatau as st
from conftest import ROOT
from sigmatau._native import kernels
from sigmatau.model.transform import integrate_density
from sigmatau.noise.terms import TERMS, aliasing_inflation, avar, psd
from sigmatau.noise.uncertainty import chi2_factors, degrees_of_freedom
from sigmatau.units import find, symbols, to_si

THEORY = ROOT / "docs" / "theory"
STUDY = ROOT / "docs" / "study"
PAGES = {path.stem: path.read_text(encoding="utf-8") for path in THEORY.glob("*.md")}
FLAT = {name: " ".join(text.split()) for name, text in PAGES.items()}  # without line breaks
GLOSSARY = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
PARTS = (
    "quantization", "random-walk", "bias-instability", "rate-random-walk", "rate-ramp", "gauss-markov", "sinusoid", "filter",
)  # fmt: skip
CHAPTERS = (
    "Origin",
    "Spectral density",
    "Allan variance",
    "What looks the same",
    "Length of the record",
    "Example",
    "In the code",
)

TAU0 = 0.02
M = np.array([1, 2, 7, 40])
TAU = M * TAU0
Q, N, B, K, R = 0.3, 0.7, 1.3, 0.4, 0.9
SIGMA, T = 1.1, 0.35  # of a Gauss-Markov process
A, F0, G = 0.8, 3.7, 0.4  # of a line, and the half width of a resonance
P = math.exp(-TAU0 / T)


def odd_harmonics(count):
    return sum(1 / (2 * j - 1) for j in range(1, count + 1))


def flicker_sum(size):
    """J of the page on bias instability."""
    closed = -(4 * size**2 - 1) * odd_harmonics(size - 1) / 2 + 2 * size * (size - 1) - (size - 1) ** 2 / 2
    assert closed == pytest.approx(-4 * sum((size - k) * odd_harmonics(k) for k in range(1, size)), rel=1e-12)
    return closed


def with_cutoff(tau, f0):
    x = np.pi * f0 * np.asarray(tau)
    ci = sici(2 * x)[1] - sici(4 * x)[1]
    return 2 * B**2 / np.pi * (np.log(2) - np.sin(x) ** 3 / (2 * x**2) * (np.sin(x) + 4 * x * np.cos(x)) + ci)


def exponential(variance, rate, tau):
    """The Allan variance of an autocovariance variance·exp(−rate·t); complex for a resonance."""
    z = rate * np.asarray(tau)
    return 2 * variance / z * (1 - (3 - 4 * np.exp(-z) + np.exp(-2 * z)) / (2 * z))


def resonance(tau):
    gamma = 2 * np.pi * G
    omega = np.sqrt((2 * np.pi * F0) ** 2 - gamma**2)
    return exponential(SIGMA**2 * (1 + 1j * gamma / omega), gamma - 1j * omega, tau).real


def from_autocovariance(r):
    """σ²(m) = (4V(m) − V(2m))/(2m²) of the page on filters."""
    sums = [size * r(0) + 2 * sum((size - k) * r(k * TAU0) for k in range(1, size)) for size in range(2 * M[-1] + 1)]
    return np.array([(4 * sums[m] - sums[2 * m]) / (2 * m**2) for m in M])


def sin_f(f):
    return np.sin(np.pi * f * TAU0)


FC = 4.0
W = 2 * math.pi * FC


def first_order(t):
    return N**2 * W / 2 * np.exp(-W * abs(t))


def second_order(t):
    turn = W * abs(t) / math.sqrt(2)
    return N**2 * W / (2 * math.sqrt(2)) * np.exp(-turn) * (np.cos(turn) + np.sin(turn))


# Page, formula of the density, formula of the variance, density, variance; None: continuous time, or TAU0: of samples
INTEGRALS = [
    ("quantization", "S(f) = (4Q²/τ₀) sin²(πfτ₀)", "= 3Q²/τ²",
     lambda f: 4 * Q**2 / TAU0 * sin_f(f) ** 2, 3 * Q**2 / TAU**2, TAU0),
    ("random-walk", "S(f) = N²", "σ²(τ) = N²/τ.", lambda f: N**2 + 0 * f, N**2 / TAU, None),
    ("random-walk", "S(f) = N²", "= N²/(mτ₀)", lambda f: N**2 + 0 * f, N**2 / TAU, TAU0),
    ("bias-instability", "S(f) = B²/(2πf)", "(2 ln 2/π) B²", lambda f: B**2 / (2 * np.pi * f),
     2 * np.log(2) / np.pi * B**2 + 0 * TAU, None),
    ("bias-instability", "S(f) = B²τ₀/(2 sin(πfτ₀))", "σ²(m) = (2B²/(πm²)) [J(m) − J(2m)/4]",
     lambda f: B**2 * TAU0 / (2 * sin_f(f)),
     [2 * B**2 / (np.pi * m**2) * (flicker_sum(m) - flicker_sum(2 * m) / 4) for m in M.tolist()], TAU0),
    ("rate-random-walk", "S(f) = (K/(2πf))²", "σ²(τ) = K²τ/3.", lambda f: (K / (2 * np.pi * f)) ** 2, K**2 * TAU / 3, None),
    ("rate-random-walk", "S(f) = K²τ₀²/(4 sin²(πfτ₀))", "σ²(m) = K²τ₀(2m² + 1)/(6m) = (K²τ/3)(1 + 1/(2m²))",
     lambda f: K**2 * TAU0**2 / (4 * sin_f(f) ** 2), K**2 * TAU0 * (2 * M**2 + 1) / (6 * M), TAU0),
    ("gauss-markov", "S(f) = 2σ²T/(1 + (2πfT)²)",
     "σ²(τ) = (2σ²T/τ) [1 − (T/(2τ))(3 − 4e^(−τ/T) + e^(−2τ/T))]",
     lambda f: 2 * SIGMA**2 * T / (1 + (2 * np.pi * f * T) ** 2), exponential(SIGMA**2, 1 / T, TAU), None),
    ("gauss-markov", "S(f) = σ²τ₀(1 − p²)/(1 − 2p cos(2πfτ₀) + p²)",
     "σ²(m) = σ² [m(1 − p²) − 3p + 4p^(m+1) − p^(2m+1)]/(m²(1 − p)²)",
     lambda f: SIGMA**2 * TAU0 * (1 - P**2) / (1 - 2 * P * np.cos(2 * np.pi * f * TAU0) + P**2),
     SIGMA**2 * (M * (1 - P**2) - 3 * P + 4 * P ** (M + 1) - P ** (2 * M + 1)) / (M**2 * (1 - P) ** 2), TAU0),
    ("sinusoid", "S(f) = (2σ²g/π) f²/((f² − f₀²)² + 4g²f²)",
     "σ²(τ) = Re { (2σ²(1 + jγ/ω)/(ζτ)) [1 − (3 − 4e^(−ζτ) + e^(−2ζτ))/(2ζτ)] }",
     lambda f: 2 * SIGMA**2 * G / np.pi * f**2 / ((f**2 - F0**2) ** 2 + 4 * G**2 * f**2), resonance(TAU), None),
    ("filter", "S(f) = N²/(1 + (f/f_c)^(2p))", "N²/τ [1 − (T/(2τ))(3 − 4e^(−τ/T) + e^(−2τ/T))]",
     lambda f: N**2 / (1 + (f / FC) ** 2), exponential(N**2 * W / 2, W, TAU), None),
]  # fmt: skip


IDS = [f"{row[0]}-{'samples' if row[5] else 'continuous'}" for row in INTEGRALS]


@pytest.mark.parametrize(("page", "density", "variance", "s", "expected", "tau0"), INTEGRALS, ids=IDS)
def test_formulas_are_the_integrals_of_their_densities(page, density, variance, s, expected, tau0):
    assert density in FLAT[page]
    assert variance in FLAT[page]
    assert integrate_density(s, TAU, tau0=tau0) == pytest.approx(np.asarray(expected), rel=1e-9)


SAMPLED = {row[0]: row[3:5] for row in INTEGRALS if row[5]}


@pytest.mark.parametrize("page", SAMPLED)
def test_the_package_has_the_formulas_of_samples(page):
    s, expected = SAMPLED[page]
    f = np.array([0.1, 3.0, 20.0])
    name = page.replace("-", "_")
    if name == "gauss_markov":
        model = st.ChannelModel(gauss_markov=(st.GaussMarkov(sigma=SIGMA, time=T),))
        got, density = model.avar(m=M, tau0=TAU0), model.psd(f, tau0=TAU0)
    else:
        value = {"quantization": Q, "random_walk": N, "bias_instability": B, "rate_random_walk": K}[name]
        got, density = avar(name, value, m=M, tau0=TAU0), psd(name, value, f, tau0=TAU0)
    assert got == pytest.approx(np.asarray(expected), rel=1e-12)
    assert density == pytest.approx(s(f), rel=1e-12)


def test_flicker_with_a_cutoff():
    assert "(2B²/π) [ln 2 − sin³(x)/(2x²) (sin x + 4x cos x) + Ci(2x) − Ci(4x)]" in FLAT["bias-instability"]
    got = integrate_density(lambda f: B**2 / (2 * np.pi * f), TAU, f_max=5.0)
    assert with_cutoff(TAU, 5.0) == pytest.approx(got, rel=1e-9)
    assert avar("bias_instability", B, m=M, tau0=TAU0, cutoff=5.0) == pytest.approx(got, rel=1e-9)
    assert "B²x²/π" in FLAT["bias-instability"]
    assert with_cutoff([1e-3], 1.0)[0] == pytest.approx(B**2 * (np.pi * 1e-3) ** 2 / np.pi, rel=1e-4)


def test_ramp():
    assert "σ²(τ) = R²τ²/2," in FLAT["rate-ramp"]
    n = 1000
    curve = st.allan(st.Record.from_arrays(rate=1 / TAU0, x=R * TAU0 * np.arange(n)), taus=M * TAU0)["x"]
    assert curve.avar == pytest.approx(R**2 * TAU**2 / 2, rel=1e-10)
    assert "R²D/(2πf)²." in FLAT["rate-ramp"]
    y, duration = R * TAU0 * np.arange(n), n * TAU0
    periodogram = abs(np.fft.rfft(y)[1:9]) ** 2 * TAU0 / n
    f = np.arange(1, 9) / duration
    assert periodogram == pytest.approx(
        R**2 * duration / (2 * np.pi * f) ** 2, rel=2e-3
    )  # of samples: 1/sin² in place of 1/x²


def test_lines_and_resonances():
    page = FLAT["sinusoid"]
    for formula in ("A² sin⁴(πf₀τ)/(πf₀τ)²", "A² sin⁴(πf₀mτ₀)/(m² sin²(πf₀τ₀))", "σ² e^(−γt) (cos ωt − (γ/ω) sin ωt)"):
        assert formula in page
    sampled = A**2 * np.sin(np.pi * F0 * TAU) ** 4 / (M * np.sin(np.pi * F0 * TAU0)) ** 2
    assert kernels.sinusoid_avar(A, F0, M, TAU0) == pytest.approx(sampled, rel=1e-12)
    phases = np.arange(64) * 2 * np.pi / 64  # a mean over all phases, from three angles each
    edges = np.array([0, 1, 2])[:, None, None] * TAU[:, None]
    angle = -A / (2 * np.pi * F0) * np.cos(2 * np.pi * F0 * edges + phases)
    continuous = np.mean((angle[2] - 2 * angle[1] + angle[0]) ** 2, axis=1) / (2 * TAU**2)
    assert A**2 * np.sin(np.pi * F0 * TAU) ** 4 / (np.pi * F0 * TAU) ** 2 == pytest.approx(continuous, rel=1e-9)
    top = minimize_scalar(
        lambda u: -(np.sin(u) ** 2) / u, bounds=(0.5, 1.5), method="bounded", options={"xatol": 1e-10}
    )
    assert (f"{top.x:.4f}", f"{-top.fun:.4f}", f"{top.x / np.pi:.4f}") == ("1.1656", "0.7246", "0.3710")
    assert np.tan(top.x) == pytest.approx(2 * top.x, rel=1e-6)
    assert "u = 1.1656: σ = 0.7246 A at τ = 0.3710/f₀" in page
    raised = math.sqrt(1 + kernels.sinusoid_avar(1.0, 23.3, np.array([1]), 0.01)[0])
    assert f"raises σ at m = 1 by {100 * (raised - 1):.0f} %" in page
    fine = TAU0 / 400  # of samples so close that they are continuous
    assert kernels.resonance_avar(SIGMA, F0, G, 400 * M, fine) == pytest.approx(resonance(TAU), rel=1e-4)
    f = np.array([1.0, F0, 9.0])
    assert kernels.resonance_psd(SIGMA, F0, G, f) == pytest.approx(INTEGRALS[-2][3](f), rel=1e-12)


AUTOCOVARIANCES = [
    (1, first_order, "r(t) = (N²w/2) e^(−w|t|)"),
    (2, second_order, "r(t) = (N²w/(2√2)) e^(−w|t|/√2) (cos(wt/√2) + sin(w|t|/√2))"),
]


@pytest.mark.parametrize(("order", "r", "formula"), AUTOCOVARIANCES, ids=["1", "2"])
def test_filters(order, r, formula):
    assert formula in FLAT["filter"]
    assert "V(l) = l r₀ + 2 Σ_{k<l} (l − k) r_k" in FLAT["filter"]
    model = st.ChannelModel(terms={"random_walk": N}, bandwidth=st.LowPass(order=order, corner=FC))
    assert from_autocovariance(r) == pytest.approx(model.avar(m=M, tau0=TAU0), rel=1e-9)
    power = 2 * quad(lambda f: N**2 / (1 + (f / FC) ** (2 * order)), 0, np.inf)[0]
    assert power == pytest.approx(r(0.0), rel=1e-8)


def test_folding():
    rows = re.findall(r"^\| (\d+) \| ([\d.]+) \| ([\d.]+) \|$", PAGES["filter"], flags=re.MULTILINE)
    assert len(rows) == 6
    for ratio, *printed in rows:
        found = [aliasing_inflation(rate=float(ratio), bandwidth=1.0, order=order) for order in (1, 2)]
        assert [f"{x:.3f}" for x in found] == printed
        x = math.pi / float(ratio)
        assert found[0] == pytest.approx(math.sqrt(x / math.tanh(x)), rel=1e-12)
    k = np.arange(-200_000, 200_001)
    assert np.sum(1 / (1 + (k / 0.6) ** 2)) == pytest.approx(aliasing_inflation(rate=1.0, bandwidth=0.6) ** 2, rel=1e-5)
    assert "N_eff²/N² = Σ_k |H(k/τ₀)|²" in FLAT["filter"]
    assert [f"{100 * (aliasing_inflation(rate=r, bandwidth=1.0) - 1):.0f}" for r in (5, 3)] == ["6", "16"]


def deficit(ratio):
    """1 − σ²τ/N² behind a filter of first order at τ = ratio·T."""
    return 1 - exponential(0.5, 1.0, ratio) * ratio


def half_decade_low():
    """By how much the curve of a Gauss-Markov process is lower half a decade from its top."""
    top = math.sqrt(exponential(1.0, 1.0, 1.892618))
    return [100 * (1 - math.sqrt(exponential(1.0, 1.0, 1.892618 * 10**x)) / top) for x in (-0.5, 0.5)]


def above_plateau(m):
    """Sampled flicker noise over the plateau. [%]"""
    return 100 * (avar("bias_instability", 1.0, m=[m], tau0=1.0)[0] / TERMS["bias_instability"].level ** 2 - 1)


PEAK = minimize_scalar(lambda x: -exponential(1.0, 1.0, x), bounds=(1, 3), method="bounded", options={"xatol": 1e-10})
CIMU_Q, CIMU_N = to_si(0.973, "arcsec"), to_si(0.0015, "deg/sqrt(h)")
EDF_4096 = degrees_of_freedom({"quantization": 1.0}, n=4096, m=[1024], tau0=1.0)[0]

NUMBERS = [
    ("quantization", "9.8·10⁻⁵ m/s", 9.80665 * 10e-6, 9.8e-5, 0.1e-5),
    ("quantization", "0.1 % from 500 000", 100 / math.sqrt(2 * 500_000), 0.1, 1e-9),
    ("quantization", "1.8 times smaller", 10**0.25, 1.8, 0.05),
    ("quantization", "1418 for 4096 samples", EDF_4096, 1418, 0.5),
    ("random-walk", "0.0387 deg after a", 0.3 / math.sqrt(60), 0.0387, 5e-5),
    ("random-walk", "0.12 % from an hour", 100 / math.sqrt(2 * 360_000), 0.12, 0.005),
    ("random-walk", "at 0.21 Hz", CIMU_N / (2 * np.pi * CIMU_Q * math.sqrt(1 / 200)), 0.21, 0.005),
    ("random-walk", "at 351 s", 3 * CIMU_Q**2 / CIMU_N**2, 351, 0.5),
    ("bias-instability", "44 % above the plateau at m = 1", above_plateau(1), 44, 0.5),
    ("bias-instability", "15 % at m = 2", above_plateau(2), 15, 0.5),
    ("bias-instability", "0.5 % at m = 16", above_plateau(16), 0.5, 0.05),
    ("noise-terms", "44 % more", above_plateau(1), 44, 0.5),
    ("noise-terms", "50 % more", 100 * (avar("rate_random_walk", 1, m=[1], tau0=3)[0] - 1), 50, 1e-9),
    ("bias-instability", "B = 1.62 √(NK)", math.sqrt(2 / math.sqrt(3)) / TERMS["bias_instability"].level, 1.62, 0.005),
    ("bias-instability", "τ = 2.27 N²/B²", np.pi / (2 * math.log(2)), 2.27, 0.005),
    ("rate-random-walk", "0.5 % at m = 10", 100 / (2 * 10**2), 0.5, 1e-9),
    ("rate-ramp", "1.04 deg/h² for N = 0.3 deg/√h and 1 h", 0.3 * math.sqrt(12), 1.04, 0.005),
    ("rate-ramp", "32 times less", 10**1.5, 32, 0.5),
    ("gauss-markov", "0.6174 σ at τ = 1.8926 T", PEAK.x, 1.8926, 5e-5),
    ("gauss-markov", "0.6174 σ", math.sqrt(-PEAK.fun), 0.6174, 5e-5),
    ("gauss-markov", "B = 0.929 σ", math.sqrt(-PEAK.fun) / TERMS["bias_instability"].level, 0.929, 5e-4),
    ("gauss-markov", "σ = 1.076 B", TERMS["bias_instability"].level / math.sqrt(-PEAK.fun), 1.076, 5e-4),
    ("gauss-markov", "18 % too low", max(half_decade_low()), 18, 1.0),
    ("gauss-markov", "36 correlation times of 300 s", 3 * 3600 / 300, 36, 1e-9),
    ("filter", "5 % at τ = 30 T = 4.8/f_c", 100 * deficit(30.0), 5, 0.5),
    ("filter", "30 T = 4.8/f_c", 30 / (2 * np.pi), 4.8, 0.05),
    ("filter", "1 % at 150 T", 100 * deficit(150.0), 1, 0.05),
    ("estimators", "from 0.45 to 32 times", chi2_factors([1.0])[1][0], 32, 0.5),
    ("estimators", "from 0.45", chi2_factors([1.0])[0][0], 0.45, 0.005),
    ("estimators", "0.70 to 1.75 times", chi2_factors([10.0])[1][0], 1.75, 0.01),
    ("estimators", "0.70 to", chi2_factors([10.0])[0][0], 0.70, 0.005),
]  # fmt: skip


@pytest.mark.parametrize(("page", "words", "value", "printed", "error"), NUMBERS, ids=[row[0] for row in NUMBERS])
def test_numbers(page, words, value, printed, error):
    assert words in FLAT[page]
    assert float(value) == pytest.approx(printed, abs=error)


def test_clusters_that_do_not_overlap():
    """Of 1000 samples of white noise, m = 100: nine differences, correlated by −1/2 with their neighbours."""
    edf = 9**2 / (9 + 2 * 8 / 4)
    overlapped = degrees_of_freedom({"random_walk": 1.0}, n=1000, m=[100], tau0=1.0)[0]
    assert edf / overlapped == pytest.approx(0.5, abs=0.03)
    assert "about half of the degrees of freedom" in FLAT["estimators"]


# What `plan` says, on the pages of the terms

N_MEMS = {"random_walk": to_si(0.3, "deg/sqrt(h)")}
BACKGROUNDS = {"N": N_MEMS, "N, B": N_MEMS | {"bias_instability": to_si(5, "deg/h")}}
HOURS = {"10 min": 1 / 6, "1 h": 1, "10 h": 10, "100 h": 100}


@pytest.mark.parametrize("page", PARTS[:5])
def test_lengths_of_records(page):
    term = page.replace("-", "_")
    others = {"quantization": to_si(1, "arcsec")} if term == "random_walk" else N_MEMS
    rows = re.findall(
        r"^\| (\d+ (?:min|h)) \| (?:(N|N, B) \| )?(\S+) (\S+) \| (\S+) (\S+) \|$", PAGES[page], flags=re.MULTILINE
    )
    assert {row[0] for row in rows} == HOURS.keys()
    for length, beside, half, unit, most, _ in rows:
        found = st.plan(
            BACKGROUNDS.get(beside, others), term, duration=3600 * HOURS[length], channel="gyro_x", quantity="angular_rate",
            rate_unit="rad/s", rate=100,
        )  # fmt: skip
        assert [float(f"{x / find(unit).factor:.3g}") for x in (found.half, found.most)] == [float(half), float(most)]


# What is quoted of the studies


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def rows_of(text):
    return [cells(line) for line in text.splitlines() if line.startswith("|")]


def study(name):
    return (STUDY / f"{name}.md").read_text(encoding="utf-8")


def test_costs_of_filters_are_those_of_the_study():
    measured = {row[0]: row for row in rows_of(study("likelihood").partition("## Records that no model")[2])}
    table = PAGES["filter"].partition("| half width of N [%]")[2].partition("\n\n")[0]
    quoted = [row for row in rows_of(table) if row[0] not in ("record", "---")]
    assert len(quoted) == 6
    for name, half, covered in quoted:
        row = measured["ideal" if name == "without a filter" else name]
        assert [half, covered] == row[8:10]


def test_weak_coverage_is_that_of_the_study():
    measured = {row[0]: row for row in rows_of(study("likelihood").partition("## Records that no model")[2])}
    page = PAGES["intervals"].partition("## Exceptions")[2]
    for words, name, column, covered in (
        ("ripple of 6 %", "ripple of 6 % in the white noise", 9, "66"),
        ("telegraph noise", "telegraph noise, 50 s", 15, "90"),
        ("telegraph noise", "telegraph noise, 200 s", 15, "88"),
        ("a hump near 20 s of 0.6 times", "hump at 20 s, 0.6 times", 12, "86"),
    ):
        assert measured[name][column] == covered
        (line,) = (line for line in page.splitlines() if words in line)
        assert covered in cells(line)[2]
    vibrations = measured["two vibrations with harmonics"]
    assert (vibrations[7], vibrations[9], measured["two lines that wander"][9]) == ("+0.012", "96", "100")


def test_degrees_of_freedom_are_those_of_the_study():
    measured = {row[0]: row[1:] for row in rows_of(study("intervals"))}
    quoted = {row[0]: row[1:] for row in rows_of(PAGES["intervals"])}
    for name, letter in (
        ("quantization", "Q"),
        ("random walk", "N"),
        ("bias instability", "B"),
        ("rate random walk", "K"),
    ):
        exact = measured[f"{letter}: exact degrees of freedom"]
        assert quoted[name] == [exact[k] for k in (0, 1, 2, 3, 5, 7)]


def test_spread_of_the_methods_is_that_of_the_studies():
    text = study("likelihood").partition("## Ideal records, 1048576 samples")[2].partition("\n## ")[0]
    likelihood = {tuple(row[:2]): row for row in rows_of(text)}
    efficiency = {tuple(row[:3]): row for row in rows_of(study("efficiency"))}
    letters = {"N": "random_walk", "B": "bias_instability", "Q": "quantization"}
    quoted = [row for row in rows_of(PAGES["estimators"]) if row[0] in ("MEMS", "tactical", "navigation")]
    assert len(quoted) == 6
    for unit, letter, bound, by_likelihood, *others in quoted:
        row = likelihood[unit, letter]
        close = {"rel": 0.02}
        assert float(bound.split(";")[0]) == pytest.approx(float(row[7]), **close)
        assert float(by_likelihood) == pytest.approx(float(row[5]), **close)
        for method, value in zip(("GLS, terms known", "unweighted log fit", "read off"), others, strict=True):
            cell = efficiency[unit, letters[letter], method][5]
            assert (value == "–") if not cell else float(value) == pytest.approx(float(cell), **close)


# The pages


def test_every_part_of_a_model_has_a_page():
    for name in PARTS:
        page = PAGES[name]
        heads = re.findall(r"^## (.*)$", page, flags=re.MULTILINE)
        assert [head for head in heads if head in CHAPTERS] == [head for head in CHAPTERS if head in heads], name
        wanted = set(CHAPTERS) - ({"Origin"} if name == "filter" else set())
        assert wanted - {"Spectral density", "Allan variance"} <= set(heads), name
        assert f"](../figures/term-{name}.svg)" in page
        assert f"({name}.md)" in FLAT["noise-terms"]
        figure = (ROOT / "docs" / "figures" / f"term-{name}.svg").stat().st_size
        assert 20_000 < figure < 150_000
    assert {f"`{key}`" for key in (*TERMS, "gauss_markov", "sinusoid", "resonance", "bandwidth")} <= set(
        re.findall(r"`\w+`", PAGES["noise-terms"])
    )


@pytest.mark.parametrize("name", [*PARTS, "intervals"])
def test_modules_that_are_named_exist(name):
    named = PAGES[name].partition("## In the code")[2]
    modules = re.findall(r"`(sigmatau\.[a-z_.]+)`", named)
    assert modules
    for module in modules:
        package, _, last = module.rpartition(".")
        try:
            assert importlib.import_module(module)
        except ModuleNotFoundError:
            assert hasattr(importlib.import_module(package), last), module
    for path in re.findall(r"`(crates/[\w/]+)`", named):
        assert (ROOT / path).exists() or (ROOT / path).with_suffix(".rs").exists(), path


def slug(head):
    return re.sub(r"[^\w\- ]", "", head.replace("`", "").strip().lower()).replace(" ", "-")


@pytest.mark.parametrize(
    "path", [ROOT / "docs" / "glossary.md", *sorted(THEORY.glob("*.md"))], ids=lambda path: path.stem
)
def test_anchors(path):
    for target, anchor in re.findall(r"\]\(([^)#\s]*)#([^)]+)\)", path.read_text(encoding="utf-8")):
        if target.startswith("https://"):
            continue
        text = (path.parent / target if target else path).read_text(encoding="utf-8")
        assert anchor in {slug(head) for head in re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)}, (
            f"{target}#{anchor}"
        )


# The glossary


def test_the_glossary_names_every_unit():
    rows = re.findall(r"^\| accepted units, [a-z]+ \(`([^`]+)`\) \| (.*) \|$", GLOSSARY, flags=re.MULTILINE)
    assert {si for si, _ in rows} == {find(symbol).si for symbol in symbols()}
    for si, units in rows:
        assert re.findall(r"`([^`]+)`", units) == list(symbols(si)), si


VALUE = re.compile(r"`([\d.e+-]+) ([^`]+)`")


def test_conversions_of_the_glossary():
    chains = [VALUE.findall(line) for line in re.findall(r"`[\d.e+-]+ [^`]+`(?: = `[\d.e+-]+ [^`]+`)+", GLOSSARY)]
    assert len(chains) > 20
    for chain in chains:
        (value, unit), *others = chain
        for other, to in others:
            assert find(unit).si == find(to).si
            digits = max(4, len(re.sub(r"e.*|\.", "", other).lstrip("0")))  # as printed, without zeros at the end
            assert to_si(float(other), to) == pytest.approx(to_si(float(value), unit), rel=5.1 * 10.0**-digits), (
                other,
                to,
            )


def test_factors_of_the_glossary():
    rows = re.findall(r"^\| (\S+) \| (\S+) \| ([πg\d./· ×⁻⁶]+) \|$", GLOSSARY, flags=re.MULTILINE)
    assert len(rows) == 7
    for unit, to, factor in rows:
        text = factor.replace("9.80665·10⁻⁶", "9.80665e-6").replace("·", "*").replace("π", "math.pi")
        assert to_si(1, unit) / to_si(1, to) == pytest.approx(eval(text, {"math": math}), rel=1e-12)


def test_spellings_of_the_glossary():
    table = GLOSSARY.partition("Accepted spellings")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (`.*`) \| `([^`]+)` \|$", table, flags=re.MULTILINE)
    assert len(rows) > 10
    for spellings, unit in rows:
        for spelling in re.findall(r"`([^`]+)`", spellings):
            assert find(spelling).symbol == unit, spelling


def test_examples_of_the_glossary():
    n, d = 0.005, 7.07e-3  # deg/s/√Hz
    for words, value in (
        ("0.3 deg/√h at 100 Hz: 0.05 deg/s", n * 10),
        ("0.3 deg/√h, 30 Hz: 0.0485 deg/s", n * math.sqrt(math.pi * 30)),
        ("0.3 deg/√h, 30 Hz: 0.0408 deg/s", n * math.sqrt(math.pi * 30 / math.sqrt(2))),
        ("7.07 mdps/√Hz, 1.571 · 30 Hz: 0.0485 deg/s", d * math.sqrt(math.pi / 2 * 30)),
        ("15 deg/h/√h at 100 Hz: 0.025 deg/h", to_si(15, "deg/h/sqrt(h)") / 10 / to_si(1, "deg/h")),
        ("0.3 deg/√h, 1 s: 18 deg/h", to_si(0.3, "deg/sqrt(h)") / to_si(1, "deg/h")),
        ("0.3 deg/√h, 60 s: 0.0387 deg", to_si(0.3, "deg/sqrt(h)") * math.sqrt(60) / to_si(1, "deg")),
        ("B = 12.04 deg/h", 8 / TERMS["bias_instability"].level),
        ("N = 3.536 mdeg/s/√Hz", 5 / math.sqrt(2)),
        ("= 0.2121 deg/√h", 60 * 5e-3 / math.sqrt(2)),
        ("1.571 f_c for the first", math.pi / 2),
        ("1.111 f_c for the second", math.pi / (2 * math.sqrt(2))),
    ):
        assert words in " ".join(GLOSSARY.split())
        printed = re.findall(r"[\d.]+", words.split(":")[-1])[0]
        assert f"{value:.{len(printed.split('.')[1]) if '.' in printed else 0}f}" == printed, words


def test_keys_of_the_glossary_are_those_of_the_pages_of_the_programs():
    """The pages of docs/how-to show the files that the exports write."""
    pages = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "docs" / "how-to").glob("*.md"))
    table = GLOSSARY.partition("## Keys of other programs")[2].partition("\n## ")[0]
    keys = set(re.findall(r"`([A-Za-z_.0-9]+)`", table))
    assert len(keys) > 50
    assert {key for key in keys if key not in pages} <= {"biasAccOmegaInt"}  # which is not of an export
