"""Lists of findings in words, for the terminal and errors: the most likely causes first, one line per kind."""

from __future__ import annotations

from typing import TYPE_CHECKING

from sigmatau.findings.finding import Finding, effects, ranked
from sigmatau.findings.phrases import short_axes
from sigmatau.results import WIDTH, printable, wrapped

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence


def sentence(finding: Finding) -> str:
    """The words of a finding in the text of an error: its message, then its action after a semicolon."""
    message, action = finding.words()
    return f"{message}; {action[0].lower()}{action[1:]}" if action else message


def causes(findings: Iterable[Finding], *, rest: str, max_kinds: int = 5, room: int = 0) -> list[str]:
    """The important findings: errors, warnings and excluded samples, one line per kind, for its worst axis. Errors include
    what to do.

    Parameters
    ----------
    findings : iterable of Finding
    max_kinds : int
        Largest number of listed kinds. Warnings name as many axes as fit; a last line counts and names the other kinds.
    rest : str
        Where the other findings are listed.
    room : int
        Lines of the terminal that the list may use. Warnings are listed with actions as far as the
        lines suffice, and the worst one always. 0: actions of errors only.

    Returns
    -------
    list of str
    """
    findings = tuple(findings)
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in ranked(findings):
        if finding.severity != "info" or finding.left_out:
            kinds.setdefault((finding.severity, finding.code), []).append(finding)
    shown = _choose_kinds(list(kinds.values()), max_kinds)
    lines = [_cause(alike) for alike in shown]
    for k, alike in enumerate(shown if room else ()):
        action = _worst(alike).action if alike[0].severity == "warning" else ""
        longer = [*lines[:k], f"{lines[k]}. {action}", *lines[k + 1 :]]
        if action and (k == 0 or len(wrapped(longer)) <= room):
            lines = longer
    while room and len(wrapped(lines)) > room and shown[-1][0].severity == "info":
        shown, lines = shown[:-1], lines[:-1]
    named = {finding for alike in shown for finding in alike}
    if unnamed := [finding for finding in findings if finding not in named]:
        lines.append(_count_unnamed(unnamed, rest))
    return lines


def _choose_kinds(kinds: Sequence[list[Finding]], number: int) -> list[list[Finding]]:
    """Select the first `number` kinds of findings, but replace some by later ones that concern axes not yet named:
    infos first, then warnings all of whose axes have another selected kind.
    """
    shown = list(kinds[:number])
    for alike in kinds[number:]:
        if alike[0].severity == "info" or _channels([alike]) <= _channels(shown):
            continue
        for k in reversed(range(len(shown))):
            rest = [*shown[:k], *shown[k + 1 :]]
            axes = _channels([shown[k]])
            if shown[k][0].severity == "info" or (
                shown[k][0].severity == "warning" and axes and axes <= _channels(rest)
            ):
                shown = [*rest, alike]
                break
    return shown


def _channels(kinds: Iterable[Iterable[Finding]]) -> set[str]:
    """The axes that have errors and warnings."""
    return {
        channel for alike in kinds for finding in alike if finding.severity != "info" for channel in finding.channels
    }


def _count_unnamed(findings: Sequence[Finding], rest: str) -> str:
    """Number and kinds of the findings not listed, as far as they fit on a line, those that exclude samples first."""
    ordered = sorted(findings, key=lambda finding: not (finding.left_out or finding.code.endswith("left_out")))
    names = [code.replace("_", " ") for code in dict.fromkeys(finding.code for finding in ordered)]
    line = f"· {len(findings)} more"
    for k in range(len(names), 0, -1):
        text = f"{line}: {', '.join(names[:k])}{', …' if k < len(names) else ''}; see {rest}"
        if len(text) <= WIDTH:
            return text
    return f"{line}; see {rest}"


def _worst(alike: Sequence[Finding]) -> Finding:
    return max(alike, key=lambda finding: (effects(finding), abs(finding.size or 0.0)))


def _cause(alike: Sequence[Finding]) -> str:
    worst = _worst(alike)
    more_axes = tuple(dict.fromkeys(c for finding in alike for c in finding.channels if c not in worst.channels))
    axes = short_axes(worst.channels) if worst.channels else ""
    about = "".join(f"{name}: " for name in (worst.topic, axes) if name)
    also = f" (also {short_axes(more_axes)})" if more_axes else ""
    done = f". {worst.action}" if worst.action and worst.severity == "error" else ""
    return printable(f"{_MARKS[worst.severity]} {about}{worst.message}{also}{done}")


_MARKS = {"error": "!!", "warning": "!", "info": "·"}
