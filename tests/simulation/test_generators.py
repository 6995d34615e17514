"""Simulated noise against the Allan variance and the spectrum that the model states; what a seed stands for."""

import math
from fractions import Fraction

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, allan, psd, simulate
from sigmatau._native import generators, kernels
from sigmatau.model.channel import ChannelModel
from sigmatau.model.matern import Matern
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.noise import terms
from sigmatau.simulation.rows import correlation_root

TAU0 = 0.01
RECORDS = 150
SAMPLES = 4096

TERMS = {
    "quantization": ChannelModel(terms={"quantization": 1e-3}),
    "random walk": ChannelModel(terms={"random_walk": 0.005}),
    "bias instability": ChannelModel(terms={"bias_instability": 0.7}),
    "rate random walk": ChannelModel(terms={"rate_random_walk": 1e-4}),
    "Gauss-Markov": ChannelModel(gauss_markov=(GaussMarkov(sigma=1e-3, time=0.5), GaussMarkov(sigma=2e-3, time=0.02))),
    "Matern": ChannelModel(
        matern=(Matern(sigma=1e-3, time=0.5, smoothness=0.25), Matern(sigma=2e-3, time=20.0, smoothness=0.05))
    ),
    **{
        f"bandwidth {order} at {corner:g} Hz": ChannelModel(
            terms={"random_walk": 0.005}, bandwidth=LowPass(order=order, corner=corner)
        )
        # 0.3 Hz of order 9: the covariance that a step adds is singular to rounding.
        for order, corner in [(1, 30.0), (2, 30.0), (3, 3.0), (9, 20.0), (9, 0.3)]
    },
}
LINES = {"sinusoid": ChannelModel(sinusoid=(Sinusoid(amplitude=1e-3, frequency=0.37),))}
RAMP = {"ramp": ChannelModel(terms={"rate_ramp": -1e-3})}


def records(case, flicker, *, samples=SAMPLES):
    """Many records of one noise, as channels of one."""
    model = NoiseModel(channels={f"gyro_{k}": {**TERMS, **LINES, **RAMP}[case] for k in range(RECORDS)})
    return simulate(model, duration=samples * TAU0, rate=1 / TAU0, rng=seed_of(case), flicker=flicker)


def ways(cases):
    """Every case as arrays; as streams too where another generator is at work there."""
    return [(c, "exact") for c in cases] + [("bias instability", "poles")]


@pytest.mark.parametrize(("case", "flicker"), [*ways([*TERMS, *LINES])])
def test_mean_avar_is_the_closed_form(case, flicker):
    """At every octave up to a third of the record, within 4 standard errors of 150 records."""
    m = 2 ** np.arange(int(math.log2(SAMPLES / 3)) + 1)
    curves = allan(records(case, flicker), taus=m * TAU0)
    got = np.array([curve.avar for curve in curves.values()])
    assert np.array_equal(next(iter(curves.values())).m, m)
    expected = {**TERMS, **LINES}[case].avar(m=m, tau0=TAU0)
    error = got.std(axis=0, ddof=1) / math.sqrt(RECORDS)
    assert (np.abs(got.mean(axis=0) - expected) <= 4 * error).all()


def scatter(case, flicker, at):
    """Mean square of the samples `at` over the records."""
    stream = records(case, flicker).streams[0]
    return np.mean([stream.column(name)[at] ** 2 for name in stream.channels], axis=0)


@pytest.mark.parametrize("flicker", ["exact", "poles"])
def test_flicker_noise_has_had_its_past(flicker):
    """Its variogram is 4B²/π·Σ 1/(2j − 1), counted from the sample before the first; without a past it would be half."""
    at = np.array([0, 1, 30, 1000, SAMPLES - 1])
    odd = np.cumsum(1 / (2 * np.arange(1, SAMPLES + 1) - 1))
    expected = 4 * 0.7**2 / math.pi * odd[at]
    np.testing.assert_allclose(scatter("bias instability", flicker, at), expected, rtol=4 * math.sqrt(2 / RECORDS))


