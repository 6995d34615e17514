"""The whole fit: exact curves, simulated records, and what it says when it cannot."""

import dataclasses
import json
import math

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, Record, allan, fit, simulate
from sigmatau._native import kernels
from sigmatau.errors import OptionError
from sigmatau.estimators.allan import DeviationCurve
from sigmatau.estimators.deviation_kinds import cluster_sizes
from sigmatau.findings.reasons import Misfit, TooFewTimes
from sigmatau.noise.terms import NOISE, TERMS, avar
from sigmatau.units import to_si


def exact(coefficients, *, n=2**18, rate=100.0, extra=0.0, ramp=0.0, grid="half"):
    """The curve that a mixture has on average."""
    m = cluster_sizes(grid, n=n, tau0=1 / rate)
    values = sum(avar(t, c, m=m, tau0=1 / rate) for t, c in coefficients.items()) + extra
    return DeviationCurve(
        channel="gyro_x", quantity="angular_rate", unit="rad/s", m=m, tau=m / rate,
        avar=values + avar("rate_ramp", ramp, m=m, tau0=1 / rate), n_pairs=n + 1 - 2 * m, ramp=np.full(len(m), ramp),
        n=n, tau0=1 / rate,
    )  # fmt: skip


def records(coefficients, case, count, *, n=2**13, rate=1.0):
    rng = np.random.default_rng(seed_of(case))
    model = NoiseModel(channels={"gyro_x": coefficients})
    for _ in range(count):
        yield simulate(model, duration=n / rate, rate=rate, rng=rng)


MIXTURES = [
    {"random_walk": 1e-4, "bias_instability": 5e-5, "rate_random_walk": 1.2e-5},
    {"quantization": 5e-6, "random_walk": 3e-5, "bias_instability": 2e-5, "rate_random_walk": 8e-6},
    {"quantization": 5e-6, "rate_random_walk": 1e-6},
    {"bias_instability": 1e-5},
]


