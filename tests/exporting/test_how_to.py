"""The pages of docs/how-to: no target is without a page, and the index is right; tests/docs runs their commands."""

import math
import os
import re
import shlex
from itertools import pairwise

import numpy as np
import pytest

import vio
from conftest import ROOT
from known import seed_of
from sigmatau import NoiseModel, simulate
from sigmatau.cli import main
from sigmatau.exporting.choices import Choices
from sigmatau.exporting.export import export
from sigmatau.exporting.targets import NAMES, target
from sigmatau.io.write import write
from sigmatau.navigation.reference_filter import AIDING, FilterModel, TrueNoise, find_consistent_walk, judge_filter

pytestmark = pytest.mark.as_written

HOW_TO = ROOT / "docs" / "how-to"
INDEX = (HOW_TO / "README.md").read_text(encoding="utf-8")
OURS = (*vio.YAMLS, "gtsam", "basalt")  # files with N and K alone
OTHERS = tuple(name for name in NAMES if name not in (*OURS, "model"))


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A result, and the model of the index."""
    folder = tmp_path_factory.mktemp("how-to")
    (folder / "imu.toml").write_text(blocks(INDEX, "toml")[0])
    mems = {"random_walk": 1e-4, "bias_instability": 3e-5, "rate_random_walk": 2e-6}
    model = NoiseModel(channels={f"{s}_{a}": mems for s in ("gyro", "accel") for a in "xyz"})
    write(simulate(model, duration=60.0, rate=100.0, rng=seed_of("how to")), folder / "static.csv")
    assert main(["analyze", str(folder / "static.csv"), "--json", str(folder / "result.json"), "-q"]) == 0
    return folder


@pytest.mark.parametrize("name", [*OURS, *OTHERS])
def test_page_of_a_target(name):
    """From what a reader has who has installed the package and read the index: a log of a MEMS unit, and a model."""
    page = (HOW_TO / f"{name}.md").read_text(encoding="utf-8")
    commands = [shlex.split(line) for block in blocks(page, "sh") for line in block.splitlines()]
    assert commands[0][:4] == ["sigmatau", "analyze", "static.csv", "--export"]
    assert commands[0][4].startswith(f"{name}=")
    assert {argv[argv.index("--to") + 1] for argv in commands[1:]} == {name}
    assert "## Differences from other" in page
    shown = re.findall(r"^<!-- file: (\S+) -->\n```(?:yaml|python-file|text)\n", page, flags=re.MULTILINE)
    assert shown == [commands[-1][commands[-1].index("-o") + 1]] * (name != "state-space")


@pytest.mark.parametrize("name", [*OURS, *OTHERS])
def test_a_file_of_a_log_says_so(name, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    output = folder / f"log-{name}{target(name).ending or '.json'}"
    assert main(["export", "result.json", "--to", name, "-o", str(output), "-q"]) == 0, capsys.readouterr().err
    text = output.read_text(encoding="utf-8")
    assert output.suffix == ".json" or "from static.csv, 60 s at 100 Hz, analysed by sigmatau" in text
    if name in vio.YAMLS:
        values = vio.keys_of(name, vio.parse(text))
        assert len(values) == 4
        assert min(values) > 0


def index_rows(names):
    """Rows of a table of the index: program, page, and what the target declares."""
    rows = [(target(name).program, f"[{name}]({name}.md)", *target(name).columns) for name in names]
    if names == OURS:
        rows = [(*row, "yes" if target(name).needs_rate else "no") for row, name in zip(rows, names, strict=True)]
    return "".join(f"| {' | '.join(row)} |\n" for row in sorted(rows, key=lambda row: row[0].lower()))


@pytest.mark.parametrize("names", [OURS, OTHERS], ids=["noise and walk", "more"])
def test_the_tables_of_the_index_are_those_of_the_targets(names):
    """``UPDATE_WORDS=1`` writes them."""
    table = re.compile(rf"(?<=\|\n)(?:\| [^|\n]+ \| \[(?:{'|'.join(NAMES)})\][^\n]+\n)+")
    written = next(rows[0] for rows in table.finditer(INDEX) if any(f"[{name}](" in rows[0] for name in names))
    if os.environ.get("UPDATE_WORDS"):
        page = HOW_TO / "README.md"
        page.write_text(page.read_text(encoding="utf-8").replace(written, index_rows(names)), encoding="utf-8")
    else:
        assert written == index_rows(names)


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
        rate = ["--filter-rate", "100"] * ("--filter-rate" in needs)

        def run(model, *more, name=name, ending=ending):
            return main(["export", model, "--to", name, "-o", f"out-{name}{ending}", "-q", *more])

        assert run("imu.toml", *rate) == 0, capsys.readouterr().err
        assert (run("imu.toml") == 0) == (not rate), name
        assert (run("no-bottom.toml", *rate) != 0) == ("--horizon" in needs), name
        if "--horizon" in needs:
            assert "--horizon" in capsys.readouterr().err
            assert run("no-bottom.toml", *rate, "--horizon", "60s") == 0


def test_the_table_of_the_index(folder):
    """Its formulas are those of the files: N and K of the model in each, by the words of the table."""
    model = NoiseModel.read(folder / "imu.toml")
    n = {
        s: max(c["random_walk"] for name, c in model.channels.items() if name.startswith(s)) for s in ("accel", "gyro")
    }
    kalibr = vio.parse(export(model, to="kalibr", choices=Choices(filter_rate=200.0)))  # whose K is continuous
    k = {"accel": kalibr["accelerometer_random_walk"], "gyro": kalibr["gyroscope_random_walk"]}
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
        assert (rate == "yes") == target(name).needs_rate
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


def test_the_table_of_factors():
    """docs/how-to/inflate.md: what a filter states with multiples of the exported pair, with flicker noise and vibration."""
    page = (ROOT / "docs" / "how-to" / "inflate.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| ([^|]*(?:pair|K|N)) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, flags=re.MULTILINE)
    assert len(rows) == 8
    noise, flicker = 0.3 * math.radians(1) / 60, math.radians(10) / 3600
    aiding = AIDING["gyro"]
    truth = TrueNoise(terms={"random_walk": noise, "bias_instability": flicker})
    walk = find_consistent_walk(truth, noise=noise, aiding=aiding, horizon=60.0).walk
    exported = None
    for words, *numbers in rows:
        on_n, on_k = (float((re.search(rf"(\d+) {letter}\b", words) or ["", "1"])[1]) for letter in "NK")
        terms = truth.terms | {"random_walk": 3 * noise if "vibration" in words else noise}
        judged = judge_filter(
            [TrueNoise(terms=terms)], FilterModel(noise=on_n * noise, walk=on_k * walk), aiding=aiding, times=[60.0]
        )
        (error,) = judged.coasting
        exported = exported or error.real
        assert [float(n) for n in numbers] == pytest.approx(
            [judged.nees, error.ratio, error.real / exported], abs=5.1e-3
        ), words
