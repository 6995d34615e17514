"""Words of findings about exported files and files read back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

WORDS: dict[type, Callable[[Finding, Any], Words]] = {}
