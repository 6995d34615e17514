"""No code reads the words of a finding back: what a later step needs is a field."""

import ast

import pytest

from conftest import ROOT

PACKAGE = ROOT / "python" / "sigmatau"
FACES = {"findings", "cli", "reporting"}  # they make the words, and print them
ERRORS = {"self", "error", "solved"}  # an error has a message too
FORMER = {"effect", "remedy"}
MODULES = [path for path in sorted(PACKAGE.rglob("*.py")) if path.relative_to(PACKAGE).parts[0] not in FACES]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_words_are_not_read(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Attribute) or node.attr not in {"message", "action", *FORMER}:
            continue
        owner = node.value
        made = isinstance(owner, ast.Call) and isinstance(owner.func, ast.Name) and owner.func.id == "words"
        allowed = made or (isinstance(owner, ast.Name) and owner.id in ERRORS and node.attr not in FORMER)
        assert allowed, f"{path.name}, line {node.lineno}: {ast.unparse(node)}"


def test_words_are_made_in_one_room():
    """`words` and `sentence` are only for texts that a person reads: errors, remarks in files."""
    users = {
        str(path.relative_to(PACKAGE))
        for path in MODULES
        if "findings.wording import" in path.read_text(encoding="utf-8")
    }
    assert users <= {
        "analysis/stages.py",
        "analysis/result.py",
        "analysis/text.py",
        "exporting/export.py",
        "exporting/of_analysis.py",
        "lots/lot_judging.py",
        *(str(path.relative_to(PACKAGE)) for path in (PACKAGE / "io" / "read").rglob("*.py")),
    }
