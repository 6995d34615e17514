"""What is imported when: starting a program is part of its speed."""

import ast
import json
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import sigmatau
from known import seed_of

HEAVY = {"numpy", "scipy", "matplotlib", "pandas", "rich", "cyclopts"}


def loaded(code):
    """Modules of `HEAVY` and of the package that a new process has after running `code`."""
    tail = "; import sys; sys.stdout = sys.__stdout__; print(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code + tail], capture_output=True, text=True, check=True)
    modules = set(done.stdout.splitlines()[-1].split())
    return {m for m in modules if m in HEAVY or m.split(".")[0] == "sigmatau"}


def test_importing_the_package_loads_nothing_else():
    assert loaded("import sigmatau") == {"sigmatau"}


def test_every_name_loads_numpy_and_nothing_heavier():
    assert loaded("from sigmatau import *") & HEAVY == {"numpy"}


@pytest.mark.parametrize("argv", [["--help"], ["--version"]])
def test_help_of_the_command_loads_no_numbers(argv):
    modules = loaded(f"from sigmatau.cli import main; main({argv})")
    assert modules & HEAVY == {"rich", "cyclopts"}
    assert {m for m in modules if m.startswith("sigmatau")} == {
        "sigmatau",
        "sigmatau._version",
        "sigmatau.cli",
        "sigmatau.cli.words",
        "sigmatau.cli.app",
        "sigmatau.cli.earlier",
        "sigmatau.hints",
        "sigmatau.process",
        "sigmatau.cli.symbols",
        "sigmatau.errors",
        "sigmatau.results",
    }


def test_reading_off_loads_no_scipy(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{i / 100},{i * 7919 % 101}\n" for i in range(200)))
    modules = loaded(f"from sigmatau.cli import main; main(['analyze', {str(log)!r}, '--method', 'read-off'])")
    assert not modules & {"scipy", "matplotlib", "pandas"}


NOT_OF_AN_ANALYSIS = (
    *("scipy", "matplotlib", "pandas", "numpy.testing", "numpy.f2py", "numpy.random", "multiprocessing", "concurrent"),
    *("numpy.ma", "zipfile", "tomllib", "logging", "difflib"),
    *(f"sigmatau.io.read.{name}" for name in ("column_values", "devices", "instance_tables", "suggestions")),
    *(f"sigmatau.exporting.{name}" for name in ("export", "source", "targets", "values")),  # not its options
    *("sigmatau.lab.datasheets", "sigmatau.simulation", "sigmatau.statespace", "sigmatau.navigation"),
    *("sigmatau.plot", "sigmatau.fitting.planning", "sigmatau.io.write", "sigmatau.estimators.stability"),
    "sigmatau.findings.exporting",
)


def test_an_analysis_imports_only_what_it_uses(tmp_path):
    """By either method, complete or with missing samples; all in one process, since each takes a second to start."""
    rng = np.random.default_rng(seed_of("imports of an analysis"))
    white = rng.normal(size=(4000, 6)) * ([0.01] * 3 + [0.02] * 3) + [0, 0, 0, 0, 0, 9.81]
    names = [f"{sensor}_{axis} [{unit}]" for sensor, unit in (("gyro", "rad/s"), ("accel", "m/s^2")) for axis in "xyz"]
    rows = [f"{i / 100},{','.join(map(repr, row.tolist()))}" for i, row in enumerate(white)]
    (tmp_path / "complete.csv").write_text("\n".join([",".join(["time [s]", *names]), *rows, ""]))
    (tmp_path / "missing.csv").write_text("\n".join([",".join(["time [s]", *names]), *rows[:700], *rows[720:], ""]))
    ways = [(kind, method) for kind in ("complete", "missing") for method in ("likelihood", "gls")]
    result = "{}-{}.json"
    code = (
        "import sys; from sigmatau.cli import main\n"
        f"for kind, method in {ways}:\n"
        f"    main(['analyze', f'{{kind}}.csv', '--method', method, '--json', {result!r}.format(kind, method)])\n"
        "print(); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    modules = done.stdout.splitlines()[-1].split()
    for way in ways:
        found = json.loads((tmp_path / result.format(*way)).read_text())
        assert [channel["fit"]["method"] for channel in found["channels"].values()] == [way[1]] * 6
        assert any(one["code"] == "gaps" for one in found["findings"]) == (way[0] == "missing")
    assert "sigmatau.analysis" in modules
    needless = [m for m in modules if f"{m}.".startswith(tuple(f"{name}." for name in NOT_OF_AN_ANALYSIS))]
    assert needless == []


def test_every_public_name_is_in_its_home():
    stub = ast.parse(Path(sigmatau.__file__).with_name("__init__.pyi").read_text(encoding="utf-8"))
    homes = {alias.name: node.module for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    listed = next(ast.literal_eval(node.value) for node in stub.body if isinstance(node, ast.Assign))
    assert listed == sorted(homes)
    assert sorted(sigmatau.__all__) == listed == sorted(dir(sigmatau))
    for name, home in homes.items():
        assert getattr(sigmatau, name) is getattr(import_module(f"sigmatau.{home}"), name), name
    with pytest.raises(AttributeError, match="nothing"):
        _ = sigmatau.nothing


def loaded_text(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_public_functions_are_not_hidden_by_modules():
    for before in (
        "",
        "import sigmatau.estimators.allan, sigmatau.exporting.export; ",
        "import sigmatau.analysis.pipeline; ",
    ):
        code = f"{before}import sigmatau; from sigmatau import allan; print(sigmatau.allan, sigmatau.export)"
        assert loaded_text(code).count("function") == 2


def test_all_names_without_the_extras():
    """With the packages of no extra installed, `from sigmatau import *` works; a store then says what it needs."""
    code = """
import sys
for name in "sqlalchemy orjson distributed dask zarr fsspec matplotlib h5py pyarrow pandas".split():
    sys.modules[name] = None
from sigmatau import *
try:
    Store("lab.db")
except ImportError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'sigmatau[store]'" in done.stdout
