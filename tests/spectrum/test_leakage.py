"""A model with a line held against a density: what the line shows is left out, and no more."""

import math
from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import DataError, NoiseModel, from_frame, simulate
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import Sinusoid
from sigmatau.spectrum.estimate import psd
from sigmatau.spectrum.tapers import line_density

N, RATE = 2**14, 50.0
LINE = 135.5 * RATE / 2048  # between two frequencies of Welch's estimate, where it leaks most
ALL = {"welch": {}, "multitaper": {"f_max": RATE / 2}}


@pytest.mark.parametrize("method", ["welch", "multitaper"])
@pytest.mark.parametrize("line", [LINE, 40.0 * RATE + LINE, 23.7])
def test_a_line_shows_no_more_than_is_said_and_not_much_less(method, line):
    t = np.arange(N) / RATE
    y = 2.0 * np.sin(2 * math.pi * line * t + 0.7)
    found = psd(from_frame({"gyro_x": y}, rate=RATE, unit={"gyro": "rad/s"}), method=method, **ALL[method])["gyro_x"]
    tapers = found.segments if method == "multitaper" else None
    bound = line_density(found.frequency, line, 2.0, tau0=1 / RATE, resolution=found.resolution, tapers=tapers)
    folded = abs(math.remainder(line, RATE))
    near = np.abs(found.frequency - folded) < 40 * found.resolution
    # The image at the negative frequency adds its amplitude, and the mean and slope that are taken off a little.
    assert (found.density[near] / bound[near]).max() < 1.2
    octave = np.abs(np.abs(found.frequency - folded) - 6 * found.resolution) < 2 * found.resolution
    assert (found.density[octave] / bound[octave]).max() > 0.3


@pytest.mark.parametrize("method", ["welch", "multitaper"])
def test_the_model_that_made_the_record_is_not_called_wrong(method):
    model = ChannelModel(
        terms={"random_walk": 1.0},
        sinusoid=(Sinusoid(amplitude=0.3, frequency=9.1), Sinusoid(amplitude=30.0, frequency=LINE)),
    )
    rng = np.random.default_rng(seed_of(f"line beside noise {method}"))
    called_wrong, records = 0, 20
    for _ in range(records):
        made = simulate(NoiseModel(channels={"gyro_x": model}), duration=N / RATE, rate=RATE, rng=rng)
        found = psd(made, method=method, **ALL[method])["gyro_x"]
        compared = found.over(model)
        called_wrong += compared.p_value < 0.05
        assert len(compared.beside_lines) == 2
    assert called_wrong <= records * 0.05 + 3 * math.sqrt(records * 0.05)
    low, high = compared.beside_lines[0]
    assert low < LINE < high
    assert high - low < 2.0
    assert f"{low:.4g} Hz to {high:.4g} Hz" in repr(compared)
    assert compared.to_dict()["beside_lines_hz"][0] == [low, high]
    # Without the line the model is wrong, and nothing is left out.
    alone = found.over(replace(model, sinusoid=()))
    assert alone.p_value < 1e-6
    assert alone.beside_lines == ()


def test_a_model_out_of_range_is_an_error_and_not_right():
    t = np.random.default_rng(seed_of("out of range")).standard_normal(N)
    found = psd(from_frame({"gyro_x": t}, rate=RATE, unit={"gyro": "rad/s"}))["gyro_x"]

    class Infinite:
        unit = "rad/s"

        def psd(self, f, *, tau0=None):
            return np.full(f.shape, np.inf)

    class Tiny(Infinite):
        def psd(self, f, *, tau0=None):
            return np.full(f.shape, 1e-320)

    with pytest.raises(DataError, match="not a finite number"):
        found.over(Infinite())
    with pytest.raises(DataError, match="not a finite number"):
        found.over(Tiny())
