"""KF-GINS, gnss-ins-sim, MATLAB, Gazebo and ROS: files read by other readers, and in SI by each target's own rule."""

import ast
import math
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from ruamel.yaml import YAML

from known import seed_of
from sigmatau import DataError, OptionError
from sigmatau.export import Choices, export
from sigmatau.export.process import PEAK_TIME, SIGMA_OF_FLICKER
from sigmatau.model import ChannelModel, GaussMarkov, LowPass, NoiseModel

EXACT = 1e-12
RATE = 200.0
D2R = math.pi / 180
AXES = "xyz"
SIZES = {"x": 1.0, "y": 0.7, "z": 1.3}
N, B, K = {"gyro": 8.7e-5, "accel": 1.3e-3}, {"gyro": 4e-5, "accel": 5e-4}, {"gyro": 1.6e-6, "accel": 2.4e-5}
TAU = {"gyro": math.sqrt(3) * 8.7e-5 / 1.6e-6 / PEAK_TIME, "accel": math.sqrt(3) * 1.3e-3 / 2.4e-5 / PEAK_TIME}


def model():
    """Three axes of one shape, so that the bottom of each curve is at the same time."""
    return NoiseModel(
        channels={
            f"{sensor}_{axis}": {
                "random_walk": size * N[sensor],
                "bias_instability": size * B[sensor],
                "rate_random_walk": size * K[sensor],
            }
            for sensor in ("gyro", "accel")
            for axis, size in SIZES.items()
        }
    )


def one(name="gyro_x", **more):
    """A sensor of one axis each, with something about the first of them."""
    terms = {"random_walk": 1e-4, "bias_instability": 1e-5, "rate_random_walk": 1e-6}
    gyro = ChannelModel(terms=terms, **more)
    accel = ChannelModel(terms=terms, quantity="acceleration", unit="m/s^2")
    return NoiseModel(channels={name: gyro, "accel_x": accel})


def expected(coefficient, sensor, axes):
    sizes = list(SIZES.values())
    if axes == "each":
        return [size * coefficient[sensor] for size in sizes]
    size = max(sizes) if axes == "worst" else math.sqrt(sum(s**2 for s in sizes) / 3)
    return [size * coefficient[sensor]] * 3


every_axis_policy = pytest.mark.parametrize("axes", ["worst", "mean", "each"])


def block_yaml(text):
    """The few lines of YAML that are written: an optional key, below it keys with flow sequences and comments."""
    found = {}
    for line in text.splitlines():
        content = line.split(" #")[0].rstrip() if not line.startswith("#") else ""
        if not content:
            continue
        key, value = re.fullmatch(r" *([a-z_]+):(.*)", content).groups()
        assert key not in found
        found[key] = ast.literal_eval(value.strip()) if value.strip() else None
    return found


def adev(sigma, time, tau):
    """Allan deviation of a Gauss-Markov process of any scale, IEEE Std 952; as a walk where three terms would cancel."""
    x = tau / time
    if x < 1e-4:
        return np.asarray(sigma) * math.sqrt(2 * x / 3 - x**2 / 2)
    return np.asarray(sigma) * math.sqrt(2 * (1 - (3 - 4 * math.exp(-x) + math.exp(-2 * x)) / (2 * x)) / x)


class TestKfGins:
    def read(self, given, **choices):
        """As loadConfig of kf_gins.cpp converts them."""
        raw = block_yaml(export(given, to="kf-gins", choices=Choices(**choices)))
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
        choices = Choices(horizon=10.0, names={"corrtime": "0.01"})
        lines = export(given, to="kf-gins", choices=choices).splitlines()
        for key, size, of in (
            ("gbstd", D2R / 3600, lambda tau: 1e-5 * math.sqrt(2 * math.log(2) / math.pi)),
            ("abstd", 1e-5, lambda tau: 1e-5 * math.sqrt(tau / 3)),
        ):
            (line,) = (line for line in lines if line.startswith(f"  {key}"))
            assert "with 36 s in place of its own" in line
            assert "right at the horizon, 10 s" in line
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

    def test_yaml_of_others_agrees(self):
        text = export(model(), to="kf-gins", choices=Choices(axes="each"))
        ours = block_yaml(text)
        assert YAML(typ="safe").load(text) == {
            "imunoise": {key: value for key, value in ours.items() if key != "imunoise"}
        }

    def test_refused(self):
        with pytest.raises(DataError, match="gyro_y, gyro_z"):
            self.read(one(), axes="each")
        with pytest.raises(OptionError, match="`step` has no place"):
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

    def test_a_hostile_name_is_a_comment(self):
        given = one('gyro_x\nimport os\r\x0cos.system("x")\u2028"""\x85}, "gyro_b": 1')
        assert self.read(given)["gyro"][0][0] == pytest.approx(1e-4, rel=EXACT)


