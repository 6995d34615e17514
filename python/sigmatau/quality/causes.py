"""One fault, one warning: a finding that another one may explain becomes an info and names it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sigmatau.findings.finding import Cause, Finding
from sigmatau.findings.kinds.disturbances import NotStatic
from sigmatau.findings.kinds.spectrum import CorrelatedAxes, SpectralLines

__all__ = ["one_cause"]

_LOCAL = (
    "dropout",
    "saturation",
    "stuck_samples",
    "interpolated",
    "start_transient",
    "not_static",
    "spikes",
    "warm_up",
    "late_drift",
)
"""Faults with a span, in the order in which they are taken as the cause."""

_EXPONENTIAL = ("warm_up", "late_drift")
_DRIFTS = (*_EXPONENTIAL, "temperature_drift")
_SEGMENTS = 8  # of a record, that `non_stationary` compares
_STRONGEST_LINES = 4  # that must all be broad


def one_cause(findings: Sequence[Finding], channels: Sequence[str], duration: float) -> list[Finding]:
    """Findings, with those as infos with a `cause` that follow from another finding.

    These are noise that is largest in the segment with a fault, lines that are all broad, a curve without an adequate
    model, and axes that share their drifts. `channels` are all that were analysed, `duration` that of the record. [s]
    """
    findings = _without_steps_of_drifts(findings)
    causes: dict[str, Finding] = {}
    for code in _LOCAL:
        for finding in findings:
            if finding.code == code and finding.severity == "warning" and finding.spans:
                for channel in finding.channels:
                    if channel in channels:
                        causes.setdefault(channel, finding)
    drifts = {finding.channel: finding for finding in findings if finding.code in _DRIFTS}
    return [_explained(finding, causes, drifts, duration) for finding in findings]


def _explained(
    finding: Finding, causes: dict[str, Finding], drifts: dict[str | None, Finding], duration: float
) -> Finding:
    details = finding.details
    if finding.severity != "warning":
        return finding
    cause = causes.get(finding.channel or "")
    if isinstance(details, CorrelatedAxes):
        together = details.only_slow and all(channel in drifts for channel in finding.channels)
        cause = drifts[finding.channels[0]] if together else None
    elif cause is not None and not _follows(finding, cause, duration):
        cause = None
    if cause is None:
        return finding
    return replace(finding, severity="info", cause=Cause(code=cause.code, spans=cause.spans))


def _follows(finding: Finding, cause: Finding, duration: float) -> bool:
    if finding.code == "no_adequate_model":
        return True
    if isinstance(finding.details, SpectralLines):  # a disturbance that rings or recurs makes broad lines only
        return all(line.width > 0 for line in finding.details.lines[:_STRONGEST_LINES])
    if finding.code != "non_stationary" or not finding.spans:
        return False
    begins = finding.spans[0][0]
    first, last = begins - 1e-3 * duration, begins + duration * (1 / _SEGMENTS + 1e-3)
    return any(start <= last and stop >= first for start, stop in cause.spans)


def _without_steps_of_drifts(findings: Sequence[Finding]) -> list[Finding]:
    """Without the steps of the level that are part of a warm-up or a late drift of the same channel."""
    drifts = {f.channel: f.spans[0] for f in findings if f.code in _EXPONENTIAL and f.spans}
    separate = {f.channel for f in findings if _steps(f, beside_drift=True)}

    def part_of_drift(finding: Finding) -> bool:
        if finding.channel not in drifts or not _steps(finding, beside_drift=False):
            return False
        start, stop = drifts[finding.channel]  # steps that are not part of the drift have their own finding
        return finding.channel in separate or all(start <= a and b <= stop for a, b in finding.spans)

    return [finding for finding in findings if not part_of_drift(finding)]


def _steps(finding: Finding, *, beside_drift: bool) -> bool:
    """Whether a finding is about steps of the level only, beside a drift or not."""
    one = finding.details
    return isinstance(one, NotStatic) and bool(one.steps) and not one.bursts and one.beside_drift is beside_drift
