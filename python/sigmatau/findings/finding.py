"""A finding: code, severity, channels, spans of time, size, factors by coefficient, and the details of its kind."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from typing import Any, ClassVar, Literal, NamedTuple

from sigmatau.frozen import frozen
from sigmatau.hints import Hint, as_options, hints_in, worded
from sigmatau.noise.terms import RANKED
from sigmatau.results import Tabular, plain_value, printable

Severity = Literal["info", "warning", "error"]

Span = tuple[float, float]
"""Beginning and end, from the beginning of the whole record even if a part is analysed; equal for an instant. [s]"""

WITHOUT_REST = ("not_at_rest", "too_short_to_tell")  # errors without coefficients
# findings that leave out the samples of all axes, not only of the affected ones
_ON_ALL_AXES = ("not_static", "start_transient")
DISTURBANCES = (*_ON_ALL_AXES, "spikes", "dropout", "stuck_samples", "saturation", "interpolated")
"""Codes of findings about samples that are not the sensor's noise."""

_SEVERITIES: tuple[Severity, ...] = ("error", "warning", "info")


class Words(NamedTuple):
    """Message and action of a finding.

    Attributes
    ----------
    message : str
        One sentence without a full stop: what was found, where, what it changes.
    action : str
        One sentence without a full stop: what to do; empty if there is nothing to do.
    """

    message: str
    action: str = ""


@frozen
class Details:
    """Parameters of one kind of finding: base of the classes in the modules of `findings`.

    Each class statement has the code: ``class SpectralLines(Details, code="spectral_line")``. ``alters_all=True`` means
    that no coefficient is meaningful, or none has an interval.
    """

    code: ClassVar[str] = ""  # stable name of the kind
    alters_all: ClassVar[bool] = False
    # share of the samples up to which the intervals of a fit cover the effect of such a warning [1]
    allowed_share: ClassVar[float] = 0.0

    def __init_subclass__(cls, *, code: str = "", alters_all: bool = False) -> None:
        cls.code = code or cls.code
        cls.alters_all = alters_all or cls.alters_all

    def words(self, finding: Finding) -> Words:
        """Message and action of a finding of this kind. The channels are named only where one of several is meant."""
        raise NotImplementedError

    def possible_factors(self, size: float | None) -> dict[str, float]:
        """Factors by which coefficients may be wrong, by term, if `Finding.factors` is empty. `size` is the size of the
        finding.
        """
        return {}

    @property
    def biases_walk(self) -> bool:
        """Whether the factor applies to the random walk of a fit, whose interval then includes the values with and
        without it.
        """
        return False


@frozen
class Stated(Details):
    """A finding of another version of sigmatau, with parameters that this version does not know.

    Attributes
    ----------
    stated_code, message, action : str
        As in the result.
    parameters : mapping
        Its details.
    """

    stated_code: str
    message: str = ""
    action: str = ""
    parameters: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def words(self, finding: Finding) -> Words:
        return Words(self.message, self.action)


