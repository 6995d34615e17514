"""Words of findings about runs that are fitted jointly."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from sigmatau.findings.finding import Finding
from sigmatau.findings.kinds import joint as kinds
from sigmatau.findings.wording.phrases import Words, number
from sigmatau.noise.terms import TERMS


def _run_differs(_: Finding, d: kinds.RunDiffers) -> Words:
    action = "Fit the other runs without it, or find what differed in this run"
    if d.term is None:
        return Words(f"{d.run}: its spectrum is not that of the other runs (p = {d.p_value:.1g})", action)
    label = TERMS[d.term].label("")
    if d.factor is None:
        return Words(f"{d.run}: has {label}, which the other runs do not show (p = {d.p_value:.1g})", action)
    return Words(f"{d.run}: {label} is {number(d.factor)} times that of the other runs (p = {d.p_value:.1g})", action)


def _runs_differ(_: Finding, d: kinds.RunsDiffer) -> Words:
    label = TERMS[d.term].label("")
    return Words(
        f"{label} is not the same in all {d.runs} runs (p = {d.p_value:.1g}); its interval is too narrow",
        "Leave out the run that differs, or leave the term out of --common",
    )


def _run_left_out(_: Finding, d: kinds.RunLeftOut) -> Words:
    return Words(f"{d.run} is not in the joint fit: {d.reason}", "Correct the log, or name the logs without it")


WORDS: dict[type, Callable[[Finding, Any], Words]] = {
    kinds.RunDiffers: _run_differs,
    kinds.RunsDiffer: _runs_differ,
    kinds.RunLeftOut: _run_left_out,
}
"""What words each kind."""
