"""Each hint in a message names an option of Python and of the command line."""

import ast
import functools
import inspect

from test_public_names import of_command_line, of_python

import sigmatau
from package_trees import MODULES, nodes, tree
from sigmatau.exporting.tuning.table import read_innovations
from sigmatau.hints import SPELLED, Hint, as_options
from sigmatau.lab.store.naming import Naming

BELOW_CLI = [name for name in MODULES if not name.startswith(("app/", "cli/"))]


def calls(code):
    """Names of the options of hints in a module, and whether they are of a command that is to be typed."""
    commands = {
        inner
        for node in nodes(code)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("command", "as_options")
        for inner in ast.walk(node)
    }
    for node in nodes(code):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "Hint" and node.args:
            names = [one.value for one in ast.walk(node.args[0]) if isinstance(one, ast.Constant)]
            yield from ((name, node in commands) for name in names if isinstance(name, str))


@functools.cache
def arguments():
    """The options of Python."""
    return {
        *(one.rpartition("(")[2].rstrip("=)") for one in of_python() if "(" in one),
        *inspect.signature(sigmatau.Choices).parameters,
        *inspect.signature(Naming).parameters,
        *inspect.signature(read_innovations).parameters,
    }


def test_each_hint_names_an_option_of_both_faces():
    typed = {one.rpartition(" ")[2] for one in of_command_line()}
    for name in BELOW_CLI:
        for option, in_command in calls(tree(name)):
            assert as_options([Hint(option)]) in typed, (name, option)
            assert in_command or option in arguments(), (name, option)


def test_the_calls_are_found():
    code = ast.parse('f\'{Hint("rate", value=1)} {command("analyze", Hint("json"))} {Hint("a" if x else "b")}\'')
    assert sorted(calls(code)) == [("a", False), ("b", False), ("json", True), ("rate", False)]
    assert set(SPELLED) <= arguments()


def test_only_faces_type_options():
    """Errors, failures and findings have words for the command line and for JSON; all else has hints, which a face words."""
    typing = {name for name in BELOW_CLI if "as_options" in MODULES[name].read_text(encoding="utf-8")}
    typing = {name for name in typing if not name.startswith("findings/")}
    assert typing == {"errors.py", "hints.py", "analysis/failed.py"}
