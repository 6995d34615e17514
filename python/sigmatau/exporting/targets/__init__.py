"""The targets of an export, one module each. Its `TARGET` declares the fields of the file.

A module is imported when its target is used. The name of a target is that of its module, with hyphens.
"""

from __future__ import annotations

from difflib import get_close_matches
from importlib import import_module
from pkgutil import iter_modules

from sigmatau.errors import OptionError
from sigmatau.exporting.target import Target

NAMES = tuple(sorted(module.name.replace("_", "-") for module in iter_modules(__path__)))
"""Names of the targets, as they are typed."""


def target(name: str) -> Target:
    """Find a target by its name or that of its program, in any case. Raises an `OptionError` that lists the names."""
    if not isinstance(name, str):
        raise OptionError(
            f"{{option}} must be the name of a target, not {name!r}; targets: {', '.join(NAMES)}", option="to"
        )
    typed = name.lower().replace("_", "-")
    without_hyphens = {full.replace("-", ""): full for full in NAMES}
    typed = without_hyphens.get(typed.replace("-", ""), typed)
    if typed in NAMES:
        return _load(typed)
    for each in map(_load, NAMES):
        if typed in each.aliases:
            return each
    close = get_close_matches(typed, NAMES, n=1)
    meant = f", perhaps {close[0]}" if close else ""
    raise OptionError(f"unknown target {name!r}{meant}; targets: {', '.join(NAMES)}", option="to")


def _load(name: str) -> Target:
    loaded: Target = import_module(f"{__name__}.{name.replace('-', '_')}").TARGET
    return loaded