class TestExactCurves:
    @pytest.mark.parametrize("coefficients", MIXTURES)
    @pytest.mark.parametrize("grid", ["octave", "half", "quarter", "eighth"])
    def test_coefficients_come_back(self, coefficients, grid):
        fitted = fit(exact(coefficients, grid=grid), terms=NOISE)
        assert fitted.verdict == "adequate"
        assert fitted.p_value > 0.999
        assert fitted.tau_min == 0.01
        for name, value in coefficients.items():
            term = fitted[name]
            assert term.observed
            assert term.value == pytest.approx(value, rel=1e-3)
            assert term.low < value < term.high

    def test_of_every_time_half_octaves_are_used(self):
        every, half = (fit(exact(MIXTURES[0], grid=grid)) for grid in ("all", "half"))
        assert every.to_dict() == half.to_dict()

    def test_absent_terms_have_limits(self):
        fitted = fit(exact({"random_walk": 1e-4}))
        for name in ("quantization", "bias_instability", "rate_random_walk"):
            term = fitted[name]
            assert not term.observed
            assert term.value is None
            assert term.upper_limit > 0
            assert term.p_value > 0.05
        assert fitted.observed == {"random_walk": pytest.approx(1e-4, rel=1e-3)}

    @pytest.mark.parametrize("ramp", [3e-8, -3e-8])
    def test_a_ramp_keeps_its_sign(self, ramp):
        fitted = fit(exact({"random_walk": 1e-4}, ramp=ramp))
        term = fitted["rate_ramp"]
        assert term.observed
        assert term.value == pytest.approx(ramp, rel=1e-6)
        assert term.low < ramp < term.high
        assert fitted["random_walk"].value == pytest.approx(1e-4, rel=0.01)
        assert fitted.model["rate_ramp"] == term.value

    def test_a_ramp_of_zero_is_as_likely_as_can_be(self):
        """Both signs count: p = 2·P(t > 0) = 1."""
        assert fit(exact({"random_walk": 1e-4}))["rate_ramp"].p_value == pytest.approx(1.0)

    def test_eight_times_are_enough_for_a_later_start(self):
        """Nine half octaves, of which the shortest is far too low: the eight others are fitted."""
        curve = exact({"random_walk": 1e-4}, n=80)
        assert len(curve.m[curve.m <= 80 // 3]) == 9
        fitted = fit(dataclasses.replace(curve, avar=np.where(curve.m == 1, 0.01, 1.0) * curve.avar))
        assert (fitted.verdict, fitted.tau_min) == ("adequate", 0.02)

    def test_scale_and_units(self):
        """c·y has c times the coefficients; another interval, other units of time."""
        base = fit(exact(MIXTURES[0]))
        for factor in (1e-9, 1e9):
            scaled = fit(exact({k: factor * v for k, v in MIXTURES[0].items()}))
            for name, term in base.items():
                for key in ("value", "low", "high", "upper_limit"):
                    a, b = getattr(term, key), getattr(scaled[name], key)
                    assert (a is None) == (b is None)
                    if a is not None:
                        assert b == pytest.approx(factor * a, rel=1e-3)

    def test_gauss_markov_process(self):
        rate, tc, sigma = 100.0, 2.0, 3e-4
        m = cluster_sizes("half", n=2**20, tau0=1 / rate)
        hump = kernels.gauss_markov_avar(sigma, tc, m, 1 / rate)
        fitted = fit(exact({"random_walk": 1e-4, "bias_instability": 2e-5}, n=2**20, extra=hump))
        assert fitted.verdict == "adequate"
        assert fitted.tau_min == 0.01
        (process,) = fitted.gauss_markov
        assert process.time.value == pytest.approx(tc, rel=0.01)
        assert process.sigma.value == pytest.approx(sigma, rel=0.01)
        assert process.time.low < tc < process.time.high
        assert process.sigma.low < sigma < process.sigma.high
        assert not fitted.sinusoid
        assert fitted["random_walk"].value == pytest.approx(1e-4, rel=0.01)

    def test_only_the_terms_that_may_be_there(self):
        fitted = fit(exact(MIXTURES[0]), terms=["random_walk", "bias_instability", "rate_random_walk"])
        assert set(fitted) == {"random_walk", "bias_instability", "rate_random_walk"}


class TestRecords:
    """Small Monte Carlo; the studies in docs/study are the large ones."""

    def test_intervals_cover_and_absent_terms_stay_absent(self):
        truth = {"random_walk": 1.0, "bias_instability": 0.2}
        covered, false, moved, sizes = [], [], 0, []
        count = 20
        for record in records(truth, "fit: N and B", count):
            fitted = fit(allan(record, threads=1)["gyro_x"])
            moved += fitted.tau_min is None or fitted.tau_min > 1
            if fitted.verdict != "adequate":
                continue
            sizes.append(fitted.p_value)
            for name, value in truth.items():
                t = fitted[name]
                covered.append(t.low <= value <= t.high if t.observed else value <= t.upper_limit)
            false += [fitted[name].observed for name in ("quantization", "rate_random_walk", "rate_ramp")]
        # Limits ± 3 standard errors of so many records.
        assert np.mean(covered) >= 0.94 - 3 * math.sqrt(0.05 * 0.95 / len(covered))
        assert np.mean(false) <= 0.065 + 3 * math.sqrt(0.065 * 0.935 / len(false))
        assert moved / count <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / count)
        assert np.mean(np.array(sizes) < 0.05) <= 0.05 + 3 * math.sqrt(0.05 * 0.95 / count)

    def test_the_valley_is_no_bias_instability(self):
        truth = {"random_walk": 1.0, "rate_random_walk": 0.02}
        found, walks = [], []
        for record in records(truth, "fit: N and K", 20):
            fitted = fit(allan(record, threads=1)["gyro_x"])
            if fitted.verdict == "adequate":
                found.append(fitted["bias_instability"].observed)
                walks.append(fitted["rate_random_walk"])
        assert np.mean(found) <= 0.065 + 3 * math.sqrt(0.065 * 0.935 / len(found))
        covered = [t.low <= 0.02 <= t.high if t.observed else t.upper_limit >= 0.02 for t in walks]
        assert np.mean(covered) >= 0.94 - 3 * math.sqrt(0.05 * 0.95 / len(covered))

    def test_spread_is_the_theorys(self):
        """White noise: that of a variance of N numbers, 1/√(2N), for 100 records to 3 standard errors."""
        n = 2**12
        values = [
            fit(allan(record, threads=1)["gyro_x"], terms=["random_walk"], tau_min=1.0)["random_walk"].value
            for record in records({"random_walk": 1.0}, "fit: N alone", 100, n=n)
        ]
        values = [v for v in values if v is not None]
        expected = 1 / math.sqrt(2 * n)
        assert np.std(values, ddof=1) == pytest.approx(expected, rel=3 / math.sqrt(2 * len(values)) + 0.02)
        assert abs(np.mean(values) - 1) <= 0.1 * expected + 3 * expected / math.sqrt(len(values))

    def test_a_low_pass_moves_the_shortest_time_and_not_the_random_walk(self):
        rng = np.random.default_rng(seed_of("fit: low-pass"))
        from scipy.signal import lfilter

        decay = math.exp(-2 * math.pi * 30 / 100)
        for _ in range(2):
            y = lfilter([1 - decay], [1, -decay], rng.standard_normal(2**17)) * 1e-3
            fitted = fit(allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"])
            assert fitted.verdict == "adequate"
            assert 0.02 < fitted.tau_min <= 1.28
            assert fitted.reasons[0].ratio < 1
            assert "low-pass" in fitted.reason
            assert fitted["random_walk"].value == pytest.approx(1e-4, rel=0.05)

    def test_a_gauss_markov_process_is_found_and_covered(self):
        """Searched for on a grid, its time free: 4 records, intervals of its size and time and of the random walk."""
        from scipy.signal import lfilter

        rng = np.random.default_rng(seed_of("fit: Gauss-Markov"))
        n, tau0, time, sigma, walk = 2**15, 0.01, 0.5, 1.0, 0.1
        decay = math.exp(-tau0 / time)
        found, covered, count = 0, [], 4
        for _ in range(count):
            driven = rng.standard_normal(n) * math.sqrt(1 - decay**2) * sigma
            driven[0] /= math.sqrt(1 - decay**2)
            y = lfilter([1], [1, -decay], driven) + rng.standard_normal(n) * walk / math.sqrt(tau0)
            fitted = fit(allan(Record.from_arrays(rate=1 / tau0, gyro_x=y))["gyro_x"])
            if not fitted.gauss_markov:
                continue
            found += 1
            process, noise = fitted.gauss_markov[0], fitted["random_walk"]
            covered.append(process.sigma.low <= sigma <= process.sigma.high)
            covered.append(process.time.low <= time <= process.time.high)
            covered.append(noise.low <= walk <= noise.high if noise.observed else walk <= noise.upper_limit)
        assert found >= count * (0.95 - 3 * math.sqrt(0.95 * 0.05 / count))
        # Three intervals a record, taken as one for the error.
        assert np.mean(covered) >= 0.95 - 3 * math.sqrt(0.05 * 0.95 / found)

    def test_results_do_not_depend_on_the_order_of_channels(self):
        y = np.random.default_rng(5).standard_normal((20_000, 2))
        both = allan(Record.from_arrays(rate=10, gyro_x=y[:, 0], gyro_y=y[:, 1]))
        alone = allan(Record.from_arrays(rate=10, gyro_y=y[:, 1]))
        assert repr(fit(both["gyro_y"])) == repr(fit(alone["gyro_y"]))


class TestWhatItSays:
    def test_printed(self):
        fitted = fit(
            exact({"random_walk": to_si(0.512, "deg/sqrt(h)"), "bias_instability": to_si(13.6, "deg/h")}, n=720_000)
        )
        lines = repr(fitted).splitlines()
        assert lines[0].startswith("gyro_x   generalised least squares, τ from 0.01 s to 1966 s, p = ")
        assert lines[2].split() == ["angle", "random", "walk", "0.5120", "[0.5105,", "0.5135]", "deg/√h"]
        assert lines[3].split()[:3] == ["bias", "instability", "13.60"]
        assert lines[4].startswith("  rate random walk    below ")
        assert lines[4].endswith("not seen in 2 h")
        assert "deg/h²: not seen in 2 h" in lines[5]
        shown = fitted._repr_html_()
        assert "<td style=text-align:left>0.5120</td><td style=text-align:left>[0.5105, 0.5135]</td>" in shown
        assert "generalised least squares" in shown

    def test_unknown_coefficient(self):
        with pytest.raises(KeyError, match="no coefficient 'arw'; fitted: quantization, random_walk, bias_instability"):
            fit(exact({"random_walk": 1e-4}))["arw"]

    def test_to_another_unit(self):
        fitted = fit(exact({"random_walk": to_si(0.5, "deg/sqrt(h)")}))
        assert fitted["random_walk"].to("deg/sqrt(h)") == pytest.approx(0.5, rel=1e-3)
        with pytest.raises(OptionError, match="does not fit"):
            fitted["random_walk"].to("deg/h")
        with pytest.raises(ValueError, match="not observed"):
            fitted["bias_instability"].to("deg/h")

    def test_too_short(self):
        fitted = fit(allan(Record.from_arrays(rate=1, gyro_x=np.random.default_rng(1).standard_normal(30)))["gyro_x"])
        assert fitted.verdict == "too_short"
        assert len(fitted) == 0
        assert fitted.reasons == (TooFewTimes(times=6, needed=8, samples=30),)
        assert fitted.reason in repr(fitted)
        assert fitted.to_dict()["terms"] == {"gauss_markov": [], "sinusoid": []}

    def test_no_adequate_model(self):
        """Two lines too slow to be left out: five terms and one more do not make them."""
        rng = np.random.default_rng(seed_of("fit: two lines"))
        t = np.arange(2**17) / 100
        y = rng.standard_normal(2**17) * 1e-3 + 1e-3 * np.sin(2 * np.pi * 0.05 * t) + 1e-3 * np.sin(2 * np.pi * 0.3 * t)
        fitted = fit(allan(Record.from_arrays(rate=100, gyro_x=y))["gyro_x"])
        assert fitted.verdict == "descriptive"
        assert isinstance(fitted.reasons[0], Misfit)
        assert fitted.reasons[0].p_value < 0.002
        assert all(t.low is None and t.high is None for t in fitted.values())
        assert fitted.observed == {}
        assert all(t.observed is None for t in fitted.values())
        assert fitted["random_walk"].value == pytest.approx(1e-4, rel=0.15)

    @pytest.mark.parametrize("y", [np.arange(1000.0), np.r_[np.zeros(999), 1.0], np.tile([1.0, -1.0], 500)])
    def test_what_is_no_noise_gets_no_interval_or_no_crash(self, y):
        fitted = fit(allan(Record.from_arrays(rate=1, gyro_x=y))["gyro_x"])
        assert fitted.verdict in {"adequate", "descriptive", "too_short"}
        repr(fitted)
        assert all(math.isfinite(v) for v in fitted.observed.values())

    def test_wrong_arguments(self):
        curve = exact({"random_walk": 1e-4})
        with pytest.raises(OptionError, match="overlapping"):
            fit(dataclasses.replace(curve, overlap="none"))
        with pytest.raises(OptionError, match="`level` must lie in"):
            fit(curve, level=1.0)
        with pytest.raises(OptionError, match="one of them a noise"):
            fit(curve, terms=["rate_ramp"])
        with pytest.raises(OptionError, match="`terms`: unknown term 'arw'"):
            fit(curve, terms=["arw"])
        with pytest.raises(OptionError, match=r"`tau_min` may be at most 61\.44 s"):
            fit(curve, tau_min=100.0)

    def test_paper_counting_is_a_record_shorter_by_one(self):
        y = np.random.default_rng(3).standard_normal(5000)
        paper = fit(allan(Record.from_arrays(rate=1, gyro_x=y), counting="paper", taus="octave")["gyro_x"], terms=NOISE)
        short = fit(allan(Record.from_arrays(rate=1, gyro_x=y[:-1]), taus="octave")["gyro_x"], terms=NOISE)
        assert paper["random_walk"].value == pytest.approx(short["random_walk"].value, rel=1e-9)

    def test_the_shortest_time_may_be_given(self):
        fitted = fit(exact(MIXTURES[0]), tau_min=0.1)
        assert fitted.tau_min == 0.12
        assert fitted.reasons == ()

    def test_level(self):
        curve = exact(MIXTURES[0])
        wide, narrow = fit(curve, level=0.99), fit(curve, level=0.68)
        for name in MIXTURES[0]:
            assert wide[name].low < narrow[name].low < narrow[name].high < wide[name].high
            assert wide[name].level == 0.99

    def test_every_term_has_its_unit(self):
        fitted = fit(exact(MIXTURES[0]))
        assert {name: t.unit for name, t in fitted.items()} == {
            "quantization": "rad",
            "random_walk": "rad/sqrt(s)",
            "bias_instability": "rad/s",
            "rate_random_walk": "rad/s/sqrt(s)",
            "rate_ramp": "rad/s^2",
        }
        assert set(fitted) == set(TERMS)

    def test_covariance_of_the_coefficients(self):
        fitted = fit(exact(MIXTURES[0]))
        names, matrix = fitted.covariance.names, fitted.covariance.matrix
        assert names == tuple(MIXTURES[0])
        assert np.allclose(matrix, matrix.T)
        assert np.all(np.linalg.eigvalsh(matrix / np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))) > 0)
        half = [(fitted[n].high - fitted[n].low) / 2 for n in names]
        # The interval allows for the terms that were not found, the covariance does not.
        assert np.all(1.96 * np.sqrt(np.diag(matrix)) < 1.3 * np.array(half))

    def test_degrees_of_freedom_of_the_curve(self):
        from sigmatau.noise.uncertainty import degrees_of_freedom

        fitted = fit(exact(MIXTURES[0]))
        m = np.array([1, 10, 100, 1000])
        expected = degrees_of_freedom(fitted.model, n=fitted.n, m=m, tau0=fitted.tau0)
        assert fitted.degrees_of_freedom(m=m) == pytest.approx(expected, rel=1e-9)
        dense = np.arange(1, 5000)
        thinned = fitted.degrees_of_freedom(m=dense)
        # Interpolated between 100 sizes.
        assert thinned[m - 1] == pytest.approx(expected, rel=0.02)


