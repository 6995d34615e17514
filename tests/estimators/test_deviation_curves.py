"""Deviations beside Allan: degrees of freedom, arguments, what a curve prints and holds, the command line."""

import json
import math

import numpy as np
import pytest

import known
from sigmatau import NoiseModel, Record, deviation, simulate
from sigmatau._native import kernels
from sigmatau.cli import main
from sigmatau.digits import round_to_error
from sigmatau.errors import NonFiniteError, OptionError, RecordTooShortError
from sigmatau.estimators.deviation_kinds import KINDS, bias, degrees_of_freedom
from sigmatau.noise.uncertainty import chi2_factors
from sigmatau.units import to_si

TERMS = ("quantization", "random_walk", "bias_instability", "rate_random_walk")


def record(y, rate=1.0):
    return Record.from_arrays(rate=rate, y=y)


class TestFreedom:
    def test_greenhall_and_riley(self):
        """Their interpolation is good to half a per cent for large m and several at small m; here are exact sums."""
        import allantools

        for kind, options in (("modified", {"d": 2, "modified": True}), ("hadamard", {"d": 3, "modified": False})):
            for alpha, term in (
                (2, "quantization"),
                (0, "random_walk"),
                (-1, "bias_instability"),
                (-2, "rate_random_walk"),
            ):
                expected = allantools.edf_greenhall(alpha=alpha, m=100, N=10_001, overlapping=True, **options)
                got = degrees_of_freedom(kind, term, n=10_000, m=np.array([100]), tau0=1.0)[0]
                assert got == pytest.approx(expected, rel=0.01), (kind, term)

    def test_total_as_published(self):
        """b·T/τ − c, NIST SP 1065, table 7; in place of 1.5 T/τ there are 2/3 T/τ at one sample of white noise."""
        n, m = 100_000, np.array([1000, 10_000, 40_000])
        for term, b, c in (
            ("random_walk", 1.5, 0),
            ("bias_instability", 1.16832, 0.222),
            ("rate_random_walk", 0.92707, 0.358),
        ):
            got = degrees_of_freedom("total", term, n=n, m=m, tau0=0.01)
            assert got == pytest.approx(b * n / m - c, rel=0.01)
        assert degrees_of_freedom("total", "random_walk", n=n, m=np.array([1]), tau0=1.0) == pytest.approx(
            2 / 3 * n, rel=1e-3
        )

    @pytest.mark.parametrize(("kind", "overlap"), [
        ("modified", None), ("hadamard", "full"), ("hadamard", "none"), ("time", None), ("total", None), ("theo1", None),
        ("parabolic", None), ("modified_total", None), ("hadamard_total", None),
    ])  # fmt: skip
    @pytest.mark.parametrize("term", TERMS)
    def test_scatter_of_simulated_records(self, kind, overlap, term):
        """Mean and variance of 500 records, within 4.5 standard errors."""
        n, count, tau0 = 600, 500, 0.04
        m = np.array(
            [1, 7, 48, 200] if kind not in ("theo1", "total") else [10, 48] if term == "quantization" else [10, 48, 200]
        )
        if (kind, term) == ("hadamard_total", "quantization"):
            m = m[:-1]
        # As channels of one record, which is made at once.
        model = NoiseModel(channels={f"gyro_{k}": {term: 2e-3} for k in range(count)})
        seed = known.seed_of(f"scatter {kind} {overlap} {term}")
        options = {} if overlap is None else {"overlap": overlap}
        taus = m * tau0 * KINDS[kind].tau_per_m
        record = simulate(model, duration=n * tau0, rate=1 / tau0, rng=seed)
        curves = list(deviation(record, kind=kind, taus=taus, threads=1, **options).values())
        squares = np.array([curve.deviation**2 for curve in curves])
        edf = curves[0].edf(noise={term: 2e-3})
        got = 2 * squares.mean(axis=0) ** 2 / squares.var(axis=0, ddof=1)
        # Of a χ² with edf degrees of freedom: kurtosis 12/edf; the mean's own error is small beside it.
        error = np.sqrt((2 + 12 / edf) / count + 4 * 2 / edf / count)
        assert (np.abs(got / edf - 1) <= 4.5 * error).all(), got / edf
        if kind in ("total", "theo1") and (kind, term) != ("total", "quantization"):
            size = m if kind == "total" else np.rint(0.75 * m).astype(int)
            truth = model.avar("gyro_0", m=size, tau0=tau0) * curves[0].bias(noise=term)
            # 0.75 m is no whole number for m = 10: 7.5 is taken as 8, which is at most 14 % off in the square.
            slack = 0.14 if kind == "theo1" else 0.003
            assert (np.abs(squares.mean(axis=0) / truth - 1) <= 4.5 * np.sqrt(2 / edf / count) + slack).all()
        if kind in ("modified_total", "hadamard_total"):
            truth, _ = kernels.stationary_moments(
                kind.removesuffix("_total"), overlap="full", n=n, m=m, coefficients={term: 2e-3}, tau0=tau0
            )
            mean = squares.mean(axis=0) / (truth * curves[0].bias(noise=term))
            assert (np.abs(mean - 1) <= 4.5 * np.sqrt(2 / edf / count)).all(), mean

    @pytest.mark.parametrize("term", TERMS[1:])
    @pytest.mark.parametrize("kind", ["parabolic", "modified_total", "hadamard_total"])
    def test_coverage(self, kind, term):
        """95 % intervals, for the expectation."""
        n, count, tau0 = 360, 1000, 0.1
        m = np.array([4, 36, 100])
        model = NoiseModel(channels={f"gyro_{k}": {term: 2e-3} for k in range(count)})
        record = simulate(model, duration=n * tau0, rate=1 / tau0, rng=known.seed_of(f"coverage {kind} {term}"))
        curves = list(deviation(record, kind=kind, taus=m * tau0, threads=1).values())
        low, high = chi2_factors(curves[0].edf(noise=term), level=0.95)
        deviations = np.array([curve.deviation for curve in curves])
        truth = np.sqrt(np.mean(deviations**2, axis=0))
        covered = np.mean((deviations * low <= truth) & (truth <= deviations * high), axis=0)
        assert (covered >= 0.95 - 3 * np.sqrt(0.95 * 0.05 / count)).all(), covered
        assert (covered <= 0.985).all(), covered

    @pytest.mark.parametrize("term", TERMS[1:])
    def test_bias_of_theobr(self, term):
        """It estimates the Allan variance: 600 records, to 15 %, where Theo1 is wrong by a factor up to 2.7."""
        n, count, m = 360, 600, np.array([40, 120, 240])
        model = NoiseModel(channels={f"gyro_{k}": {term: 2e-3} for k in range(count)})
        record = simulate(model, duration=n, rate=1, rng=known.seed_of(f"theobr {term}"))
        for kind, sizes in (("theobr", m), ("theoh", m[1:])):
            curves = deviation(record, kind=kind, taus=0.75 * sizes, threads=1).values()
            mean = np.mean([curve.deviation**2 for curve in curves], axis=0)
            truth = model.avar("gyro_0", m=(0.75 * sizes).astype(int), tau0=1)
            assert mean / truth == pytest.approx(1, abs=0.15), (kind, mean / truth)

    def test_bias(self):
        """1 − aτ/T of NIST SP 1065, section 5.2.11; Theo1 of table 11 there is up to 4 % off at m = 10."""
        assert bias("total", "bias_instability", n=1000, m=np.array([250]), tau0=1.0)[0] == pytest.approx(1 - 0.481 / 4)
        assert bias("theo1", "random_walk", n=1000, m=np.array([10, 64, 500]), tau0=1.0) == pytest.approx(1, rel=1e-12)
        got = 1 / bias("theo1", "rate_random_walk", n=1000, m=np.array([128, 512]), tau0=1.0)
        assert got == pytest.approx([2.6749, 2.6937], rel=1e-4)

    @pytest.mark.parametrize(
        ("kind", "noise", "words"),
        [
            ("mtie", "random_walk", "the distribution of the MTIE"),
            ("tie_rms", "random_walk", "the distribution of the TIE rms"),
            ("theobr", "random_walk", "the distribution of the TheoBR"),
            ("theoh", "random_walk", "the distribution of the TheoH"),
            ("modified", "arw", "unknown term 'arw'"),
            ("modified", 3, "name of a term"),
            ("modified", {"random_walk": math.nan}, "finite"),
            ("hadamard", {"rate_ramp": 1.0}, "has no noise"),
            ("total", {"random_walk": 1.0, "rate_ramp": 1.0}, "leave `rate_ramp` out"),
            ("total", "quantization", "leave it out"),
        ],
    )
    def test_what_has_none(self, kind, noise, words):
        curve = deviation(record(np.random.default_rng(1).standard_normal(1000)), kind=kind)["y"]
        with pytest.raises(OptionError, match=words):
            curve.interval(noise=noise)

    def test_bias_of_others(self):
        curve = deviation(record(np.arange(30.0) ** 2), kind="hadamard")["y"]
        with pytest.raises(OptionError, match="have a bias"):
            curve.bias(noise="random_walk")
        with pytest.raises(OptionError, match="for one of"):
            deviation(record(np.arange(30.0) ** 2), kind="total")["y"].bias(noise="quantization")


