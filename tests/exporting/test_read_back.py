"""Models from Kalibr's and imu_utils' YAML: in SI, and with what is wrong with them said."""

import numpy as np
import pytest
from ruamel.yaml import YAML

from sigmatau import DataError, NoiseModel, OptionError
from sigmatau.analysis.inputs import read_source
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.rates import filter_rate
from sigmatau.exporting.source import common_rate, read_yaml
from vio import IMU_UTILS, KALIBR


def test_kalibr():
    back = read_yaml(KALIBR)
    assert back.model == NoiseModel(
        channels={
            "gyro": {"random_walk": 1.87e-4, "rate_random_walk": 2.66e-5},
            "accel": {"random_walk": 1.86e-3, "rate_random_walk": 4.33e-4},
        }
    )
    assert set(back.rates.values()) == {200.0}
    assert [finding.code for finding in back.findings] == ["imported_without_intervals"]
    assert set(read_yaml(KALIBR, rate=100.0).rates.values()) == {100.0}


@pytest.mark.parametrize("name", ["kalibr", "openvins", "euroc"])
def test_what_we_write_reads_back(name):
    model = NoiseModel(channels={s: {"random_walk": 1e-4 / 3, "rate_random_walk": 1e-6 / 7} for s in ("gyro", "accel")})
    back = read_yaml(export(model, to=name, choices=Choices(filter_rate=217.3)))
    assert (back.model, set(back.rates.values())) == (model, {217.3})


def test_imu_utils():
    back = read_yaml(IMU_UTILS, rate=400.0)
    expected = {f"gyro_{a}": {"random_walk": v * 1e-3 / 20} for a, v in zip("xyz", (1, 2, 3), strict=True)}
    expected |= {f"accel_{a}": {"random_walk": v * 1e-2 / 20} for a, v in zip("xyz", (1, 2, 3), strict=True)}
    assert list(back.model.channels) == list(expected)
    for name, terms in expected.items():
        assert dict(back.model.channels[name].terms) == pytest.approx(terms, rel=1e-12)  # no walk among them
    assert [(f.code, f.severity) for f in back.findings] == [
        ("deviation_as_density", "warning"),
        ("minimum_as_walk", "warning"),
    ]
    assert (back.findings[0].size, back.findings[0].details.rate) == (20.0, 400.0)
    assert back.findings[1].details.keys == ("gyr_w", "acc_w")


def test_imu_utils_without_axes():
    text = "Gyr:\n   avg-axis:\n      gyr_n: 2.0e-03\n"
    back = read_yaml(text, rate=100.0)
    assert dict(back.model.channels["gyro"].terms) == pytest.approx({"random_walk": 2e-4}, rel=1e-12)
    assert [finding.code for finding in back.findings] == ["deviation_as_density"]


def test_imu_utils_needs_the_rate():
    with pytest.raises(OptionError, match="`rate`") as refused:
        read_yaml(IMU_UTILS)
    assert refused.value.option == "rate"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "not an imu.yaml of Kalibr"),
        ("a: 1\n- b\n", "not an imu.yaml of Kalibr"),
        ("{gyroscope_noise_density: 1e-4}", "not an imu.yaml of Kalibr"),
        (KALIBR.replace("1.87e-04", "0.0"), "gyroscope_noise_density: '0.0' is not a positive number"),
        (KALIBR.replace("1.87e-04", "-1.0"), "is not a positive number"),
        (KALIBR.replace("1.87e-04", ".nan"), "is not a positive number"),
        (KALIBR.replace("1.87e-04", "1e999"), "is not a positive number"),
        (KALIBR.replace("1.87e-04", "*anchor"), "is not a positive number"),
        (KALIBR + "update_rate: 100\n", "update_rate is a duplicate key"),
        (KALIBR.replace("200.0", "fast"), "update_rate: 'fast'"),
        (f"imu0:\n  {KALIBR}imu1:\n  gyroscope_noise_density: 1e-4\n", "several IMUs|is a duplicate key"),
        ("imu0: {gyroscope_noise_density: 1e-4, update_rate: 200}\n", "other YAML is not read; anchors and {…}"),
        ("a: &a\n  x: 1\nimu0:\n  <<: *a\n  gyroscope_noise_density: 1e-4\n", "; anchors and {…} are not supported"),
        ("imu0:\n  gyroscope_noise_density: 1e-4\nimu1:\n  gyroscope_noise_density: 1e-4\n", r"\(imu0, imu1\)"),
    ],
)
def test_refusals(text, message):
    with pytest.raises(DataError, match=message):
        read_yaml(text)


