"""No code reads the words of a finding back: what a later step needs is a field."""

import ast

import pytest

from conftest import ROOT

PACKAGE = ROOT / "python" / "sigmatau"
FACES = {"findings", "cli", "reporting", "pages"}  # they make the words, and print them
ERRORS = {"self", "error", "solved"}  # an error has a message too
TEXTS = {
    *("analysis/stages.py", "analysis/result.py", "exporting/export.py", "exporting/of_analysis.py"),
    "lab/lots/lot_remark.py",
    *("lab/store/rows.py", "lab/store/text.py"),
}  # errors, and remarks in files, that a person reads
MODULES = [
    path
    for path in sorted(PACKAGE.rglob("*.py"))
    if FACES.isdisjoint(path.relative_to(PACKAGE).parts) and path.name != "errors.py"
]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_words_are_not_read(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Attribute) or node.attr not in {"message", "action"}:
            continue
        owner = node.value
        shown = str(path.relative_to(PACKAGE)) in TEXTS and node.attr == "message"
        allowed = shown or (isinstance(owner, ast.Name) and owner.id in ERRORS)
        assert allowed, f"{path.name}, line {node.lineno}: {ast.unparse(node)}"
