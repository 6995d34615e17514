"""Words of findings about spectra: lines, low-pass filters, resampling, common noise."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.wording.phrases import Words

__all__ = ["WORDS"]

WORDS: dict[type, Callable[[Finding, Any], Words]] = {}
