"""How long to record: the paper's own case, simulation, and what cannot be planned."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.fft import dct

from known import seed_of
from sigmatau import NoiseModel, allan, simulate
from sigmatau._native.gls import Components, Gls
from sigmatau.cli import main
from sigmatau.errors import OptionError
from sigmatau.fitting.alternatives import Modes
from sigmatau.fitting.components import LONGEST_SHARE, half_octaves
from sigmatau.fitting.planning import needed_samples, plan, relative_error, smallest_detectable, smallest_significant
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid
from sigmatau.noise.terms import NOISE
from sigmatau.units import to_si

CIMU = {"quantization": to_si(0.973, "arcsec"), "random_walk": to_si(0.0015, "deg/sqrt(h)")}
IN_RUN_BIAS = to_si(0.0022, "deg/h")  # the manufacturer's, Section III-A of the paper


def test_relative_error_is_half_that_of_the_square():
    """Of generalised least squares with all four terms free, whose coefficients are roots of what is fitted."""
    n, theta = 10_000, np.array([0.0, 1.0, 0.09, 0.0])
    parts = Components(n, half_octaves(1, n // LONGEST_SHARE))
    information = parts.design.T @ np.linalg.solve(parts.covariance(theta), parts.design)
    expected = math.sqrt(np.linalg.inv(information)[2, 2]) / (2 * theta[2])
    found = relative_error({"random_walk": 1.0}, "bias_instability", 0.3, n=n, tau0=1.0)
    assert found == pytest.approx(expected, rel=1e-4)


class TestThePapersHundredHours:
    """Section IV: 2 h are not enough for the CIMU's bias instability, which takes about 100 h."""

    def test_two_hours_do_not_show_it(self):
        assert smallest_detectable(CIMU, "bias_instability", n=2 * 3600 * 200, tau0=0.005) > 2 * IN_RUN_BIAS

    def test_a_hundred_hours_show_and_determine_it(self):
        n = 100 * 3600 * 200
        assert smallest_detectable(CIMU, "bias_instability", n=n, tau0=0.005) < IN_RUN_BIAS
        assert relative_error(CIMU, "bias_instability", IN_RUN_BIAS, n=n, tau0=0.005) < 0.2

    def test_how_long_it_takes(self):
        hours = needed_samples(CIMU, "bias_instability", IN_RUN_BIAS, tau0=0.1) / 36_000
        assert 80 < hours < 120


@pytest.mark.parametrize(
    ("term", "others"),
    [
        ("bias_instability", {"random_walk": 1.0}),
        ("rate_random_walk", {"random_walk": 1.0, "bias_instability": 0.1}),
        ("random_walk", {"quantization": 10.0}),
    ],
)
def test_half_of_the_records_show_it(term, others):
    """By the test of a fit alone; studies/coverage.py has a thousand whole fits of each of more cases."""
    n, count = 2**12, 50
    value = smallest_significant(others, term, n=n, tau0=1.0)
    model = NoiseModel(channels={"gyro_x": {**others, term: value}})
    share = found_share(model, term, f"plan {term}", n=n, count=count)
    # 50 % to 3 standard errors, and to what the law's third moment leaves open.
    assert share == pytest.approx(0.5, abs=3 * math.sqrt(0.25 / count) + 0.05)


