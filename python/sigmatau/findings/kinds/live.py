"""Kinds of findings about samples that are read while they are logged."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class LinesLost(Details, code="lines_lost"):
    """Lines that cannot be read are left out; the samples around them are taken as consecutive."""

    lines: int
    last: str  # beginning of the last of them
