"""Eq. (26) and the paper's ±."""

import numpy as np
import pytest

import known
from sigmatau import NoiseModel, allan, simulate
from sigmatau.noise.terms import avar
from sigmatau.noise.uncertainty import avar_covariance, chi2_factors, degrees_of_freedom, percentage_error


def curves_of(terms, count, *, taus="octave", **run):
    """Of many records, which are the channels of one: it is made at once."""
    model = NoiseModel(channels={f"gyro_{k}": terms for k in range(count)})
    return list(allan(simulate(model, **run), taus=taus).values())


@pytest.mark.parametrize(
    ("n", "m", "expected"),
    [
        (2000, 500, 0.40824829),
        (2000, 10, 0.050125471),
        (1_440_000, 2**14, 0.075857503),
        (1_440_000, 2**18, 0.333586805),
    ],
)
def test_eq_26(n, m, expected):
    assert percentage_error(n, m)[0] == pytest.approx(expected, rel=5e-8)


def test_paper_examples():
    """Section II-D: 40 % and 5 %; Section IV: 0.06 % at one sample of the CIMU."""
    assert round(100 * percentage_error(2000, 500)[0]) == 41  # "approximately 40 %"
    assert round(100 * percentage_error(2000, 10)[0]) == 5
    assert round(100 * percentage_error(1_440_000, 1)[0], 2) == 0.06


@pytest.mark.parametrize("cell", known.PLUS_MINUS)
def test_plus_minus_of_the_tables(cell):
    value, printed, n, m, rounded, digits = known.PLUS_MINUS[cell]
    delta = percentage_error(n, m)[0]
    error = value * (round(delta, 3) if rounded else delta)
    assert error == pytest.approx(printed, abs=0.51 * 10**-digits)  # half a unit of the printed digit


def test_wrong_sizes():
    with pytest.raises(ValueError, match="1 … 99"):
        percentage_error(100, [100])


@pytest.mark.parametrize("term", known.EDF)
@pytest.mark.parametrize("tau0", [1.0, 0.01])
def test_degrees_of_freedom(term, tau0):
    got = degrees_of_freedom({term: 3e-4}, n=1000, m=known.EDF_SIZES, tau0=tau0)
    assert got == pytest.approx(known.EDF[term], rel=1e-10)


def test_covariance_of_a_mixture():
    got = avar_covariance(known.MIXTURE, n=1000, m=[1, 10, 100], tau0=1.0)
    assert got == pytest.approx(np.array(known.MIXTURE_COVARIANCE), rel=1e-10)


def test_a_ramp_alone_does_not_scatter():
    assert avar_covariance({"rate_ramp": 1e-3}, n=100, m=[1, 10], tau0=0.1) == pytest.approx(np.zeros((2, 2)))


def test_scatter_of_simulated_records():
    """Variances and correlations of 600 records with all terms and a ramp, each within 4.5 standard errors."""
    coefficients = {
        "quantization": 1e-2,
        "random_walk": 5e-3,
        "bias_instability": 8e-3,
        "rate_random_walk": 4e-3,
        "rate_ramp": 1e-3,
    }
    records = 600
    seed = known.seed_of("scatter of simulated records")
    curves = curves_of(coefficients, records, duration=40.96, rate=25, rng=seed)
    m = curves[0].m[:8]
    expected = avar_covariance(coefficients, n=1024, m=m, tau0=0.04)
    got = np.cov(np.array([c.avar[:8] for c in curves]).T)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    # The variance of a variance is 2/(n-1) for Gaussian data and more for the skewed AVAR: kurtosis 12/edf at the longest τ.
    kurtosis = 12 / degrees_of_freedom(coefficients, n=1024, m=m, tau0=0.04)
    error = np.sqrt((2 + np.maximum.outer(kurtosis, kurtosis)) / records) * scale
    assert (np.abs(got - expected) <= 4.5 * error).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [({"coefficients": {"arw": 1.0}}, "unknown term 'arw'"), ({"m": [51]}, "1 … 50"), ({"tau0": -1.0}, "tau0")],
)
def test_wrong_arguments(change, words):
    arguments = {"coefficients": {"random_walk": 1.0}, "n": 100, "m": [1], "tau0": 1.0} | change
    with pytest.raises(ValueError, match=words):
        avar_covariance(arguments.pop("coefficients"), **arguments)


class TestChi2:
    def test_factors_are_those_of_the_quantiles(self):
        from scipy.stats import chi2

        edf = np.array([0.7, 1.0, 4.0, 33.3, 1e5])
        for level in (0.683, 0.95):
            low, high = chi2_factors(edf, level=level)
            assert low == pytest.approx(np.sqrt(edf / chi2.ppf(0.5 + level / 2, edf)), rel=1e-9)
            assert high == pytest.approx(np.sqrt(edf / chi2.ppf(0.5 - level / 2, edf)), rel=1e-9)

    def test_many_degrees_of_freedom_are_a_normal_law(self):
        low, high = chi2_factors(1e6)
        assert high - 1 == pytest.approx(1.96 / np.sqrt(2e6), rel=1e-2)
        assert 1 - low == pytest.approx(1.96 / np.sqrt(2e6), rel=1e-2)

    @pytest.mark.parametrize(
        "arguments", [{"edf": 0.0}, {"edf": [1.0, -1.0]}, {"edf": np.nan}, {"edf": 1.0, "level": 1.0}]
    )
    def test_wrong_arguments(self, arguments):
        with pytest.raises(ValueError, match="must"):
            chi2_factors(**arguments)

    @pytest.mark.parametrize("term", ["quantization", "random_walk", "bias_instability", "rate_random_walk"])
    def test_coverage(self, term):
        """95 % by the exact degrees of freedom, at a tenth and a quarter of the record; eq. (26) at a quarter does not."""
        n, m, count = 1024, np.array([102, 256]), 400
        low, high = chi2_factors(degrees_of_freedom({term: 1.0}, n=n, m=m, tau0=1.0))
        truth = np.sqrt(avar(term, 1.0, m=m, tau0=1.0))
        seed = known.seed_of(f"chi2 coverage {term}")
        curves = curves_of({term: 1.0}, count, taus=m, duration=n, rate=1, rng=seed)
        ratio = np.array([curve.adev / truth for curve in curves])
        covered = np.mean((ratio * low <= 1) & (ratio * high >= 1), axis=0)
        # Limits of docs/study/intervals.md, to 3 standard errors.
        error = 3 * np.sqrt(0.05 * 0.95 / count)
        assert np.all((covered >= 0.935 - error) & (covered <= 0.985 + error))
