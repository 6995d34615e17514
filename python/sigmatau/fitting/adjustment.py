"""Changes that a check of the record makes to a fit, as data. `sigmatau.fitting.adjust` applies them."""

from __future__ import annotations

from typing import Any, Literal

from sigmatau.decoding import key
from sigmatau.findings.reasons import Reason
from sigmatau.fitting.fitted_values import FittedTerm, Interval
from sigmatau.frozen import frozen
from sigmatau.model.parameters import Parameter
from sigmatau.results import Plain, plain

Verdict = Literal["adequate", "adequate_with", "widened", "disturbed", "descriptive", "too_short"]
Cause = Literal["vibration", "coarse_counts", "crowded_lines", "changing_level", "misfit", "rounding", "bias"]
Part = Literal[
    "gauss_markov",
    "sinusoid",
    "resonance",
    "response",
    "warm_up",
    "highest",
    "alike_from",
    "alike_sigma",
    "second",
    "unclear",
    "discrepancy",
    "reasons",
    "covariance",
]


@frozen(kw_only=False)
class Ends(Plain):
    """Interval or upper limit of a number.

    Attributes
    ----------
    low, high : float or None
        Ends of the interval; None without one. [SI]
    upper_limit : float or None
        Upper limit of a term that was not observed. [SI]
    """

    low: float | None
    high: float | None
    upper_limit: float | None

    @classmethod
    def of(cls, number: FittedTerm | Interval) -> Ends:
        """The ends of a number.

        Parameters
        ----------
        number : FittedTerm or Interval
            A term, or a number of a process.

        Returns
        -------
        Ends
        """
        return cls(number.low, number.high, getattr(number, "upper_limit", None))

    @property
    def width(self) -> float:
        """Width of the interval; 0 without one. [SI]"""
        return 0.0 if self.low is None or self.high is None else max(self.high - self.low, 0.0)


@frozen(kw_only=False)
class Change(Plain):
    """Change of the interval or of the upper limit of one number of a fit.

    Attributes
    ----------
    parameter : Parameter
    kind : {"widen", "limit"}
        "widen": the interval or limit changes. "limit": the interval becomes a limit, or is removed.
    before, after : Ends
    scale : float
        Ratio of the standard error in the covariance to that before the change. [1]
    """

    parameter: Parameter
    kind: Literal["widen", "limit"]
    before: Ends
    after: Ends
    scale: float = key("ratio of the standard error to that before the change", default=1.0, always=True)

    @classmethod
    def limiting(cls, parameter: Parameter, number: FittedTerm | Interval, limit: float | None = None) -> Change:
        """Build a change that leaves only a limit, or neither an interval nor a limit.

        Parameters
        ----------
        parameter : Parameter
            The number that changes.
        number : FittedTerm or Interval
            The number before the change.
        limit : float, optional
            [SI]

        Returns
        -------
        Change
        """
        return cls(parameter, "limit", Ends.of(number), Ends(None, None, limit))

    @classmethod
    def widening(cls, parameter: Parameter, before: Ends, after: Ends) -> Change:
        """Build a change of an interval or limit. The standard error grows with the width of the interval.

        Parameters
        ----------
        parameter : Parameter
            The number that changes.
        before, after : Ends
            Ends before and after the change. [SI]

        Returns
        -------
        Change
        """
        scale = after.width / before.width if before.width > 0 and after.width > 0 else 1.0
        return cls(parameter, "widen", before, after, scale)


@frozen
class Adjustment:
    """Change of a fit by one check of the record.

    Attributes
    ----------
    cause : str
        The check, in the order in which adjustments are applied: "vibration" or "coarse_counts" (they hide the noise),
        "crowded_lines", "changing_level" (of white noise), "misfit", "rounding", "bias" (stated by findings).
    findings : tuple of str
        Codes of the findings that state the cause.
    changes : tuple of Change
        Changes by number. A number that is replaced by a limit is removed from the covariance.
    verdict : str or None
        New verdict of the fit; None if it does not change.
    without : tuple of str
        Parts that are removed from the fit.
    tau_min : float or None
        Shortest averaging time that the fit describes; None if it does not change. [s]
    reason : Reason or None
        Reasons for the fit. They are not in the JSON of the adjustment, but in that of the fit.
    """

    cause: Cause
    findings: tuple[str, ...] = key(default=(), always=True)
    changes: tuple[Change, ...] = key(default=(), always=True)
    verdict: Verdict | None = key(default=None, always=True, null=True)
    without: tuple[Part, ...] = key(default=(), always=True)
    tau_min: float | None = key("shortest averaging time that remains, in s", default=None, always=True, null=True)
    reason: Reason | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "cause findings changes verdict without tau_min")
