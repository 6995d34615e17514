"""Kinds of findings about runs that are fitted jointly."""

from __future__ import annotations

from sigmatau.findings.finding import Details
from sigmatau.frozen import frozen


@frozen
class RunDiffers(Details, code="run_differs"):
    """A run differs from the model of the others.

    Attributes
    ----------
    run : str
        Its name.
    runs : int
        Of the joint fit.
    term : str or None
        That differs; None for the shape of the spectrum, with its filter.
    factor : float or None
        Coefficient of the run over that of the others; None if they do not show it. [1]
    p_value : float
        P-value of no difference, corrected for the number of runs and tests.
    """

    run: str
    runs: int
    term: str | None
    factor: float | None
    p_value: float


@frozen
class RunsDiffer(Details, code="runs_differ"):
    """A term that is treated as common is not the same in all runs.

    Attributes
    ----------
    runs : int
        Of the joint fit.
    term : str
        Key of `sigmatau.noise.terms.TERMS`.
    p_value : float
        P-value of no difference.
    """

    runs: int
    term: str
    p_value: float


@frozen
class RunLeftOut(Details, code="run_left_out"):
    """A channel of a run is not in the joint fit.

    Attributes
    ----------
    run : str
        Its name.
    reason : str
        Reason why it cannot be used.
    """

    run: str
    reason: str