class TestArguments:
    @pytest.mark.parametrize(
        ("kind", "words"),
        [
            *((kind, "unknown; kinds: modified, hadamard, parabolic") for kind in ("nonesuch", None, 3)),
            ("adev", r"the Allan deviation is sigmatau\.allan"),
            ("hdev", "write hadamard"),
        ],
    )
    def test_unknown_kind(self, kind, words):
        with pytest.raises(OptionError, match=words):
            deviation(record(np.zeros(100)), kind=kind)

    @pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "hadamard"])
    def test_overlap_is_of_hadamard(self, kind):
        with pytest.raises(OptionError, match="omit it"):
            deviation(record(np.zeros(100)), kind=kind, overlap="full")

    @pytest.mark.parametrize(
        ("kind", "tau", "words"),
        [
            ("modified", 35, "out of reach of the modified Allan deviation: 100 samples at 1 Hz give 1 s to 33 s"),
            ("hadamard", 34, "1 s to 33 s"),
            ("total", 100, "1 s to 99 s"),
            ("theo1", 3, "7.5 s to 75 s"),
            ("mtie", 101, "1 s to 100 s"),
            ("mtie", 0.2, "out of reach"),
            ("mtie", -1, "positive"),
            ("mtie", [], "list"),
            ("mtie", "thirds", "unknown grid"),
        ],
    )
    def test_times(self, kind, tau, words):
        with pytest.raises(OptionError, match=words):
            deviation(record(np.zeros(100)), kind=kind, taus=tau)

    @pytest.mark.parametrize("option", [{"overlap": "half"}, {"threads": 0}, {"threads": 10**30}])
    def test_options(self, option):
        with pytest.raises(OptionError, match=next(iter(option))):
            deviation(record(np.zeros(10)), kind="hadamard", **option)

    def test_too_short(self):
        with pytest.raises(RecordTooShortError, match="at least 10 are needed") as e:
            deviation(record(np.arange(9.0)), kind="theo1")
        assert (e.value.need, e.value.got) == (10, 9)

    def test_missing_and_infinite(self):
        y = np.arange(100.0)
        y[17] = math.nan
        with pytest.raises(NonFiniteError, match="longest_run"):
            deviation(Record.from_arrays(rate=1, gyro_x=y), kind="mtie")
        y[17] = 1e200
        with pytest.raises(NonFiniteError, match="`gyro_x` is 1e\\+200"):
            deviation(Record.from_arrays(rate=1, gyro_x=y), kind="mtie")

    def test_no_record(self):
        with pytest.raises(TypeError, match="must be a Record"):
            deviation(np.zeros(100), kind="mtie")


