"""`Verdict`: comparison of each claim of a datasheet with each channel, the overall status, and its printed form."""

from __future__ import annotations

from typing import Any, Literal

from sigmatau.digits import limit_text, round_to_error, two_digits
from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.datasheets.claims import Claim, Meaning
from sigmatau.lab.datasheets.doubts import Doubt
from sigmatau.lab.datasheets.measured import Measured
from sigmatau.results import WIDTH, Printed, plain, printable, wrapped
from sigmatau.units import find

Side = Literal["below", "undecided", "above"]
Status = Literal["within", "above typical", "undecided", "out"]

_WORST: tuple[Status, ...] = ("out", "undecided", "above typical", "within")
_COLUMNS = 5  # number of columns of a full row; the last one, the limits, is printed on separate lines
_MOST_PRINTED_SIGMAS = 100  # largest number of standard errors that is printed


@frozen
class LimitComparison:
    """Comparison of a measured value with one limit.

    Attributes
    ----------
    limit : float
        Limit in the convention of the comparison. [SI]
    side : {"below", "undecided", "above"}
        Position of the measured value relative to the limit.
    sigmas : float or None
        Number of standard errors above (+) or below (−) the limit; None without an interval, or if not observed.
    """

    limit: float
    side: Side
    sigmas: float | None = None

    def words(self) -> str:
        """``"above by 3.2 σ"``."""
        if self.sigmas is None:
            return self.side
        size = abs(self.sigmas)
        number = f"more than {_MOST_PRINTED_SIGMAS} σ" if size > _MOST_PRINTED_SIGMAS else f"{size:.1f} σ"
        if self.side == "undecided":
            return f"{'above' if self.sigmas > 0 else 'below'} by {number}, not significant"
        return f"{self.side} by {number}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return {"limit": self.limit, "side": self.side, **({} if self.sigmas is None else {"sigmas": self.sigmas})}


@frozen
class ClaimReading:
    """A claim in one of its meanings, and the measurement.

    Attributes
    ----------
    meaning : Meaning
    measured : Measured
        Measured value for this meaning.
    typical, maximum : LimitComparison or None
        Comparison with the typical value and with the maximum; None if the datasheet does not state it.
    """

    meaning: Meaning
    measured: Measured
    typical: LimitComparison | None
    maximum: LimitComparison | None

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        comparisons = {"typical": self.typical, "maximum": self.maximum}
        return {
            "of": self.meaning.of,
            **({"meaning": self.meaning.words} if self.meaning.words else {}),
            "measured": self.measured.to_dict(),
            **{key: comparison.to_dict() for key, comparison in comparisons.items() if comparison is not None},
        }


