"""Covariances for ROS messages, read back."""

import functools
import math
import re

import numpy as np
import pytest
from simulators import AXES, EXACT, RATE, N, block_yaml, every_axis_policy, expected, model

from known import seed_of
from sigmatau import DataError, OptionError, Record, analyze
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export, prepare
from sigmatau.model.channel import ChannelModel
from sigmatau.model.noise_model import NoiseModel
from sigmatau.model.processes import GaussMarkov, LowPass, Sinusoid


@functools.cache
def correlated_samples():
    """A line, samples behind a filter, and ones that were differenced; and their analysis."""
    from scipy.signal import butter, lfilter

    rng = np.random.default_rng(seed_of("ros measured variance"))
    n = 60_000
    white = rng.standard_normal((3, n + 100))
    record = Record.from_arrays(
        rate=100,
        gyro_x=1e-3 * white[0, 100:] + 1e-3 * np.sin(0.7 * np.arange(n)),
        gyro_y=3e-3 * lfilter(*butter(2, 0.3), white[1])[100:],
        gyro_z=1e-3 * (white[2, 1:] - 0.4 * white[2, :-1])[99:],
    )
    return record, analyze(record)


class TestRos:
    def read(self, given, **choices):
        found = block_yaml(export(given, to="ros", choices=Choices(**{"filter_rate": RATE, **choices})))
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
        assert "treated as independent" in export(given, to="ros", choices=Choices(filter_rate=RATE))

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
        text = export(given, to="ros", choices=Choices(filter_rate=RATE))
        assert "samples are correlated" in text
        assert "N^2*rate = 0.0002 is for a filter that assumes independent samples" in text

    @pytest.mark.parametrize(("axes", "square"), [("worst", 100.0), ("mean", 50.5)])
    def test_what_independent_samples_need_is_of_the_axes_that_were_chosen(self, axes, square):
        band = LowPass(order=1, corner=30.0)
        x, y = (ChannelModel(terms={"random_walk": n}, bandwidth=band) for n in (1e-4, 1e-3))
        text = export(
            NoiseModel(channels={"gyro_x": x, "gyro_y": y}), to="ros", choices=Choices(filter_rate=RATE, axes=axes)
        )
        of = {"worst": r"N\^2\*rate = (\S+) is", "mean": r"in the mean N\^2\*rate = (\S+)"}[axes]
        assert float(re.search(of, text)[1]) == pytest.approx(square * 1e-8 * RATE, rel=1e-3)

    @every_axis_policy
    def test_a_random_walk_that_was_chosen_is_in_a_sample(self, axes):
        """Quantization covers that of the gyros: a value, or what it is below."""
        hidden = ChannelModel(terms={"quantization": 1e-6}, limits={"random_walk": 5e-5})
        given = NoiseModel(channels={f"gyro_{axis}": hidden for axis in AXES})
        for chosen, n in ((3e-5, 3e-5), ("upper-limit", 5e-5)):
            _, gyro, _ = self.read(given, noise={"gyro": chosen}, noise_factor=2.0, axes=axes)
            assert np.diag(gyro) == pytest.approx([4 * (n**2 * RATE + 2 * (1e-6 * RATE) ** 2)] * 3, rel=EXACT)
        with pytest.raises(OptionError, match="choose `noise="):
            self.read(given, axes=axes, strict=True)
        _, gyro, _ = self.read(given, axes=axes)
        assert np.diag(gyro) == pytest.approx([5e-5**2 * RATE + 2 * (1e-6 * RATE) ** 2] * 3, rel=EXACT)

    def test_processes_and_lines_of_a_model_are_in_a_sample(self):
        own = {
            "gauss_markov": (GaussMarkov(sigma=3e-3, time=5.0),),
            "sinusoid": (Sinusoid(amplitude=0.02, frequency=20.0),),
        }
        given = NoiseModel(
            channels={"gyro_x": ChannelModel(terms={"random_walk": 1e-3, "bias_instability": 1.0}, **own)}
        )
        _, gyro, _ = self.read(given, noise_factor=2.0)
        assert gyro[0, 0] == pytest.approx(4 * (1e-6 * RATE + 9e-6 + 2e-4), rel=EXACT)

    @every_axis_policy
    def test_of_a_record_it_is_what_its_samples_have(self, axes):
        """In each of three kinds of correlated samples, N²·rate is another number."""
        record, analysis = correlated_samples()
        prepared = prepare(analysis, to="ros", choices=Choices(axes=axes, noise_factor=2.0))
        found = block_yaml(prepared.content)["angular_velocity_covariance"]
        each = [4 * float(np.var(record.streams[0].column(f"gyro_{axis}"))) for axis in AXES]
        wanted = {"worst": [max(each)] * 3, "mean": [sum(each) / 3] * 3, "each": each}[axes]
        # Both are of the same samples; the last means, beyond white noise, leave 1/1000.
        assert [found[0], found[4], found[8]] == pytest.approx(wanted, rel=2e-3)
        correlated = {f.channel: f.details for f in prepared.findings if f.code == "correlated_samples"}
        assert set(correlated) == {"gyro_x", "gyro_y", "gyro_z"}
        assert correlated["gyro_y"].corner is not None
        assert correlated["gyro_y"].ratio < 1
        assert correlated["gyro_z"].corner is None

    def test_at_another_rate_it_is_the_models(self):
        rng = np.random.default_rng(seed_of("ros other rate"))
        analysis = analyze(Record.from_arrays(rate=100, gyro_x=1e-3 * rng.standard_normal(20_000)))
        n = analysis.fits["gyro_x"]["random_walk"].value
        text = export(analysis, to="ros", choices=Choices(filter_rate=400))
        assert block_yaml(text)["angular_velocity_covariance"][0] == pytest.approx(n**2 * 400, rel=EXACT)
        assert "measured" not in text

    def test_a_curve_without_octaves_leaves_the_model(self):
        record = Record.from_arrays(
            rate=100, gyro_x=1e-3 * np.random.default_rng(seed_of("few taus")).normal(size=20_000)
        )
        text = export(analyze(record, taus=[0.01, 0.03, 0.1, 1.0, 10.0, 60.0]), to="ros")
        assert "measured" not in text
        assert "N^2*rate" in text

    def test_a_noise_that_was_chosen_is_written(self):
        """Where quantization hides the random walk, and the user says what it is."""
        rng = np.random.default_rng(seed_of("ros chosen"))
        steps = np.diff(rng.uniform(-0.5, 0.5, 50_001)) * 1e-3
        analysis = analyze(Record.from_arrays(rate=100, gyro_x=steps))
        assert "random_walk" not in analysis.to_source().model.channels["gyro_x"]
        measured = block_yaml(export(analysis, to="ros"))["angular_velocity_covariance"][0]
        assert measured == pytest.approx(np.var(steps), rel=2e-3)
        chosen = block_yaml(export(analysis, to="ros", choices=Choices(noise={"gyro": 1e-6})))
        q = analysis.fits["gyro_x"]["quantization"].value
        assert chosen["angular_velocity_covariance"][0] == pytest.approx(1e-12 * 100 + 2 * (q * 100) ** 2, rel=EXACT)

    def test_what_has_no_place(self):
        for choice in ({"walk": {"gyro": 1e-6}}, {"walk_factor": 2.0}, {"horizon": 1.0}, {"step": 0.01}):
            with pytest.raises(OptionError, match="does not apply to ros"):
                self.read(model(), **choice)
        with pytest.raises(OptionError, match="rate of the filter"):
            export(model(), to="ros")
