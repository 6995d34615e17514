"""Types are complete for users: `pyright --verifytypes` finds no name whose type is unknown or guessed.

Strict mypy already asks for the types of parameters, results and type arguments. What it lets pass, and pyright counts as
guessed, is an attribute or a variable that gets its type from a call or another expression: that is tested here, in one
second. The whole check takes 20 s and Node: ``pyright --verifytypes sigmatau --ignoreexternal``, with the Python that has
NumPy first in PATH, because types of arrays are unknown otherwise.
"""

import ast
import re
from importlib.resources import files

from package_trees import MODULES, PACKAGE, tree

PRIVATE = {"_native", "versions"}  # folders without a name for users
CONSTANT = re.compile(r"[A-Z][A-Z0-9_]*$")  # pyright takes its value for its type
TYPES = re.compile(r"\b(TypeVar|NewType|attach_stub)\b")  # calls that make a type, or all names


def targets(node):
    for target in node.targets:
        yield from target.elts if isinstance(target, ast.Tuple) else [target]


def shows_its_type(value, parameters):
    """Whether a value is a text, a truth value, or a parameter with an annotation."""
    if isinstance(value, ast.Name):
        return value.id in parameters
    return isinstance(value, ast.Constant) and isinstance(value.value, str | bool)


def guessed_attributes(code):
    """Public attributes that ``__init__`` of a public class, or of a base class, sets without a type."""
    classes = [node for node in code.body if isinstance(node, ast.ClassDef)]
    bases = {ast.unparse(base) for cls in classes for base in cls.bases}
    for cls in (cls for cls in classes if not cls.name.startswith("_") or cls.name in bases):
        declared = {node.target.id for node in cls.body if isinstance(node, ast.AnnAssign)}
        for init in (node for node in cls.body if isinstance(node, ast.FunctionDef) and node.name == "__init__"):
            given = {one.arg for one in (*init.args.args, *init.args.kwonlyargs) if one.annotation}
            for node in (node for node in ast.walk(init) if isinstance(node, ast.Assign)):
                unpacked = any(isinstance(target, ast.Tuple) for target in node.targets)
                for target in targets(node):
                    name = ast.unparse(target).removeprefix("self.")
                    is_public = ast.unparse(target) == f"self.{name}" and not name.startswith("_")
                    if is_public and name not in declared and (unpacked or not shows_its_type(node.value, given)):
                        yield f"{cls.name}.{name}, line {node.lineno}"


def guessed_variables(code):
    """Public variables of a module that a call makes, without a type; a constant in capitals has that of its value."""
    for node in (node for node in code.body if isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)):
        for target in targets(node):
            name = ast.unparse(target)
            if not name.startswith("_") and not CONSTANT.match(name) and not TYPES.search(ast.unparse(node.value.func)):
                yield f"{name}, line {node.lineno}"


def test_types_are_stated():
    modules = [name for name in MODULES if not PRIVATE & set(name.split("/"))]
    assert len(modules) > 300
    guessed = []
    for name in modules:
        found = (*guessed_attributes(tree(name)), *guessed_variables(tree(name)))
        guessed += [f"{name}: {one}" for one in found]
    assert not guessed, "\n".join(guessed)


def test_a_guess_is_found():
    code = (
        "class A:\n    def __init__(self, a: int) -> None:\n        self.a = a\n        self.b = a + 1\nc = open('x')\n"
    )
    assert list(guessed_attributes(ast.parse(code))) == ["A.b, line 4"]
    assert list(guessed_variables(ast.parse(code))) == ["c, line 5"]


def test_the_package_says_that_it_is_typed():
    """Type checkers read the annotations of a package with this file, and names from the stub, which is loaded lazily."""
    assert (files("sigmatau") / "py.typed").is_file()
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text(encoding="utf-8"))
    imported = {alias.name for node in stub.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    (exported,) = (node.value for node in stub.body if isinstance(node, ast.Assign))
    assert imported == set(ast.literal_eval(exported))
