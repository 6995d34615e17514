"""Files for stated values, and for a sensor beside running motors against the same at rest."""

import json
import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest

import vio
from known import seed_of
from sigmatau import Analysis, ChannelModel, NoiseModel, Sinusoid, analyze, list_datasheets, simulate
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.inflation import inflation
from sigmatau.exporting.source import Sample, Source
from sigmatau.exporting.stated import HORIZON, prepare_stated
from sigmatau.exporting.targets import NAMES
from sigmatau.io.write import write
from sigmatau.noise.terms import BIAS_LEVEL

COMPLETE = [name for name, sheet in list_datasheets().items() if {c.sensor for c in sheet.claims} >= {"gyro", "accel"}]


def written(model, to="kalibr", **choices):
    return prepare_stated(model, to=to, choices=Choices(filter_rate=200.0, **choices), origins=["from a sheet"]).content


@pytest.mark.parametrize("name", ["bmi088", "stim300", "ism330dhcx", "mpu6050"])
@pytest.mark.parametrize("to", NAMES)
def test_every_target_has_a_complete_file_of_a_datasheet(name, to, tmp_path, capsys):
    assert name in COMPLETE
    argv = ["export", "--from-datasheet", name, "--to", to, "--filter-rate", "200", "-o", str(tmp_path / "out")]
    assert main(argv) == 0, capsys.readouterr().err
    text = (tmp_path / "out").read_text()
    assert "from the datasheet of" in text or to == "state-space"
    if to in vio.YAMLS:
        assert min(vio.keys_of(to, vio.parse(text))) > 0


def test_a_stated_bias_instability_has_a_consistent_walk():
    """Without one K²T/3 is the Allan variance of the random walk at the horizon; a chosen walk is kept."""
    n, b = 1e-4, 2e-5
    both = {"random_walk": n, "bias_instability": b}
    model = NoiseModel(channels={"gyro_x": both, "accel_x": {"random_walk": n}})
    measured = NoiseModel(channels={"gyro_x": both, "accel_x": both})
    for horizon in (HORIZON, 60.0):
        choices = {} if horizon == HORIZON else {"horizon": horizon}
        text = written(model, **choices)
        walks = vio.parse(text)
        of_model = vio.parse(export(measured, to="kalibr", choices=Choices(filter_rate=200.0, **choices)))
        assert walks["gyroscope_random_walk"] == of_model["gyroscope_random_walk"]
        assert walks["accelerometer_random_walk"] == pytest.approx(math.sqrt(3) * n / horizon, rel=1e-12)
        assert text.count(f"not stated; with the Allan variance at {horizon:g} s") == 1
    chosen = written(model, walk={"gyro": 1e-5, "accel": 2e-5})
    assert vio.parse(chosen)["gyroscope_random_walk"] == 1e-5
    assert "not stated" not in chosen


@pytest.mark.parametrize("name", ["bmi088", "stim300"])  # without and with a bias instability
def test_the_horizon_of_the_command_line(name, capsys):
    walks = []
    for horizon in ("10s", "40s"):
        assert (
            main(["export", "--from-datasheet", name, "--to", "kalibr", "--filter-rate", "200", "--horizon", horizon])
            == 0
        )
        walks.append(vio.parse(capsys.readouterr().out)["gyroscope_random_walk"])
    if name == "bmi088":
        assert walks[0] / walks[1] == pytest.approx(4, rel=1e-12)
    else:
        assert 1 < walks[0] / walks[1] < 2  # flicker noise that is matched at one time has K·√T
    assert main(["export", "--from-datasheet", name, "--to", "ros", "--filter-rate", "200", "--horizon", "10s"]) == 2
    assert "--horizon does not apply to ros" in capsys.readouterr().err


def test_a_process_is_matched_where_the_stated_bias_instability_is():
    n, b = 1e-4, 2e-5
    both = {"random_walk": n, "bias_instability": b}
    text = written(NoiseModel(channels={"gyro_x": both, "accel_x": both}), to="gnss-ins-sim")
    place = (n / (BIAS_LEVEL * b)) ** 2
    assert f"exact at the horizon, {place:.3g} s" in text