def _odd(kind, n, rng):
    """Records that no one should trust: coarse, integrated, bursts, lines, steps, held samples."""
    w, t = rng.standard_normal(n), np.arange(n)
    return {
        "coarse": np.round(0.3 * w),
        "walk": np.cumsum(w),
        "twice integrated": np.cumsum(np.cumsum(w)),
        "ramp": t + 1e-9 * w,
        "parabola": t**2 + 1e-9 * w,
        "line": np.sin(0.7 * t),
        "half silent": np.r_[np.zeros(n // 2), w[: n - n // 2]],
        "dying away": w * np.exp(-t * 20 / n),
        "held": np.repeat(w, 7)[:n],
        "one sample": np.where(t == n // 3, 1.0, 0.0),
    }[kind]


ODD = (
    "coarse",
    "walk",
    "twice integrated",
    "ramp",
    "parabola",
    "line",
    "half silent",
    "dying away",
    "held",
    "one sample",
)


@pytest.mark.parametrize("kind", ODD)
def test_no_record_crashes_a_fit(kind):
    """Any length, any grid, any scale; warnings are errors in these tests."""
    rng = np.random.default_rng(seed_of(f"odd records: {kind}"))
    # Octaves of a short record are too few for a fit.
    grids = {
        4: ["half"],
        20: ["half"],
        48: ["half"],
        49: ["octave"],
        100: ["eighth"],
        333: [None],
        2000: ["half"],
    }
    for n, chosen in grids.items():
        y = _odd(kind, n, rng) * 10.0 ** rng.integers(-30, 30)
        some = sorted(set(rng.integers(1, n // 2 + 1, size=30).tolist()))
        for grid in (some if one is None else one for one in chosen):
            curve = allan(Record.from_arrays(rate=1, gyro_x=y), taus=grid)["gyro_x"]
            fitted = fit(curve)
            assert fitted.verdict in {"adequate", "descriptive", "too_short"}
            json.dumps(fitted.to_dict(), allow_nan=False)
            assert repr(fitted)
            for term in fitted.values():
                if term.low is not None:
                    assert term.low <= term.value <= term.high
