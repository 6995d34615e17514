"""One fault, one warning: what a disturbance does to the fit and to the segments is told, but is no fault of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sigmatau.findings.finding import Finding
from sigmatau.quality.drift.drift import BESIDE
from sigmatau.quality.spectrum.axis_correlation import OVER

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
"""Faults at a time, the plainest first."""

_SETTLING = ("warm_up", "late_drift")

_DRIFTS = (*_SETTLING, "temperature_drift")

_LEVEL = "the level "
"""How a finding about nothing but changes of level begins."""

_SEGMENTS = 8

_WORDS = {
    "dropout": "dropout",
    "saturation": "saturation",
    "stuck_samples": "stuck samples",
    "interpolated": "made-up samples",
    "start_transient": "start",
    "not_static": "disturbance",
    "warm_up": "warm-up",
    "late_drift": "drift",
    "spikes": "spikes",
}


def one_cause(findings: Sequence[Finding], channels: Sequence[str], duration: float) -> list[Finding]:
    """Findings with those as information that follow from a fault of the samples that is told already.

    Noise that is largest in the segment with the fault, lines that are all broad, and a curve without an adequate model are
    told as information that names the fault. They stay warnings if there is no such fault, and noise that is largest
    elsewhere does in any case.

    Parameters
    ----------
    findings : sequence of Finding
    channels : sequence of str
        All channels: a finding of several axes names them in its message.
    duration : float
        Of the record. [s]
    """
    findings = _without_steps_of_drifts(findings)
    causes: dict[str, Finding] = {}
    for code in _LOCAL:
        for finding in findings:
            if finding.code != code or finding.severity != "warning" or not finding.where:
                continue
            for channel in [finding.channel] if finding.channel else [c for c in channels if c in finding.message]:
                causes.setdefault(channel, finding)
    drifting = {finding.channel for finding in findings if finding.code in _DRIFTS}
    said = []
    for finding in findings:
        if finding.code == "correlated_axes" and _of_drifts(finding, channels, drifting):
            message = f"{finding.message}; the drifts that are told of them may be all of the reason"
            said.append(replace(finding, severity="info", message=message))
            continue
        cause = causes.get(finding.channel or "")
        if cause is None or finding.severity != "warning" or not _follows(finding, cause, duration):
            said.append(finding)
            continue
        remedy = (
            f"see to the {_WORDS[cause.code]} first, and analyse again without it: what is left then is another fault"
        )
        message = f"{finding.message}; the {_WORDS[cause.code]} at {cause.where} may be all of the reason"
        said.append(replace(finding, severity="info", message=message, remedy=remedy))
    return said


def _of_drifts(finding: Finding, channels: Sequence[str], drifting: set[str | None]) -> bool:
    """Whether axes share only slow changes, and each of them drifts: as all do that warm up together."""
    if finding.severity == "info" or "neighbouring" in finding.message:
        return False
    return OVER in finding.message and all(c in drifting for c in channels if c in finding.message)


def _follows(finding: Finding, cause: Finding, duration: float) -> bool:
    if finding.code == "no_adequate_model":
        return True
    if finding.code == "spectral_line":  # what rings down or comes now and then has a broad line, what goes on has not
        return finding.message.count(" Hz wide") == finding.message.count("amplitude")
    if finding.code != "non_stationary":
        return False
    begins = _spans(finding.where)
    if not begins:
        return False
    first, last = begins[0][0] - 1e-3 * duration, begins[0][0] + duration * (1 / _SEGMENTS + 1e-3)
    return any(start <= last and stop >= first for start, stop in _spans(cause.where))


def _without_steps_of_drifts(findings: Sequence[Finding]) -> list[Finding]:
    """Without the changes of level that are part of a warm-up or a late drift of the same channel: it is told once."""
    drifts = {f.channel: _spans(f.where)[0] for f in findings if f.code in _SETTLING and _spans(f.where)}

    told = {f.channel for f in findings if f.code == "not_static" and f.message.startswith(BESIDE)}

    def part_of_drift(finding: Finding) -> bool:
        if finding.code != "not_static" or finding.channel not in drifts or not finding.message.startswith(_LEVEL):
            return False
        if finding.channel in told:  # those that are none of it are told beside it
            return True
        start, stop = drifts[finding.channel]
        return all(start <= a and b <= stop for a, b in _spans(finding.where))

    return [finding for finding in findings if not part_of_drift(finding)]


def _spans(where: str) -> list[tuple[float, float]]:
    """Beginnings and ends in a place: ``"t = 600 s, 1200 s"`` or ``"t = 800 s to 860 s"``."""
    if not where.startswith("t = "):
        return []
    spans = []
    for text in where[4:].split(","):
        start, _, stop = text.partition(" to ")
        begins = float(start.split()[0])
        spans.append((begins, float(stop.split()[0]) if stop else begins))
    return spans
