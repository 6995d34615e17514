"""Kinds of findings about runs that are fitted jointly."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class RunDiffers(Details, code="run_differs"):
    """A run does not have the model of the others."""

    run: str  # its name
    runs: int  # of the joint fit
    term: str | None  # that differs; None for the shape of the spectrum, with its filter
    factor: float | None  # coefficient of the run over that of the others; None if they do not show it
    p_value: float  # corrected for the number of runs and tests


@frozen
class RunsDiffer(Details, code="runs_differ"):
    """A term that is taken as common is not the same in all runs."""

    runs: int  # of the joint fit
    term: str
    p_value: float


@frozen
class RunLeftOut(Details, code="run_left_out"):
    """A channel of a run is not in the joint fit."""

    run: str
    reason: str  # why it cannot be used
