"""Words of findings about samples that are read while they are logged."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.live import LinesLost
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

_LONGEST = 20  # characters of a line that are shown


def _lines_lost(finding: Finding, details: LinesLost) -> Words:
    lines = "1 unreadable line" if details.lines == 1 else f"{details.lines} unreadable lines"
    return Words(
        f"{lines} skipped, the last {details.last[:_LONGEST]!r}; the samples before and after are treated as consecutive",
        "Check the connection and the logger",
    )


WORDS: dict[type, Callable[[Finding, Any], Words]] = {LinesLost: _lines_lost}
