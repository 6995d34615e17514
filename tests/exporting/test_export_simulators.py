"""KF-GINS, gnss-ins-sim and Gazebo: files read by other readers, and in SI by each target's own rule."""

import ast
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from simulators import (
    AXES,
    D2R,
    EXACT,
    RATE,
    TAU,
    B,
    N,
    adev,
    block_yaml,
    every_axis_policy,
    expected,
    model,
    one,
)

from sigmatau import OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.gauss_markov import PEAK_TIME, SIGMA_OF_FLICKER
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import GaussMarkov
from sigmatau.navigation.reference_filter import AIDING, FilterModel, TrueNoise, judge_filter


class TestKfGins:
    def read(self, given, **choices):
        """As loadConfig of kf_gins.cpp converts them."""
        raw = block_yaml(export(given, to="kf-gins", choices=Choices(**({"strict": True} | choices))))
        assert list(raw) == ["imunoise", "arw", "vrw", "gbstd", "abstd", "gsstd", "asstd", "corrtime"]
        return {
            "arw": np.array(raw["arw"]) * (D2R / 60),
            "vrw": np.array(raw["vrw"]) / 60,
            "gbstd": np.array(raw["gbstd"]) * (D2R / 3600),
            "abstd": np.array(raw["abstd"]) * 1e-5,
            "gsstd": np.array(raw["gsstd"]) * 1e-6,
            "asstd": np.array(raw["asstd"]) * 1e-6,
            "corrtime": raw["corrtime"] * 3600,
        }

    @every_axis_policy
    def test_values_in_si_are_the_models(self, axes):
        found = self.read(model(), axes=axes)
        for key, sensor in (("arw", "gyro"), ("vrw", "accel")):
            assert found[key] == pytest.approx(expected(N, sensor, axes), rel=EXACT)
        for key, sensor in (("gbstd", "gyro"), ("abstd", "accel")):
            bottom = PEAK_TIME * TAU[sensor]  # of each sensor another, and there 0.664 B with the time that both share
            plateau = math.sqrt(2 * math.log(2) / math.pi) * np.array(expected(B, sensor, axes))
            assert adev(found[key], found["corrtime"], bottom) == pytest.approx(plateau, rel=1e-9)
        assert found["corrtime"] == pytest.approx(math.sqrt(TAU["gyro"] * TAU["accel"]), rel=1e-9)
        assert list(found["gsstd"]) == [300e-6] * 3

    def test_one_time_for_all(self):
        found = self.read(model(), names={"corrtime": "4", "gsstd": "120", "asstd": "0"})
        assert (found["corrtime"], found["gsstd"][0], found["asstd"][0]) == (14400.0, pytest.approx(120e-6), 0.0)
        bottom = PEAK_TIME * TAU["gyro"]
        plateau = math.sqrt(2 * math.log(2) / math.pi) * 1.3 * B["gyro"]
        assert adev(found["gbstd"][0], 14400.0, bottom) == pytest.approx(plateau, rel=1e-9)

    @pytest.mark.parametrize("hours", ["", "1e-3", "0.05", "1", "4", "1e6"])
    def test_the_allan_deviation_is_right_at_the_horizon_whatever_the_time(self, hours):
        horizon = 60.0
        given = NoiseModel(
            channels={
                "gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5},
                "accel_x": {"random_walk": 1e-3, "rate_random_walk": 1e-5},
            }
        )
        found = self.read(given, horizon=horizon, walk_factor=2.0, names={"corrtime": hours} if hours else {})
        time = found["corrtime"]
        gyro, accel = 2e-5 * math.sqrt(2 * math.log(2) / math.pi), 2e-5 * math.sqrt(horizon / 3)
        assert adev(found["gbstd"][0], time, horizon) == pytest.approx(gyro, rel=1e-9)
        assert adev(found["abstd"][0], time, horizon) == pytest.approx(accel, rel=1e-9)

    def test_the_comment_has_the_true_error(self):
        given = NoiseModel(
            channels={
                "gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5},
                "accel_x": {"random_walk": 1e-3, "rate_random_walk": 1e-5},
            }
        )
        choices = Choices(horizon=10.0, names={"corrtime": "0.01"}, strict=True)
        lines = export(given, to="kf-gins", choices=choices).splitlines()
        for key, size, of in (
            ("gbstd", D2R / 3600, lambda tau: 1e-5 * math.sqrt(2 * math.log(2) / math.pi)),
            ("abstd", 1e-5, lambda tau: 1e-5 * math.sqrt(tau / 3)),
        ):
            (line,) = (line for line in lines if line.startswith(f"  {key}"))
            assert "with 36 s instead of its own" in line
            assert "exact at the horizon, 10 s" in line
            sigma = size * ast.literal_eval(re.search(r"\[.*?\]", line)[0])[0]
            errors = re.findall(r"([\d.]+) % (low|high) at ([\d.]+) s", line)
            assert [float(tau) for *_, tau in errors] == [3.16, 31.6]
            for text, side, tau in errors:
                ratio = adev(sigma, 36.0, float(tau)) / of(float(tau))
                assert float(text) == pytest.approx(100 * abs(ratio - 1), rel=0.05)
                assert (side == "low") == (ratio < 1)

    def test_the_models_own_process_keeps_its_peak(self):
        own = one(gauss_markov=(GaussMarkov(sigma=3e-5, time=250.0),))
        found = self.read(own, names={"corrtime": "1"})
        peak = PEAK_TIME * 250.0
        assert adev(found["gbstd"][0], 3600.0, peak) == pytest.approx(adev(3e-5, 250.0, peak), rel=1e-9)

    @pytest.mark.parametrize(
        ("axes", "horizon", "hours"), [("worst", 60.0, ""), ("each", 60.0, "0.05"), ("mean", 10.0, "")]
    )
    def test_a_filter_states_its_error_right(self, axes, horizon, hours):
        """After the horizon, by the joint covariance after a run; with the factor on σ alone."""
        choices = {"strict": False, "axes": axes, "horizon": horizon, "names": {"corrtime": hours} if hours else {}}
        found = self.read(model(), **choices)
        assert found["corrtime"] == pytest.approx(3600 * float(hours) if hours else 60 * horizon, rel=1e-3)
        ratios = []
        for k, axis in enumerate("xyz"):
            terms = model().channels[f"gyro_{axis}"].terms
            process = GaussMarkov(sigma=found["gbstd"][k], time=found["corrtime"])
            judged = judge_filter(
                [TrueNoise(terms=terms)],
                FilterModel(noise=terms["random_walk"], process=process),
                aiding=AIDING["gyro"],
                times=[horizon],
                run=max(60 * horizon, found["corrtime"]),
            )
            ratios.append(judged.coasting[0].ratio)
        if axes == "each":
            assert ratios == pytest.approx([1.0] * 3, rel=2e-3)
        else:
            assert max(ratios) == pytest.approx(1.0, rel=2e-3) if axes == "worst" else min(ratios) < 1 < max(ratios)
        doubled = self.read(model(), **choices, walk_factor={"gyro": 2.0})
        assert doubled["gbstd"] == pytest.approx(2 * found["gbstd"], rel=1e-12)
        assert list(doubled["abstd"]) == list(found["abstd"])

    def test_the_file_says_what_a_filter_states(self):
        text = export(model(), to="kf-gins")
        assert re.search(
            r"# gyro Gauss-Markov bias: a filter states 1\.00 of its error after 60 s, .* in a run of 1 h", text
        )
        flat = {"random_walk": 1e-4}
        given = NoiseModel(
            channels={
                "gyro_x": ChannelModel(terms=flat, limits={"rate_random_walk": 1e-6}),
                "accel_x": ChannelModel(terms=flat | {"rate_random_walk": 1e-6}, quantity="acceleration", unit="m/s^2"),
            }
        )
        assert "count at 1/sqrt(3) of their upper limits" in export(given, to="kf-gins")
        least = [
            self.read(given, strict=False, unobserved=policy)["gbstd"][0]
            for policy in ("absent", "mean", "upper-limit")
        ]
        assert least == sorted(least)

    def test_refused(self):
        with pytest.raises(OptionError, match="gyro_y, gyro_z"):
            self.read(one(), axes="each")
        with pytest.raises(OptionError, match="`step` does not apply"):
            self.read(model(), step=0.01)
        with pytest.raises(OptionError, match="corrtime"):
            self.read(model(), names={"corrtime": "4 # 5\nimunoise: 3"})
        with pytest.raises(OptionError, match="from 1e-06 to 1e"):
            self.read(model(), names={"corrtime": "1e300"})


