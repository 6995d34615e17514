"""`Remark`: a finding about a unit of a lot, and its effect on the state of the unit."""

from __future__ import annotations

from typing import Any, Literal

from sigmatau import Finding
from sigmatau.findings.finding import Details, Severity
from sigmatau.findings.phrases import short_axes
from sigmatau.frozen import frozen
from sigmatau.results import plain_value, printable

State = Literal["passed", "failed", "not_judged", "unreadable", "missing"]

STATES: tuple[State, ...] = ("failed", "not_judged", "unreadable", "missing", "passed")
"""States of a unit, worst first. Each unit has exactly one."""

Kind = Literal["limit", "judging", "data", "lot", "note"]

_SEVERITIES: dict[Kind, Severity] = {"limit": "error", "note": "info"}
_JSON_DETAILS = ("what", "value", "limit", "ratio")  # details that the JSON of a remark has


@frozen
class Remark:
    """A finding about a unit.

    Attributes
    ----------
    finding : Finding
        A finding of `sigmatau.lab.lots.lot_findings`, or of the analysis.
    kind : {"limit", "judging", "data", "lot", "note"}
        ``"limit"``: a maximum is exceeded. ``"judging"``: a claim cannot be judged. ``"data"``: a warning about the record.
        ``"lot"``: the unit does not fit the others. ``"note"``: reported only.
    channels : tuple of str
        Channels; empty for the whole unit.
    """

    finding: Finding
    kind: Kind
    channels: tuple[str, ...] = ()

    @property
    def code(self) -> str:
        """Code of the finding."""
        return self.finding.code

    @property
    def details(self) -> Details:
        """Parameters of the finding."""
        return self.finding.details

    @property
    def text(self) -> str:
        """The remark in words, one line."""
        return self._text(self.finding.message)

    def _text(self, message: str) -> str:
        about = f"{short_axes(self.channels)}: " if self.channels else ""
        return printable(about + message)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, and the words."""
        details = plain_value(self.details)
        return {
            "code": self.code,
            "kind": self.kind,
            "channels": list(self.channels),
            **{key: details[key] for key in _JSON_DETAILS if details.get(key) not in (None, "")},
            "message": self._text(self.finding.words_of_files().message),
        }


def remark(details: Details, kind: Kind, channels: tuple[str, ...] = ()) -> Remark:
    """Make a remark from a finding of the comparison with a specification or with the lot."""
    finding = Finding(details=details, severity=_SEVERITIES.get(kind, "warning"), channels=channels)
    return Remark(finding=finding, kind=kind, channels=channels)