@frozen
class Judged:
    """The status of one claim for one channel.

    Attributes
    ----------
    channel : str
    claim : Claim
        What the datasheet specifies.
    readings : tuple of ClaimReading
        One for each possible meaning of the claim.
    status : {"within", "above typical", "undecided", "out"}
        ``"above typical"``: above the typical value, but not above a maximum.
    doubt : Doubt or None
        Reason for ``"undecided"``, unless the interval just contains the limit.
    """

    channel: str
    claim: Claim
    readings: tuple[ClaimReading, ...]
    status: Status
    doubt: Doubt | None = None

    @property
    def reason(self) -> str:
        """The reason for ``"undecided"`` in words; otherwise empty."""
        return "" if self.doubt is None else self.doubt.words

    @property
    def may_be_out(self) -> bool:
        """Whether there is a maximum that is not shown to be met."""
        return any(reading.maximum is not None and reading.maximum.side != "below" for reading in self.readings)

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI."""
        return plain(self, "channel claim status may_be_out", "reason" if self.reason else "", "readings")


@frozen(eq=False)
class Verdict(Printed):
    """Whether a unit meets its datasheet.

    Attributes
    ----------
    unit : str
        Name of the compared unit, such as that of a result file.
    datasheet : str
        Name of the datasheet.
    judged : tuple of Judged
        Each claim for each channel.
    unsaid : tuple of (str, str)
        Channels and terms that were measured but are not in the datasheet.
    missing : tuple of str
        Sensors and axes of the datasheet that are not in the result, or have no model in it.
    absent : tuple of str
        The part of `missing` that is not in the result at all.
    level : float
        Confidence level of "above" and of "below".
    factor : float or None
        Factor from the typical value to the maximum, used if the datasheet has no maximum; None without a factor.

    See Also
    --------
    compare_with : makes it.

    Examples
    --------
    >>> import sigmatau as st
    >>> measured = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-3}})
    >>> verdict = st.compare_with(measured, "icm42688p", sided="one", bias="minimum", factor=2)
    >>> verdict.status, verdict.out
    ('out', True)
    """

    unit: str
    datasheet: str
    judged: tuple[Judged, ...]
    unsaid: tuple[tuple[str, str], ...] = ()
    missing: tuple[str, ...] = ()
    absent: tuple[str, ...] = ()
    level: float = 0.95
    factor: float | None = None

    @property
    def status(self) -> Status:
        """Worst status of all claims; at least ``"undecided"`` without claims, or if a channel is missing."""
        statuses = {judged.status for judged in self.judged}
        if self.missing or not statuses:
            statuses.add("undecided")
        return next(status for status in _WORST if status in statuses)

    @property
    def out(self) -> bool:
        """Whether the maximum of a claim is exceeded."""
        return self.status == "out"

    @property
    def may_be_out(self) -> bool:
        """Whether a maximum is or may be exceeded, or a sensor is missing."""
        return bool(self.missing) or not self.judged or any(judged.may_be_out for judged in self.judged)

    def fails(self, undecided: Literal["pass", "fail"] = "pass") -> bool:
        """Whether the unit fails: it is out, or with ``"fail"`` a maximum is not shown to be met.

        A unit does not fail because of an undecided typical value.

        Parameters
        ----------
        undecided : {"pass", "fail"}
            Whether a unit passes or fails if a maximum is not shown to be met.

        Returns
        -------
        bool

        Raises
        ------
        OptionError
            For an invalid `undecided`.
        """
        if undecided not in ("pass", "fail"):
            raise OptionError(f"{{option}} must be 'pass' or 'fail', not {undecided!r}", option="undecided")
        return self.out or (undecided == "fail" and self.may_be_out)

    def of(self, status: Status) -> tuple[Judged, ...]:
        """The claims with a status.

        Parameters
        ----------
        status : {"within", "above typical", "undecided", "out"}

        Returns
        -------
        tuple of Judged
        """
        return tuple(judged for judged in self.judged if judged.status == status)

    def line(self) -> str:
        """The unit, its status, and the claims with this status, in one line."""
        worst = self.of(self.status) if self.status != "within" else ()
        named = [f"{j.channel} {j.claim.label}{_sigmas_text(j)}" for j in worst]
        named += [f"no {channel}" for channel in self.missing] if self.status == "undecided" else []
        return f"{printable(self.unit)}: {self.status}" + (f": {', '.join(named)}" if named else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, no NaN."""
        fields = "unit datasheet status may_be_out level missing claims=judged not_in_the_result=absent"
        unspecified = [{"channel": channel, "term": term} for channel, term in self.unsaid]
        return plain(self, fields, "" if self.factor is None else "factor", not_in_the_datasheet=unspecified)

    def __repr__(self) -> str:
        lines = [f"{printable(self.unit)} against {self.datasheet}: {self.status}"]
        rows = [row for judged in self.judged for row in _rows(judged)]
        rows = _narrow(rows)
        full = [row for row in rows if len(row) == _COLUMNS]
        widths = [max((len(row[k]) for row in full), default=0) for k in range(_COLUMNS)]
        for row in rows:
            if len(row) < _COLUMNS:
                lines += wrapped([f"{' ' * 7}{row[-1].strip()}"], indent=9)
                continue
            *cells, against = [cell.ljust(w) for cell, w in zip(row, widths, strict=True)]
            lines.append("  " + "  ".join(cells).rstrip())
            lines += [f"{' ' * (widths[0] + 8)}{text}" for text in against.rstrip().split("; ") if text]
        if not self.judged:
            lines.append("  the datasheet has no noise specification for these channels")
        notes = [
            f"  {name}: in the datasheet, no model in the result" for name in self.missing if name not in self.absent
        ]
        if self.absent:
            notes.append(f"  {', '.join(self.absent)}: in the datasheet, not in the result{_hint(self.absent)}")
        by_term: dict[str, list[str]] = {}
        for channel, term in self.unsaid:
            by_term.setdefault(term, []).append(channel)
        notes += [
            f"  measured, not in the datasheet: {term.replace('_', ' ')} ({', '.join(names)})"
            for term, names in by_term.items()
        ]
        factor = "" if self.factor is None else f"; maximum, where not stated: {self.factor:g} times typical"
        notes.append(f"  confidence level of above and below: {100 * self.level:g} % each{factor}")
        return "\n".join([*lines, *wrapped(notes, indent=4)])


