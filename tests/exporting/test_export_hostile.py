"""Names that want to be more than names: what is written holds the model's numbers and nothing else."""

import ast
import functools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vio
from sigmatau import DataError, NoiseModel, OptionError
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.targets import NAMES, target

EVIL = {
    "line": "x\nrostopic: /evil",
    "carriage return": "x\rgyroscope_noise_density: 1",
    "line separators": "x\u2028rostopic: /evil\u2029y: 1\u0085z: 2",
    "vertical": "x\x0brostopic: 1\x0c\x1c\x1d\x1ey: 2",
    "nul and escape": "x\x00\x1b[31m\x07",
    "mapping": "x: y, {a: [b",
    "comment": "x # y",
    "quotes": '"\'\\" x: 1',
    "dollar": "${HOME} $(rm -rf /) `id`",
    "tag": "!!python/object/apply:os.system [id]",
    "anchor": "&a *a <<: *a",
    "document": "x\n---\n...\n%YAML 1.1",
    "markup": "</x>]]> --> <!-- ?>",
    "python": '"""\nimport os\nos.system("id")\n"""',
    "directions": "x\u202e\u2066y\ufeff",
    "surrogate": "x\U0001f4a5",
    "brace": "{numbers} {gravity} %s %n",
    "long": "x" * 100_000,
}
FLAT = {"random_walk": 3e-4, "rate_random_walk": 7e-6}
RATE = 200.0


def model_of(name):
    return NoiseModel(channels={f"gyro_{name}": FLAT, f"accel_{name}": FLAT})


@functools.cache
def plain_text(target_name):
    return export(model_of("x"), to=target_name, choices=Choices(filter_rate=RATE, axes="worst"))


@functools.cache
def plain_values(target_name, version):
    return vio.parse(plain_text(target_name), version)


def check(target_name, text, monkeypatch):
    plain = plain_text(target_name)
    assert text.isascii()
    assert all(character == "\n" or character.isprintable() for character in text)
    assert len(text.split("\n")) == len(plain.split("\n"))
    assert max(map(len, text.split("\n"))) < 2500
    if target_name == "gtsam":
        assert ast.dump(ast.parse(text)) == ast.dump(ast.parse(plain))
        made = vio.gtsam_params(text, monkeypatch)
        assert made.set["GyroscopeCovariance"][0, 0] == pytest.approx(FLAT["random_walk"] ** 2, rel=1e-12)
    else:
        for version in ("1.1", "1.2"):
            assert vio.parse(text, version) == plain_values(target_name, version)


VIO = (*vio.YAMLS, "gtsam")


# Every name for a YAML with a comment of its own and for Python; those that differ most for the others.
WORST = ("line", "line separators", "nul and escape", "quotes", "document", "python", "long")


@pytest.mark.parametrize(
    ("name", "evil"), [(name, evil) for name in VIO for evil in (EVIL if name in ("kalibr", "gtsam") else WORST)]
)
def test_channels(name, evil, monkeypatch):
    for factor in (1.0, 2.0):  # which have words of their own
        model = model_of(EVIL[evil])
        scaled = NoiseModel(channels={n: c.scaled(1 / factor) for n, c in model.channels.items()})
        check(
            name,
            export(scaled, to=name, choices=Choices(filter_rate=RATE, noise_factor=factor, walk_factor=factor)),
            monkeypatch,
        )


@settings(max_examples=20, deadline=None)
@given(name=st.text(max_size=40))
def test_channels_of_any_name(name):
    with pytest.MonkeyPatch.context() as patch:
        for target_name in ("kalibr", "openvins", "gtsam"):
            check(target_name, export(model_of(name), to=target_name, choices=Choices(filter_rate=RATE)), patch)


@pytest.mark.parametrize(
    ("name", "evil"),
    [("kalibr", evil) for evil in EVIL] + [(name, "line") for name in VIO if "topic" in target(name).names],
)
def test_topics_are_refused(name, evil):
    with pytest.raises(OptionError, match="a topic has only letters") as refused:
        export(model_of("x"), to=name, choices=Choices(filter_rate=RATE, names={"topic": EVIL[evil]}))
    assert len(str(refused.value)) < 1000


@pytest.mark.parametrize(
    "value", ["nan", "inf", "-9.8", "0", "9.8; x: 1", "9.8\ny: 1", "1e400", "", "__import__('os')"]
)
@pytest.mark.parametrize("name", ["vins", "lio-sam", "gtsam"])
def test_constants_are_numbers(name, value):
    with pytest.raises(OptionError, match=r"gravity.*positive number"):
        export(model_of("x"), to=name, choices=Choices(filter_rate=RATE, names={"gravity": value}))


def test_topics_that_yaml_reads_as_something_else():
    for topic in ("yes", "null", "0x1F", "1_000", "on", "~", "/a/b", "1e3"):
        for version in ("1.1", "1.2"):
            text = export(model_of("x"), to="kalibr", choices=Choices(filter_rate=RATE, names={"topic": topic}))
            assert vio.parse(text, version)["rostopic"] == topic


def test_paths(tmp_path, capsys, monkeypatch):
    """Of the path of the source, a file has the name, in a comment; messages have it on one line."""
    folder = tmp_path / "a\nrostopic: evil #"
    folder.mkdir()
    source = folder / "m\n'\"${x}.toml"
    model_of("x").write(source)
    for name in VIO:
        output = folder / f"{name}\n: #.out"
        assert main(["export", str(source), "--to", name, "--filter-rate", "200", "-o", str(output), "-q"]) == 0
        text = output.read_text(encoding="utf-8")
        head = next(line for line in text.split("\n") if line.startswith("# from "))
        assert head == "# from m?'\"${x}.toml"
        check(name, text.replace(f"{head}\n", ""), monkeypatch)
    assert capsys.readouterr().err == ""
    assert main(["export", str(folder / "no\nsuch.toml"), "--to", "kalibr"]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_a_model_file_with_any_name_reads_back(tmp_path):
    for evil in (*EVIL.values(), "x\x7fy", ""):
        export(model_of(evil), to="model", path=tmp_path / "m.toml")
        assert NoiseModel.read(tmp_path / "m.toml") == model_of(evil)
    with pytest.raises(DataError, match="unpaired UTF-16 surrogate"):
        export(model_of("x\ud800"), to="model")


def test_every_target_of_this_file_is_one():
    assert set(VIO) <= set(NAMES)
    assert np.unique(NAMES).size == len(NAMES)