def matlab(text):
    """Assignments ``a.b = value;`` of a script: numbers, row vectors, strings and calls; all else must be a comment."""
    found = {}
    for line in re.split(r"[\n\r\x0b\x0c\x1c-\x1e\x85\u2028\u2029]", text):
        code = re.match(r"((?:[^'%]|'[^']*')*)", line)[1].strip()
        if not code:
            continue
        name, value = re.fullmatch(r"([a-z]+(?:\.[A-Za-z]+)?) = (.+);", code).groups()
        assert name not in found
        is_vector = re.fullmatch(r"\[([-+.0-9e]+, [-+.0-9e]+, [-+.0-9e]+)\]", value)
        found[name] = [float(x) for x in is_vector[1].split(",")] if is_vector else value
    return found


def matlab_in_si(found, sensor, rate):
    """N, B and K of what IMUSensorSimulator.m makes of the parameters: setupBandwidth and the setStdDev… methods."""
    bandwidth = {"'double-sided'": rate / 2, "'single-sided'": rate}[found[f"{sensor}.NoiseType"]]
    white = math.sqrt(bandwidth) * np.array(found[f"{sensor}.NoiseDensity"])  # of a sample
    walk = np.array(found[f"{sensor}.RandomWalk"]) / math.sqrt(bandwidth)  # of a step
    correlation_time = 2 / rate
    drive = math.sqrt(2 / (rate * correlation_time)) * np.array(found[f"{sensor}.BiasInstability"])
    return white / math.sqrt(rate), drive, walk * math.sqrt(rate)


