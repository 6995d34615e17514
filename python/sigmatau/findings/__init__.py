"""Findings about a record, as typed data.

A module per subject has its kinds: frozen dataclasses in SI units, each with its code and its words.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sigmatau.findings.finding import Details


@cache
def details_by_code() -> Mapping[str, type[Details]]:
    """All kinds of findings, by their code."""
    from pkgutil import iter_modules

    from sigmatau.findings.finding import Details

    modules = [import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__)]
    members = (member for module in modules for member in vars(module).values())
    classes = (each for each in members if isinstance(each, type) and issubclass(each, Details))
    return {each.code: each for each in classes if each.code}
