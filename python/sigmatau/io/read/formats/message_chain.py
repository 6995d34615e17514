"""What flight logs share: chains of messages without checksums, which are believed only as far as they hold."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.io.read.table import REST_MISSING

__all__ = ["broken"]


def broken(scan: Mapping[str, Any], size: int) -> tuple[Finding, ...]:
    """Where a chain breaks off, from a scan of `sigmatau._native.logs`; nothing if it holds to the end of the file.

    Parameters
    ----------
    scan : mapping
        With ``messages`` and ``broken``.
    size : int
        Of the file. [bytes]
    """
    if scan["broken"] is None:
        return ()
    at, what = scan["broken"]
    read = f"{scan['messages']} messages were read"
    if what is None:
        message = f"the log breaks off in the middle of a message at byte {at} of {size}; {read}"
        return (Finding(code="broken_off", severity="error", message=message, effect=REST_MISSING),)
    message = f"the log is damaged at byte {at} of {size}: {what}; {read} up to there"
    return (Finding(code="damaged", severity="error", message=message, effect=REST_MISSING),)