def found_share(model, term, case, *, n, count, level=0.95, correlation_time=None):
    """Share of simulated records in which the test of a term is significant, all others free."""
    rng = np.random.default_rng(seed_of(case))
    sizes = half_octaves(1, n // LONGEST_SHARE)
    parts = Components(n, sizes, correlation_time=correlation_time)
    found = 0
    for _ in range(count):
        curve = allan(simulate(model, duration=n, rate=1.0, rng=rng), taus=sizes, threads=1)["gyro_x"]
        assert curve.m.tolist() == list(sizes)
        found += Gls(parts, curve.avar / curve.avar[0]).score(NOISE.index(term), 0.0)[0] < 1 - level
    return found / count


def test_laws():
    others = {"random_walk": 1e-4, "bias_instability": 1e-6}
    at = {n: smallest_detectable(others, "rate_random_walk", n=n, tau0=0.01) for n in (10_000, 100_000, 1_000_000)}
    assert at[10_000] > at[100_000] > at[1_000_000]
    tenfold = smallest_detectable({k: 10 * v for k, v in others.items()}, "rate_random_walk", n=100_000, tau0=0.01)
    assert tenfold == pytest.approx(10 * at[100_000], rel=1e-2)
    # The term's own value does not count.
    assert (
        smallest_detectable({**others, "rate_random_walk": 1.0}, "rate_random_walk", n=100_000, tau0=0.01)
        == at[100_000]
    )
    n = needed_samples(others, "rate_random_walk", at[100_000], tau0=0.01)
    assert n == pytest.approx(100_000, rel=0.15)


def test_cosine_modes_of_a_ramp():
    """The squares of a ramp are those of its cosine transform; even modes contain none of it."""
    n, tau0 = 64, 0.5
    modes = Modes(n, tau0, 0.0)
    single = modes.count == 1
    transform = dct((np.arange(n) + 0.5) * tau0, norm="ortho") ** 2 * tau0
    expected = transform[modes.number[single].astype(int)]
    assert modes.ramp()[single] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_a_filter_hides_what_shows_at_short_times():
    others = {"random_walk": 1e-4}
    free, filtered = (smallest_detectable(others, "quantization", n=100_000, tau0=0.01, tau_min=t) for t in (0.0, 0.32))
    assert filtered > 10 * free
    n = needed_samples(others, "quantization", filtered, tau0=0.01, tau_min=0.32)
    assert n == pytest.approx(100_000, rel=0.15)


def test_ramp():
    """Beside white noise alone: 18 standard errors N√(12/T³), because a weak rate random walk explains less."""
    n, tau0 = 2**16, 0.01
    least = smallest_detectable({"random_walk": 1e-4}, "rate_ramp", n=n, tau0=tau0)
    sigma = 1e-4 * math.sqrt(12 / (n * tau0) ** 3)
    assert 15 < least / sigma < 22


def test_printed():
    text = repr(
        plan(
            CIMU,
            "bias_instability",
            channel="gyro_x",
            quantity="angular_rate",
            rate_unit="rad/s",
            rate=10,
            duration=360_000,
            value=IN_RUN_BIAS,
        )
    )
    assert max(map(len, text.splitlines())) <= 80
    text = " ".join(text.split())
    assert text.startswith(
        "gyro_x: bias instability beside quantization 0.973 arcsec, angle random walk 0.0015 deg/√h; 10 Hz"
    )
    assert "a record of 100 h shows 0.0021 deg/h (50 % probability)" in text
    assert "0.0022 deg/h needs a record of " in text
    assert "a record of 100 h determines a bias instability of 0.0022 deg/h to ± " in text


def test_what_a_record_does_not_determine_is_named():
    text = repr(
        plan(
            {"random_walk": 1e-4, "bias_instability": 3e-5},
            "rate_random_walk",
            channel="gyro_x",
            quantity="angular_rate",
            rate_unit="rad/s",
            rate=1,
            duration=7200,
            value=1e-7,
        )
    )
    value = f"{math.degrees(1e-7) * 60**3:.4g}"
    assert " ".join(text.split()).endswith(
        f" a record of 2 h does not determine a rate random walk of {value} deg/h/√h: its standard error exceeds 50 %"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"others": {}}, "there is no noise besides"),
        ({"others": {"bias_instability": 1.0}}, "there is no noise besides"),
        ({"term": "arw"}, "unknown term 'arw'"),
        ({"others": {"arw": 1.0}}, "unknown term 'arw'"),
        ({"n": 20}, "too short"),
        ({"n": 10**15}, "too long"),
        ({"tau0": 0.0}, "`tau0`"),
    ],
)
def test_what_cannot_be_planned(arguments, message):
    complete = {"others": {"random_walk": 1.0}, "term": "bias_instability", "n": 10_000, "tau0": 1.0, **arguments}
    others, term = complete.pop("others"), complete.pop("term")
    with pytest.raises(OptionError, match=message):
        smallest_detectable(others, term, **complete)


