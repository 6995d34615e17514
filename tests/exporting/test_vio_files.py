"""Files for VIO and LIO read back by a parser that is not ours, and in SI by each target's own rule: the model again."""

import numpy as np
import pytest

import vio
from sigmatau import DataError, NoiseModel, OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export, prepare
from sigmatau.exporting.targets import target
from sigmatau.model.channel import ChannelModel
from sigmatau.model.processes import GaussMarkov

RATE = 217.3
N = {"gyro": (1.1e-4, 3.7e-4, 2.9e-4), "accel": (1.3e-3, 0.9e-3, 2.2e-3)}
K = {"gyro": (3.1e-6, 1.7e-6, 2.9e-6), "accel": (3.3e-5, 8.9e-5, 2.2e-5)}
MODEL = NoiseModel(
    channels={
        f"{s}_{a}": {"random_walk": N[s][i], "rate_random_walk": K[s][i], "bias_instability": 1e-5}
        for s in N
        for i, a in enumerate("xyz")
    }
)


OBSERVED = {"gyro": "observed", "accel": "observed"}


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("version", ["1.1", "1.2"])
@pytest.mark.parametrize(("axes", "one"), [("worst", max), ("mean", rms)])
@pytest.mark.parametrize("name", vio.YAMLS)
def test_numbers_are_the_models(name, axes, one, version):
    text = export(MODEL, to=name, choices=Choices(filter_rate=RATE, axes=axes, walk=OBSERVED))
    got = vio.in_si(name, vio.keys_of(name, vio.parse(text, version)), RATE)
    expected = [one(N["accel"]), one(N["gyro"]), one(K["accel"]), one(K["gyro"])]
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize("name", vio.YAMLS)
def test_factors_stand_apart_from_the_estimate(name):
    text = export(MODEL, to=name, choices=Choices(filter_rate=RATE, noise_factor=2.0, walk_factor=10.0, walk=OBSERVED))
    got = vio.in_si(name, vio.keys_of(name, vio.parse(text)), RATE)
    expected = [2 * max(N["accel"]), 2 * max(N["gyro"]), 10 * max(K["accel"]), 10 * max(K["gyro"])]
    np.testing.assert_allclose(got, expected, rtol=1e-12, atol=0)
    for estimate, factor in [(max(N["gyro"]), 2), (max(K["accel"]), 10)]:
        assert f"= {estimate!r}, times {factor}\n" in text


@pytest.mark.parametrize("scale", [1e-30, 1.0, 1e30])
@pytest.mark.parametrize("name", vio.YAMLS)
def test_numbers_of_any_size_are_numbers(name, scale):
    model = NoiseModel(
        channels={s: {"random_walk": scale * 3e-4, "rate_random_walk": scale * 7e-6} for s in ("gyro", "accel")}
    )
    for version in ("1.1", "1.2"):
        content = vio.parse(export(model, to=name, choices=Choices(filter_rate=200.0)), version)
        got = vio.in_si(name, vio.keys_of(name, content), 200.0)
        np.testing.assert_allclose(got, [scale * 3e-4] * 2 + [scale * 7e-6] * 2, rtol=1e-12, atol=0)


@pytest.mark.parametrize("axes", ["worst", "each"])
def test_gtsam(axes, monkeypatch):
    made = vio.gtsam_params(export(MODEL, to="gtsam", choices=Choices(axes=axes, walk=OBSERVED)), monkeypatch)
    for key, of in [
        ("AccelerometerCovariance", N["accel"]),
        ("GyroscopeCovariance", N["gyro"]),
        ("BiasAccCovariance", K["accel"]),
        ("BiasOmegaCovariance", K["gyro"]),
    ]:
        expected = np.square(of) if axes == "each" else np.full(3, max(of) ** 2)
        np.testing.assert_allclose(made.set[key], np.diag(expected), rtol=1e-12, atol=0)
    assert made.gravity == 9.80665
    np.testing.assert_array_equal(made.set["IntegrationCovariance"], 1e-8 * np.eye(3))
    np.testing.assert_array_equal(made.set["BiasAccOmegaInit"], np.zeros((6, 6)))


def test_gtsam_of_an_axis_that_the_model_lacks(monkeypatch):
    text = export(MODEL.of(["gyro_x", "gyro_z", "accel_y"]), to="gtsam", choices=Choices(axes="each"))
    made = vio.gtsam_params(text, monkeypatch)
    x, _, z = N["gyro"]
    np.testing.assert_allclose(np.diag(made.set["GyroscopeCovariance"]), np.square([x, max(x, z), z]), rtol=1e-12)
    assert "y: not in the model" in text


