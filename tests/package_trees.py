"""The modules of the package, and their syntax trees, parsed once in a process for all tests that read code."""

import ast
import functools

from conftest import ROOT

PACKAGE = ROOT / "python" / "sigmatau"
MODULES = {str(path.relative_to(PACKAGE)): path for path in sorted(PACKAGE.rglob("*.py"))}


@functools.cache
def tree(name):
    """The syntax tree of a module. Nobody changes it."""
    return ast.parse(MODULES[name].read_text(encoding="utf-8"))


@functools.cache
def nodes(code):
    """All nodes of a tree, as `ast.walk` yields them, which takes longer than what most tests do with them."""
    return tuple(ast.walk(code))