class TestGnssInsSim:
    def read(self, given, **choices):
        """As the class IMU of imu_model.py takes them; the file holds an import and one assignment, and no more."""
        text = export(given, to="gnss-ins-sim", choices=Choices(**choices))
        statements = ast.parse(text).body
        assert [type(s) for s in statements] == [ast.Import, ast.Assign]
        space = {}
        exec(compile(text, "imu_err.py", "exec"), space)
        err = space["imu_err"]
        assert sorted(err) == sorted(
            f"{s}_{k}" for s in ("gyro", "accel") for k in ("b", "b_stability", "b_corr", {"gyro": "arw"}.get(s, "vrw"))
        )
        return {
            "gyro": (err["gyro_arw"] * D2R / 60, err["gyro_b_stability"] * D2R / 3600, err["gyro_b_corr"]),
            "accel": (err["accel_vrw"] / 60, err["accel_b_stability"], err["accel_b_corr"]),
        }

    @every_axis_policy
    def test_values_in_si_are_the_models(self, axes):
        found = self.read(model(), axes=axes)
        for sensor, (noise, sigma, time) in found.items():
            assert noise == pytest.approx(expected(N, sensor, axes), rel=EXACT)
            assert sigma == pytest.approx(SIGMA_OF_FLICKER * np.array(expected(B, sensor, axes)), rel=EXACT)
            assert time == pytest.approx(TAU[sensor], rel=1e-9)

    def test_its_own_process(self):
        own = one(gauss_markov=(GaussMarkov(sigma=3e-5, time=250.0),))
        noise, sigma, time = self.read(own)["gyro"]
        assert (noise[0], sigma[0], time[0]) == (
            pytest.approx(1e-4, rel=EXACT),
            pytest.approx(3e-5, rel=EXACT),
            250.0,
        )


