"""What the README claims is run: its Python, its model, its command lines; its table is the demo's real output."""

import re
import shlex
import shutil

import numpy as np
import pytest

from conftest import ROOT
from sigmatau import NoiseModel, analyze, read
from sigmatau.cli import main
from sigmatau.cli.app import EXAMPLES

README, GUIDE, MODEL = (
    (ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/guide.md", "docs/model.md")
)


def blocks(language, page=README):
    return re.findall(rf"^```{language}\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)


def commands():
    lines = [line for page in (README, GUIDE) for block in blocks("sh", page) for line in block.splitlines()]
    lines += [line for examples in EXAMPLES.values() for line in examples.splitlines()]
    every = sorted({line.split("   ")[0].strip() for line in lines if line.startswith("sigmatau ")})
    # A command that another one goes on with is run with that.
    return [line for line in every if not any(other.startswith(line + " --") for other in every)]


def test_readme_is_short():
    assert len(README.splitlines()) <= 150


def test_python(capsys):
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    assert "random walk" in capsys.readouterr().out


def test_python_of_the_model(capsys, tmp_path, monkeypatch):
    (code,) = blocks("python", MODEL)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "model.md", "exec"), {})
    out = capsys.readouterr().out
    for words in ("coherence", "|H(f)|", "linear model of", "inertial navigation at rest"):
        assert words in out
    matrices = (tmp_path / "matrices.json").read_text(encoding="utf-8")
    assert "gyro_x" in matrices
    assert "gyro_y" in matrices


def test_functions_of_the_model_page_exist():
    import sigmatau
    from sigmatau.spectrum.result import Spectrum

    rows = [row.split("|")[2] for row in MODEL.splitlines() if row.startswith("| ")][1:]
    named = {name for row in rows for name in re.findall(r"`([\w.]+)`", row)}
    assert {"psd", "cross_spectrum", "transfer", "simulate_to", "state_space", "arma", "predict", "verify"} < named
    for name in named - {"Spectrum.over"}:
        found = sigmatau
        for part in name.split("."):
            found = getattr(found, part)
        assert callable(found), name
    assert callable(Spectrum.over)


def test_the_index_of_theory_leads_to_every_page():
    theory = ROOT / "docs" / "theory"
    index = (theory / "README.md").read_text(encoding="utf-8")
    for page in {*theory.glob("*.md")} - {theory / "README.md"}:
        assert f"({page.name})" in index, page.name
    assert "(docs/theory/README.md)" in README
    assert "(docs/glossary.md)" in README


@pytest.mark.parametrize("page", sorted(ROOT.glob("docs/**/*.md")), ids=lambda page: page.stem)
def test_python_of_the_pages(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for code in re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE):
        exec(compile(code, str(page), "exec"), {})


def test_model():
    import tomllib

    (text,) = blocks("toml", GUIDE)
    assert set(NoiseModel.from_dict(tomllib.loads(text)).channels) == {"gyro_y", "accel_x"}


DEMO = "sigmatau demo --output demo"


def test_demo(tmp_path, monkeypatch, capsys):
    """The command of the README: the table is its output's beginning, and the files are there."""
    assert DEMO in commands()
    monkeypatch.chdir(tmp_path)
    assert main(DEMO.split()[1:]) == 0
    out, err = capsys.readouterr()
    (shown,) = blocks("text")
    assert out.startswith(shown)
    assert "truth" in out
    assert "written:" in err
    files = sorted(path.name for path in (tmp_path / "demo").iterdir())
    assert files == ["hg1700.toml", "report.html", "result.json", "static.csv"]