class TestMatlab:
    @every_axis_policy
    def test_values_in_si_are_the_models(self, axes):
        found = matlab(export(model(), to="matlab", choices=Choices(axes=axes, rate=RATE)))
        for sensor in ("gyro", "accel"):
            assert found[sensor] == f"{sensor}params"
            poles = math.ceil(RATE * TAU[sensor] * PEAK_TIME)  # to the bottom of the curve
            assert found[f"{sensor}.BiasInstabilityCoefficients"] == f"fractalcoef({poles})"
            for got, coefficient in zip(matlab_in_si(found, sensor, RATE), (N, B, K), strict=True):
                assert got == pytest.approx(expected(coefficient, sensor, axes), rel=EXACT)
        assert found["imu"].startswith("imuSensor('accel-gyro', 'SampleRate', 200.0, ")

    def test_of_neither_gyros_nor_accelerometers(self):
        warm = ChannelModel(terms={"random_walk": 0.2}, quantity="signal", unit="K")
        with pytest.raises(DataError, match="neither gyros nor accelerometers"):
            export(NoiseModel(channels={"temp": warm}), to="matlab")

    def test_its_filter_makes_flicker_noise_up_to_the_horizon(self):
        """fractalcoef: (k − 3/2)/k, multiplied up, as the denominator; σ² by eq. (11) for samples."""
        given = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5}})
        found = matlab(export(given, to="matlab", choices=Choices(rate=100.0, horizon=5.0)))
        poles = int(re.fullmatch(r"fractalcoef\((\d+)\)", found["gyro.BiasInstabilityCoefficients"])[1])
        assert poles == 500

        def deviation(poles, m, n=1 << 18):
            k = np.arange(1, poles + 1)
            denominator = np.concatenate(([1.0], np.cumprod((k - 1.5) / k)))
            psd = 1 / np.abs(np.fft.rfft(denominator, n)[1:]) ** 2
            x = math.pi * np.arange(1, n // 2 + 1) / n
            return math.sqrt(4 * np.sum(psd * np.sin(m * x) ** 4 / (m * np.sin(x)) ** 2) / n)

        plateau = math.sqrt(2 * math.log(2) / math.pi)
        for m in (10, 50, 200, 500):
            assert deviation(poles, m) / plateau == pytest.approx(1.0, abs=0.07)
        # The default, one pole: white noise of 1/(1 − 1/2) times the drive.
        assert deviation(1, 100) == pytest.approx(2 / math.sqrt(100), rel=0.02)
        assert deviation(1, 100) / deviation(1, 400) == pytest.approx(2.0, rel=0.01)

    def test_a_time_is_asked_for(self):
        given = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "bias_instability": 1e-5}})
        with pytest.raises(OptionError, match="give `rate`, `horizon`"):
            export(given, to="matlab")
        with pytest.raises(OptionError, match="give `horizon`"):
            export(given, to="matlab", choices=Choices(rate=100.0))
        with pytest.raises(OptionError, match=r"give `rate`$"):
            export(given, to="matlab", choices=Choices(horizon=1.0))
        white = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
        with pytest.raises(OptionError, match="`horizon` has no place"):
            export(white, to="matlab", choices=Choices(horizon=1.0))

    def test_what_was_not_seen_is_not_made_up(self):
        """K is no B, and B is no K; limits are said and not written."""
        limits = {"rate_random_walk": 3e-6}
        no_walk = NoiseModel(
            channels={"gyro_x": ChannelModel(terms={"random_walk": 1e-4, "bias_instability": 1e-5}, limits=limits)}
        )
        some = {"rate": 100.0, "horizon": 10.0}
        text = export(no_walk, to="matlab", choices=Choices(**some))
        assert "gyro.RandomWalk" not in matlab(text)
        assert "% gyro.RandomWalk stays 0: not observed, below 3e-06 rad/s/sqrt(s)" in text
        assert "accel" not in matlab(text)
        chosen = matlab(export(no_walk, to="matlab", choices=Choices(walk={"gyro": "upper-limit"}, **some)))
        assert chosen["gyro.RandomWalk"] == [3e-6] * 3
        stands_for_all = matlab(export(no_walk, to="matlab", choices=Choices(walk={"gyro": "horizon"}, **some)))
        assert "gyro.BiasInstability" not in stands_for_all
        assert stands_for_all["gyro.RandomWalk"][0] > 0
        no_flicker = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6}})
        assert "gyro.BiasInstability" not in matlab(export(no_flicker, to="matlab"))

    def test_an_axis_without_a_term_has_0(self):
        given = NoiseModel(
            channels={
                "gyro_x": {"random_walk": 1e-4, "rate_random_walk": 1e-6},
                "gyro_y": {"random_walk": 1e-4, "bias_instability": 1e-5},
                "gyro_z": {"random_walk": 1e-4},
            }
        )
        chosen = Choices(axes="each", walk_factor=2.0, noise_factor=3.0, rate=10.0, horizon=10.0)
        found = matlab(export(given, to="matlab", choices=chosen))
        assert found["gyro.RandomWalk"] == [2e-6, 0, 0]
        assert found["gyro.BiasInstability"] == [0, 2e-5, 0]
        assert found["gyro.NoiseDensity"] == pytest.approx([3e-4] * 3, rel=EXACT)

    def test_a_hostile_name_is_a_comment(self):
        name = "gyro_x\n!rm -rf x\r%{\u2028system('x');\x85gyro.NoiseDensity = 1;\x1e"
        text = export(one(name), to="matlab", choices=Choices(rate=1.0))
        assert matlab(text)["gyro.NoiseDensity"] == pytest.approx([1e-4] * 3, rel=EXACT)
        assert not re.search(r"^\s*%[{}]\s*$", text, flags=re.MULTILINE)


