"""Kinds of findings about samples that are read while they are logged."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from sigmatau.findings.finding import Details

__all__ = ["LinesLost"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LinesLost(Details):
    """Lines that cannot be read are left out; the samples around them are taken as consecutive.

    Attributes
    ----------
    lines : int
    last : str
        Beginning of the last of them.
    """

    code: ClassVar[str] = "lines_lost"

    lines: int
    last: str