class TestGaussMarkov:
    """A process beside the term makes as much of the curve as the term does: it counts."""

    model = ChannelModel(terms={"random_walk": 1.0}, gauss_markov=(GaussMarkov(sigma=0.2, time=20.0),))

    @pytest.mark.parametrize("term", ["bias_instability", "rate_random_walk"])
    def test_half_of_the_records_show_it(self, term):
        n, count = 2**12, 80
        value = smallest_significant(self.model, term, n=n, tau0=1.0)
        assert value > 1.2 * smallest_significant(self.model.terms, term, n=n, tau0=1.0)
        made = NoiseModel(channels={"gyro_x": replace(self.model, terms={"random_walk": 1.0, term: value})})
        share = found_share(made, term, f"plan beside Gauss-Markov {term}", n=n, count=count, correlation_time=20.0)
        # As above: 3 standard errors, and what the law's third moment leaves open.
        assert share == pytest.approx(0.5, abs=3 * math.sqrt(0.25 / count) + 0.05)

    def test_a_process_hardly_there_costs_little(self):
        # A fifth at most, because its variance is free in the fit; a slow one has the shape of a rate random walk, free too.
        weak = replace(self.model, gauss_markov=(GaussMarkov(sigma=1e-9, time=1e7),))
        for term in ("quantization", "bias_instability"):
            alone = smallest_significant({"random_walk": 1.0}, term, n=10_000, tau0=1.0)
            assert alone <= 1.001 * smallest_significant(weak, term, n=10_000, tau0=1.0) <= 1.2 * alone
        alone = relative_error({"random_walk": 1.0}, "bias_instability", 0.3, n=10_000, tau0=1.0)
        assert alone <= 1.001 * relative_error(weak, "bias_instability", 0.3, n=10_000, tau0=1.0) <= 1.2 * alone

    def test_seconds_are_not_samples(self):
        fast = replace(self.model, terms={"random_walk": 0.1}, gauss_markov=(GaussMarkov(sigma=0.2, time=0.2),))
        # A hundredth of the time: rates are the same, N goes with the root of the time, K with its inverse.
        expected = smallest_detectable(self.model, "rate_random_walk", n=10_000, tau0=1.0) * 10
        assert smallest_detectable(fast, "rate_random_walk", n=10_000, tau0=0.01) == pytest.approx(expected, rel=1e-6)

    @pytest.mark.parametrize(
        ("more", "word"),
        [
            ({"sinusoid": (Sinusoid(amplitude=1.0, frequency=0.1),)}, "a sinusoid"),
            ({"bandwidth": LowPass(order=2, corner=0.1)}, "a bandwidth"),
            ({"gauss_markov": 2 * (GaussMarkov(sigma=1.0, time=2.0),)}, "several Gauss-Markov"),
        ],
    )
    def test_what_is_not_counted_is_refused(self, more, word):
        with pytest.raises(OptionError, match=word):
            smallest_detectable(replace(self.model, **more), "bias_instability", n=10_000, tau0=1.0)

    def test_the_command_counts_it_and_names_what_it_does_not(self, tmp_path, capsys):
        path = tmp_path / "m.toml"
        NoiseModel(channels={"gyro_x": replace(self.model, sinusoid=(Sinusoid(amplitude=1.0, frequency=0.1),))}).write(
            path
        )
        argv = ["plan", str(path), "--term", "rate_random_walk", "--rate", "1", "--hours", "3"]
        assert main([*argv, "--json"]) == 0
        out, err = capsys.readouterr()
        assert "gyro_x: the plan ignores its sinusoid" in err
        (found,) = json.loads(out)
        assert found["gauss_markov"] == [{"sigma": 0.2, "time_s": 20.0}]
        assert found["found_in_half"] == pytest.approx(
            smallest_detectable(self.model, "rate_random_walk", n=10_800, tau0=1.0)
        )
        assert main(argv) == 0
        assert "Gauss-Markov 4.125e+04 deg/h over 20 s" in " ".join(capsys.readouterr().out.split())


