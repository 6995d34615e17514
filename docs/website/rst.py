"""Pieces of reStructuredText."""

from __future__ import annotations

import re

_SPECIAL = re.compile(r"([\\*`|_])")


def heading(text: str, line: str) -> list[str]:
    """Lines of a heading."""
    return ["", text, line * len(text), ""]


def escaped(text: str) -> str:
    """A text on one line, without markup."""
    return _SPECIAL.sub(r"\\\1", " ".join(text.split()))