def test_parts_of_yaml_that_are_passed_over():
    text = "\ufeff" + KALIBR.replace("\n", "\r\n") + "T_i_b:\r\n  - [1.0, 0.0]\r\n  data: [1, 2,\r\n    3]\r\n"
    assert read_yaml(text).model == read_yaml(KALIBR).model
    quoted = KALIBR.replace("gyroscope_noise_density", '"gyroscope_noise_density"')
    assert read_yaml(quoted).model == read_yaml(KALIBR).model


@pytest.mark.parametrize(
    "legal",
    [
        "gyroscope_noise_density:\t1.87e-04",
        "gyroscope_noise_density :  \t 1.87e-04",
        "gyroscope_noise_density:\n  1.87e-04",
        "gyroscope_noise_density:   # in what follows\n\n     1.87e-04 # here",
        "gyroscope_noise_density: !!float 1.87e-04",
        "gyroscope_noise_density: &n 1.87e-04",
        "gyroscope_noise_density: 187.0e-06",
        "gyroscope_noise_density: .000187",
    ],
)
def test_scalars_as_yaml_reads_them(legal):
    text = KALIBR.replace("gyroscope_noise_density:     1.87e-04", legal)
    if "\t" not in legal:  # which the standard allows there, and this reader does not
        assert float(YAML(typ="safe").load(text)["gyroscope_noise_density"]) == 1.87e-4
    assert read_yaml(text).model == read_yaml(KALIBR).model


def test_what_stands_in_a_text_is_no_key():
    text = KALIBR + "comment: |\n  gyroscope_noise_density: 5\n  as in 2020\n"
    assert read_yaml(text).model == read_yaml(KALIBR).model
    with pytest.raises(DataError, match=r"'1.87e-04 2' is not a positive number"):
        read_yaml(KALIBR.replace("1.87e-04", "1.87e-04\n  2"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "gyroscope_noise_density",
            "Gyroscope_noise_density",
            "missing gyroscope_noise_density: .*; 'Gyroscope_noise_density': did you mean gyroscope_noise_density?",
        ),
        ("gyroscope_random_walk", "gyro_random_walk", "'gyro_random_walk': did you mean gyroscope_random_walk?"),
        ("update_rate", "updat_rate", "'updat_rate': did you mean update_rate?"),
        ("gyroscope_random_walk:  ", "# ", "^missing gyroscope_random_walk: all four densities are needed$"),
        ("gyroscope_random_walk:       ", "gyroscope_random_walk:", "missing gyroscope_random_walk"),
        (
            "_",
            "-",
            "not an imu.yaml of Kalibr.*; 'accelerometer-noise-density': did you mean accelerometer_noise_density?",
        ),
    ],
)
def test_keys_that_are_nearly_right(old, new, message):
    with pytest.raises(DataError, match=message):
        read_yaml(KALIBR.replace(old, new))


