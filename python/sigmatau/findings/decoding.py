"""Findings from JSON: their kind if this version has it with these parameters, otherwise what the JSON states."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import field
from typing import Any

from sigmatau.decoding import WrongValueError, decode_details
from sigmatau.findings import details_by_code
from sigmatau.findings.finding import Details, Finding, Severity, Span, Stated
from sigmatau.frozen import frozen


@frozen
class FindingForm:
    """A finding; `channel` is that of schema 1."""

    code: str = ""
    severity: Severity = "info"
    channels: tuple[str, ...] = ()
    channel: str | None = None
    message: str = ""
    action: str = ""
    spans_s: tuple[Span, ...] = ()
    more_spans: int = 0
    size: float | None = None
    unit: str = ""
    factors: Mapping[str, float] = field(default_factory=dict)
    left_out: int = 0
    topic: str = ""
    details: Mapping[str, Any] = field(default_factory=dict)

    @property
    def stated_text(self) -> str:
        """The finding in the words of the version that wrote it."""
        return self.message


def decode_finding(form: FindingForm) -> Finding:
    """The finding of its JSON form."""
    kind = details_by_code().get(form.code)
    details: Details = Stated(stated_code=form.code, message=form.message, action=form.action, parameters=form.details)
    if kind is not None:
        with contextlib.suppress(WrongValueError):  # details of another version
            details = decode_details(kind, form.details)
    return Finding(
        details=details,
        severity=form.severity,
        channels=form.channels or (() if form.channel is None else (form.channel,)),
        spans=form.spans_s,
        more_spans=form.more_spans,
        size=form.size,
        unit=form.unit,
        factors=tuple(form.factors.items()),
        left_out=form.left_out,
        topic=form.topic,
    )
