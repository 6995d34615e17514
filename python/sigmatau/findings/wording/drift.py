"""Words of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

WORDS: dict[type, Callable[[Finding, Any], Words]] = {}
