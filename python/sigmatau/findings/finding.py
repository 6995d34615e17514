"""A finding: code, severity, channels, spans of time, size, factors by coefficient, and the details of its kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, ClassVar, Literal

__all__ = ["Cause", "Details", "Finding", "FitEffect", "Severity", "Span", "by_severity", "damaged"]

Severity = Literal["info", "warning", "error"]

Span = tuple[float, float]
"""Beginning and end, from the beginning of the record; equal for a single instant. [s]"""

_FIRST = "no_adequate_model"  # no number has an interval then, which matters more than any other warning


@dataclass(frozen=True, slots=True, kw_only=True)
class Details:
    """What is known of one kind of finding, beside what all findings have: base of the classes in `findings.kinds`.

    Attributes
    ----------
    code : str
        Stable name of the kind, such as ``"spectral_line"``; a class attribute.
    """

    code: ClassVar[str] = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitEffect:
    """How the printed fit compares with a fit without the fault; by which factors is in `Finding.factors`.

    Attributes
    ----------
    channel : str
        Channel of the fit; of several channels the one that changes most.
    tau_min_s : float
        Shortest averaging time of the printed fit.
    compared_from_s : float
        Shortest averaging time of the fit without the fault.
    without : tuple of str
        Codes of the findings whose fault the other fit is without.
    verdict, verdict_without : str
        Verdicts of the printed fit and of the other one; the latter is empty if too little is left to fit.
    hidden : tuple of str
        Terms that the other fit observes and the printed fit does not, or limits to less.
    at_least : tuple of str
        Terms whose factor is a lower bound: the other fit does not observe them.
    lower_bound : bool
        Whether more of the fault stays undetected, so that all factors are lower bounds.
    counted_in : str
        Code of the finding with the factors, if several faults of a channel are counted together; else empty.
    """

    channel: str
    tau_min_s: float
    compared_from_s: float
    without: tuple[str, ...]
    verdict: str
    verdict_without: str = ""
    hidden: tuple[str, ...] = ()
    at_least: tuple[str, ...] = ()
    lower_bound: bool = False
    counted_in: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cause:
    """Another finding that may explain this one.

    Attributes
    ----------
    code : str
        Code of the other finding.
    spans : tuple of (float, float)
        Its spans. [s]
    """

    code: str
    spans: tuple[Span, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """Something to know about the record before a number is trusted.

    Attributes
    ----------
    details : Details
        The parameters of what was found; their class says which kind it is.
    severity : {"info", "warning", "error"}
    channels : tuple of str
        The channels concerned; empty for the whole record.
    spans : tuple of (float, float)
        Where in the record: beginnings and ends. [s]
    size : float or None
        How large it is, in `unit`.
    unit : str
        Unit of the size; empty for a bare number.
    factors : tuple of (str, float)
        Coefficients, by term, and the factor by which each is larger than the sensor's own.
    fit_effect : FitEffect or None
        What the factors of a fit are compared with; None if the factors are those of a value read off.
    cause : Cause or None
        The finding that may explain this one.
    """

    code: str = ""
    severity: Severity
    details: Details | None = None
    channels: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()
    size: float | None = None
    unit: str = ""
    factors: tuple[tuple[str, float], ...] = ()
    fit_effect: FitEffect | None = None
    cause: Cause | None = None
    # Not converted to `details` yet: words that were made where the finding was.
    message: str = ""
    channel: str | None = None
    effect: str = ""
    where: str = ""
    changes: tuple[tuple[str, float], ...] = ()
    remedy: str = ""

    def __post_init__(self) -> None:
        def put(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        if self.details is None:
            if not self.channels:
                put("channels", (self.channel,) if self.channel else ())
            put("factors", self.changes)
            if self.where.startswith("t = "):
                put("spans", _parsed(self.where))
            return
        from sigmatau.findings.wording import words

        put("code", type(self.details).code)
        put("channel", self.channels[0] if len(self.channels) == 1 else None)
        put("changes", self.factors)
        message, action = words(self)
        put("message", message)
        put("remedy", action)

    @property
    def action(self) -> str:
        """What to do, in words; empty if there is nothing to do."""
        return self.remedy

    def to_dict(self) -> dict[str, Any]:
        return {
            "code": self.code,
            "severity": self.severity,
            "channel": self.channel,
            "channels": list(self.channels),
            "message": self.message,
            "effect": self.effect,
            **({"where": self.where} if self.where else {}),
            **({"spans_s": [list(span) for span in self.spans]} if self.spans else {}),
            **({} if self.size is None else {"size": self.size, "unit": self.unit}),
            **({"changes": dict(self.factors)} if self.factors else {}),
            **({"remedy": self.remedy} if self.remedy else {}),
            **({} if self.fit_effect is None else {"fit_effect": plain(self.fit_effect)}),
            **({} if self.cause is None else {"cause": plain(self.cause)}),
            **({"details": plain(self.details)} if self.details is not None else {}),
        }

    def __str__(self) -> str:
        if self.details is not None:
            from sigmatau.findings.wording.phrases import axes_text

            about = f"{axes_text(self.channels)}: " if self.channels else ""
            return f"{self.severity}: {about}{self.message}" + (f". {self.remedy}" if self.remedy else "")
        channel = f"{self.channel}: " if self.channel else ""
        more = "; ".join(text for text in (self.effect, self.remedy) if text)
        return f"{self.severity}: {channel}{self.message}" + (f" ({more})" if more else "")


def _parsed(where: str) -> tuple[Span, ...]:
    spans = []
    for text in where[4:].split(","):
        start, _, stop = text.partition(" to ")
        begins = float(start.split()[0])
        spans.append((begins, float(stop.split()[0]) if stop else begins))
    return tuple(spans)


def plain(value: object) -> Any:  # noqa: ANN401
    """Details as plain data for JSON: dataclasses and mappings as dictionaries, tuples as lists, no NaN or infinity."""
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, tuple | list):
        return [plain(one) for one in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def by_severity(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Errors first, then warnings, of them first that no model is adequate; each once, else in the order found."""

    def weight(finding: Finding) -> tuple[int, bool]:
        return ("error", "warning", "info").index(finding.severity), finding.code != _FIRST

    return tuple(sorted(dict.fromkeys(findings), key=weight))


def damaged(findings: Iterable[Finding]) -> int:
    """Exit code of a command that has done what it could: 4 if rows of the data are missing or wrong, else 0."""
    return 4 if any(finding.severity == "error" and not finding.channels for finding in findings) else 0
