"""The words of findings, for the terminal, the report and JSON alike: one module per subject, as in `findings.kinds`.

Each module has a table `WORDS` from a kind to the function that words it. A message is one sentence that names what was
found, where, and what it changes; the action is one sentence that says what to do, or empty.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from sigmatau.findings.wording.phrases import Words, axes_text

if TYPE_CHECKING:
    from collections.abc import Callable

    from sigmatau.findings.finding import Finding

__all__ = ["SUBJECTS", "Words", "line", "sentence", "words"]

SUBJECTS = ("reading", "stamps", "disturbances", "values", "spectrum", "drift", "fit", "exporting", "live")
"""Modules of this package, one per subject."""


_DISTURBANCES = (
    *("not_static", "start_transient", "spikes", "dropout", "stuck_samples", "saturation", "interpolated"),
    "repeated_samples",
)  # codes of findings about samples that may be left out


@cache
def _table() -> dict[type, Callable[[Finding, Any], Words]]:
    table: dict[type, Callable[[Finding, Any], Words]] = {}
    for subject in SUBJECTS:
        table.update(import_module(f"{__name__}.{subject}").WORDS)
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
    said = _table()[type(finding.details)](finding, finding.details)
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
    return f"{finding.severity}: {about}{finding.message}"
