"""The noise terms are listed once: code that goes through them walks the table, and a further term needs no other list."""

import ast
import re
from collections.abc import Iterator

from conftest import ROOT
from package_trees import MODULES, nodes, tree
from sigmatau.noise.terms import NOISE, TERMS

ROOMS = {name for name in MODULES if "/" in name}
LISTED = {
    "noise/terms.py",
    "_native/arguments.py",
    "_native/kernels.py",
    "exporting/targets/ieee952.py",
    "fitting/read_off_regions.py",
}  # CONTRIBUTING names them


def lists(code: ast.AST) -> Iterator[int]:
    """Lines of literals with all terms of noise in them."""
    for node in nodes(code):
        if isinstance(node, ast.Dict | ast.Tuple | ast.List | ast.Set):
            parts = node.keys if isinstance(node, ast.Dict) else node.elts
            if {part.value for part in parts if isinstance(part, ast.Constant)} >= {*NOISE}:
                yield node.lineno


def test_no_other_list_of_terms() -> None:
    found = [f"{name}:{line}" for name in sorted(ROOMS - LISTED) for line in lists(tree(name))]
    assert not found, f"walk `sigmatau.noise.terms.TERMS`: {found}"


FOUR = 4  # of the names in one place are a list of them
LACKING = {
    "cli/deviation.py": {"rate_ramp"},  # not a noise
    "exporting/gauss_markov.py": {"bias_instability"},  # flat: the lowest point does not depend on it
    "fitting/rounding.py": {"random_walk"},  # with an error of its own
    "quality/sensor_class.py": {"quantization"},  # no limit
}
"""Terms that the lists of a module do not have, and why."""


def names_in(node: ast.AST) -> set[str]:
    """The terms in a literal, a docstring, the parameters or arguments of a call, or the fields of a class."""
    names: set[object] = set()
    match node:
        case ast.Dict():
            names = {key.value for key in node.keys if isinstance(key, ast.Constant)}
        case ast.Tuple() | ast.List() | ast.Set():
            names = {part.value for part in node.elts if isinstance(part, ast.Constant)}
        case ast.Constant(value=str() as text):
            names = {*re.findall(r"\w+", text)}
        case ast.arguments():
            names = {argument.arg for argument in (*node.args, *node.kwonlyargs)}
        case ast.Call():
            names = {keyword.arg for keyword in node.keywords}
        case ast.ClassDef():
            fields = (part.target for part in node.body if isinstance(part, ast.AnnAssign))
            names = {field.id for field in fields if isinstance(field, ast.Name)}
    return {name for name in TERMS if name in names}


def test_a_list_of_terms_has_all() -> None:
    """A further term is asked for in each place that has a list in spite of the table."""
    incomplete = {}
    for module in sorted(ROOMS):
        for node in nodes(tree(module)):
            names = names_in(node)
            if len(names) >= FOUR and (lacking := {*TERMS} - names - LACKING.get(module, set())):
                incomplete[module] = lacking
    assert not incomplete, f"add the terms to the lists in these modules, or to LACKING with the reason: {incomplete}"


def test_the_crate_has_the_same_terms() -> None:
    """In the same order: coefficients go to it by their place."""
    source = (ROOT / "crates" / "core" / "src" / "terms.rs").read_text(encoding="utf-8")
    named = re.findall(r'Self::\w+ => "(\w+)"', source)
    assert named == [*TERMS], "put the term in the same place in `TERMS` of noise/terms.py and `Term` of terms.rs"