@pytest.mark.parametrize("case", ["Gauss-Markov", *(name for name in TERMS if name.startswith("bandwidth"))])
def test_what_is_stationary_is_so_from_its_first_sample_on(case):
    """Mean squares within 4 standard errors of Σσ², and of N²·2f·(π/2n)/sin(π/2n) behind a filter."""
    model = TERMS[case]
    if model.bandwidth is None:
        expected = sum(process.sigma**2 for process in model.gauss_markov)
    else:
        angle = math.pi / (2 * model.bandwidth.order)
        expected = model["random_walk"] ** 2 * 2 * model.bandwidth.corner * angle / math.sin(angle)
    got = scatter(case, "exact", np.array([0, 1, SAMPLES - 1]))
    np.testing.assert_allclose(got, expected, rtol=4 * math.sqrt(2 / RECORDS))


def test_a_ramp_is_exact():
    y = records("ramp", "exact").streams[0].column("gyro_0")
    np.testing.assert_allclose(y, -1e-3 * TAU0 * np.arange(SAMPLES), rtol=1e-15)


@pytest.mark.parametrize(("case", "flicker"), [*ways([c for c in TERMS if c != "bandwidth 9 at 0.3 Hz"])])
def test_mean_spectrum_is_the_models(case, flicker):
    """The mean over each octave of frequencies from the 16th on, within 4 standard errors.

    Hann's taper lets a sixth of each neighbour in. Behind filters up to twice the corner, where they still leak nothing.
    """
    model = TERMS[case]
    spectra = psd(records(case, flicker), segment=2048 * TAU0)
    f = next(iter(spectra.values())).frequency
    step = f[1] - f[0]
    highest = (
        0.5 / TAU0 - 2 * step if model.bandwidth is None else min(2 * model.bandwidth.corner, 0.5 / TAU0 - 2 * step)
    )
    use = (f >= 16 * step) & (f <= highest)
    density = {shift: model.psd(f[use] + shift * step, tau0=TAU0) for shift in (-1, 0, 1)}
    expected = (density[-1] + 4 * density[0] + density[1]) / 6
    octave = np.floor(np.log2(f[use] / f[use][0])).astype(int)
    ratios = np.array([s.density[use] / expected for s in spectra.values()])
    for k in range(octave[-1] + 1):
        ratio = ratios[:, octave == k].mean(axis=1)
        error = ratio.std(ddof=1) / math.sqrt(RECORDS)
        assert abs(ratio.mean() - 1) <= 4 * error, k
    assert octave[-1] >= 2


def test_the_poles_have_flickers_allan_variance_up_to_a_third_of_the_longest_record():
    """Without chance: the autocovariance of the bank is that of Gauss-Markov processes, Σ aᵢaⱼ/(1 − pᵢpⱼ) for pole j."""
    for n in (4, 1000, 10**6, 10**9, 10**12):
        loss, weight = generators.flicker_poles(n)
        cross = loss[:, None] + loss - loss[:, None] * loss
        variance = weight * (weight[:, None] / cross).sum(axis=0)
        time = -1 / np.log1p(-loss)
        m = 2 ** np.arange(max(int(math.log2(n / 3)), 0) + 1)
        got = sum(kernels.gauss_markov_avar(math.sqrt(v), t, m, 1.0) for v, t in zip(variance, time, strict=True))
        off = np.sqrt(got / terms.avar("bias_instability", 1.0, m=m, tau0=1.0)) - 1
        assert np.abs(off).max() < 2e-5  # as the documentation has it; the aim is 1e-3