def test_an_unstated_density_is_warned_about(capsys):
    argv = ["export", "--from-datasheet", "bmi088", "--to", "model"]
    assert main(argv) == 0
    two, err = capsys.readouterr()
    assert err.startswith("warning: BMI088: the datasheet does not state")
    assert err.endswith("--sided one\n")
    assert main([*argv, "--sided", "one"]) == 0
    one, err = capsys.readouterr()
    assert err == ""
    models = [NoiseModel.from_dict(tomllib.loads(text)) for text in (two, one)]
    noise = [model["gyro_x"]["random_walk"] for model in models]
    assert noise[0] / noise[1] == pytest.approx(math.sqrt(2), rel=1e-12)
    assert main(["export", "--from-datasheet", "stim300", "--to", "model"]) == 0  # states random walks
    assert capsys.readouterr().err == ""
    assert main(["export", "imu.toml", "--to", "kalibr", "--sided", "one"]) == 2
    assert "--sided needs --from-datasheet" in capsys.readouterr().err


@pytest.fixture(scope="module")
def records():
    """The same gyro at rest, and with three times the random walk and a line."""
    rng = np.random.default_rng(seed_of("inflation"))
    at_rest, running = (
        simulate(NoiseModel(channels={"gyro_x": {"random_walk": n}}), duration=100.0, rate=100.0, rng=rng)
        for n in (1e-3, 3e-3)
    )
    return at_rest, running


def test_factors_by_coefficient(records):
    """Of what both records show, with an interval; in the file beside the numbers."""
    sources = [analyze(record).to_source() for record in records]
    found = {one.term: one for one in inflation(*sources).factors}
    assert found["random_walk"].low < 3 < found["random_walk"].high
    assert found["sample"].value == pytest.approx(3, rel=4 * math.sqrt(1 / 10_000))
    assert found["rate_random_walk"].text == "not observed"
    first, second = (
        Source.of_model(NoiseModel(channels={"gyro_x": m})) for m in ({"random_walk": 1.0}, {"random_walk": 4.0})
    )
    assert inflation(first, second).factors[0].text == "x 4.0"


def test_coverage_of_a_factor():
    """The interval of a quotient of two estimates holds the true one in 95 %, within 3 standard errors."""
    rng = np.random.default_rng(seed_of("inflation: coverage"))
    covered, runs = 0, 2000
    for sizes in np.exp(rng.standard_normal((runs, 2)) * (0.02, 0.05)) * (1e-4, 3e-4):
        first, second = (
            Source.of_model(
                NoiseModel(
                    channels={
                        "gyro_x": ChannelModel(
                            terms={"random_walk": n},
                            intervals={"random_walk": (n * math.exp(-1.96 * error), n * math.exp(1.96 * error))},
                            duration=100.0,
                        )
                    }
                )
            )
            for n, error in zip(sizes, (0.02, 0.05), strict=True)
        )
        factor = inflation(first, second).factors[0]
        covered += factor.low < 3 < factor.high
    assert abs(covered / runs - 0.95) < 3 * math.sqrt(0.95 * 0.05 / runs)


REST = ChannelModel(terms={"random_walk": 1e-4, "bias_instability": 1e-5})


@pytest.mark.parametrize(
    ("running", "cause", "words"),
    [
        ({"random_walk": 3e-4}, "white vibration", "multiply N by 3"),
        ({"rate_random_walk": 1e-5, "random_walk": 1e-4}, None, "not a reason to inflate"),
        ({"random_walk": 1.05e-4}, None, "not a reason to inflate"),
        ({"random_walk": 1e-4, "bias_instability": 4e-5}, "slow noise", "multiply K by 4"),
        ({"random_walk": 3e-5}, "smaller", "3.3 times smaller with motors on: are the files swapped?"),
    ],
)
def test_causes(running, cause, words):
    sources = [Source.of_model(NoiseModel(channels={"gyro_x": model})) for model in (REST, ChannelModel(terms=running))]
    factors = inflation(*sources)
    assert [each.cause for each in factors.causes] == ([cause] if cause else [])
    assert words in factors.statements()[0]
    assert words in " ".join(repr(factors).split())


