"""No option, key, sentence or place is recovered from a message: what a later step needs is a field of the error."""

import ast

import pytest

from conftest import ROOT

PACKAGE = ROOT / "python" / "sigmatau"
MODULES = {str(path.relative_to(PACKAGE)): path for path in sorted(PACKAGE.rglob("*.py"))}
TEXT_METHODS = {name for name in dir(str) if not name.startswith("_")} - {"join", "format", "format_map"}
FOREIGN = {
    "_native/arguments.py": "fields of errors of the extension",
    "_native/kernels.py": "errors of the extension",
    "io/read/formats/damage.py": "errors of other libraries, shortened",
    "io/read/formats/matlab.py": "errors of mat-io, shortened",
    "io/read/formats/npy.py": "errors of NumPy",
    "store/ingest.py": "errors of databases",
}
"""Modules that read messages of other programs, which have no fields."""


def messages(tree):
    """The expressions of a module that are the words of an error or of a finding."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ExceptHandler) and node.name:
            for inner in ast.walk(node):
                is_text = isinstance(inner, ast.Call) and ast.unparse(inner) in (
                    f"str({node.name})",
                    f"repr({node.name})",
                )
                is_field = isinstance(inner, ast.Attribute) and ast.unparse(inner) == f"{node.name}.args"
                if is_text or is_field:
                    yield inner
        if (
            isinstance(node, ast.Attribute)
            and node.attr in ("message", "reason", "action", "args")
            and is_named_error(node.value)
        ):
            yield node
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "headline":
            yield node
        if (
            isinstance(node, ast.Call)
            and ast.unparse(node.func) == "str"
            and node.args
            and is_named_error(node.args[0])
        ):
            yield node


def is_named_error(owner):
    return isinstance(owner, ast.Name) and owner.id in ("error", "problem", "finding", "refused")


def reads(tree):
    """The expressions that take a message apart, search it, or compare it."""
    words = {ast.unparse(message) for message in messages(tree)}
    for handler in (node for node in ast.walk(tree) if isinstance(node, ast.ExceptHandler)):
        for node in ast.walk(handler):
            if isinstance(node, ast.Assign) and ast.unparse(node.value) in words:
                words |= {ast.unparse(target) for target in node.targets}

    def is_message(node):
        return ast.unparse(node) in words

    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and node.attr in TEXT_METHODS and is_message(node.value):
            yield node
        if isinstance(node, ast.Subscript) and is_message(node.value):
            yield node
        if isinstance(node, ast.Compare) and any(map(is_message, [node.left, *node.comparators])):
            yield node
        if isinstance(node, ast.Call) and ast.unparse(node.func).startswith("re.") and any(map(is_message, node.args)):
            yield node


@pytest.mark.parametrize("name", [name for name in MODULES if name not in FOREIGN])
def test_no_message_is_read(name):
    found = [f"line {node.lineno}: {ast.unparse(node)}" for node in reads(ast.parse(MODULES[name].read_text("utf-8")))]
    assert not found, found


@pytest.mark.parametrize(
    "offence",
    [
        'str(error).partition(": ")',
        "str(error).split()[0]",
        'error.message.removeprefix(", ")',
        '"--rate" in str(error)',
        're.search("line (.*):", str(error))',
        "error.args[0]",
        'error.message.replace("{option}", "x")',
        'fit.headline().startswith("adequate")',
        'str(error) == "is empty"',
    ],
)
def test_an_offence_is_found(offence):
    tree = ast.parse(f"try:\n    read()\nexcept DataError as error:\n    use({offence})")
    assert list(reads(tree))
    assert not list(reads(ast.parse("try:\n    read()\nexcept DataError as error:\n    raise Other(str(error))\n")))


def test_exempt_modules_are_there():
    assert FOREIGN.keys() <= MODULES.keys()
    assert all(list(reads(ast.parse(MODULES[name].read_text("utf-8")))) for name in FOREIGN)