def test_what_else_the_files_hold():
    given = Choices(filter_rate=RATE, names={"topic": "/my/imu", "gravity": "9.79"})
    assert vio.parse(export(MODEL, to="vins", choices=given))["imu_topic"] == "/my/imu"
    assert vio.parse(export(MODEL, to="vins", choices=given))["g_norm"] == 9.79
    lio = vio.parse(export(MODEL, to="lio-sam", choices=given))["lio_sam"]
    assert (lio["imuTopic"], lio["imuGravity"]) == ("/my/imu", 9.79)
    plain = Choices(filter_rate=RATE)
    kalibr = vio.parse(export(MODEL, to="kalibr", choices=plain))
    assert (kalibr["rostopic"], kalibr["update_rate"]) == ("/imu0", RATE)
    # ORB-SLAM3 stops at a whole number.
    assert type(vio.parse(export(MODEL, to="orb-slam3", choices=Choices(filter_rate=200)))["IMU.Frequency"]) is float


def test_model_file_reads_back_to_the_same_bits(tmp_path):
    export(MODEL, to="model", path=tmp_path / "imu.toml")
    assert NoiseModel.read(tmp_path / "imu.toml") == MODEL
    with pytest.raises(OptionError, match="what was found"):
        export(MODEL, to="model", choices=Choices(noise_factor=2.0))


@pytest.mark.parametrize("name", vio.YAMLS)
def test_no_file_without_what_it_needs(name):
    flat = {"random_walk": 1e-4}
    model = NoiseModel(channels={"gyro_x": flat, "accel_x": flat})
    with pytest.raises(OptionError, match="`walk="):
        export(model, to=name, choices=Choices(filter_rate=200.0))
    if target(name).needs_rate:
        with pytest.raises(OptionError, match="rate of the filter"):
            export(MODEL, to=name)
    with pytest.raises(OptionError, match="each"):
        export(MODEL, to=name, choices=Choices(filter_rate=200.0, axes="each"))
    with pytest.raises(DataError, match="no accelerometers"):
        export(MODEL.of(["gyro_x"]), to=name, choices=Choices(filter_rate=200.0))
    with pytest.raises(OptionError, match="no name 'tpoic'"):
        export(MODEL, to=name, choices=Choices(filter_rate=200.0, names={"tpoic": "/imu"}))


@pytest.mark.parametrize("name", [*vio.YAMLS, "gtsam"])
def test_what_has_no_place_is_said(name):
    """Once for each sensor, and not what a walk stands for."""
    gyro = {"random_walk": 1e-4, "rate_random_walk": 1e-6, "bias_instability": 1e-5, "quantization": 1e-6}
    accel = ChannelModel(
        terms={"random_walk": 1e-3, "rate_random_walk": 1e-5},
        gauss_markov=(GaussMarkov(sigma=1e-4, time=9.0),),
        quantity="acceleration",
        unit="m/s^2",
    )
    model = NoiseModel(channels={"gyro_x": gyro, "gyro_y": gyro, "accel_x": accel})
    text = export(model, to=name, choices=Choices(filter_rate=200.0))
    assert text.count("no field for quantization of the gyros; omitted.\n") == 1
    assert text.count(" N and K: a filter states ") == 2
    assert "of the accelerometers; omitted" not in text
    text = export(
        model, to=name, choices=Choices(filter_rate=200.0, walk={"gyro": "horizon", "accel": "horizon"}, horizon=5.0)
    )
    assert "no field for quantization of the gyros; omitted.\n" in text
    assert text.count(" N and K: a filter states ") == 2
    bare = {s: {"random_walk": 1e-4, "rate_random_walk": 1e-6} for s in ("gyro", "accel")}
    assert "omitted" not in export(NoiseModel(channels=bare), to=name, choices=Choices(filter_rate=200.0))


