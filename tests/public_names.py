"""The public surface of sigmatau, defined here once for the tests of docstrings, types and errors.

A name is public if it is one of:

1. the names of `sigmatau.__all__`; 2. names that a page of the documentation imports from a submodule; 3. the classes of
sigmatau in an argument, a result or a field of a public name.

The methods, properties and fields of a public class without an underscore are public, including those inherited from
sigmatau, except `INTERNAL`, which other rooms of the package need. The kinds of findings (`KINDS`) are public as data.
"""

import ast
import functools
import importlib
import inspect
import json
import re
import sys
import typing
from dataclasses import fields, is_dataclass

import sigmatau
from conftest import ROOT
from sigmatau.findings import details_by_code
from sigmatau.findings.finding import Details

# Attributes that are not for users. They have no underscore because another module of the package reads them.
INTERNAL = {
    "RunComparison.table": "rows of all runs as arrays; users have columns() and values()",
    "RunComparison.cells": "groups of these rows; users have comparison[group, channel, term]",
    "RunComparison.effects": "estimates of these groups; users have row() and judgements()",
}

PRIVATE = "sigmatau._"  # the extension and its interface are not public


@functools.cache
def exported():
    """The names of `sigmatau.__all__` with their objects, without the version."""
    return {name: getattr(sigmatau, name) for name in sigmatau.__all__ if not name.startswith("__")}


@functools.cache
def imported_by_pages():
    """Names that README.md and the pages and notebooks of docs import from submodules, with their objects."""
    pages = [ROOT / "README.md", *sorted(ROOT.glob("docs/**/*.md"))]
    texts = [page.read_text(encoding="utf-8") for page in pages]
    for notebook in sorted(ROOT.glob("docs/**/*.ipynb")):
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        texts += ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    imported = {}
    for text in texts:
        for module, names in re.findall(r"^from (sigmatau\.[\w.]+) import ([\w, ]+)", text, flags=re.MULTILINE):
            for name in names.split(","):
                if not module.startswith(PRIVATE):
                    imported[f"{module}.{name.strip()}"] = getattr(importlib.import_module(module), name.strip())
    return imported


def data_imported_by_pages():
    """Constants that pages import, as module and name."""
    for name, value in imported_by_pages().items():
        if not (inspect.isclass(value) or inspect.isfunction(value) or inspect.ismodule(value)):
            module, _, last = name.rpartition(".")
            yield module, last


@functools.cache
def _imports(module):
    """Names that a module imports, at its top or for type checkers only, with their origin."""
    tree = ast.parse(inspect.getsource(sys.modules[module]))
    return {
        alias.asname or alias.name: (node.module, alias.name)
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("sigmatau")
        for alias in node.names
    }


def _resolved(name, module):
    value = getattr(sys.modules[module], name, None)
    if value is None and name in _imports(module):
        source, attribute = _imports(module)[name]
        value = getattr(importlib.import_module(source), attribute, None)
    return value


def is_own(candidate):
    return (
        inspect.isclass(candidate)
        and candidate.__module__.startswith("sigmatau")
        and not candidate.__name__.startswith("_")
    )


def classes_of(annotation, module):
    """The classes of sigmatau in an annotation, including those of an alias."""
    for name in re.findall(r"[A-Za-z_]\w*", str(annotation)):
        value = _resolved(name, module)
        if is_own(value):
            yield value
        else:
            for part in typing.get_args(value):
                part = part.__forward_arg__ if isinstance(part, typing.ForwardRef) else part
                if is_own(part):
                    yield part
                elif isinstance(part, str):
                    yield from classes_of(part, module)


def function_of(member):
    """The function of a method, a property or a class method; None for anything else."""
    member = member.fget if isinstance(member, property) else getattr(member, "func", member)
    member = getattr(member, "__func__", member)
    return inspect.unwrap(member) if inspect.isfunction(member) else None


def is_protocol(cls):
    """Whether a class is a protocol: its attributes are documented where they are implemented."""
    return getattr(cls, "_is_protocol", False)


def members(cls):
    """Public methods and properties of a class by name, including those inherited from sigmatau, each with its class."""
    members_ = {}
    if is_protocol(cls):
        return members_
    for owner in cls.__mro__:
        if owner.__module__.startswith("sigmatau"):
            for name, member in vars(owner).items():
                if not name.startswith("_") and function_of(member) and f"{cls.__name__}.{name}" not in INTERNAL:
                    members_.setdefault(name, (owner, member))
    return members_


def public_fields(cls):
    """Public fields of a dataclass, each with the class that annotates it."""
    if not is_dataclass(cls):
        return {}
    named = [field.name for field in fields(cls) if not field.name.startswith("_")]
    named = [name for name in named if f"{cls.__name__}.{name}" not in INTERNAL]
    return {name: next(k for k in cls.__mro__ if name in vars(k).get("__annotations__", {})) for name in named}


def _reached_from(described):
    if not inspect.isclass(described):
        for annotation in described.__annotations__.values():
            yield from classes_of(annotation, described.__module__)
        return
    for name, owner in public_fields(described).items():
        yield from classes_of(owner.__annotations__[name], owner.__module__)
    for _, member in members(described).values():
        yield from _reached_from(function_of(member))


def is_finding_kind(candidate):
    return is_own(candidate) and candidate.__module__ in {kind.__module__ for kind in kinds()}


@functools.cache
def public():
    """Every public class and function by its name: ``"allan"``, ``"sigmatau.noise.terms.avar"``, …"""
    reached = dict(exported())
    for name, described in imported_by_pages().items():
        if described not in reached.values() and (inspect.isclass(described) or inspect.isfunction(described)):
            reached[name] = described
    waiting = [*reached.values()]
    for module, name in data_imported_by_pages():
        annotation = vars(sys.modules[module]).get("__annotations__", {}).get(name, "")
        waiting += [described for described in classes_of(annotation, module) if described not in reached.values()]
    reached |= {
        f"{described.__module__}.{described.__name__}": described
        for described in waiting
        if described not in reached.values()
    }
    while waiting:
        for described in _reached_from(waiting.pop()):
            if described not in reached.values() and not is_finding_kind(described) and described is not Details:
                reached[f"{described.__module__}.{described.__name__}"] = described
                waiting.append(described)
    return reached


@functools.cache
def public_functions():
    """Functions of the public names, and methods and properties of their classes: each once, with its class."""
    functions = {}
    for name, described in public().items():
        if inspect.isclass(described):
            for member_name, (owner, member) in members(described).items():
                if not any(member is function for _, function in functions.values()):
                    short = name.rpartition(".")[0]
                    functions[f"{short}.{owner.__name__}.{member_name}".lstrip(".")] = (owner, member)
        else:
            functions[name] = (None, described)
    return functions


@functools.cache
def kinds():
    """The kinds of `sigmatau.findings`: classes of the parameters of findings, and of the reasons of fits."""
    names = {*(kind.__module__ for kind in details_by_code().values()), "sigmatau.findings.reasons"}
    modules = [importlib.import_module(name) for name in sorted(names)]
    return [
        cls for module in modules for cls in vars(module).values() if is_own(cls) and cls.__module__ == module.__name__
    ]