@frozen
class Finding:
    """A fault of the record, or another fact that affects the results.

    Attributes
    ----------
    details : Details
        Parameters of the finding; their class is the kind of finding.
    severity : {"info", "warning", "error"}
    channels : tuple of str
        The channels concerned; empty for the whole record.
    spans : tuple of (float, float)
        Start and end times of all stretches that it is about, from the beginning of the whole record. [s]
    more_spans : int
        Number of stretches that are not in `spans`, which has at most the 1000 longest.
    size : float or None
        Size of the fault. [`unit`]
    unit : str
        Unit of the size; empty for a bare number.
    factors : tuple of (str, float)
        For each biased term, the factor by which its coefficient is larger than the true one of the sensor.
    left_out : int
        Number of samples that were treated as missing because of it, in the channel with the largest number; 0 if none.
    topic : str
        Topic or table of the file that the finding is about, if several are read; otherwise empty.

    See Also
    --------
    check : finds the faults of a record.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> rates = 1e-3 * np.random.default_rng(1).standard_normal(10_000)
    >>> rates[5000] = 1.0
    >>> for finding in st.check(st.Record.from_arrays(rate=100, gyro_x=rates)):
    ...     print(finding.code, finding.severity, finding.channels, finding.spans)
    spikes info ('gyro_x',) ((50.0, 50.0),)
    """

    details: Details
    severity: Severity
    channels: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()
    more_spans: int = 0
    size: float | None = None
    unit: str = ""
    factors: tuple[tuple[str, float], ...] = ()
    left_out: int = 0
    topic: str = ""

    @property
    def code(self) -> str:
        """Stable name of the kind of finding."""
        details = self.details
        return details.stated_code if isinstance(details, Stated) else type(details).code

    @property
    def channel(self) -> str | None:
        """The only channel concerned; None for several, or for the whole record."""
        return self.channels[0] if len(self.channels) == 1 else None

    @property
    def message(self) -> str:
        """The finding in words."""
        return worded(self.words().message)

    @property
    def action(self) -> str:
        """Action in words; empty if no action is needed."""
        return worded(self.words().action)

    @property
    def hints(self) -> tuple[Hint, ...]:
        """The options that the action names."""
        return hints_in(self.words().action)

    @property
    def walk_factor(self) -> float | None:
        """Factor by which the random walk of a fit is larger than that of the sensor; None if it is not computed."""
        factor = dict(self.factors).get("random_walk") if self.details.biases_walk else None
        return factor if factor is not None and 0 < factor < math.inf else None

    def words_of_files(self) -> Words:
        """Message and action with options in the form of the command line, for files written by any face."""
        return Words(*(worded(text, as_options) for text in self.words()))

    def words(self) -> Words:
        """Message and action with hints in them; see `sigmatau.hints`."""
        stated = self.details.words(self)
        if isinstance(self.details, Stated):
            return stated
        if part := getattr(self.details, "part", ""):  # a log may be split into several files
            stated = stated._replace(message=f"{part}: {stated.message}")
        if self.left_out:
            axes = " on all axes" if self.code in _ON_ALL_AXES else ""
            return stated._replace(message=f"{stated.message}; left out{axes}")
        if self.severity == "warning" and not stated.action and self.code in (*DISTURBANCES, "repeated_samples"):
            return stated._replace(action="Find the cause: these samples are part of the analysis")
        return stated

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, with message and action worded for the command line."""
        message, action = self.words_of_files()
        return {
            "code": self.code,
            "severity": self.severity,
            "channels": list(self.channels),
            "message": message,
            "action": action,
            **({"spans_s": [list(span) for span in self.spans]} if self.spans else {}),
            **({"more_spans": self.more_spans} if self.more_spans else {}),
            **({} if self.size is None else {"size": plain_value(self.size), "unit": self.unit}),
            **({"factors": plain_value(dict(self.factors))} if self.factors else {}),
            **({"left_out": self.left_out} if self.left_out else {}),
            **({"topic": self.topic} if self.topic else {}),
            "details": plain_value(self.details.parameters if isinstance(self.details, Stated) else self.details),
        }

    def __str__(self) -> str:
        return line(self) + (f". {self.action}" if self.action else "")


def axes_text(channels: Sequence[str]) -> str:
    """``"gyro_x, gyro_y and gyro_z"``."""
    return channels[0] if len(channels) == 1 else f"{', '.join(channels[:-1])} and {channels[-1]}"


def line(finding: Finding) -> str:
    """A finding in one line, without its action: ``"warning: gyro_x: 3 spikes …"``, with its topic if any."""
    about = (finding.topic, axes_text(finding.channels) if finding.channels else "")
    return printable(": ".join(filter(None, (finding.severity, *about, finding.message))))


class Findings(tuple[Finding, ...], Tabular):
    """Findings in their order, and as a table."""

    __slots__ = ()

    def columns(self) -> dict[str, list[Any]]:
        """One row per finding, see `Tabular.columns`."""
        return {
            "severity": [finding.severity for finding in self],
            "code": [finding.code for finding in self],
            "channels": [", ".join(finding.channels) for finding in self],
            "message": [finding.message for finding in self],
            "action": [finding.action for finding in self],
            "size": [finding.size for finding in self],
            "unit": [finding.unit for finding in self],
            "left_out": [finding.left_out for finding in self],
            "topic": [finding.topic for finding in self],
        }

    def __repr__(self) -> str:
        return "\n".join(map(str, self)) or "no findings"


def ranked(findings: Iterable[Finding]) -> Findings:
    """Findings without duplicates: errors first, then warnings. Within a severity, the finding that changes the coefficients
    most comes first, compared by its factor on the random walk, then on the bias instability, the rate random walk and the
    others.
    """

    def rank(finding: Finding) -> tuple[int, tuple[float, ...]]:
        return _SEVERITIES.index(finding.severity), tuple(-effect for effect in effects(finding))

    return Findings(sorted(dict.fromkeys(findings), key=rank))


def effects(finding: Finding) -> tuple[float, ...]:
    """Size of the effect of a finding on each term, ``|ln factor|``, the random walk first; infinite if it alters all."""
    if type(finding.details).alters_all:
        return (math.inf,) * len(RANKED)
    factors = finding.details.possible_factors(finding.size) | dict(finding.factors)
    return tuple(_effect(factors.get(term, 1.0)) for term in RANKED)


def _effect(factor: float) -> float:
    return abs(math.log(factor)) if 0 < factor < math.inf else math.inf


def exit_code(findings: Iterable[Finding]) -> int:
    """Exit code of an analysis: 5 if the sensor is not at rest, else that of `damaged`."""
    listed = tuple(findings)
    return (
        5
        if any(finding.code in WITHOUT_REST and finding.severity == "error" for finding in listed)
        else damaged(listed)
    )


def damaged(findings: Iterable[Finding]) -> int:
    """Exit code of a command that completed as far as possible: 4 if rows of the data are missing or wrong, else 0."""
    return (
        4
        if any(
            finding.severity == "error" and not finding.channels and finding.code not in WITHOUT_REST
            for finding in findings
        )
        else 0
    )