class TestWalk:
    """What stands in the place of a rate random walk that was not observed."""

    def model(self, *, limits=(2e-6, 5e-6, 3e-6), observed=()):
        channels = {}
        for i, axis in enumerate("xyz"):
            terms = {"random_walk": 1e-4} | ({"rate_random_walk": 1e-6} if axis in observed else {})
            limit = {} if axis in observed or limits[i] is None else {"rate_random_walk": limits[i]}
            channels[f"gyro_{axis}"] = ChannelModel(terms=terms, limits=limit)
        return NoiseModel(channels=channels | {"accel": {"random_walk": 1e-3, "rate_random_walk": 1e-5}})

    def walk(self, model, **choices):
        text = export(model, to="kalibr", choices=Choices(filter_rate=200.0, **choices))
        return vio.parse(text)["gyroscope_random_walk"], text

    def test_upper_limit(self):
        value, text = self.walk(self.model(), walk={"gyro": "upper-limit"})
        assert value == 5e-6
        assert "gyro_y: not observed; its upper limit (95 %)" in text

    def test_limits_of_the_axes_that_show_none(self):
        value, _ = self.walk(self.model(observed="x"), walk={"gyro": "upper-limit"})
        assert value == 5e-6
        with pytest.raises(OptionError, match=r"^gyro_y, gyro_z: no rate random walk observed") as refused:
            self.walk(self.model(observed="x"), strict=True)
        assert "worst" not in str(refused.value)
        mean, _ = self.walk(self.model(observed="x"), axes="mean", walk={"gyro": "upper-limit"})
        assert mean == pytest.approx(np.sqrt(np.mean(np.square([1e-6, 5e-6, 3e-6]))), rel=1e-12)

    @pytest.mark.parametrize(("unobserved", "share"), [("upper-limit", 1.0), ("mean", 3**-0.5)])
    def test_what_was_not_observed_counts_by_its_policy(self, unobserved, share):
        """A walk alone, by its policy, is the walk of the filter; the file and the finding say what was assumed."""
        prepared = prepare(self.model(), to="kalibr", choices=Choices(filter_rate=200.0, unobserved=unobserved))
        assert vio.parse(prepared.content)["gyroscope_random_walk"] == pytest.approx(share * 5e-6, rel=1e-3)
        where = "at their upper limits" if share == 1 else "at 1/sqrt(3) of their upper limits"
        assert prepared.content.count(f"Terms that were not observed count {where}.") == 1
        assert prepared.findings == ()  # the filter states all right
        with pytest.raises(OptionError, match=r"gyros: no rate random walk observed \(below 5.0e-06"):
            self.walk(self.model(), strict=True)

    def test_nothing_beside_n(self):
        """The least K: N alone states the error, and the file says that K makes it larger."""
        value, text = self.walk(self.model(), unobserved="absent")
        assert value == pytest.approx(0.01 * 1e-4 / 60, rel=1e-12)
        assert "the smallest K used" in text

    def test_the_walk_of_the_model(self):
        value, text = self.walk(self.model(observed="xyz"), walk={"gyro": "observed"})
        assert value == 1e-6
        assert "not used" not in text
        with pytest.raises(OptionError, match=r"^gyro_y, gyro_z: no rate random walk observed"):
            self.walk(self.model(observed="x"), walk={"gyro": "observed"})

    def test_an_overconfident_walk_is_a_warning(self):
        """The upper limit beside flicker noise; the consistent walk states its error right."""
        flicker = ChannelModel(
            terms={"random_walk": 1e-4, "bias_instability": 5e-5}, limits={"rate_random_walk": 1e-7}, level=0.9
        )
        model = NoiseModel(channels={"gyro_x": flicker, "accel": {"random_walk": 1e-3, "rate_random_walk": 1e-5}})
        for walk, severity in (("upper-limit", "warning"), ("consistent", "info")):
            choices = Choices(filter_rate=200.0, walk={"gyro": walk})
            (finding,) = prepare(model, to="kalibr", choices=choices).findings
            assert (finding.code, finding.severity, finding.details.sensor) == ("pair_consistency", severity, "gyro")
            at_horizon = finding.details.stated[1]
            assert at_horizon.time == 60.0
            assert at_horizon.share < 0.5 if walk == "upper-limit" else at_horizon.share == pytest.approx(1, abs=1e-3)
            assert finding.details.nees > 2

    def test_the_bias_can_be_right_instead(self):
        model = NoiseModel(channels={s: {"random_walk": 1e-4, "bias_instability": 5e-5} for s in ("gyro", "accel")})
        findings = prepare(model, to="kalibr", choices=Choices(filter_rate=200.0, consistent="bias")).findings
        assert [f.details.nees for f in findings] == pytest.approx([1, 1], abs=1e-3)
        assert all(f.details.stated[1].share > 1.5 for f in findings)

    def test_quantization_in_a_sample(self):
        """By 20·√2 times N·√rate, with its channels; not where it is below twice of it."""
        channels = {
            f"gyro_{axis}": {"random_walk": 1e-4, "rate_random_walk": 1e-6, "quantization": ratio * 1e-4 / 400**0.5}
            for axis, ratio in (("x", 20.0), ("y", 1.9))
        }
        model = NoiseModel(channels=channels | {"accel": {"random_walk": 1e-3, "rate_random_walk": 1e-5}})
        (finding,) = prepare(model, to="kalibr", choices=Choices(filter_rate=200.0)).findings
        assert (finding.code, finding.channels) == ("quantization_in_samples", ("gyro_x",))
        assert finding.details.ratio == pytest.approx(20.0, rel=1e-12)

    def test_no_limit_is_known(self):
        with pytest.raises(OptionError, match=r"no upper limit .* for gyro_y"):
            self.walk(self.model(limits=(1e-6, None, 1e-6)), walk={"gyro": "upper-limit"})

    def test_value(self):
        value, text = self.walk(self.model(), walk={"gyro": 4e-6}, walk_factor=3.0)
        assert value == pytest.approx(1.2e-5, rel=1e-15)
        assert "chosen value = 4.0e-06, times 3" in text

    @pytest.mark.parametrize("horizon", [1.0, 10.0])
    def test_horizon(self, horizon):
        """N and K_eff have the Allan variance of the model there: N²/T + K²T/3."""
        channel = {"random_walk": 1e-4, "bias_instability": 3e-4, "rate_random_walk": 1e-5}
        model = NoiseModel(channels={"gyro_x": channel, "accel": {"random_walk": 1e-3, "rate_random_walk": 1e-5}})
        value, text = self.walk(model, walk={"gyro": "horizon"}, horizon=horizon)
        expected = model.avar("gyro_x", m=[round(200 * horizon)], tau0=1 / 200)[0]
        assert 1e-8 / horizon + value**2 * horizon / 3 == pytest.approx(expected, rel=1e-12)
        assert f"at {horizon:g} s" in text

    def test_never_b_as_k(self):
        """A model whose only slow noise is flicker has a consistent walk, and its B stands in no file."""
        model = NoiseModel(channels={s: {"random_walk": 1e-4, "bias_instability": 0.0123} for s in ("gyro", "accel")})
        for name in (*vio.YAMLS, "gtsam", "px4", "ardupilot"):
            text = export(model, to=name, choices=Choices(filter_rate=200.0))
            assert "0.0123" not in text
            with pytest.raises(OptionError, match="choose"):
                export(model, to=name, choices=Choices(filter_rate=200.0, strict=True))


