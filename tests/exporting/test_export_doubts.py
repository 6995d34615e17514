"""What a file must not be silent about, and errors that lead to something that works."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from known import seed_of
from sigmatau import Analysis, DataError, NoiseModel, OptionError, Record, analyze
from sigmatau.analysis.inputs import read_model, read_source
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export, place_choices, prepare, prepare_placed
from sigmatau.exporting.source import Source
from sigmatau.exporting.targets import NAMES, target
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import NOT_ADEQUATE, ONLY_LIMITS

FIVE = {"random_walk": 1e-4, "bias_instability": 5e-5, "rate_random_walk": 1e-6}
NO_K = {"random_walk": 1e-4, "bias_instability": 5e-5}
ACCEL = {"quantity": "acceleration", "unit": "m/s^2"}


def model_of(gyro, accel=None, **more):
    """Three axes of each, with what a fit knows beside its coefficients."""
    channels = {f"gyro_{a}": ChannelModel(terms=gyro, **more) for a in "xyz"}
    channels |= {f"accel_{a}": ChannelModel(terms=accel or gyro, **ACCEL, **more) for a in "xyz"}
    return NoiseModel(channels=channels)


def with_one(model, name, **changes):
    return NoiseModel(channels=dict(model.channels) | {name: replace(model.channels[name], **changes)})


@pytest.mark.parametrize("name", NAMES)
def test_every_target_says_that_a_fit_is_not_adequate(name):
    good = model_of(FIVE)
    worse = {term: 2 * value for term, value in FIVE.items()}
    bad = with_one(good, "gyro_y", adequate=False, terms=worse)
    observed = {"gyro": "observed", "accel": "observed"}
    choices = Choices(filter_rate=100.0, walk=observed if target(name).has_walk else {})
    assert NOT_ADEQUATE not in export(good, to=name, choices=choices)
    judged = {"pair_consistency"} if target(name).has_walk or name == "kf-gins" else set()
    assert {f.code for f in prepare(good, to=name, choices=choices).findings} == judged
    found = prepare(bad, to=name, choices=choices)
    assert NOT_ADEQUATE in found.content
    assert {(f.code, f.severity) for f in found.findings if f.code not in judged} == {("not_adequate", "warning")}
    assert found.findings[0].channels == ("gyro_y",)


@pytest.mark.parametrize("name", NAMES)
def test_every_target_says_that_a_hidden_random_walk_is_an_upper_limit(name):
    limits = {term: 2 * value for term, value in FIVE.items()}
    hidden = {"random_walk": limits["random_walk"]}
    bad = with_one(model_of(FIVE), "gyro_y", adequate=False, terms=hidden, limits=limits)
    found, refused = None, ""
    try:
        found = prepare(bad, to=name, choices=Choices(filter_rate=100.0))
    except OptionError as error:  # of a process that needs slow noise
        refused = str(error)
    if found is None:
        assert "gyro_y" in refused
        return
    assert NOT_ADEQUATE not in found.content
    assert ONLY_LIMITS in found.content or "upper limit" in found.content
    (doubt,) = [one for one in found.findings if one.severity == "warning"]
    assert (doubt.code, doubt.channels) == ("only_limits", ("gyro_y",))


def test_a_model_file_carries_it_both_ways(tmp_path):
    bad = with_one(model_of(FIVE), "gyro_y", adequate=False)
    bad.write(tmp_path / "m.toml")
    back = NoiseModel.read(tmp_path / "m.toml")
    assert [name for name, channel in back.items() if not channel.adequate] == ["gyro_y"]
    assert (tmp_path / "m.toml").read_text().count(NOT_ADEQUATE) == len(FIVE)
    with pytest.raises(DataError, match="true or false"):
        NoiseModel.from_dict({"channels": {"gyro_x": {"random_walk": "1 deg/sqrt(h)", "adequate": "no"}}})


@pytest.mark.parametrize("name", ["kf-gins", "gazebo", "gnss-ins-sim"])
def test_a_chosen_walk_does_not_hide_what_was_observed(name):
    model = model_of(NO_K, limits={"rate_random_walk": 1e-6})
    walk = {"gyro": "upper-limit", "accel": "horizon"}
    found = prepare(model, to=name, choices=Choices(walk=walk, horizon=10.0, filter_rate=100.0))
    assert "omitted for the chosen random walk: gyro_x bias instability 10.31 deg/h; gyro_y" in found.content
    assert "accel_x bias" not in found.content
    (finding,) = found.findings
    assert (finding.code, finding.severity) == ("slow_noise_left_out", "warning")
    assert finding.channels == ("gyro_x", "gyro_y", "gyro_z")
    assert [(one.term, one.value) for one in finding.details.omitted] == [("bias_instability", 5e-5)] * 3
    both = Choices(walk={"gyro": "horizon", "accel": "horizon"}, horizon=10.0, filter_rate=100.0)
    assert prepare(model, to=name, choices=both).findings == ()


@pytest.fixture
def result(tmp_path):
    """A result of the form that analyze writes, at 50 Hz, with a filter found and a fit that is not adequate."""

    def term(value):
        return {"observed": True, "value": value, "level": 0.95, "unit": ""}

    def channel(quantity, unit, verdict):
        fit = {
            "verdict": verdict,
            "model": {"random_walk": 1e-3, "bias_instability": 1e-4},
            "terms": {
                "random_walk": term(1e-3),
                "bias_instability": term(1e-4),
                "gauss_markov": [],
                "sinusoid": [],
            },
        }
        curve = {"m": [1, 2], "adev": [5e-3, 4e-3], "unit": unit}
        return {"quantity": quantity, "sample_rate_hz": 50.0, "samples": 1000, "curve": curve, "fit": fit}

    content = {
        "findings": [{"code": "low_pass_filter", "channel": "gyro_x", "size": 12.0}],
        "channels": {
            "gyro_x": channel("angular_rate", "rad/s", "adequate"),
            "accel_x": channel("acceleration", "m/s^2", "descriptive"),
        },
    }
    path = tmp_path / "sim.json"
    path.write_text(json.dumps(content))
    return path


class TestOfAResult:
    def test_it_knows_its_rate(self, result):
        assert all(channel.rate == 50.0 for channel in read_model(result).values())
        walk = {"gyro": 1e-6, "accel": 1e-6}
        for given in (read_source(result), read_model(result)):
            assert "update_rate: 50.0 " in export(given, to="kalibr", choices=Choices(walk=walk))
            assert json.loads(export(given, to="state-space"))["systems"]["gyro_x"]["dt_s"] == 0.02
            assert "fractalcoef(3000)" in export(given, to="matlab", choices=Choices(horizon=60.0))

    def test_another_rate_is_said(self, result, capsys):
        assert main(["export", str(result), "--to", "ros", "--filter-rate", "200"]) == 0
        assert "# written for 200 Hz; the sampling rate of the record is 50 Hz\n" in capsys.readouterr().out

    def test_a_filter_is_said(self, result):
        found = prepare(read_source(result), to="ros")
        assert "without the low-pass filter of 12 Hz that the analysis found" in found.content
        assert {f.code for f in found.findings} == {"correlated_samples", "not_adequate"}
        details = next(f.details for f in found.findings if f.code == "correlated_samples")
        assert (details.corner, details.ratio) == (12.0, None)
        assert details.independent_variance == pytest.approx(1e-6 * 50.0)

    def test_the_sheet_says_why_there_is_no_value(self, result):
        sheet = export(read_source(result), to="ieee952")
        gyro, accel, foot = sheet.split("\n\n")[2:]
        assert gyro.count("unknown") == 3
        assert len(re.findall("no model fits(?! this axis)", accel)) == 3
        assert accel.count(NOT_ADEQUATE) == 3  # B in two units
        assert foot.startswith("No interval: ")
        assert "not in the model" in export(model_of(NO_K), to="ieee952")

    def test_a_warning_at_the_terminal(self, result, capsys):
        assert main(["export", str(result), "--to", "model"]) == 0
        out, err = capsys.readouterr()
        assert "warning: accel_x: no model fits" in err
        assert "adequate = false" in out

    def test_onto_itself(self, result, capsys):
        assert main(["export", str(result), "--to", "model", "-o", str(result)]) == 2
        assert "is the file that is read" in capsys.readouterr().err


def test_several_targets_at_once(tmp_path):
    model = model_of(NO_K, limits={"rate_random_walk": 1e-6}, rate=100.0)
    choices = Choices(walk={"gyro": "upper-limit", "accel": "upper-limit"}, horizon=60.0, consistent="bias")
    files = {"kalibr": tmp_path / "a", "kf-gins": tmp_path / "b", "ros": tmp_path / "c"}
    placed = place_choices(model, files, choices)
    made = [prepare_placed(model, to=name, path=path, placed=placed[name]) for name, path in files.items()]
    assert [file.to for file in made] == list(files)
    (details,) = (f.details for f in made[1].findings if f.code == "choice_without_place")
    assert (details.target, details.option, details.key) == ("kf-gins", "consistent", "")
    assert made[1].content == export(model, to="kf-gins", choices=replace(choices, consistent="horizon"))
    with pytest.raises(OptionError, match="`step` does not apply to kalibr"):
        place_choices(model, ["kalibr", "ros"], replace(choices, step=0.1))
    with pytest.raises(OptionError, match="upper limit"):
        prepare_placed(model_of(NO_K, rate=100.0), to="kalibr", path=files["kalibr"], placed=placed["kalibr"])
    assert list(tmp_path.iterdir()) == []


class TestAdvice:
    def test_only_what_works_is_proposed(self):
        quiet = model_of({"random_walk": 1e-4})
        with pytest.raises(OptionError) as refused:
            export(quiet, to="lio-sam")
        assert "upper-limit" not in str(refused.value)
        assert "horizon" not in str(refused.value)
        assert str(refused.value).count("random walk observed") == 2  # both sensors at once
        for walk in ("horizon", "upper-limit"):
            with pytest.raises(OptionError) as refused:
                export(
                    quiet,
                    to="lio-sam",
                    choices=Choices(walk={"gyro": walk, "accel": walk}, horizon=9.0 if walk == "horizon" else None),
                )
            assert "horizon" not in str(refused.value).replace("at a horizon", "")
            assert "upper-limit" not in str(refused.value)
        export(
            quiet,
            to="lio-sam",
            choices=Choices(
                walk={s: "1e-6 " + u for s, u in (("gyro", "rad/s^2/sqrt(Hz)"), ("accel", "m/s^3/sqrt(Hz)"))}
            ),
        )

    def test_axes_are_named(self):
        model = with_one(with_one(model_of(FIVE), "gyro_x", terms=NO_K), "gyro_z", terms=NO_K)
        with pytest.raises(OptionError, match=r"^gyro_x, gyro_z: no rate random walk observed"):
            export(model, to="gtsam", choices=Choices(axes="each", strict=True))
        model = with_one(model_of(NO_K), "gyro_z", terms={"random_walk": 1e-4})
        horizon = {"walk": {"gyro": "horizon", "accel": "horizon"}, "horizon": 9.0}
        assert "worst of 2 axes, gyro_x: " in export(model, to="gtsam", choices=Choices(**horizon))
        assert "no slow noise in the model of gyro_z" in export(model, to="gtsam", choices=Choices(**horizon))
        with pytest.raises(OptionError, match=r"^gyro_z: .*`axes=.worst.`"):
            export(model, to="gtsam", choices=Choices(axes="each", **horizon))

    @pytest.mark.parametrize(
        ("more", "message"),
        [
            (
                ["--rate-random-walk", "gyro=1e-6 rad/s/sqrt(s)", "accel=upper-limit"],
                "no upper limit of the acceleration",
            ),
            (["b.json"], "once for each"),
            (["--rate-random-walk", "gyros=upper-limit"], "--rate-random-walk: unknown sensor 'gyros'"),
            (["--step", "3"], "--step does not apply to kalibr"),
            (["--strict"], "--rate-random-walk gyro=horizon with --horizon 10s"),
        ],
    )
    def test_on_the_command_line(self, more, message, tmp_path, capsys):
        model_of(NO_K).write(tmp_path / "m.toml")
        assert main(["export", str(tmp_path / "m.toml"), "--to", "Kalibr", "--filter-rate", "100", *more]) == 2
        err = capsys.readouterr().err
        assert message in err
        assert "`" not in err


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"walk": "upper-limit"}, "walk"),
        ({"filter_rate": "100"}, "filter_rate"),
        ({"horizon": "10s"}, "horizon"),
        ({"noise_factor": "2"}, "noise_factor"),
        ({"noise_factor": None}, "noise_factor"),
        ({"walk": {"gyro": None}}, "walk"),
        ({"names": {"topic": 1}}, "names"),
        ({"step": True}, "step"),
    ],
)
def test_choices_of_a_wrong_kind(given, name):
    with pytest.raises(OptionError, match=f"`{name}`"):
        Choices(**given)


def test_arguments_of_a_wrong_kind(tmp_path):
    for given in ("sim.json", tmp_path, 3, None):
        with pytest.raises(OptionError, match="`model` must be"):
            export(given, to="gtsam")
    with pytest.raises(OptionError, match="`choices` must be"):
        export(model_of(FIVE), to="gtsam", choices={"rate": 100})
    with pytest.raises(OptionError, match="`to` must be"):
        export(model_of(FIVE), to=3)
    assert export(model_of(FIVE), to="GTSAM") == export(Source.of_model(model_of(FIVE)), to="gtsam")
    assert Choices(filter_rate=np.float64(100.0)).filter_rate == 100.0


def test_a_factor_that_multiplies_nothing_is_refused():
    for name in ("matlab", "state-space"):
        with pytest.raises(OptionError, match="`walk_factor` does not apply"):
            export(model_of({"random_walk": 1e-4}), to=name, choices=Choices(walk_factor=2.0, filter_rate=100.0))


def test_times_beyond_what_a_program_can_do():
    with pytest.raises(OptionError, match="8640000 poles"):
        export(model_of(FIVE), to="matlab", choices=Choices(filter_rate=100.0, horizon=86400.0))
    for name in ("px4", "ardupilot"):
        with pytest.raises(OptionError, match=r"`step=0\.004`"):
            export(model_of(FIVE), to=name, choices=Choices(step=4.0))


def test_a_topic_is_carried_over(tmp_path):
    path = tmp_path / "imu.yaml"
    export(model_of(FIVE), to="kalibr", path=path, choices=Choices(filter_rate=100.0, names={"topic": "/my/imu"}))
    assert 'rostopic: "/my/imu"' in export(read_source(path), to="kalibr")


def test_a_spectrum_without_a_corner():
    """A finding of an uneven spectrum has no size; the result is exported all the same."""
    content = analyze(Record.from_arrays(rate=100, gyro_x=np.random.default_rng(1).standard_normal(4096))).to_dict()
    details = {"shape": "uneven", "order": None, "corner": None, "low": None, "high": None}
    content["findings"] = [{"code": "low_pass_filter", "severity": "info", "channels": ["gyro_x"], "details": details}]
    assert Analysis.from_dict(content).to_source().corners == {}


def test_axes_that_are_not_to_be_used_are_named_in_file_and_finding():
    """Accelerations in g taken as m/s² twice over: the mean tells, and every coefficient is wrong by 9.8."""
    rng = np.random.default_rng(seed_of("poor trust"))
    gyro, *accel = rng.normal(size=(4, 20_000)) * np.array([1e-3, 1e-2, 1e-2, 1e-2])[:, None]
    axes = {"accel_x": accel[0], "accel_y": accel[1], "accel_z": accel[2] + 9.80665**2}
    analysis = analyze(Record.from_arrays(rate=100, gyro_x=gyro, **axes))
    assert [one["trust"] for one in analysis.to_dict()["channels"].values()] == ["good", *["poor"] * 3]
    prepared = prepare(analysis, to="kalibr")
    assert "# trust: gyro good, accel poor\n" in prepared.content
    (finding,) = (one for one in prepared.findings if one.code == "poor_trust")
    assert (finding.severity, finding.channels) == ("warning", tuple(axes))
    good = prepare(replace(analysis.to_source(), poor=()), to="kalibr")
    assert "poor_trust" not in [one.code for one in good.findings]


class TestFilterRate:
    """Sensors of different rates: a field for one rate has the highest, and discrete numbers need a choice."""

    @pytest.fixture
    def two_rates(self):
        channels = dict.fromkeys(("gyro_x", "accel_x"), FIVE)
        return Source(model=NoiseModel(channels=channels), rates={"gyro_x": 399.66, "accel_x": 199.83})

    @pytest.mark.parametrize("name", ["kalibr", "openvins", "euroc", "orb-slam3"])
    def test_a_field_has_the_highest(self, two_rates, name):
        found = prepare(two_rates, to=name)
        assert "399.7" in found.content
        (finding,) = [f for f in found.findings if f.code == "fastest_rate"]
        assert dict(finding.details.rates) == {"gyro": 399.66, "accel": 199.83}
        assert "highest of the sensors" in found.content
        chosen = prepare(two_rates, to=name, choices=Choices(filter_rate=200.0))
        assert "200" in chosen.content
        assert not [f for f in chosen.findings if f.code == "fastest_rate"]

    @pytest.mark.parametrize("name", ["vins", "fast-lio", "ros", "gazebo"])
    def test_discrete_numbers_need_a_choice(self, two_rates, name):
        horizon = {"horizon": 10.0} if name == "gazebo" else {}
        with pytest.raises(OptionError, match=r"gyro 399.66 Hz, accel 199.83 Hz\): give `filter_rate`"):
            export(two_rates, to=name, choices=Choices(**horizon))
        assert export(two_rates, to=name, choices=Choices(filter_rate=400.0, **horizon))

    def test_the_rate_of_a_log_is_refused(self):
        with pytest.raises(OptionError, match=r"`rate` is the sampling rate of a log; .* `filter_rate=200`"):
            Choices(rate=200)
