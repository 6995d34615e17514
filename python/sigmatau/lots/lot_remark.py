"""`Remark`: one fact about a unit of a lot that decides on its state, or is told beside it; as data, without words."""

from __future__ import annotations

from typing import Any, Literal

from sigmatau.frozen import frozen

State = Literal["passed", "failed", "not_judged", "unreadable", "missing"]

STATES: tuple[State, ...] = ("failed", "not_judged", "unreadable", "missing", "passed")
"""What a unit can be, worst first. Each unit is exactly one of them."""

Kind = Literal["limit", "judging", "data", "lot", "note"]


@frozen
class Remark:
    """A fact about a unit.

    Attributes
    ----------
    code : str
        A code of `CODES`, or that of a finding of the analysis.
    kind : {"limit", "judging", "data", "lot", "note"}
        ``"limit"``: a maximum is exceeded. ``"judging"``: a claim cannot be judged. ``"data"``: a warning about the record.
        ``"lot"``: the unit does not fit the others. ``"note"``: told, and decides nothing.
    channels : tuple of str
        Channels; empty for the whole unit.
    what : str
        Name of the claim or of the coefficient.
    value, limit : float or None
        Measured value and its limit. [`factor` of `unit`]
    ratio : float or None
        Value over limit, over the median of the lot, or over the typical value. [1]
    unit : str
        Unit in which value and limit are told.
    factor : float
        Factor from this unit to that of value and limit.
    text : str
        Message of a finding or of an error, in its own words.
    """

    code: str
    kind: Kind
    channels: tuple[str, ...] = ()
    what: str = ""
    value: float | None = None
    limit: float | None = None
    ratio: float | None = None
    unit: str = ""
    factor: float = 1.0
    text: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, and the words."""
        from sigmatau.lots.lot_words import remark_text

        known = {"what": self.what, "value": self.value, "limit": self.limit, "ratio": self.ratio}
        return {
            "code": self.code,
            "kind": self.kind,
            "channels": list(self.channels),
            **{key: value for key, value in known.items() if value not in (None, "")},
            "message": remark_text(self),
        }


CODES = {
    "above_maximum": "a value is above its maximum",
    "undecided": "the interval contains the maximum",
    "no_maximum": "the specification states no maximum of a value",
    "not_measured": "a value or an axis of the specification is not in the result",
    "no_model": "no model fits a channel, so that its errors are unknown",
    "not_at_rest": "the sensor moved",
    "too_short_to_tell": "the record is too short to tell rest from motion",
    "no_specification": "there is no specification",
    "implausible_value": "a value is far from what the specification states: a wrong unit, or another sensor",
    "other_scale": "all curves of a sensor are several times those of the lot: a wrong unit, or a bad unit",
    "outlier": "a value does not belong to the distribution of the others",
    "short_record": "the record is shorter than those of the lot",
    "other_rate": "the sampling rate is not that of the lot",
    "other_axes": "the channels are not those of the lot",
    "same_data": "the data are those of another unit",
    "not_expected": "the unit is not on the list of those expected",
    "unreadable": "the log or the result cannot be read",
    "missing": "the unit is expected, but there is no file",
}
"""Codes of the remarks of a lot, and their meaning; findings of the analysis have their own codes."""