def test_the_bias_of_an_accelerometer_is_in_the_unit_of_the_table_of_analyze():
    kind = {"channel": "accel_x", "quantity": "acceleration", "rate_unit": "m/s^2"}
    made = plan({"random_walk": 1e-3}, "bias_instability", rate=10, value=40 * 9.80665e-6, **kind)
    assert "40 µg needs a record of" in repr(made)
    model = ChannelModel(terms={"bias_instability": made.value}, quantity="acceleration", unit="m/s^2")
    assert "bias instability 40 µg" in repr(model)


class TestCommand:
    @pytest.fixture
    def model(self, tmp_path):
        path = tmp_path / "imu.toml"
        path.write_text(
            '[channels.gyro_x]\nrandom_walk = "0.3 deg/sqrt(h)"\nbias_instability = "10 deg/h"\n'
            '[channels.accel_x]\nbias_instability = "10 ug"\n'
        )
        return path

    def run(self, *argv, capsys):
        code = main(["plan", *(str(a) for a in argv)])
        return code, *capsys.readouterr()

    def test_a_model(self, model, capsys):
        code, out, err = self.run(model, "--term", "bias_instability", "--rate", 100, "--hours", 2, capsys=capsys)
        assert (code, err) == (0, "")
        assert "gyro_x: bias instability beside angle random walk 0.3 deg/√h; 100 Hz" in out
        assert "a record of 2 h shows" in out
        assert "10 deg/h needs a record of" in out
        assert "accel" not in out  # nothing beside its bias instability

    def test_a_result(self, model, tmp_path, capsys):
        log, result = tmp_path / "log.csv", tmp_path / "r.json"
        assert main(["simulate", str(model), "--hours", "0.1", "--rate", "50", "-o", str(log), "-q"]) == 0
        assert main(["analyze", str(log), "--json", str(result), "-q"]) == 0
        capsys.readouterr()
        code, out, _ = self.run(
            result,
            "--term",
            "rate_random_walk",
            "--channels",
            "gyro_x",
            "--value",
            "20 deg/h/sqrt(h)",
            "--json",
            capsys=capsys,
        )
        assert code == 0
        (found,) = json.loads(out)
        assert found["channel"] == "gyro_x"
        assert found["record_s"] == pytest.approx(360)
        assert found["value"] == pytest.approx(to_si(20, "deg/h/sqrt(h)"))
        assert found["half_find_it_in_s"] < found["nine_of_ten_find_it_in_s"]

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--term", "arw", "--rate", "1"], "--term: unknown term 'arw'; it is random_walk"),
            (["--term", "bias_instability"], "--rate"),
            (["--term", "rate_ramp", "--rate", "1"], "--hours or --value"),
            (["--term", "rate_ramp", "--rate", "1", "--value", "3"], "--value '3'"),
            (["--term", "rate_ramp", "--rate", "1", "--value", "3 deg/h"], "deg/h"),
            (["--term", "rate_ramp", "--rate", "1", "--hours", "-2"], "--hours"),
            (["--term", "rate_ramp", "--rate", "1", "--hours", "2", "--channels", "gyro_q"], "gyro_q"),
            (["--term", "bias_instability", "--rate", "1", "--hours", "2", "--channels", "accel_x"], "accel_x"),
        ],
    )
    def test_wrong_options(self, model, options, message, capsys):
        code, out, err = self.run(model, *options, capsys=capsys)
        assert (code, out) == (2, "")
        assert message in err
        assert err.count("\n") == 1

    @pytest.mark.parametrize("text", ["", "{}", '{"channels": {"gyro_x": {}}}', "[1]", '{"channels": 3}'])
    def test_no_result(self, tmp_path, text, capsys):
        path = tmp_path / "r.json"
        path.write_text(text)
        code, out, err = self.run(path, "--term", "bias_instability", "--hours", 1, capsys=capsys)
        assert (code, out) == (1, "")
        assert err.count("\n") == 1
        assert "r.json" in err
