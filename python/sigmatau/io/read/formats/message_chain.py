"""Flight logs: chains of messages without checksums, which are read up to the first that does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds.reading import BrokenOff, Damage, Damaged, Place

__all__ = ["broken"]


def broken(scan: Mapping[str, Any], size: int) -> tuple[Finding, ...]:
    """A finding of where the chain of messages breaks off; nothing if it reaches the end of the file.

    `scan`: of `sigmatau._native.logs`, with ``messages`` and ``broken``; `size`: size of the file [bytes].
    """
    if scan["broken"] is None:
        return ()
    at, reason = scan["broken"]
    place, kept = Place("byte", at, of=size), scan["messages"]
    details: Damage = (
        BrokenOff(place=place, inside="message", kept=kept, counted="messages")
        if reason is None
        else Damaged(place=place, reason=reason, kept=kept, counted="messages")
    )
    return (Finding(details=details, severity="error"),)
