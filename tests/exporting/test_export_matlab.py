"""The script for MATLAB, read back by rules of its own toolbox."""

import math
import re

import numpy as np
import pytest
from simulators import EXACT, RATE, TAU, B, K, N, every_axis_policy, expected, model, one

from sigmatau import DataError, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.gauss_markov import PEAK_TIME
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel


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
        found = matlab(export(model(), to="matlab", choices=Choices(axes=axes, filter_rate=RATE)))
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
        found = matlab(export(given, to="matlab", choices=Choices(filter_rate=100.0, horizon=5.0)))
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
        with pytest.raises(OptionError, match="give `filter_rate`, `horizon`"):
            export(given, to="matlab")
        with pytest.raises(OptionError, match="give `horizon`"):
            export(given, to="matlab", choices=Choices(filter_rate=100.0))
        with pytest.raises(OptionError, match=r"give `filter_rate`$"):
            export(given, to="matlab", choices=Choices(horizon=1.0))
        white = NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
        with pytest.raises(OptionError, match="`horizon` does not apply"):
            export(white, to="matlab", choices=Choices(horizon=1.0))

    def test_what_was_not_seen_is_not_made_up(self):
        """K is no B, and B is no K; limits are said and not written."""
        limits = {"rate_random_walk": 3e-6}
        no_walk = NoiseModel(
            channels={"gyro_x": ChannelModel(terms={"random_walk": 1e-4, "bias_instability": 1e-5}, limits=limits)}
        )
        some = {"filter_rate": 100.0, "horizon": 10.0}
        text = export(no_walk, to="matlab", choices=Choices(**some))
        assert "gyro.RandomWalk" not in matlab(text)
        assert "% gyro.RandomWalk stays 0: not observed, below 3.0e-06 rad/s/sqrt(s)" in text
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
        chosen = Choices(axes="each", walk_factor=2.0, noise_factor=3.0, filter_rate=10.0, horizon=10.0)
        found = matlab(export(given, to="matlab", choices=chosen))
        assert found["gyro.RandomWalk"] == [2e-6, 0, 0]
        assert found["gyro.BiasInstability"] == [0, 2e-5, 0]
        assert found["gyro.NoiseDensity"] == pytest.approx([3e-4] * 3, rel=EXACT)

    def test_a_hostile_name_is_a_comment(self):
        name = "gyro_x\n!rm -rf x\r%{\u2028system('x');\x85gyro.NoiseDensity = 1;\x1e"
        text = export(one(name), to="matlab", choices=Choices(filter_rate=1.0))
        assert matlab(text)["gyro.NoiseDensity"] == pytest.approx([1e-4] * 3, rel=EXACT)
        assert not re.search(r"^\s*%[{}]\s*$", text, flags=re.MULTILINE)
