"""Names of runs and units, short enough for the labels of a figure."""

from __future__ import annotations

import re
from collections.abc import Sequence

LONGEST = 18
"""Longest label. [characters]"""


def common_prefix(names: Sequence[str]) -> str:
    """The beginning that all names share, in whole words; empty if all names are short enough.

    Examples
    --------
    >>> common_prefix(["2026-11_static_A001", "2026-11_static_A012"])
    '2026-11_static_'
    >>> common_prefix(["unit 1", "unit 2"])
    ''
    """
    if len(names) < 2 or max(map(len, names)) <= LONGEST:
        return ""
    differ = (k for k, letters in enumerate(zip(*names, strict=False)) if len(set(letters)) > 1)
    words = re.match(r".*[\W_]", names[0][: next(differ, min(map(len, names)))], re.DOTALL)
    prefix = words[0] if words else ""
    return "" if prefix in names else prefix


def short_names(names: Sequence[str]) -> list[str]:
    """Each name without the common prefix; a name that is still too long is cut at its beginning.

    Examples
    --------
    >>> short_names(["2026-11_static_A001", "2026-11_static_A012"])
    ['A001', 'A012']
    >>> short_names(["bench 3, left side, upper slot", "bench 4"])
    ['… side, upper slot', '4']
    """
    start = len(common_prefix(names))
    return [_end(name[start:]) for name in names]


def _end(name: str) -> str:
    return name if len(name) <= LONGEST else f"…{name[1 - LONGEST :]}"
