"""Mutants of arrays: NumPy files and raw binary files."""

import pytest
from benches.logs import KINDS, made

from container_damage import survives


@pytest.mark.parametrize("name", ["NumPy .npy", "NumPy .npz", "raw binary"])
def test_mutants(tmp_path, name):
    kind = KINDS[name]
    path = kind.make(tmp_path, *made(40))
    assert survives(f"arrays {name}", path.read_bytes(), path, 100, **kind.options) > 0
