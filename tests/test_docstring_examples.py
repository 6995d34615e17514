"""The examples in docstrings are run."""

import doctest
import importlib
import pkgutil

import pytest

import sigmatau

MODULES = [
    name for _, name, _ in pkgutil.walk_packages(sigmatau.__path__, "sigmatau.") if not name.endswith("__main__")
]


@pytest.mark.parametrize("name", [name for name in MODULES if not name.endswith("._core")])
def test_examples(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    assert doctest.testmod(module, optionflags=doctest.ELLIPSIS).failed == 0
