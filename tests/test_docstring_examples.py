"""The examples in docstrings are run."""

import doctest
import importlib

import pytest

from package_trees import MODULES

WITH_EXAMPLES = [name for name, path in MODULES.items() if ">>> " in path.read_text(encoding="utf-8")]


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_examples(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(
        "sigmatau." + name.removesuffix("/__init__.py").removesuffix(".py").replace("/", ".")
    )
    tested = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert tested.attempted > 0
    assert tested.failed == 0
