"""The words of findings, for the terminal, the report and JSON alike: one module per subject, as in `findings.kinds`.

Each module has a table `WORDS` from a kind to the function that words it. A message is one sentence that names what was
found, where, and what it changes; the action is one sentence that says what to do, or empty.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from sigmatau.findings.wording.phrases import Words, axes_text, short_axes
from sigmatau.results import printable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from sigmatau.findings.finding import Finding

SUBJECTS = ("reading", "stamps", "rest", "disturbances", "values", "spectrum", "drift", "fit", "exporting")
"""Modules of this package, one per subject."""


_DISTURBANCES = (
    *("not_static", "start_transient", "spikes", "dropout", "stuck_samples", "saturation", "interpolated"),
    "repeated_samples",
)  # codes of findings about samples that may be left out


@cache
def _words_of(subject: str) -> Mapping[type, Callable[[Finding, Any], Words]]:
    """What words each kind of a subject."""
    table: Mapping[type, Callable[[Finding, Any], Words]] = import_module(f"{__name__}.{subject}").WORDS
    return table


def words(finding: Finding) -> Words:
    """The words of a finding.

    Parameters
    ----------
    finding : Finding

    Returns
    -------
    Words
        Message and action; the channels are not named in them unless one of several is meant.
    """
    kind = type(finding.details)
    said = _words_of(kind.__module__.rpartition(".")[2])[kind](finding, finding.details)
    if finding.left_out:
        return said._replace(message=f"{said.message}; left out{_axes(finding)}")
    if finding.severity == "warning" and not said.action and finding.code in _DISTURBANCES:
        return said._replace(action="Find the cause: these samples are part of the analysis")
    return said


def _axes(finding: Finding) -> str:
    """Where more was left out than the axes on which it was found."""
    return " on all axes" if finding.code in ("not_static", "start_transient") else ""


def sentence(finding: Finding) -> str:
    """The words of a finding for the text of an error: its message, and its action behind a semicolon."""
    action = finding.action
    return f"{finding.message}; {action[0].lower()}{action[1:]}" if action else finding.message


def line(finding: Finding) -> str:
    """A finding in one line, without its action: ``"warning: gyro_x: 3 spikes …"``."""
    about = f"{axes_text(finding.channels)}: " if finding.channels else ""
    return printable(f"{finding.severity}: {about}{finding.message}")


def causes(findings: Iterable[Finding], *, most: int = 5, rest: str = "--verbose") -> list[str]:
    """What matters: errors, warnings and what was left out, one line a kind of finding, of its worst axis; of an
    error, what to do.

    Parameters
    ----------
    findings : iterable of Finding
    most : int
        Kinds that are named; a last line counts the other findings.
    rest : str
        Where the other findings are.

    Returns
    -------
    list of str
    """
    from sigmatau.findings.finding import by_severity

    findings = tuple(findings)
    kinds: dict[str, list[Finding]] = {}
    for one in by_severity(findings):
        if one.severity != "info" or one.left_out:
            kinds.setdefault(one.code, []).append(one)
    told = list(kinds.values())[:most]
    lines = [_cause(alike) for alike in told]
    if left := len(findings) - sum(map(len, told)):
        lines.append(f"· {left} more finding{'s' if left > 1 else ''}, and what to do: {rest}")
    return lines


def _cause(alike: list[Finding]) -> str:
    worst = max(alike, key=lambda one: abs(one.size or 0.0))
    others = tuple(dict.fromkeys(c for one in alike for c in one.channels if c not in worst.channels))
    about = f"{short_axes(worst.channels)}: " if worst.channels else ""
    also = f" (also {short_axes(others)})" if others else ""
    done = f". {worst.action}" if worst.action and worst.severity == "error" else ""
    return printable(f"{_MARKS[worst.severity]} {about}{worst.message}{also}{done}")


_MARKS = {"error": "!!", "warning": "!", "info": "·"}