class TestGazebo:
    def read(self, given, **choices):
        return ET.fromstring(export(given, to="gazebo", choices=Choices(rate=RATE, **choices)).encode())

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

    def test_its_recursion_has_the_variance_of_the_process(self):
        """σ_b²·Tc/2·(1 − e^(−2dt/Tc)) a step, as both programs have it, against the process's own law."""
        drive_time = self.noise(self.read(model()), "gyro", "x")
        sigma, time, dt = drive_time[1], drive_time[2], 0.005
        drive = sigma * math.sqrt(2 / time)
        variance = 0.0
        for _ in range(2000):
            variance = math.exp(-2 * dt / time) * variance - drive**2 * time / 2 * math.expm1(-2 * dt / time)
        assert variance == pytest.approx(-(sigma**2) * math.expm1(-2 * 2000 * dt / time), rel=1e-9)

    def test_hostile_names(self):
        name = 'gyro_x --><plugin name="x" filename="evil.so"/><!-- ]]> & \x00\x01 \ud800 --'
        root = self.read(one(name))
        assert [p.get("filename") for p in root.iter("plugin")] == ["libgazebo_imu_plugin.so"]
        assert self.noise(root, "gyro", "x")[0] == pytest.approx(1e-4, rel=EXACT)
        for key in ("link", "plugin"):
            with pytest.raises(OptionError, match=f"`name` {key}=.*are allowed there") as refused:
                self.read(one(), names={key: '"/><plugin filename="evil.so'})
            assert refused.value.option == "name"
        with pytest.raises(OptionError, match="gyro_turn_on_bias"):
            self.read(one(), names={"gyro_turn_on_bias": "0</x>"})
        assert self.read(one(), names={"link": "base/imu"}).find("model/link").get("name") == "base/imu"