def test_lines_are_not_white():
    """A new line makes the noise of a sample; one of the record at rest is not named."""
    hum, motor = Sinusoid(amplitude=1e-3, frequency=50.0), Sinusoid(amplitude=1e-2, frequency=13.0)
    sources = [
        replace(
            Source.of_model(NoiseModel(channels={"gyro_x": replace(REST, sinusoid=lines)})),
            samples={"gyro_x": Sample(variance=variance, time=1.0)},
        )
        for lines, variance in (((hum,), 1e-6), ((hum, motor), 51e-6))
    ]
    (cause,) = inflation(*sources).causes
    assert (cause.cause, cause.frequency) == ("lines", 13.0)
    assert cause.factor.value == pytest.approx(math.sqrt(51))


def test_the_command(records, tmp_path, capsys):
    names = ("rest", "running")
    for name, record in zip(names, records, strict=True):
        write(record, tmp_path / f"{name}.csv")
        assert main(["analyze", str(tmp_path / f"{name}.csv"), "--json", str(tmp_path / f"{name}.json"), "-q"]) == 0
    files = [str(tmp_path / f"{name}.json") for name in names]
    capsys.readouterr()
    assert main(["export", "--inflate", *files]) == 2
    assert "sigmatau tune --rest" in capsys.readouterr().err
    assert main(["tune", "--rest", *files, "--json", str(tmp_path / "t.json")]) == 0
    out, err = capsys.readouterr()
    assert " x 3" in next(line for line in out.splitlines() if line.startswith("gyro_x"))
    assert "--to TARGET --noise-factor gyro=3" in err
    assert json.loads((tmp_path / "t.json").read_text())["causes"][0]["cause"] == "white vibration"
    for wrong, words in (
        ([files[1]], "--rest rest.json"),
        (["--rest", *files, "--noise", "gyro=1"], "--noise applies to innovations"),
        (["--rest", files[0], str(tmp_path / "running.csv")], "running.csv --at-rest --json running.json"),
    ):
        assert main(["tune", *wrong]) == 2
        assert words in capsys.readouterr().err
    assert main(["tune", "--rest", *reversed(files)]) == 0
    assert "times smaller with motors on: are the files swapped?" in " ".join(capsys.readouterr().out.split())
    assert main(["export", "--inflate", *files, "--to", "ieee952"]) == 0
    out, err = capsys.readouterr()
    assert "swapped" not in err
    assert "inflated: the sensor of rest.json with running motors" in out
    assert "gyro_x over the record at rest: random walk x 3" in out


def test_the_topic_and_the_length_of_the_log_are_in_the_file():
    record = simulate(
        NoiseModel(channels={"gyro_x": {"random_walk": 1e-3}, "accel_x": {"random_walk": 1e-3}}),
        duration=60.0, rate=100.0, rng=seed_of("origin"),
    )  # fmt: skip
    content = analyze(record).to_dict()
    content["source"] |= {"path": "/home/me/night.bag", "topics": ["/bmi088/imu"]}
    content["findings"].append(
        {"code": "spikes", "severity": "warning", "channels": ["gyro_x"], "message": "9 spikes", "size": 1.0}
    )
    text = export(Analysis.from_dict(content).to_source(), to="kalibr")
    assert vio.parse(text)["rostopic"] == "/bmi088/imu"
    assert "# from night.bag, topic /bmi088/imu, 60 s at 100 Hz, analysed by sigmatau" in text
    assert "# warning: gyro_x: 9 spikes\n" in text
    chosen = export(Analysis.from_dict(content).to_source(), to="kalibr", choices=Choices(names={"topic": "/other"}))
    assert vio.parse(chosen)["rostopic"] == "/other"
    for topics in (["/a", "/b"], ["sensor_combined"]):
        content["source"]["topics"] = topics
        assert vio.parse(export(Analysis.from_dict(content).to_source(), to="kalibr"))["rostopic"] == "/imu0"


@pytest.mark.as_written
def test_numbers_have_four_digits():
    model = NoiseModel(
        channels={s: {"random_walk": 1.23456e-3, "rate_random_walk": 9.87654e-6} for s in ("gyro", "accel")}
    )
    content = vio.parse(export(model, to="kalibr", choices=Choices(filter_rate=199.98765)))
    assert (content["gyroscope_noise_density"], content["gyroscope_random_walk"]) == (1.235e-3, 9.877e-6)
    assert content["update_rate"] == 199.98765
    record = simulate(model, duration=30.0, rate=199.9987, rng=seed_of("digits"))
    assert vio.parse(export(analyze(record), to="kalibr"))["update_rate"] == 200.0
