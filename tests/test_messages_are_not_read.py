"""No option, key, sentence or place is recovered from a message: what a later step needs is a field of the error."""

import ast
import functools
import re

import pytest

from package_trees import MODULES, nodes, tree

TEXT_METHODS = {name for name in dir(str) if not name.startswith("_")} - {"join", "format", "format_map"}
SPOKEN = {"error", "message", "reason", "why", "action"}
"""Names of variables and of attributes that hold words."""

FOREIGN = {
    "errors.py": "the placeholder for the option in a message",
    "_native/arguments.py": "fields of errors of the extension",
    "_native/kernels.py": "errors of the extension",
    "io/read/formats/damage.py": "errors of other libraries, shortened",
    "io/read/formats/matlab.py": "errors of mat-io, shortened",
    "io/read/formats/npy.py": "errors of NumPy",
    "lab/store/ingest.py": "errors of databases",
}
"""Modules that read messages of other programs, which have no fields, or that make messages."""


def is_name(node, *names):
    return isinstance(node, ast.Name) and node.id in names


def is_call(node, *names):
    """Whether a node calls a function of these names."""
    return isinstance(node, ast.Call) and is_name(node.func, *names)


def messages(code):
    """The expressions of a module that are the words of an error or of a finding."""
    for node in nodes(code):
        if isinstance(node, ast.ExceptHandler) and node.name:
            for inner in ast.walk(node):
                is_text = is_call(inner, "str", "repr") and [*map(ast.unparse, inner.args)] == [node.name]
                is_field = isinstance(inner, ast.Attribute) and inner.attr == "args" and is_name(inner.value, node.name)
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
        if is_call(node, "str") and node.args and is_named_error(node.args[0]):
            yield node


def is_sentence(node):
    """Whether a node is a text of two words or more, wherever values stand in it."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    texts = [part.value for part in parts if isinstance(part, ast.Constant) and isinstance(part.value, str)]
    return any(re.search(r"[a-z]{2},? [a-z]", text, re.IGNORECASE) for text in texts)


@functools.cache
def sentences(name):
    """The constants of a module that hold a sentence, or several."""
    return set(constants_with_sentences(tree(name)))


def constants_with_sentences(code):
    for node in code.body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(map(is_sentence, elements(node.value))):
                yield from (target.id for target in targets if isinstance(target, ast.Name))


def elements(node):
    """The elements of a display, or the node."""
    return node.elts if isinstance(node, ast.Tuple | ast.List | ast.Set) else [node]


def spoken_constants(code):
    """The names in a module that stand for a constant with a sentence, of this module or of another of the package."""
    yield from constants_with_sentences(code)
    for node in nodes(code):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sigmatau."):
            path = node.module.removeprefix("sigmatau.").replace(".", "/")
            source = next((name for name in (f"{path}.py", f"{path}/__init__.py") if name in MODULES), None)
            yield from (each.asname or each.name for each in node.names if source and each.name in sentences(source))


def is_spoken(node):
    """Whether a node is a variable or an attribute that holds words by its name."""
    return (isinstance(node, ast.Name) and node.id in SPOKEN) or (
        isinstance(node, ast.Attribute) and node.attr in SPOKEN
    )


def cuts(code):
    """The comparisons with a sentence, and the expressions that take words apart or search them."""
    constants = set(spoken_constants(code))
    for node in nodes(code):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            parts = [part for side in sides for part in elements(side)]
            is_constant = any(isinstance(part, ast.Name) and part.id in constants for part in parts)
            is_text = any(isinstance(part, ast.JoinedStr) and is_sentence(part) for part in parts)
            is_search = isinstance(node.ops[0], ast.In | ast.NotIn) and is_spoken(node.comparators[0])
            if is_constant or is_text or is_search:
                yield node
        is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        if is_method and node.func.attr in TEXT_METHODS and is_spoken(node.func.value):
            yield node
        if is_method and is_name(node.func.value, "re") and any(map(is_spoken, node.args)):
            yield node


def is_named_error(owner):
    return is_name(owner, "error", "problem", "finding", "refused")


def reads(code):
    """The expressions that take a message apart, search it, or compare it."""
    words = {ast.unparse(message) for message in messages(code)}
    for handler in (node for node in nodes(code) if isinstance(node, ast.ExceptHandler)):
        for node in ast.walk(handler):
            if isinstance(node, ast.Assign) and ast.unparse(node.value) in words:
                words |= {ast.unparse(target) for target in node.targets}

    def is_message(node):
        return bool(words) and ast.unparse(node) in words

    for node in nodes(code):
        if isinstance(node, ast.Attribute) and node.attr in TEXT_METHODS and is_message(node.value):
            yield node
        if isinstance(node, ast.Subscript) and is_message(node.value):
            yield node
        if isinstance(node, ast.Compare) and any(map(is_message, [node.left, *node.comparators])):
            yield node
        is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        if is_method and is_name(node.func.value, "re") and any(map(is_message, node.args)):
            yield node
    yield from cuts(code)


def test_no_message_is_read():
    modules = MODULES.keys() - FOREIGN.keys()
    found = [f"{name}, line {node.lineno}: {ast.unparse(node)}" for name in modules for node in reads(tree(name))]
    assert not found, "\n".join(found)


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
    assert list(reads(ast.parse(f"try:\n    read()\nexcept DataError as error:\n    use({offence})")))
    assert not list(reads(ast.parse("try:\n    read()\nexcept DataError as error:\n    raise Other(str(error))\n")))


@pytest.mark.parametrize(
    "offence",
    [
        "judged.reason in (NOT_ADEQUATE, OTHER)",
        "judged.reason not in ('', NOTHING)",
        "judged.reason == NOTHING",
        "judged.reason in BOTH",
        "text == f'{name} is empty'",
        "error.startswith(prefix)",
        "error.removeprefix(f'{path}: ')",
        "message if log.place in message else f'{log.place}: {message}'",
        "self.why.partition(': ')",
        "re.sub(path, '', outcome.error)",
    ],
)
def test_a_sentence_that_is_compared_or_cut_is_found(offence):
    before = """
from sigmatau.model.file import NOT_ADEQUATE
NOTHING = "not in the result"
BOTH = ("is empty", "is missing")
OTHER = "likelihood"
"""
    assert list(reads(ast.parse(before + offence)))
    assert not list(reads(ast.parse(before + "use(f'{NOTHING}: {error}', method == OTHER, error[:500], BOTH)")))


def test_exempt_modules_are_there():
    assert FOREIGN.keys() <= MODULES.keys()
    assert all(list(reads(tree(name))) for name in FOREIGN)
