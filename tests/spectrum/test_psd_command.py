"""``sigmatau psd``: its options reach `sigmatau.psd`, and its table says what the JSON says."""

import json

import numpy as np
import pytest

from known import seed_of
from sigmatau import NoiseModel, allan, psd, read, simulate
from sigmatau.cli import main
from sigmatau.io.write import write
from sigmatau.plot.curves import curve_unit
from sigmatau.simulation.imperfections import Imperfections, Temperature
from sigmatau.spectrum.tapers import bin_starts

MODEL = """\
[channels.gyro_x]
random_walk = "0.3 deg/sqrt(h)"
sinusoid = [{ amplitude = "0.05 deg/s", frequency = "5 Hz" }]
[channels.gyro_y]
random_walk = "0.3 deg/sqrt(h)"
rate_ramp = "1 deg/h^2"
[channels.accel_x]
random_walk = "0.1 m/s/sqrt(h)"
"""


@pytest.fixture
def log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "m.toml").write_text(MODEL)
    warm = Imperfections(temperature=Temperature(start=20.0, end=30.0, time=60.0))
    made = simulate(
        NoiseModel.read("m.toml"), duration=200.0, rate=50.0, rng=seed_of("psd command"), imperfections=warm
    )
    write(made, tmp_path / "a.csv")
    return read("a.csv")


def densities(capsys, *argv):
    assert main(["psd", "a.csv", *argv, "--json", "-"]) == 0, capsys.readouterr().err
    return json.loads(capsys.readouterr().out)["channels"]


@pytest.mark.parametrize(
    ("argv", "options"),
    [
        (["--segment", "10s"], {"segment": 10.0}),
        (["--method", "multitaper", "--tapers", "20"], {"method": "multitaper", "tapers": 20}),
        (["--method", "multitaper", "--f-max", "2 Hz"], {"method": "multitaper", "f_max": 2.0}),
    ],
)
def test_options_are_those_of_psd(log, capsys, argv, options):
    got = densities(capsys, *argv)
    expected = psd(log, **options)
    for name, channel in got.items():
        assert channel["density"] == expected[name].binned(per_octave=3).density.tolist()
    assert got["gyro_x"]["segments"] != psd(log, method=options.get("method", "welch"))["gyro_x"].segments or (
        "f_max" in options
    )


def test_axes(log, capsys):
    assert set(densities(capsys)) == {"gyro_x", "gyro_y", "accel_x"}  # a temperature drifts, and is no noise
    assert set(densities(capsys, "--axes", "gyro")) == {"gyro_x", "gyro_y"}
    assert set(densities(capsys, "--axes", "gyro_y,accel_x")) == {"gyro_y", "accel_x"}
    assert set(densities(capsys, "--axes", "gyro_y", "--axes", "temperature")) == {"gyro_y", "temperature"}


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["--axes", "gyro_q"], "--axes gyro_q: the log has gyro_x, gyro_y, accel_x, temperature"),
        (["--tapers", "4"], "--tapers needs --method multitaper, not welch"),
        (["--method", "multitaper", "--segment", "1s"], "--segment needs --method welch, not multitaper"),
        (["--segment", "10"], "--segment '10': want a value with its unit"),
        (["--segment", "1h"], "--segment must be of"),
        (["--method", "multitaper", "--f-max", "1s"], "does not fit here"),
    ],
)
def test_refusals(log, capsys, argv, words):
    assert main(["psd", "a.csv", *argv]) == 2
    assert words in capsys.readouterr().err


def test_the_ratio_stands_beside_the_density_of_its_band(log, capsys):
    channels = densities(capsys, "--model", "m.toml")
    for channel in channels.values():
        bands = channel["frequency_hz"]
        # A band that begins below what is trusted, or has the line in it, has no ratio; all others have.
        beside = channel["over_model"]["beside_lines_hz"]
        assert bool(beside) is (channel is channels["gyro_x"])
        kept = [f for f in bands if f >= 1.3 * channel["trusted_from_hz"]]
        if beside:
            kept = [f for f in kept if not any(low / 1.3 <= f <= high * 1.3 for low, high in beside)]
            assert set(kept) <= set(channel["over_model"]["frequency_hz"]) < set(bands)
        else:
            assert channel["over_model"]["frequency_hz"] == bands[-len(channel["over_model"]["ratio"]) :]
        assert channel["over_model"]["frequency_hz"][0] >= channel["trusted_from_hz"]
    assert channels["gyro_x"]["over_model"]["left_out"] == ["sinusoid at 5 Hz"]
    assert channels["gyro_y"]["over_model"]["left_out"] == ["rate ramp"]
    assert main(["psd", "a.csv", "--model", "m.toml", "--plot", "p.svg"]) == 0
    out = capsys.readouterr().out
    assert out.count("S over the model, 95 % interval") == 3
    assert "omitted, because they have no density: sinusoid at 5 Hz" in out
    ratio = channels["accel_x"]["over_model"]["ratio"][-1]
    last = out[out.index("accel_x: two-sided") :].split("~ below")[0].splitlines()[-2]
    assert float(last.split()[0]) == pytest.approx(channels["accel_x"]["frequency_hz"][-1], rel=1e-3)
    assert float(last.split()[1]) == pytest.approx(channels["accel_x"]["density"][-1], rel=0.02)
    assert float(last.split()[-3]) == pytest.approx(ratio, rel=0.02)  # two digits of its error


def test_ratios_of_bands_are_those_of_the_bands_mean(log):
    """Of white noise the model is the same at each frequency: the ratio is the binned density over it."""
    spectrum = psd(log)["accel_x"]
    model = NoiseModel.read("m.toml")
    compared, bands = spectrum.over(model), spectrum.binned(per_octave=3)
    there = np.isin(bands.frequency, compared.frequency)
    assert there.sum() == len(compared.frequency) >= 8
    np.testing.assert_allclose(compared.dof, bands.dof[there])
    first = spectrum.frequency[bin_starts(spectrum.frequency, 3)]
    np.testing.assert_array_equal(there, first >= spectrum.trusted)
    # Near the ends the slope within a band is taken from other neighbours.
    expected = bands.density[there] / model.channels["accel_x"]["random_walk"] ** 2
    np.testing.assert_allclose(compared.ratio[1:], expected[1:], rtol=1e-9)


def test_the_figure_says_what_is_what(log):
    model = NoiseModel.read("m.toml")
    figure = psd(log).plot(model=model)
    shown = [ax for ax in figure.axes if "degC" not in ax.get_ylabel()]
    assert {ax.get_ylabel().split("[")[1] for ax in shown} == {"(deg/h)²/Hz]", "(µg)²/Hz]"}
    assert [curve_unit(allan(log)[name], None)[1] for name in ("gyro_x", "accel_x")] == ["deg/h", "µg"]
    for ax in shown:
        texts = [text.get_text() for text in ax.get_legend().get_texts()]
        assert any("1/f²" in text for text in texts)
        assert ("gyro_x: model without sinusoid at 5 Hz" in texts) == ("deg" in ax.get_ylabel())