@pytest.mark.parametrize("name", [*vio.YAMLS, "gtsam"])
def test_a_choice_without_a_place_is_refused(name):
    with pytest.raises(OptionError, match=f"`step` does not apply to {name}"):
        export(MODEL, to=name, choices=Choices(filter_rate=RATE, step=0.01))


@pytest.mark.parametrize(
    "choices", [{"consistent": "bias"}, {"walk": {"gyro": "consistent"}}, {"unobserved": "absent"}]
)
def test_consistent_is_for_filters_with_n_and_k(choices):
    for name in ("kf-gins", "ros", "ieee952"):
        if name == "kf-gins" and "unobserved" in choices:
            continue  # its process is consistent too
        with pytest.raises(OptionError, match=f"does not apply to {name}"):
            export(MODEL, to=name, choices=Choices(filter_rate=RATE, **choices))


class TestNoise:
    """A random walk that quantization covers is chosen as a walk is."""

    covered = ChannelModel(
        terms={"quantization": 1e-6, "rate_random_walk": 1e-6}, limits={"random_walk": 2e-5}, level=0.9
    )
    seen = ChannelModel(terms={"random_walk": 1e-5, "rate_random_walk": 1e-6})

    def noise(self, *, seen=False, **choices):
        gyros = {"gyro_x": self.covered, "gyro_y": self.seen if seen else self.covered}
        text = export(
            NoiseModel(channels=gyros | {"accel": {"random_walk": 1e-3, "rate_random_walk": 1e-5}}),
            to="kalibr",
            choices=Choices(filter_rate=200.0, **choices),
        )
        return vio.parse(text)["gyroscope_noise_density"], text

    def test_is_never_made_up(self):
        with pytest.raises(OptionError, match=r"gyros: no angle random walk observed \(below 2.0e-05.*`noise=.*gyro"):
            self.noise(strict=True)
        assert self.noise()[0] == 2e-5

    def test_upper_limit_and_value(self):
        value, text = self.noise(seen=True, noise={"gyro": "upper-limit"})
        assert value == 2e-5
        assert "gyro_x: not observed; its upper limit (90 %)" in text
        assert self.noise(noise={"gyro": 4e-5}, noise_factor=2.0)[0] == 8e-5

    @pytest.mark.parametrize("wrong", [{"gyro": "horizon"}, {"gyro": -1.0}, {"gyro": float("nan")}, {"imu": 1.0}])
    def test_wrong_choices(self, wrong):
        with pytest.raises(OptionError, match="`noise`"):
            Choices(noise=wrong)