def test_keys_that_are_not_read_are_said():
    back = read_yaml(KALIBR + "temperature: 25\nserial: 7\n")
    assert [finding.code for finding in back.findings] == ["imported_without_intervals", "keys_not_read"]
    assert back.findings[1].details.keys == ("temperature", "serial")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("Gyr:", "Gyro:", r"Gyro\.unit: unknown key; 'Gyro': did you mean Gyr\?"),
        ("z-axis", "Z-axis", "'Z-axis': did you mean z-axis?"),
        ("gyr_n", "gyr_N", "'gyr_N': did you mean gyr_n?"),
        ("gyr_n", "drift", r"drift: unknown key; known keys: gyr_n, gyr_w"),
        (" rad/s", "rad", "Gyr.unit: 'rad' is not a unit of Gyr"),
        (" m/s^2", "deg/s", "Acc.unit: 'deg/s' is not a unit of Acc"),
        (" rad/s", "turns/s", "Gyr.unit: unknown unit"),
    ],
)
def test_imu_utils_with_keys_and_units_that_are_not_its_own(old, new, message):
    with pytest.raises(DataError, match=message):
        read_yaml(IMU_UTILS.replace(old, new), rate=400.0)


def test_the_unit_of_imu_utils_is_that_of_its_numbers():
    text = IMU_UTILS.replace('" rad/s"', '" deg/s"').replace('" m/s^2"', "g")
    plain, other = (read_yaml(given, rate=400.0).model.channels for given in (IMU_UTILS, text))
    assert other["gyro_y"]["random_walk"] == pytest.approx(np.radians(plain["gyro_y"]["random_walk"]), rel=1e-12)
    assert other["accel_y"]["random_walk"] == pytest.approx(9.80665 * plain["accel_y"]["random_walk"], rel=1e-12)


class TestSource:
    def test_yaml(self, tmp_path):
        path = tmp_path / "imu.yml"
        path.write_text(KALIBR)
        source = read_source(path)
        assert source.model == read_yaml(KALIBR).model
        assert common_rate(source.rates) == 200.0
        for content in (b"\xff\xfe", b"a: 1"):
            path.write_bytes(content)
            with pytest.raises(DataError, match=r"imu\.yml: "):
                read_source(path)
        with pytest.raises(DataError, match=r"no\.yaml: No such file"):
            read_source(tmp_path / "no.yaml")

    def test_the_common_rate(self):
        assert common_rate({"gyro_x": 100.0, "accel_x": 100.05, "strain": 7.0}) == 100.0
        assert common_rate({}) is None
        several = {"gyro_x": 100.0, "accel_x": 101.0}
        assert common_rate(several) is None
        with pytest.raises(OptionError, match=r"gyro 100 Hz, accel 101 Hz.*`filter_rate`"):
            filter_rate(several, Choices())


def test_from_yaml_to_another_file(tmp_path, capsys):
    path = tmp_path / "old.yaml"
    path.write_text(IMU_UTILS)
    assert main(["export", str(path), "--to", "model"]) == 2
    assert "old.yaml: gyr_n and acc_n of imu_utils" in capsys.readouterr().err
    assert main(["export", str(path), "--to", "model", "--rate", "400", "-o", str(tmp_path / "imu.toml")]) == 0
    err = capsys.readouterr().err
    assert "warning: gyr_n and acc_n are standard deviations of a sample" in err
    assert "not read: a minimum of the Allan deviation" in err
    model = NoiseModel.read(tmp_path / "imu.toml")
    np.testing.assert_allclose(model.channels["gyro_z"]["random_walk"], 1.5e-4, rtol=1e-12)
    path.write_text(KALIBR)
    assert main(["export", str(path), "--to", "orb-slam3", "-q"]) == 0
    out, err = capsys.readouterr()
    assert "IMU.Frequency: 200.0" in out
    assert err == ""


@pytest.mark.parametrize("source", ["imu.toml", "--from-datasheet"])
def test_the_sampling_rate_is_not_that_of_a_filter(source, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}}).write("imu.toml")
    argv = ["export", source, *(["bmi088"] if source.startswith("--") else []), "--to", "vins", "--rate", "200"]
    assert main(argv) == 2
    assert (
        "--rate is the sampling rate of a log; the rate of the filter is --filter-rate 200" in capsys.readouterr().err
    )