def test_links():
    for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]:
        for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", page.read_text(encoding="utf-8")):
            if not target.startswith("https://"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def _write_logs(folder):
    """The files that the examples name, with what the text says of them."""
    y = np.random.default_rng(1).standard_normal((1000, 6))
    t = np.arange(1000) / 100
    names = [f"{s}_{a}" for s in ("gyro", "accel") for a in "xyz"]
    few = 30  # rows, too few for a fit, where units and columns are what the example is about

    def table(name, columns, header, delimiter=","):
        np.savetxt(folder / name, columns, delimiter=delimiter, header=header, comments="", fmt="%.9g")

    table(
        "static.csv",
        np.column_stack([t, y[:, 0], y[:, 3]]),
        "time [s],gyro_x [deg/s],accel_x [g]",
    )
    table("unit.csv", np.column_stack([t, y[:, :3]]), "time [s]," + ",".join(f"{n} [deg/s]" for n in names[:3]))
    for name in ("night1.csv", "night2.csv"):
        table(
            name,
            np.column_stack([t, y])[:few],
            "time [s]," + ",".join(f"{n} [{'deg/s' if n.startswith('g') else 'g'}]" for n in names),
        )
    for name, rows in (("day1.csv", slice(0, 600)), ("day2.csv", slice(400, 1000))):
        table(name, np.column_stack([t[:600], y[rows, :1]]), "time [s],gyro_x [deg/s]")
    np.savetxt(folder / "imu.txt", np.column_stack([t, y])[:few])
    table("growing.csv", np.column_stack([t, y]), "time [s]," + ",".join(f"{n} [rad/s]" for n in names[:3]) + ",p,q,r")
    for name in ("log.csv", "daq.csv", "counts.csv"):
        wanted = names if name == "log.csv" else names[:3]
        table(name, y[:few, : len(wanted)], ",".join(wanted))
    for name in ("rlg.csv", "laser_gyro.csv"):
        table(name, np.column_stack([t, y])[:few], "time [s]," + ",".join(names))
    np.savetxt(folder / "phase.txt", np.cumsum(y[:, 0]))
    for name in ("imu.toml", "rlg.toml"):
        (folder / name).write_text(blocks("toml", GUIDE)[0])
    (folder / "spec.toml").write_text(
        'name = "spec"\nmaker = "us"\nsource = "here"\n[gyro]\nrandom_walk = { maximum = "60 deg/sqrt(h)" }\n'
    )
    z = np.random.default_rng(2).standard_normal((1000, 3))
    head = "time [s]," + ",".join(f"{n} [deg/s]" for n in names[:3])
    (folder / "shift").mkdir()
    for name, rates in (("shift/unit1.csv", y[:, :3]), ("shift/unit2.csv", z), ("other.csv", z)):
        table(name, np.column_stack([t, rates]), head)
    for logs in ("logs", "night"):
        shutil.copytree(folder / "shift", folder / logs)
    (folder / "units.txt").write_text("unit1\nunit2\n")
    for log, result in (("static", "result"), ("unit", "unit1"), ("other", "unit2")):
        assert main(["analyze", str(folder / f"{log}.csv"), "--json", str(folder / f"{result}.json"), "-q"]) == 0
    shutil.copy(folder / "result.json", folder / "static.json")
    shutil.copy(folder / "static.json", folder / "running.json")
    (folder / "results").mkdir()
    (folder / "table1.csv").write_text(_typed("arcsec", (0.973, 0.960, 0.919)))
    for day in range(1, 4):
        log = folder / f"day{day}.csv"
        drawn = np.random.default_rng(day).standard_normal((1000, 2))
        table(log.name, np.column_stack([t, drawn]), "time [s],gyro_x [deg/s],accel_x [g]")
        note = ["--note", "serial number=A123", "--note", f"run=day {day}"]
        assert main(["analyze", str(log), "--json", str(folder / f"day{day}.json"), *note, "-q"]) == 0
        shutil.copy(folder / f"day{day}.json", folder / "results" / f"day{day}.json")
    add = ["store", "add", str(folder / "results"), "--store", str(folder / "lab.db"), "--date", "2026-05-01", "-q"]
    assert main(add) == 0


def _typed(unit, values):
    rows = [f"{day},gyro_x,quantization,{value},{unit},0.06" for day, value in enumerate(values, 1)]
    return "\n".join(["run,channel,term,value,unit,error_percent", *rows]) + "\n"


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    """A folder with the files that the pages speak of; commands run in a copy of it."""
    folder = tmp_path_factory.mktemp("logs")
    _write_logs(folder)
    return folder


@pytest.mark.parametrize("command", [line for line in commands() if line != DEMO])
def test_command_lines(command, logs, tmp_path, monkeypatch, capsys):
    shutil.copytree(logs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    command = (
        command.replace("10min:50min", "1s:9s")
        .replace("720s:722s,30min:31min", "1s:1.5s,2.5s:3s")
        .replace("--tau-min 0.5", "--tau-min 0.05")
        .replace("--hours 2", "--hours 0.01")
        .replace("0.5 deg/h", "3000 deg/h")  # shows in a short record
        .replace("--jobs 2", "--jobs 1")  # processes are the matter of tests/cli/test_batch.py
        .replace("--idle 60", "--idle 0.2 --every 0.1")
    )
    argv = shlex.split(command, comments=True)[1:]
    assert main(argv) == 0, capsys.readouterr().err
    for written in re.findall(r"(?:--plot|--stability|--json|-o) (\S+)", command):
        assert (tmp_path / written).stat().st_size > 0


def test_study_page_is_of_the_packages_rules():
    """docs/study/read-off.md marks the rules that are in force; a changed rule asks for ``make study``."""
    from sigmatau.fitting.read_off_regions import RULES

    page = (ROOT / "docs" / "study" / "read-off.md").read_text(encoding="utf-8")
    marked = re.findall(r"^\| (\w+) \| (\w+) \| \*\*([\d.]+)\*\* \| ([\d.]+) ", page, flags=re.MULTILINE)
    numbers = ("tolerance", "slope_error", "rest", "gain", "scatter")
    assert {(m[0], m[1]): float(m[2]) for m in marked} == {
        (term, number): getattr(rule, number) for term, rule in RULES.items() for number in numbers
    }
    assert all(float(m[3]) <= 5 for m in marked)


def test_record_prints_itself(logs):
    record = read(logs / "static.csv")
    assert repr(record).startswith("Record of 2 streams\n  gyro: gyro_x [rad/s], 1000 samples at 100 Hz")
    head, gyro, *_ = repr(analyze(record, method="read-off")).split("\n\n")
    assert head == "static.csv: 2 axes at 100 Hz (time stamps), 10 s, at rest"
    assert gyro.startswith("gyro: 1 channel, 1000 samples at 100 Hz (time stamps in column 'time [s]'), 10 s")


def test_one_version():
    import tomllib

    from sigmatau import __version__

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    crates = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["workspace"]["package"]["version"]
    assert project == crates == __version__


def test_every_finding_is_explained():
    """docs/findings.md has one row for each code of `sigmatau.findings.kinds`, and no other."""
    import importlib

    from sigmatau.findings.finding import Details
    from sigmatau.findings.wording import SUBJECTS

    kinds = [vars(importlib.import_module(f"sigmatau.findings.kinds.{subject}")).values() for subject in SUBJECTS]
    codes = {
        one.code for each in kinds for one in each if isinstance(one, type) and issubclass(one, Details) and one.code
    }
    page = (ROOT / "docs" / "findings.md").read_text(encoding="utf-8").partition("## Time stamps")[2]
    rows = re.findall(r"^\| `([a-z_]+)` \|", page, flags=re.MULTILINE)
    assert len(rows) == len(set(rows))
    assert set(rows) == codes
