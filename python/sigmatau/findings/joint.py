"""Findings about runs that are fitted jointly."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from sigmatau.digits import significant
from sigmatau.findings.finding import Details, Finding, Words
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.noise.terms import TERMS


@frozen
class RunDiffers(Details, code="run_differs"):
    """A run differs from the model of the others.

    Attributes
    ----------
    run : str
        Name of the run.
    runs : int
        Number of runs in the joint fit.
    term : str or None
        The term that differs; None for the shape of the spectrum, with its filter.
    factor : float or None
        Coefficient of the run over that of the others; None if they do not show it. [1]
    p_value : float
        P-value of equality, corrected for the number of runs and tests. [1]
    """

    run: str
    runs: int
    term: str | None
    factor: float | None
    p_value: float

    def words(self, finding: Finding) -> Words:
        action = "Fit the other runs without it, or find what differed in this run"
        if self.term is None:
            return Words(
                f"{self.run}: the spectrum differs from that of the other runs (p = {self.p_value:.1g})", action
            )
        label = TERMS[self.term].label("")
        if self.factor is None:
            return Words(f"{self.run} shows {label}, and the other runs do not (p = {self.p_value:.1g})", action)
        return Words(
            f"{self.run}: {label} is {significant(self.factor)} times that of the other runs (p = {self.p_value:.1g})",
            action,
        )


@frozen
class RunsDiffer(Details, code="runs_differ"):
    """A term that is treated as common is not the same in all runs.

    Attributes
    ----------
    runs : int
        Number of runs in the joint fit.
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    p_value : float
        P-value of equality. [1]
    """

    runs: int
    term: str
    p_value: float

    def words(self, finding: Finding) -> Words:
        label = TERMS[self.term].label("")
        return Words(
            f"{label} is not the same in all {self.runs} runs (p = {self.p_value:.1g}); its interval is too narrow",
            f"Leave out the run that differs, or leave the term out of {Hint('common')}",
        )


Unfit = Literal["too_few_samples", "constant", "coarse_counts", "only_run", "disturbed"]
"""Why a channel of a run is not in a joint fit."""

UNFIT_WORDS: Mapping[str, str] = {
    "too_few_samples": "it has too few samples",
    "constant": "it never changes",
    "coarse_counts": "the rounding of its increments is not white",
    "only_run": "it is the only run with this channel",
    "disturbed": "vibration hides its noise",
}


@frozen
class RunLeftOut(Details, code="run_left_out"):
    """A channel of a run is not in the joint fit.

    Attributes
    ----------
    run : str
        Name of the run.
    reason : str
        ``"too_few_samples"``, ``"constant"``, ``"coarse_counts"``, ``"only_run"`` or ``"disturbed"``; a text in results of
        earlier versions.
    """

    run: str
    reason: str

    def words(self, finding: Finding) -> Words:
        return Words(
            f"{self.run} is not in the joint fit: {UNFIT_WORDS.get(self.reason, self.reason)}",
            "Correct the log, or name the logs without it",
        )