class TestRos:
    def read(self, given, **choices):
        found = block_yaml(export(given, to="ros", choices=Choices(**{"rate": RATE, **choices})))
        assert list(found) == [
            "orientation_covariance",
            "angular_velocity_covariance",
            "linear_acceleration_covariance",
        ]
        return [np.array(matrix).reshape(3, 3) for matrix in found.values()]

    @every_axis_policy
    def test_values_are_the_models(self, axes):
        orientation, *found = self.read(model(), axes=axes)
        assert orientation.ravel().tolist() == [-1.0, *[0.0] * 8]
        for sensor, matrix in zip(("gyro", "accel"), found, strict=True):
            assert np.sqrt(np.diag(matrix) / RATE) == pytest.approx(expected(N, sensor, axes), rel=EXACT)
            assert not (matrix - np.diag(np.diag(matrix))).any()

    def test_absent_is_minus_one(self):
        _, gyro, accel = self.read(NoiseModel(channels={"accel_x": {"random_walk": 1e-3}}), noise_factor=2.0)
        assert gyro.ravel().tolist() == [-1.0, *[0.0] * 8]
        assert accel[2, 2] == pytest.approx(4e-6 * RATE, rel=EXACT)
        with pytest.raises(DataError, match="neither gyros nor accelerometers"):
            self.read(NoiseModel(channels={"t": ChannelModel(terms={"random_walk": 1.0}, quantity="signal", unit="K")}))

    def test_shared_noise(self):
        channels = {
            f"gyro_{axis}": {"random_walk": size, "quantization": 1e-3}
            for axis, size in zip("zyx", (3e-4, 2e-4, 1e-4), strict=True)
        }
        shared = {"random_walk": {("gyro_z", "gyro_x"): -0.5}, "quantization": {("gyro_y", "gyro_x"): 0.25}}
        given = NoiseModel(channels=channels, correlation=shared)
        _, gyro, _ = self.read(given, axes="each")
        off = -0.5 * 1e-4 * 3e-4 * RATE
        white = np.array([[1e-8 * RATE, 0, off], [0, 4e-8 * RATE, 0], [off, 0, 9e-8 * RATE]])
        quantized = np.array([[1, 0.25, 0], [0.25, 1, 0], [0, 0, 1]]) * 2 * (1e-3 * RATE) ** 2
        assert gyro == pytest.approx(white + quantized, rel=EXACT)
        assert "taken for independent" in export(given, to="ros", choices=Choices(rate=RATE))

    @pytest.mark.parametrize(("order", "corner"), [(1, 30.0), (2, 60.0)])
    def test_behind_a_bandwidth_it_is_the_variance_of_a_sample(self, order, corner):
        given = NoiseModel(
            channels={
                "gyro_x": ChannelModel(terms={"random_walk": 1e-3}, bandwidth=LowPass(order=order, corner=corner))
            }
        )
        _, gyro, _ = self.read(given)
        # ∫N²|H|² df of a Butterworth filter over all frequencies.
        area = corner * (math.pi / (2 * order)) / math.sin(math.pi / (2 * order))
        assert gyro[0, 0] == pytest.approx(1e-6 * 2 * area, rel=1e-9)
        text = export(given, to="ros", choices=Choices(rate=RATE))
        assert "samples are correlated" in text
        assert "N^2*rate = 0.0002 instead" in text

    @pytest.mark.parametrize(("axes", "square"), [("worst", 100.0), ("mean", 50.5)])
    def test_what_independent_samples_need_is_of_the_axes_that_were_chosen(self, axes, square):
        band = LowPass(order=1, corner=30.0)
        x, y = (ChannelModel(terms={"random_walk": n}, bandwidth=band) for n in (1e-4, 1e-3))
        text = export(NoiseModel(channels={"gyro_x": x, "gyro_y": y}), to="ros", choices=Choices(rate=RATE, axes=axes))
        assert float(re.search(r"N\^2\*rate = (\S+) instead", text)[1]) == pytest.approx(square * 1e-8 * RATE, rel=1e-3)

    @every_axis_policy
    def test_a_random_walk_that_was_chosen_is_in_a_sample(self, axes):
        """Quantization covers that of the gyros: a value, or what it is below."""
        hidden = ChannelModel(terms={"quantization": 1e-6}, limits={"random_walk": 5e-5})
        given = NoiseModel(channels={f"gyro_{axis}": hidden for axis in AXES})
        for chosen, n in ((3e-5, 3e-5), ("upper-limit", 5e-5)):
            _, gyro, _ = self.read(given, noise={"gyro": chosen}, noise_factor=2.0, axes=axes)
            assert np.diag(gyro) == pytest.approx([4 * (n**2 * RATE + 2 * (1e-6 * RATE) ** 2)] * 3, rel=EXACT)
        with pytest.raises(OptionError, match="choose `noise="):
            self.read(given, axes=axes)

    def test_samples_have_it(self):
        """Quantization and white noise, simulated: the mean square of the samples."""
        given = NoiseModel(channels={"gyro_x": {"random_walk": 1e-3, "quantization": 2e-5}})
        _, gyro, _ = self.read(given)
        rng = np.random.default_rng(seed_of("ros sample variance"))
        n = 100_000
        rate = 1e-3 * math.sqrt(RATE) * rng.standard_normal(n) + np.diff(2e-5 * rng.standard_normal(n + 1)) * RATE
        # Neighbours share quantization: their correlation is at most 1/2, which is at most 3/2 of the variance of it.
        assert np.mean(rate**2) == pytest.approx(gyro[0, 0], rel=3 * math.sqrt(2 * 1.5 / n))

    def test_what_has_no_place(self):
        for choice in ({"walk": {"gyro": 1e-6}}, {"walk_factor": 2.0}, {"horizon": 1.0}, {"step": 0.01}):
            with pytest.raises(OptionError, match="has no place in ros"):
                self.read(model(), **choice)
        with pytest.raises(OptionError, match="sampling rate"):
            export(model(), to="ros")

    def test_a_hostile_name_is_a_comment(self):
        name = "gyro_x\nlinear_acceleration_covariance: [9]\x85\u2028# \x00"
        text = export(one(name), to="ros", choices=Choices(rate=RATE))
        assert YAML(typ="safe").load(text) == block_yaml(text)
        assert block_yaml(text)["linear_acceleration_covariance"][0] == pytest.approx(1e-8 * RATE, rel=EXACT)


@pytest.mark.parametrize("target", ["kf-gins", "gnss-ins-sim", "gazebo"])
def test_a_horizon_that_enters_nothing_is_refused(target):
    own = (GaussMarkov(sigma=3e-5, time=250.0),)
    gyro = ChannelModel(terms={"random_walk": 1e-4}, gauss_markov=own)
    accel = ChannelModel(terms={"random_walk": 1e-3}, gauss_markov=own, quantity="acceleration", unit="m/s^2")
    given = NoiseModel(channels={"gyro_x": gyro, "accel_x": accel})
    export(given, to=target, choices=Choices(rate=RATE))
    with pytest.raises(OptionError, match="own Gauss-Markov"):
        export(given, to=target, choices=Choices(rate=RATE, horizon=10.0))
    export(
        one(gauss_markov=own), to=target, choices=Choices(rate=RATE, horizon=10.0)
    )  # for the accelerometer's flicker
