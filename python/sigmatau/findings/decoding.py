"""Findings from JSON. A kind that this version has with these parameters is restored; otherwise the words in the JSON
are kept.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from sigmatau.decoding import WrongValueError, decode_details, key
from sigmatau.findings import details_by_code
from sigmatau.findings.finding import Details, Finding, Severity, Span, Stated
from sigmatau.frozen import frozen


@frozen
class FindingForm:
    """A finding; `channel` occurs only in schema 1."""

    code: str = key(default="", always=True)
    severity: Severity = key(default="info", always=True)
    channels: tuple[str, ...] = key("affected channels; empty for the whole record", default=(), always=True)
    channel: str | None = None
    message: str = key(default="", always=True)
    action: str = key("action to take; may be empty", default="", always=True)
    spans_s: tuple[Span, ...] = key(
        "start and end times of the stretches, from the beginning of the record; the 1000 longest if there are more",
        default=(),
    )
    more_spans: int = key("number of the stretches that are not in spans_s", default=0, minimum=1)
    size: float | None = key(default=None, null=True)
    unit: str = key("unit of the size; empty for a bare number", default="")
    factors: Mapping[str, float] = key(
        "for each biased term, the coefficient divided by the true coefficient of the sensor", factory=dict, null=True
    )
    left_out: int = key(
        "largest number of samples of a channel that were treated as missing because of this finding",
        default=0,
        minimum=1,
    )
    topic: str = key("topic or table of the file that the finding is about, if several are read", default="")
    details: Mapping[str, Any] = key(
        "parameters of the finding, in SI; see allOf for the parameters of each code", factory=dict, always=True
    )


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