# Samples 0, 1, 2 and the last of 70000 at 100 Hz, as they were before buffers could be filled piece by piece.
OF_OLD = {
    "quantization": (1e-3, [0.08329914829293233, 0.07088030524585075, -0.17734631243948396, -0.05750881444384259]),
    "random_walk": (4e-3, [0.00016623361430371318, -0.0314958041825238, -0.06416562005361363, 0.10609078224954123]),
    "bias_instability": (
        6e-3,
        [-0.0016383304837906784, -0.0010524986061107486, 0.006280019895196673, 0.015493032660817394],
    ),
    "rate_random_walk": (
        3e-3,
        [-0.00019581186969463215, -0.0002996999321104747, -0.000566932759101125, -0.07065999358740198],
    ),
    "rate_ramp": (-1e-4, [0.0, -1.0000000000000002e-06, -2.0000000000000003e-06, -0.069999]),
}


@pytest.mark.parametrize("term", [*OF_OLD, "all"])
def test_a_seed_keeps_its_samples(term):
    names = list(OF_OLD) if term == "all" else [term]
    generator = generators.Generator(70_000, TAU0, seed=seed_of("samples of today"))
    for name in ("rate_ramp", "quantization", "random_walk", "bias_instability", "rate_random_walk"):
        if name in names:
            generator.add_term(name, OF_OLD[name][0], channel=0x1234)
    y = np.empty(70_000)
    for start, stop in ((0, 1), (1, 30_000), (30_000, 70_000)):
        generator.fill(y[start:stop])
    expected = np.sum([OF_OLD[name][1] for name in names], axis=0)
    # Logarithm and exponential are the system's.
    np.testing.assert_allclose(y[[0, 1, 2, -1]], expected, rtol=1e-12, atol=1e-15)


EVERYTHING = ChannelModel(
    terms={"quantization": 1e-3, "random_walk": 4e-3, "bias_instability": 6e-3, "rate_random_walk": 3e-3, "rate_ramp": 1e-4},
    gauss_markov=(GaussMarkov(sigma=1e-3, time=0.5), GaussMarkov(sigma=1e-3, time=0.5)),
    sinusoid=(Sinusoid(amplitude=1e-3, frequency=0.37), Sinusoid(amplitude=1e-3, frequency=0.37)),
    bandwidth=LowPass(order=3, corner=20.0),
)  # fmt: skip


def test_parts_have_random_numbers_of_their_own():
    """Each part alone is what it is among the others, and no two of a kind are one."""
    run = {"duration": 20.0, "rate": 100.0, "rng": seed_of("parts"), "flicker": "poles"}

    def samples(channel):
        return simulate(NoiseModel(channels={"gyro_x": channel}), **run).streams[0].column("gyro_x")

    whole, parts = samples(EVERYTHING), EVERYTHING.parts()
    np.testing.assert_allclose(sum(map(samples, parts.values())), whole, rtol=0, atol=1e-12)
    for name in ("gauss_markov", "sinusoid"):
        pair = getattr(EVERYTHING, name)
        one = samples(ChannelModel(**{name: pair[:1]}))
        assert np.abs(samples(parts[name]) - 2 * one).max() > 1e-4


def test_a_sinusoid_does_not_drift():
    """Against the phase in exact arithmetic after two million samples."""
    frequency, n = 12.3456789, 2_000_000
    generator = generators.Generator(n, TAU0, seed=seed_of("sinusoid"))
    generator.add_sinusoid(1.0, frequency, index=0, channel=1)
    y = np.empty(n)
    generator.fill(y)
    step = Fraction(frequency * TAU0)
    turn = 2 * math.pi * float(step)
    phase = math.atan2(y[0] * math.sin(turn), y[1] - y[0] * math.cos(turn))
    at = np.array([0, 1, 1000, 1_234_567, n - 1])
    expected = [math.sin(2 * math.pi * float(int(k) * step % 1) + phase) for k in at]
    np.testing.assert_allclose(y[at], expected, rtol=0, atol=1e-12)