class TestGazebo:
    def read(self, given, **choices):
        return ET.fromstring(export(given, to="gazebo", choices=Choices(filter_rate=RATE, **choices)).encode())

    @staticmethod
    def noise(root, sensor, axis):
        """N, σ and time as GaussianNoiseModel takes them."""
        element = {"gyro": "angular_velocity", "accel": "linear_acceleration"}[sensor]
        found = root.find(f"model/link/sensor/imu/{element}/{axis}/noise")
        assert found.get("type") == "gaussian"
        rate = float(root.findtext("model/link/sensor/update_rate"))
        drive, time = (float(found.findtext(f"dynamic_bias_{key}")) for key in ("stddev", "correlation_time"))
        return float(found.findtext("stddev")) / math.sqrt(rate), drive * math.sqrt(time / 2), time

    @every_axis_policy
    def test_values_in_si_are_the_models(self, axes):
        root = self.read(model(), axes=axes)
        for sensor in ("gyro", "accel"):
            wanted = zip(expected(N, sensor, axes), expected(B, sensor, axes), strict=True)
            for axis, (n, b) in zip(AXES, wanted, strict=True):
                noise, sigma, time = self.noise(root, sensor, axis)
                assert noise == pytest.approx(n, rel=EXACT)
                assert sigma == pytest.approx(SIGMA_OF_FLICKER * b, rel=EXACT)
                assert time == pytest.approx(TAU[sensor], rel=1e-9)
        assert (root.find("model/plugin") is None) == (axes == "each")

    def test_plugin_of_rotors_and_px4(self):
        root = self.read(model(), names={"gyro_turn_on_bias": "0.01"})
        plugin = root.find("model/plugin")
        for sensor, word in (("gyro", "gyroscope"), ("accel", "accelerometer")):
            time = float(plugin.findtext(f"{word}BiasCorrelationTime"))
            drive = float(plugin.findtext(f"{word}RandomWalk"))
            assert float(plugin.findtext(f"{word}NoiseDensity")) == pytest.approx(1.3 * N[sensor], rel=EXACT)
            assert drive * math.sqrt(time / 2) == pytest.approx(SIGMA_OF_FLICKER * 1.3 * B[sensor], rel=EXACT)
        assert [float(plugin.findtext(f"{w}TurnOnBiasSigma")) for w in ("gyroscope", "accelerometer")] == [0.01, 0.0]

    def test_hostile_names(self):
        name = 'gyro_x --><plugin name="x" filename="evil.so"/><!-- ]]> & \x00\x01 \ud800 --'
        root = self.read(one(name))
        assert [p.get("filename") for p in root.iter("plugin")] == ["libgazebo_imu_plugin.so"]
        assert self.noise(root, "gyro", "x")[0] == pytest.approx(1e-4, rel=EXACT)
        for key in ("link", "plugin"):
            with pytest.raises(OptionError, match=f"`name` {key}=.*are allowed") as refused:
                self.read(one(), names={key: '"/><plugin filename="evil.so'})
            assert refused.value.option == "name"
        with pytest.raises(OptionError, match="gyro_turn_on_bias"):
            self.read(one(), names={"gyro_turn_on_bias": "0</x>"})
        assert self.read(one(), names={"link": "base/imu"}).find("model/link").get("name") == "base/imu"


@pytest.mark.parametrize("target", ["kf-gins", "gnss-ins-sim", "gazebo"])
def test_a_horizon_that_enters_nothing_is_refused(target):
    own = (GaussMarkov(sigma=3e-5, time=250.0),)
    gyro = ChannelModel(terms={"random_walk": 1e-4}, gauss_markov=own)
    accel = ChannelModel(terms={"random_walk": 1e-3}, gauss_markov=own, quantity="acceleration", unit="m/s^2")
    given = NoiseModel(channels={"gyro_x": gyro, "accel_x": accel})
    strict = target == "kf-gins"  # otherwise its processes are consistent
    export(given, to=target, choices=Choices(filter_rate=RATE, strict=strict))
    with pytest.raises(OptionError, match="Gauss-Markov processes of the model itself"):
        export(given, to=target, choices=Choices(filter_rate=RATE, horizon=10.0, strict=strict))
    export(
        one(gauss_markov=own), to=target, choices=Choices(filter_rate=RATE, horizon=10.0, strict=strict)
    )  # for the accelerometer's flicker
