"""Kinds of findings about samples that are read while they are logged."""

from __future__ import annotations

from dataclasses import dataclass

from sigmatau.findings.finding import Details


@dataclass(frozen=True, slots=True, kw_only=True)
class LinesLost(Details, code="lines_lost"):
    """Lines that cannot be read are left out; the samples around them are taken as consecutive."""

    lines: int
    last: str  # beginning of the last of them
