"""The spans of a finding about many stretches of a record: all of them, up to a bound on their number."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.findings.finding import Span

_Times = NDArray[np.floating[Any]]

MAX_SPANS = 1000
"""Largest number of spans in a finding; the longest stretches are listed. For six channels they take 0.3 MB of JSON."""


def longest_spans(starts: _Times, stops: _Times) -> tuple[tuple[Span, ...], int]:
    """Select the longest `MAX_SPANS` stretches, in their order, and count the others. [s]"""
    listed = np.sort(np.argsort(starts - stops, kind="stable")[:MAX_SPANS])
    spans = tuple(zip(starts[listed].tolist(), stops[listed].tolist(), strict=True))
    return spans, len(starts) - len(listed)
