"""No code reads the words of a finding back: what a later step needs is a field."""

import ast

from package_trees import MODULES, nodes, tree

FACES = {"findings", "cli", "reporting", "pages"}  # they make the words, and print them
ERRORS = {"self", "error", "solved"}  # an error has a message too
TEXTS = {
    *("analysis/stages.py", "analysis/result.py", "exporting/export.py", "exporting/of_analysis.py"),
    "lab/lots/lot_remark.py",
    "lab/fleet/stored.py",
    *("lab/store/rows.py", "lab/store/text.py"),
}  # errors, and remarks in files, that a person reads


def read_words(name):
    """The expressions of a module that read the words of a finding."""
    for node in nodes(tree(name)):
        if isinstance(node, ast.Attribute) and node.attr in {"message", "action"}:
            shown = name in TEXTS and node.attr == "message"
            if not shown and not (isinstance(node.value, ast.Name) and node.value.id in ERRORS):
                yield f"{name}, line {node.lineno}: {ast.unparse(node)}"


def test_words_are_not_read():
    modules = [name for name, path in MODULES.items() if FACES.isdisjoint(name.split("/")) and path.name != "errors.py"]
    assert len(modules) > 300
    read = [words for name in modules for words in read_words(name)]
    assert not read, "\n".join(read)
