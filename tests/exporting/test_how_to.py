"""The pages of docs/how-to: their commands run, what they show is what is written, and no target is without a page."""

import re
import shlex
from itertools import pairwise

import numpy as np
import pytest
from test_read_back import IMU_UTILS, KALIBR

import vio
from conftest import ROOT
from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.cli import main
from sigmatau.exporting.targets import NAMES, target
from sigmatau.io.write import write

pytestmark = pytest.mark.as_written

HOW_TO = ROOT / "docs" / "how-to"
INDEX = (HOW_TO / "README.md").read_text(encoding="utf-8")
OURS = (*vio.YAMLS, "gtsam")
OTHERS = tuple(name for name in NAMES if name not in (*OURS, "model"))


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What the pages name: a result, the model of the index, and files of other programs."""
    folder = tmp_path_factory.mktemp("how-to")
    (folder / "imu.toml").write_text(blocks(INDEX, "toml")[0])
    mems = {"random_walk": 1e-4, "bias_instability": 3e-5, "rate_random_walk": 2e-6}
    model = NoiseModel(channels={f"{s}_{a}": mems for s in ("gyro", "accel") for a in "xyz"})
    write(simulate(model, duration=60.0, rate=100.0, rng=seed_of("how to")), folder / "static.csv")
    assert main(["analyze", str(folder / "static.csv"), "--json", str(folder / "result.json"), "-q"]) == 0
    (folder / "old-imu.yaml").write_text(KALIBR)
    (folder / "imu-utils.yaml").write_text(IMU_UTILS)
    return folder


def code(line):
    """What a program reads of a line: without the comment."""
    return re.split(r"\s*(?:^|\s)[#%] ", line)[0]


@pytest.mark.parametrize("name", [*OURS, *OTHERS, "reading-back"])
def test_commands_run_and_write_what_the_page_shows(name, folder, tmp_path, monkeypatch, capsys):
    """From what a reader has who has installed the package and read the index: a log of a MEMS unit, and a model."""
    for file in folder.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    monkeypatch.chdir(tmp_path)
    page = (HOW_TO / f"{name}.md").read_text(encoding="utf-8")
    commands = [line for block in blocks(page, "sh") for line in block.splitlines()]
    assert commands
    for command in commands:
        argv = shlex.split(command)
        of_log = argv[:4] == ["sigmatau", "analyze", "static.csv", "--export"]
        to, file = argv[4].split("=") if of_log else (argv[argv.index("--to") + 1], argv[argv.index("-o") + 1])
        output = tmp_path / file
        output.unlink(missing_ok=True)
        assert main(argv[1:]) == 0, capsys.readouterr().err
        assert output.exists()
        assert name == "reading-back" or to == name
        if of_log and output.suffix != ".json":
            assert "from static.csv, 60 s at 100 Hz, analysed by sigmatau" in output.read_text(encoding="utf-8")
        if of_log and name in vio.YAMLS:
            values = vio.keys_of(name, vio.parse(output.read_text(encoding="utf-8")))
            assert len(values) == 4
            assert min(values) > 0
    assert name == "reading-back" or commands[0].startswith("sigmatau analyze static.csv --export")
    if name == "reading-back":
        return
    assert "## Why the number" in page
    shown = blocks(page, "(?:yaml|python-file|text)")
    if name in OURS:
        assert shown == [output.read_text(encoding="utf-8")]  # of the last command, from the model of the index
        return
    assert len(shown) == (name != "state-space")
    for block in shown:
        rest = iter([code(line) for line in output.read_text(encoding="utf-8").splitlines()])
        for line in block.splitlines():
            assert code(line) in rest, f"{name}: {line}"  # in order; comments of XML may be between


def test_the_index_says_what_a_target_needs(folder, monkeypatch, capsys):
    """Of the second table: without what it names a target refuses, with it it writes."""
    monkeypatch.chdir(folder)
    (folder / "no-bottom.toml").write_text(re.sub(r"^rate_random_walk.*\n", "", blocks(INDEX, "toml")[0], flags=re.M))
    rows = dict(
        re.findall(r"^\| [^|]+ \| \[([a-z0-9-]+)\]\(\1\.md\) \| [^|]+ \| ((?:nothing|`--).*) \|$", INDEX, flags=re.M)
    )
    assert set(rows) == set(OTHERS)
    for name, needs in rows.items():
        ending = target(name).ending or ".json"
        rate = ["--rate", "100"] * ("--rate" in needs)

        def run(model, *more, name=name, ending=ending):
            return main(["export", model, "--to", name, "-o", f"out-{name}{ending}", "-q", *more])

        assert run("imu.toml", *rate) == 0, capsys.readouterr().err
        assert (run("imu.toml") == 0) == (not rate), name
        assert ("--horizon" in needs) == (name not in ("px4", "ardupilot", "ros", "state-space", "ieee952")), name
        if "--horizon" in needs:
            assert run("no-bottom.toml", *rate) != 0
            assert "--horizon" in capsys.readouterr().err
            assert run("no-bottom.toml", *rate, "--horizon", "60s") == 0


def test_the_table_of_the_index(folder):
    """Its formulas are those of the files: N and K of the model in each, by the words of the table."""
    model = NoiseModel.read(folder / "imu.toml")
    n = {
        s: max(c["random_walk"] for name, c in model.channels.items() if name.startswith(s)) for s in ("accel", "gyro")
    }
    k = {
        s: max(c["rate_random_walk"] for name, c in model.channels.items() if name.startswith(s))
        for s in ("accel", "gyro")
    }
    rows = re.findall(
        r"^\| [^|]+ \| \[([a-z0-9-]+)\]\(\1\.md\) \| ([^|]+) \| ([^|]+) \| (yes|no) \|$", INDEX, flags=re.M
    )
    assert {row[0] for row in rows} == set(OURS)
    forms = {
        "N": lambda v: v, "K": lambda v: v, "N²": lambda v: v**2, "K²": lambda v: v**2,
        "N·√(2f)": lambda v: v * np.sqrt(400), "K·√f": lambda v: v * np.sqrt(200),
        "N²·f": lambda v: v**2 * 200, "K²·f": lambda v: v**2 * 200,
    }  # fmt: skip
    for name, noise, walk, rate in rows:
        assert (rate == "yes") == vio.target_needs_rate(name)
        page = (HOW_TO / f"{name}.md").read_text(encoding="utf-8")
        if name == "gtsam":
            continue  # whose file holds N and K, and squares them: test_vio_files
        values = vio.keys_of(name, vio.parse(blocks(page, "yaml")[0]))
        expected = [forms[noise](n["accel"]), forms[noise](n["gyro"]), forms[walk](k["accel"]), forms[walk](k["gyro"])]
        np.testing.assert_allclose(values, expected, rtol=5e-4)  # four digits


def test_pages_lead_from_the_index():
    for page in HOW_TO.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        assert page.name == "README.md" or f"({page.name})" in INDEX, page.name
        assert "model.toml" not in text, page.name  # which nobody has: that of the index is imu.toml
        for one, other in pairwise(re.findall(r"^#+ ", text, flags=re.M)):
            assert len(other) <= len(one) + 1


def test_the_readme_names_every_target():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for name in (*OURS, *OTHERS):
        assert f"](docs/how-to/{name}.md)" in readme, name