class TestResult:
    def test_prints_itself(self):
        curve = deviation(record([1.0, 3.0, 2.0, 5.0, 4.0]), kind="hadamard", overlap="none")["y"]
        assert repr(curve).splitlines() == [
            "y: non-overlapped Hadamard deviation, 5 samples at 1 Hz [1]",
            "             1 s  1.50923      3 terms",
        ]

    def test_to_dict(self):
        curves = deviation(record(np.random.default_rng(1).standard_normal(100)), kind="hadamard", taus="octave")
        plain = json.loads(json.dumps(curves.to_dict(noise="random_walk"), allow_nan=False))["y"]
        assert list(plain) == [
            "kind", "m", "tau_s", "deviation", "n_terms", "overlap", "unit", "low", "high", "edf",
        ]  # fmt: skip
        assert all(a < b < c for a, b, c in zip(plain["low"], plain["deviation"], plain["high"], strict=True))
        assert "low" not in curves.to_dict()["y"]

    def test_plot(self):
        pytest.importorskip("matplotlib")
        y = np.random.default_rng(1).standard_normal((300, 3))
        curves = deviation(Record.from_arrays(rate=10, gyro=y, accel=y), kind="time")
        assert (
            curves["gyro_x"].plot(unit="arcsec", noise="random_walk").axes[0].get_ylabel() == "time deviation [arcsec]"
        )
        assert curves["gyro_x"].plot().axes[0].get_ylabel() == "time deviation [rad]"
        assert len(curves.plot(noise="random_walk").axes) == 2
        assert deviation(Record.from_arrays(rate=10, gyro=y), kind="mtie").plot().axes[0].get_title() == "Gyroscopes"

    @pytest.mark.parametrize("n", [10, 11, 100, 1000])
    @pytest.mark.parametrize("grid", ["octave", "half", "quarter", "eighth"])
    def test_grids(self, n, grid):
        for kind in KINDS if n >= 89 else KINDS.keys() - {"theobr", "theoh"}:
            curve = deviation(record(np.random.default_rng(n).standard_normal(n)), kind=kind, taus=grid)["y"]
            assert curve.n_terms.min() >= 1
            assert (np.diff(curve.tau) > 0).all()
            assert kind != "theo1" or (curve.m % 2 == 0).all()


