"""Datasheets: what is refused and how it is said, the library, models of them."""

import math
import tomllib

import numpy as np
import pytest

from sigmatau import DataError, OptionError, datasheet, list_datasheets
from sigmatau.lab.datasheets.claims import KEYS
from sigmatau.lab.datasheets.sheet import Datasheet
from sigmatau.model.noise_model import NoiseModel
from sigmatau.noise.terms import BIAS_LEVEL
from sigmatau.simulation.in_memory import simulate

DEG = math.radians(1)
HEAD = 'name = "N"\nmaker = "M"\nsource = "S"\n'


def sheet(text):
    return Datasheet.from_dict(tomllib.loads(HEAD + text))


class TestLibrary:
    def test_there_are_fifteen_and_the_papers_three(self):
        library = list_datasheets()
        densities = [
            key
            for key, one in library.items()
            if any(claim.term == "random_walk" for claim in one.claims) and key not in ("cimu", "hg1700", "motionpak2")
        ]
        assert len(densities) >= 15
        assert {"cimu", "hg1700", "motionpak2"} <= set(library)

    @pytest.mark.parametrize("key", list_datasheets())
    def test_each_says_where_it_is_from(self, key):
        one = list_datasheets()[key]
        assert one.source
        assert "http" in one.confirmed or "doi" in one.confirmed or "public repository" in one.confirmed
        assert "memory" not in one.confirmed
        assert one.name in repr(one)
        assert one.confirmed in repr(one)
        assert datasheet(key) is one is datasheet(one.name)

    # Typed off the sources again, in units that the files do not use.
    @pytest.mark.parametrize(
        ("key", "channel", "of", "typical", "maximum"),
        [
            ("icm42688p", "gyro_x", "noise_density", 0.0028 * DEG, None),
            ("mpu6050", "accel_y", "noise_density", 400e-6 * 9.80665, None),
            ("ism330dhcx", "accel_z", "noise_density", 60e-6 * 9.80665, 100e-6 * 9.80665),
            ("adis16470", "gyro_z", "bias_instability", 8 * DEG / 3600, None),
            ("hg1700-brochure", "accel_x", "random_walk", None, 0.065 * 0.3048 / 60),
            ("stim300", "gyro_x", "random_walk", 0.15 * DEG / 60, None),
            ("adis16405", "gyro_z", "random_walk", 2 * DEG / 60, None),
            ("adis16405", "accel_x", "random_walk", 0.2 / 60, None),
            ("adis16405", "accel_x", "bias_instability", 0.2e-3 * 9.80665, None),
            ("bmi055", "gyro_x", "noise_density", 0.014 * DEG, None),
            ("bmi055", "accel_x", "noise_density", 150e-6 * 9.80665, None),
            ("bmi088", "accel_y", "noise_density", 160e-6 * 9.80665, None),
            ("bmi088", "accel_z", "noise_density", 190e-6 * 9.80665, None),
            ("lsm6dso", "gyro_y", "noise_density", 0.0038 * DEG, None),
            ("lsm6dso", "accel_y", "noise_density", 70e-6 * 9.80665, None),
            ("vn100", "gyro_x", "noise_density", 0.0035 * DEG, None),
            ("vn100", "accel_z", "noise_density", 140e-6 * 9.80665, None),
        ],
    )
    def test_values(self, key, channel, of, typical, maximum):
        claim = next(claim for claim in datasheet(key).of(channel) if claim.key == of)
        for got, expected in ((claim.typical, typical), (claim.maximum, maximum)):
            assert got == (None if expected is None else pytest.approx(expected, rel=1e-12))

    def test_sidedness_that_a_sheet_betrays(self):
        """Own random walks that are densities over √2, and an rms that is a density over a one-sided band."""
        density, walk, _ = sorted(datasheet("ism330dhcx").of("gyro_x"), key=lambda claim: list(KEYS).index(claim.key))
        assert density.typical * math.sqrt(0.5) == pytest.approx(walk.typical, rel=0.02)  # 0.21 has two digits
        assert density.convention == "one"
        (density,) = datasheet("mpu6050").of("gyro_x")
        assert density.typical * math.sqrt(100) == pytest.approx(0.05 * DEG)
        assert density.convention == "one"
        density, walk = (c for c in datasheet("adis16405").of("gyro_x") if c.term == "random_walk")
        assert abs(density.typical * math.sqrt(0.5) / walk.typical - 1) < 0.1 < density.typical / walk.typical - 1
        assert density.convention == "one"

    def test_an_unknown_name_lists_those_there_are(self):
        with pytest.raises(OptionError, match=r"unknown datasheet 'nonesuch'; known: adis16405, .*\.toml"):
            datasheet("nonesuch")
        for hostile in ("", "../../etc/passwd", "\x00", "[/]", 300 * "x"):
            with pytest.raises(OptionError, match="unknown datasheet"):
                datasheet(hostile)

    def test_a_name_without_its_ending(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        (tmp_path / "spec.toml").touch()
        with pytest.raises(OptionError, match=r"unknown datasheet 'spec'; is the file spec\.toml meant\?"):
            datasheet("spec")

    def test_it_prints_itself_as_a_table(self):
        lines = repr(list_datasheets()).splitlines()
        assert len(lines) == len(list_datasheets())
        assert "mpu6050           MPU-6050 (InvenSense), MEMS, consumer" in lines
        with pytest.raises(OptionError, match=r"`datasheet` must be a name of the library or the path .* not None"):
            datasheet(None)


class TestModel:
    def test_a_model_has_the_sheets_numbers(self):
        model = datasheet("ism330dhcx").model(sided="one", bias="minimum")
        assert set(model.channels) == {f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"}
        gyro = model.channels["gyro_y"]
        assert gyro["random_walk"] == pytest.approx(0.21 * DEG / 60)  # before the density
        assert gyro["bias_instability"] == pytest.approx(3 * DEG / 3600 / BIAS_LEVEL)
        assert model.channels["accel_x"]["random_walk"] == pytest.approx(60e-6 * 9.80665 / math.sqrt(2))
        worst = datasheet("ism330dhcx").model(sided="two", bias="coefficient", use="maximum")
        assert worst.channels["accel_x"]["random_walk"] == pytest.approx(100e-6 * 9.80665)
        assert worst.channels["gyro_x"]["bias_instability"] == pytest.approx(3 * DEG / 3600)
        assert NoiseModel.from_dict(tomllib.loads(model.to_toml())) == model

    def test_it_can_be_simulated(self):
        """100 Hz of white noise of a density 0.0028 deg/s/√Hz, one-sided, that is 0.0028·√50 deg/s rms."""
        record = simulate(datasheet("icm42688p").model(sided="one"), duration=100.0, rate=100.0, rng=7)
        rms = np.std(record.stream_of("gyro_x").column("gyro_x"))
        assert rms == pytest.approx(0.0028 * math.sqrt(50) * DEG, rel=4 / math.sqrt(2 * 10_000))

    def test_what_the_sheet_leaves_open_is_asked_for(self):
        with pytest.raises(OptionError, match=r"ICM-42688-P: gyro: .*noise density.*`sided` one or two") as error:
            datasheet("icm42688p").model()
        assert error.value.option == "sided"
        with pytest.raises(OptionError, match="`bias` minimum or coefficient"):
            datasheet("stim300").model()
        with pytest.raises(OptionError, match="`sided`"):
            datasheet("stim300").model(sided="both")
        with pytest.raises(OptionError, match="`use`"):
            datasheet("stim300").model(use="best")
        with pytest.raises(DataError, match="no noise specification"):
            datasheet("motionpak2").model()

    def test_an_axis_has_its_own(self):
        one = sheet(
            '[accel]\nrandom_walk = {maximum = "1 m/s/sqrt(h)"}\nbias_instability = {typical = "1 mg", as = "coefficient"}\n'
            '[accel_z]\nrandom_walk = {maximum = "2 m/s/sqrt(h)"}\n'
        )
        x, z = one.model().channels["accel_x"], one.model().channels["accel_z"]
        assert z["random_walk"] == pytest.approx(2 * x["random_walk"])
        assert z["bias_instability"] == x["bias_instability"]


REFUSED = {
    '[gyro]\nnoise_density = {typical = "1 deg/s/sqrt(Hz)"}': 'gyro: noise_density needs one of sided = "one".*√2',
    '[gyro]\nnoise_density = {typical = "1 deg/s/sqrt(Hz)", sided = ["one"]}': "gyro: noise_density needs one of",
    '[gyro]\nbias_instability = {maximum = "1 deg/h"}': (
        'gyro: bias_instability needs one of .*0.664.*write e.g. bias_instability = .*, as = "minimum" }'
    ),
    '[gyro]\nrandom_walk = {typical = "1 deg/sqrt(h)", sided = "one"}': "gyro: random_walk: unknown key 'sided'",
    '[gyro]\nrandom_walk = "1 deg/sqrt(h)"': "gyro: random_walk = '1 deg/sqrt\\(h\\)'; write e.g.",
    "[gyro]\nrandom_walk = {}": "gyro: random_walk has neither typical nor maximum",
    "[gyro]\nrandom_walk = {typical = 1}": "gyro: typical of random_walk = 1 is not text",
    '[gyro]\nrandom_walk = {typical = "1"}': "gyro: typical of random_walk '1': want a value with its unit",
    '[gyro]\nrandom_walk = {typical = "1 m/s/sqrt(h)"}': "gyro: typical of random_walk: the unit .* does not fit",
    '[gyro]\nrandom_walk = {typical = "-1 deg/sqrt(h)"}': "gyro: typical of random_walk must be positive",
    '[gyro]\nrandom_walk = {typical = "1e999 deg/sqrt(h)"}': "gyro: typical of random_walk .1e999 .* more than a double",
    '[gyro]\nrandom_walk = {maximum = "1e300 deg/sqrt(h)"}': r"gyro: maximum of random_walk must be from 1e-100 to 1e\+100",
    '[gyro]\nrandom_walk = {maximum = "1e-300 deg/sqrt(h)"}': "gyro: maximum of random_walk must be from 1e-100",
    '[gyro]\nrandom_walk = {typical = "2 deg/sqrt(h)", maximum = "1 deg/sqrt(h)"}': "gyro: random_walk: typical 2 .* above",
    '[gyro]\narw = {typical = "1 deg/sqrt(h)"}': "gyro: unknown key 'arw'; keys: noise_density",
    '[gyro]\nfull_scale = "2 deg/s"': "gyro: full_scale = '2 deg/s'; write a list",
    '[gyro]\nfull_scale = ["2 g"]': "gyro: value of full_scale: the unit 'g' does not fit",
    '[gyro]\nbeside_noise = ["a\\nb"]': "gyro: beside_noise must be one line",
    '[gyro]\nbandwidth = ["9 Hz to 5 Hz"]': "gyro: bandwidth: '9 Hz to 5 Hz' is not a range",
    '[gyro]\nbandwidth = ["5 Hz to"]': "gyro: value of bandwidth",
    "[magnetometer]\nx = 1": "unknown key 'magnetometer'; a datasheet has name",
    "gyro = 3": "gyro = 3; write a table",
    "gyro = []": "gyro = \\[\\]; write a table",
}


class TestRefusals:
    @pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
    def test_sensor_and_key_are_named(self, text, tmp_path):
        path = tmp_path / "spec.toml"
        path.write_text(HEAD + text, encoding="utf-8")
        with pytest.raises(DataError, match=f"^{path}: {REFUSED[text]}"):
            datasheet(path)

    @pytest.mark.parametrize("name", ["", " ", "\x1b[2J", "a\u202eb", "x" * 500, "\u2028"], ids=range(6))
    def test_a_name_is_a_line_that_prints(self, name):
        with pytest.raises(DataError, match="name must be one line"):
            Datasheet.from_dict({"name": name, "maker": "M", "source": "S"})

    @pytest.mark.parametrize(
        "content", [b"\xff\xfe", b"a = ", b"\x00", b"x = " + b"[" * 5000, b"#" * (1 << 21)], ids=range(5)
    )
    def test_files_that_are_none(self, content, tmp_path):
        path = tmp_path / "spec.toml"
        path.write_bytes(content)
        with pytest.raises(DataError, match=f"^{path}: not a "):
            datasheet(path)

    def test_a_missing_file(self, tmp_path):
        with pytest.raises(DataError, match=r"none\.toml: No such file"):
            datasheet(str(tmp_path / "none.toml"))
        with pytest.raises(DataError, match="maker, source are missing"):
            Datasheet.from_dict({"name": "N"})


def test_to_dict_is_plain():
    import json

    for one in list_datasheets().values():
        content = json.loads(json.dumps(one.to_dict(), allow_nan=False))
        assert content["name"] == one.name
        assert len(content["claims"]) == len(one.claims)


def test_the_stim300s_gyro_says_what_its_maker_says():
    """sensonor.com, FAQ: "Bias instability [°/h] is found as lowest point of curve"; not of accelerometers."""
    conventions = {c.sensor: c.convention for c in datasheet("stim300").claims if c.key == "bias_instability"}
    assert conventions == {"gyro": "minimum", "accel": "unknown"}


class TestAxes:
    def test_are_three_by_default_and_those_of_the_sheet_else(self):
        text = 'random_walk = { typical = "0.3 deg/sqrt(h)" }'
        assert sheet(f"[gyro]\n{text}").channels("gyro") == ("gyro_x", "gyro_y", "gyro_z")
        one = sheet(f'[gyro]\naxes = ["z", "x"]\n{text}')
        assert one.channels("gyro") == ("gyro_x", "gyro_z")
        assert one.channels("accel") == ()
        assert tuple(one.model().channels) == ("gyro_x", "gyro_z")
        assert one.to_dict()["axes"] == {"gyro": ["x", "z"]}
        assert repr(one).splitlines()[-1].split() == ["gyro", "axes", "x,", "z"]

    @pytest.mark.parametrize("axes", ["[]", '"x"', "3", '["w"]', '["x", "x"]', "[1]", "[[]]"])
    def test_that_are_none(self, axes):
        with pytest.raises(DataError, match=r"gyro: axes = .*list the axes of a unit"):
            sheet(f"[gyro]\naxes = {axes}")

    def test_leave_out_none_that_has_claims(self):
        with pytest.raises(DataError, match=r"gyro: axes = \['x'\] contradicts \[gyro_z\]"):
            sheet('[gyro]\naxes = ["x"]\n[gyro_z]\nrandom_walk = { typical = "0.3 deg/sqrt(h)" }')

    def test_are_those_of_a_sensor_not_of_an_axis(self):
        with pytest.raises(DataError, match="gyro_x: unknown key 'axes'"):
            sheet('[gyro_x]\naxes = ["x"]')