def _narrow(rows: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Fit rows to the terminal: if they are too wide, values move to the lines of the limits."""
    full = [row for row in rows if len(row) == _COLUMNS]
    wide = sum(max((len(row[k]) for row in full), default=0) + 2 for k in range(_COLUMNS - 1))
    if wide <= WIDTH:
        return rows
    return [(*row[:2], row[3], "", f"{row[2]}; {row[4]}") if len(row) == _COLUMNS else row for row in rows]


def _sigmas_text(judged: Judged) -> str:
    for reading in judged.readings:
        comparison = reading.maximum if judged.status in ("out", "undecided") and reading.maximum else reading.typical
        if comparison is not None and comparison.sigmas is not None:
            return f" ({comparison.words()})"
    return ""


def _hint(absent: tuple[str, ...]) -> str:
    hint = '; for a sensor with fewer axes write axes = ["x"] in the datasheet'
    return hint if any("_" in name for name in absent) else ""


def _rows(judged: Judged) -> list[tuple[str, ...]]:
    """Rows of channel, claim, value, status and limits; a separate row has the reason. Measured values are converted to
    the unit and convention of the datasheet.
    """
    claim = judged.claim
    if not any(reading.measured.anything for reading in judged.readings):
        limits = "; ".join(
            f"{_limit_name(claim, name)} {text}" for name in ("typical", "maximum") if (text := _stated(claim, name))
        )
        row: tuple[str, ...] = (judged.channel, claim.label, "not measured", judged.status, limits)
        is_row_enough = judged.doubt is None or judged.doubt.kind == "not_in_result"
        return [row] if is_row_enough else [row, ("", f"  {judged.reason}")]
    text, unit = claim.display()
    rows: list[tuple[str, ...]] = []
    for k, reading in enumerate(judged.readings):
        words = f", {reading.meaning.words}" if reading.meaning.words else ""
        size = unit * reading.meaning.factor
        against = "; ".join(
            f"{_limit_name(claim, name)} {_limit_text(claim, name, comparison.limit / size)}"
            + (f": {comparison.words()}" if reading.measured.anything else "")
            for name, comparison in (("typical", reading.typical), ("maximum", reading.maximum))
            if comparison is not None
        )
        label = claim.label + words if k == 0 else f"  or{words[1:]}"
        value = _value_text(reading.measured, text, size)
        rows.append((judged.channel if k == 0 else "", label, value, judged.status if k == 0 else "", against))
    return [*rows, ("", f"  {judged.reason}")] if judged.reason else rows


def _limit_name(claim: Claim, name: str) -> str:
    """Name of a limit in the datasheet."""
    return claim.usual if name == "typical" else name


def _stated(claim: Claim, name: str) -> str:
    """Number of the datasheet with its printed unit; empty without a number."""
    text = claim.typical_text if name == "typical" else claim.maximum_text
    number, _, unit = text.partition(" ")
    return f"{number} {find(unit).text}" if unit else text


def _limit_text(claim: Claim, name: str, value: float) -> str:
    """Limit in the unit of the row; with its original unit if typical and maximum have different units."""
    stated = _stated(claim, name)
    return stated if stated and not stated.endswith(f" {claim.display()[0]}") else f"{value:.4g}"


def _value_text(value: Measured, text: str, size: float) -> str:
    if value.value is not None:
        low = None if value.low is None else value.low / size
        high = None if value.high is None else value.high / size
        return round_to_error(value.value / size, low, high).with_unit(text)
    if value.lower_limit is not None:
        return f"at least {two_digits(value.lower_limit / size)} {text}"
    return "not measured" if value.upper_limit is None else f"{limit_text(value.upper_limit / size)} {text}"
