"""One fault, one warning: what a disturbance does to the fit and to the segments is told, but is no fault of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from sigmatau.results import Finding

__all__ = ["one_cause"]

_LOCAL = ("dropout", "saturation", "stuck_samples", "not_static", "spikes")
"""Faults of samples at a time, the plainest first."""

_SEGMENTS = 8

_WORDS = {
    "dropout": "dropout",
    "saturation": "saturation",
    "stuck_samples": "stuck samples",
    "not_static": "disturbance",
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
    causes: dict[str, Finding] = {}
    for code in _LOCAL:
        for finding in findings:
            if finding.code != code or finding.severity != "warning":
                continue
            for channel in [finding.channel] if finding.channel else [c for c in channels if c in finding.message]:
                causes.setdefault(channel, finding)
    said = []
    for finding in findings:
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


def _follows(finding: Finding, cause: Finding, duration: float) -> bool:
    if finding.code == "no_adequate_model":
        return True
    if finding.code == "spectral_line":  # what rings down or comes now and then has a broad line, what goes on has not
        return finding.message.count(" Hz wide") == finding.message.count("amplitude")
    if finding.code != "non_stationary":
        return False
    begins, at = _seconds(finding.where), _seconds(cause.where)
    if begins is None or at is None:
        return False
    return begins - 1e-3 * duration <= at <= begins + duration * (1 / _SEGMENTS + 1e-3)


def _seconds(where: str | None) -> float | None:
    if not where or not where.startswith("t = "):
        return None
    return float(where[4:].split()[0])