class TestCorrelation:
    names = ("gyro_x", "gyro_y", "gyro_z")

    def samples(self, channels, correlation, **options):
        model = NoiseModel(channels=channels, correlation=correlation)
        run = {"duration": 500.0, "rate": 100.0, "rng": seed_of("correlation"), **options}
        record = simulate(model, **run)
        return {name: record.stream_of(name).column(name) for name in channels}

    @pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk"])
    def test_differences_are_correlated_as_stated(self, term):
        """First differences of flicker noise and walks, samples of the others: correlation within 4 standard errors."""
        r = {("gyro_x", "gyro_y"): 0.6, ("gyro_y", "gyro_z"): -0.5}
        y = self.samples({n: {term: 1e-3 * (1 + k)} for k, n in enumerate(self.names)}, {term: r})
        x = np.array([np.diff(v) if term in ("bias_instability", "rate_random_walk") else v for v in y.values()])
        got = np.corrcoef(x[:, ::4])  # four apart they are nearly independent
        assert got[0, 1] == pytest.approx(0.6, abs=4 / math.sqrt(x.shape[1] / 4))
        assert got[1, 2] == pytest.approx(-0.5, abs=4 / math.sqrt(x.shape[1] / 4))
        assert got[0, 2] == pytest.approx(0, abs=4 / math.sqrt(x.shape[1] / 4))
        # Each alone has its own strength.
        np.testing.assert_allclose(x[1].std() / x[0].std(), 2, rtol=0.03)

    def test_one_and_the_same_noise(self):
        channels = {n: {"random_walk": 1e-3 * (1 + k), "bias_instability": 1e-4} for k, n in enumerate(self.names)}
        pairs = {("gyro_x", "gyro_y"): 1.0, ("gyro_x", "gyro_z"): -1.0, ("gyro_y", "gyro_z"): -1.0}
        y = self.samples(channels, {"random_walk": pairs, "bias_instability": pairs})
        alone = self.samples({"gyro_x": channels["gyro_x"]}, {})
        assert np.array_equal(y["gyro_x"], alone["gyro_x"])
        np.testing.assert_allclose(y["gyro_y"] - y["gyro_x"], 1e-3 * self.white(), rtol=0, atol=1e-15)
        np.testing.assert_allclose(y["gyro_z"] + y["gyro_x"], -2e-3 * self.white(), rtol=0, atol=1e-15)

    def white(self):
        return self.samples({"gyro_x": {"random_walk": 1.0}}, {})["gyro_x"]

    def test_the_others_keep_their_samples(self):
        channels = {n: {"random_walk": 1e-3, "rate_random_walk": 1e-4} for n in self.names}
        alone = self.samples(channels, {})
        y = self.samples(channels, {"random_walk": {("gyro_x", "gyro_z"): 0.5}})
        assert np.array_equal(y["gyro_x"], alone["gyro_x"])
        assert np.array_equal(y["gyro_y"], alone["gyro_y"])
        assert not np.array_equal(y["gyro_z"], alone["gyro_z"])

    def test_behind_a_bandwidth(self):
        band = LowPass(order=2, corner=10.0)
        channels = {n: ChannelModel(terms={"random_walk": 1e-3}, bandwidth=band) for n in self.names[:2]}
        y = self.samples(channels, {"random_walk": {self.names[:2]: 0.3}})
        got = np.corrcoef(y["gyro_x"][::20], y["gyro_y"][::20])[0, 1]  # 0.2 s apart, far beyond the filter's memory
        assert got == pytest.approx(0.3, abs=4 / math.sqrt(2500))
        assert y["gyro_y"].std() == pytest.approx(y["gyro_x"].std(), rel=0.05)

    def test_root(self):
        for matrix in (np.eye(3), [[1, 0.5, 0], [0.5, 1, -0.3], [0, -0.3, 1]], np.ones((3, 3)), [[1, -1], [-1, 1]]):
            root = correlation_root(np.array(matrix, dtype=float))
            np.testing.assert_allclose(root @ root.T, matrix, atol=1e-15)
            assert np.array_equal(root, np.tril(root))
        nearly = 1 - 4e-9  # taken for 1, without a loss of strength
        root = correlation_root(np.array([[1, nearly], [nearly, 1]]))
        np.testing.assert_allclose((root**2).sum(axis=1), 1, rtol=1e-15)
