"""The kinds of findings: one frozen dataclass per kind, in SI units, with its code; one module per subject."""

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
    from sigmatau.findings.finding import Details
    from sigmatau.findings.wording import SUBJECTS

    modules = [import_module(f"{__name__}.{subject}") for subject in SUBJECTS]
    members = (member for module in modules for member in vars(module).values())
    classes = (each for each in members if isinstance(each, type) and issubclass(each, Details))
    return {each.code: each for each in classes if each.code}