class TestCommandLine:
    @pytest.fixture
    def log(self, tmp_path):
        path = tmp_path / "log.csv"
        y = np.random.default_rng(known.seed_of("command line")).standard_normal((300, 2))
        np.savetxt(path, y, delimiter=",", header="gyro_x [deg/s],accel_z [g]", comments="")
        return str(path)

    def test_table(self, log, capsys):
        assert main(["deviation", log, "--rate", "100", "--kind", "tie_rms", "--taus", "0.1,1"]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[0] == "gyro_x: TIE rms [rad], 300 samples at 100 Hz"
        assert lines[1].split()[:2] == ["0.1", "s"]
        assert lines[1].endswith("291 terms")
        assert lines[3] == "accel_z: TIE rms [m/s], 300 samples at 100 Hz"

    def test_the_units_of_the_other_screens(self, log, capsys):
        """deg/h and µg, as the figure; the JSON is in SI."""
        arguments = ["deviation", log, "--rate", "100", "--kind", "modified", "--noise", "random_walk", "--taus", "0.1"]
        assert main(arguments) == 0
        lines = capsys.readouterr().out.splitlines()
        assert [line.partition(",")[0] for line in lines[:4:2]] == [
            *("gyro_x: modified Allan deviation [deg/h]", "accel_z: modified Allan deviation [µg]")
        ]
        assert main([*arguments, "--json", "-"]) == 0
        channels = json.loads(capsys.readouterr().out)["channels"]
        for name, line, unit in (("gyro_x", lines[1], "deg/h"), ("accel_z", lines[3], "ug")):
            value, low, high = (channels[name][key][0] / to_si(1.0, unit) for key in ("deviation", "low", "high"))
            assert line.split()[2:5] == " ".join(round_to_error(value, low, high).cells).split()

    def test_intervals_json_and_figure(self, log, tmp_path, capsys):
        import json

        figure = tmp_path / "figure.svg"
        arguments = ["deviation", log, "--rate", "100", "--kind", "hadamard", "--overlap", "none"]
        assert main([*arguments, "--noise", "random_walk", "--json", "-", "--plot", str(figure)]) == 0
        result = json.loads(capsys.readouterr().out)
        curve = result["channels"]["accel_z"]
        assert (curve["unit"], curve["overlap"], result["noise"]) == ("m/s^2", "none", "random_walk")
        assert all(a < b for a, b in zip(curve["low"], curve["high"], strict=True))
        assert figure.stat().st_size > 5000
        written = tmp_path / "result.json"
        assert main([*arguments, "--noise", "random_walk", "--json", str(written)]) == 0
        assert json.loads(written.read_text()) == result
        assert "[ ]: 95 %" in capsys.readouterr().out

    def test_identified_noise(self, log, tmp_path, capsys):
        """White noise: the interval of a random walk where it is identified, and the types in the JSON."""
        arguments = ["deviation", log, "--rate", "100", "--kind", "hadamard", "--taus", "octave"]
        figure = tmp_path / "figure.svg"
        assert main([*arguments, "--json", "-", "--noise", "identified", "--plot", str(figure)]) == 0
        result = json.loads(capsys.readouterr().out)
        assert main([*arguments, "--json", "-", "--noise", "random_walk"]) == 0
        expected = json.loads(capsys.readouterr().out)["channels"]["gyro_x"]
        assert result["identified"]["gyro_x"]["terms"][0] == "random_walk"
        assert result["channels"]["gyro_x"]["edf"][0] == expected["edf"][0]
        for name, types in result["identified"].items():
            same = [alpha in (0, 1) for alpha in types["alpha"]][: len(expected["edf"])]
            assert np.equal(result["channels"][name]["edf"], expected["edf"]).tolist() == same
        assert main([*arguments, "--noise", "identified"]) == 0
        assert "degrees of freedom of the noise identified at each time" in capsys.readouterr().out

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["--kind", "hdev"], "hdev"),
            ([], "kind"),
            (["--kind", "total", "--overlap", "none"], "omit it"),
            (["--kind", "mtie", "--noise", "random_walk"], "the distribution of the MTIE"),
            (["--kind", "modified", "--noise", "white"], "unknown term 'white'"),
            (["--kind", "modified", "--taus", "5"], "out of reach"),
        ],
    )
    def test_wrong_options(self, log, options, words, capsys):
        assert main(["deviation", log, "--rate", "100", *options]) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        assert words in captured.err
        assert captured.err.count("\n") == 1
