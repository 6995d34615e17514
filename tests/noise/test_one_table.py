"""The noise terms are listed once: code that goes through them walks the table, and a further term needs no other list."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import sigmatau
from sigmatau.noise.terms import NOISE

ROOT = Path(sigmatau.__file__).parent
LISTED = {
    "noise/terms.py",
    "_native/arguments.py",
    "_native/kernels.py",
    "exporting/targets/ieee952.py",
    "fitting/read_off_regions.py",
}  # CONTRIBUTING names them


def lists(tree: ast.AST) -> Iterator[int]:
    """Lines of literals with all terms of noise in them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Dict | ast.Tuple | ast.List | ast.Set):
            parts = node.keys if isinstance(node, ast.Dict) else node.elts
            if {part.value for part in parts if isinstance(part, ast.Constant)} >= {*NOISE}:
                yield node.lineno


@pytest.mark.parametrize("room", sorted(path.name for path in ROOT.iterdir() if path.is_dir()))
def test_no_other_list_of_terms(room: str) -> None:
    found = {
        f"{path.relative_to(ROOT)}:{line}"
        for path in (ROOT / room).rglob("*.py")
        if str(path.relative_to(ROOT)) not in LISTED
        for line in lists(ast.parse(path.read_text(encoding="utf-8")))
    }
    assert not found, f"walk `sigmatau.noise.terms.TERMS`: {sorted(found)}"
