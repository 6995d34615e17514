"""What is imported when: starting a program is part of its speed."""

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import sigmatau

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
        "sigmatau.cli.app",
        "sigmatau.errors",
    }


def test_reading_off_loads_no_scipy(tmp_path):
    log = tmp_path / "log.csv"
    log.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{i / 100},{i * 7919 % 101}\n" for i in range(200)))
    modules = loaded(f"from sigmatau.cli import main; main(['analyze', {str(log)!r}, '--method', 'read-off'])")
    assert not modules & {"scipy", "matplotlib", "pandas"}


@pytest.mark.parametrize("method", ["likelihood", "gls"])
def test_analysing_loads_no_more_of_scipy_than_special_functions(tmp_path, method):
    log = tmp_path / "log.csv"
    log.write_text("time [s],gyro_x [deg/s]\n" + "".join(f"{i / 100},{i * 7919 % 101}\n" for i in range(2000)))
    code = f"from sigmatau.cli import main; main(['analyze', {str(log)!r}, '--method', {method!r}])"
    code += "; import sys; sys.stdout = sys.__stdout__; print(); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    modules = set(done.stdout.splitlines()[-1].split())
    assert "scipy.special" in modules
    assert not modules & {"scipy.optimize", "scipy.linalg", "scipy.stats", "scipy.fft", "scipy.signal"}


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
    for before in ("", "import sigmatau.estimators.allan, sigmatau.exporting.export; ", "import sigmatau.analysis; "):
        code = f"{before}import sigmatau; from sigmatau import allan; print(sigmatau.allan, sigmatau.export)"
        assert loaded_text(code).count("function") == 2
