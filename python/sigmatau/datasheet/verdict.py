"""Whether a sensor keeps to its datasheet: term by term, with the error of the measurement.

A value is *above* a limit if it would be measured so large on a sensor exactly at the limit in fewer than 1 − level of
records, *below* it likewise, and else *undecided*: the record is too short to tell. That is the rule of ISO 14253-1 for
proving conformity and proving the lack of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Literal, Protocol

from sigmatau.datasheet.claims import QUANTITIES, Bias, Claim, Meaning, Sided, check_meanings
from sigmatau.datasheet.measured import Measured, measured
from sigmatau.datasheet.sheet import Datasheet
from sigmatau.errors import DataError, OptionError
from sigmatau.fitting.noisefit import NoiseFit
from sigmatau.model import ChannelModel, NoiseModel
from sigmatau.model.result import channel_of_fit
from sigmatau.record import stream_name
from sigmatau.results import Printed, interval_texts, two_digits

__all__ = ["Comparison", "Judged", "Reading", "Side", "Status", "Verdict", "compare_with"]

Side = Literal["below", "undecided", "above"]
Status = Literal["within", "above typical", "undecided", "out"]

_WORST: tuple[Status, ...] = ("out", "undecided", "above typical", "within")
_COLUMNS = 5
_FEW_SIGMAS = 100  # beyond, the number says no more
_MOST_SIGMAS = 1e6  # of an interval without width


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """A measured value against one limit.

    Attributes
    ----------
    limit : float
        In the meaning that is compared. [SI]
    side : {"below", "undecided", "above"}
    sigmas : float or None
        By how many standard errors the value is above (+) or below (−) the limit; None without an interval, and for what
        was not observed.
    """

    limit: float
    side: Side
    sigmas: float | None = None

    def words(self) -> str:
        """``"above by 3.2 σ"``."""
        if self.sigmas is None:
            return self.side
        size = abs(self.sigmas)
        number = f"more than {_FEW_SIGMAS} σ" if size > _FEW_SIGMAS else f"{size:.1f} σ"
        if self.side == "undecided":
            return f"{'above' if self.sigmas > 0 else 'below'} by {number}, not significant"
        return f"{self.side} by {number}"

    def to_dict(self) -> dict[str, Any]:
        return {"limit": self.limit, "side": self.side, **({} if self.sigmas is None else {"sigmas": self.sigmas})}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A claim in one of its meanings, against what was measured."""

    meaning: Meaning
    measured: Measured
    typical: Comparison | None
    maximum: Comparison | None

    def to_dict(self) -> dict[str, Any]:
        known = {"typical": self.typical, "maximum": self.maximum}
        return {
            "of": self.meaning.of,
            **({"meaning": self.meaning.words} if self.meaning.words else {}),
            "measured": self.measured.to_dict(),
            **{key: comparison.to_dict() for key, comparison in known.items() if comparison is not None},
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """One claim about one channel.

    Attributes
    ----------
    channel : str
    claim : Claim
    readings : tuple of Reading
        One for each meaning that the claim may have.
    status : {"within", "above typical", "undecided", "out"}
        ``"above typical"`` is within the maximum, or without one.
    reason : str
        Why it is undecided.
    """

    channel: str
    claim: Claim
    readings: tuple[Reading, ...]
    status: Status
    reason: str = ""

    def to_dict(self) -> dict[str, Any]:
        return {
            "channel": self.channel,
            "claim": self.claim.to_dict(),
            "status": self.status,
            **({"reason": self.reason} if self.reason else {}),
            "readings": [reading.to_dict() for reading in self.readings],
        }


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Verdict(Printed):
    """Whether a unit keeps to its datasheet.

    Attributes
    ----------
    unit : str
        What was compared, such as the name of a result.
    datasheet : str
        Name of the sheet.
    judged : tuple of Judged
        Each claim of the sheet about each channel.
    unsaid : tuple of (str, str)
        Channels and terms that were measured and of which the sheet says nothing.
    missing : tuple of str
        Sensors and axes of which the sheet states something and that the result has not, or has no model of.
    level : float
        One-sided confidence of the comparisons.
    factor : float or None
        By which a typical value was multiplied to serve as a maximum where the sheet has none.
    """

    unit: str
    datasheet: str
    judged: tuple[Judged, ...]
    unsaid: tuple[tuple[str, str], ...] = ()
    missing: tuple[str, ...] = ()
    level: float = 0.95
    factor: float | None = None

    @property
    def status(self) -> Status:
        """The worst of all claims; ``"undecided"`` if there is none, or a channel is missing."""
        found = {judged.status for judged in self.judged}
        if self.missing or not found:
            found.add("undecided")
        return next(status for status in _WORST if status in found)

    @property
    def out(self) -> bool:
        """Whether a claim's maximum is exceeded."""
        return self.status == "out"

    def of(self, status: Status) -> tuple[Judged, ...]:
        """The claims with a status."""
        return tuple(judged for judged in self.judged if judged.status == status)

    def line(self) -> str:
        """One line: the unit, its status, and the claims that made it so."""
        worst = self.of(self.status) if self.status != "within" else ()
        named = [f"{j.channel} {j.claim.label}{_by(j)}" for j in worst]
        named += [f"no {channel}" for channel in self.missing] if self.status == "undecided" else []
        return f"{self.unit}: {self.status}" + (f": {', '.join(named)}" if named else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain values in SI, no NaN."""
        return {
            "unit": self.unit,
            "datasheet": self.datasheet,
            "status": self.status,
            "level": self.level,
            **({} if self.factor is None else {"factor": self.factor}),
            "claims": [judged.to_dict() for judged in self.judged],
            "not_in_the_datasheet": [{"channel": channel, "term": term} for channel, term in self.unsaid],
            "missing": list(self.missing),
        }

    def __repr__(self) -> str:
        lines = [f"{self.unit} against {self.datasheet}: {self.status}"]
        rows = [row for judged in self.judged for row in _rows(judged)]
        full = [row for row in rows if len(row) == _COLUMNS]
        widths = [max((len(row[k]) for row in full), default=0) for k in range(_COLUMNS)]
        for row in rows:
            cells = [cell.ljust(w) for cell, w in zip(row, widths, strict=True)] if len(row) == _COLUMNS else row
            lines.append("  " + "   ".join(cells).rstrip())
        if not self.judged:
            lines.append("  the datasheet states nothing of the noise of these channels")
        lines += [f"  {name}: in the datasheet, but the result has no model of it" for name in self.missing]
        by_term: dict[str, list[str]] = {}
        for channel, term in self.unsaid:
            by_term.setdefault(term, []).append(channel)
        lines += [
            f"  measured, not in the datasheet: {term.replace('_', ' ')} ({', '.join(names)})"
            for term, names in by_term.items()
        ]
        more = "" if self.factor is None else f"; where there is no maximum, {self.factor:g} times typical is one"
        return "\n".join([*lines, f"  above, below: {100 * self.level:g} % one-sided{more}"])


class _Fitted(Protocol):
    """An `Analysis`, as far as it matters here."""

    @property
    def fits(self) -> Mapping[str, NoiseFit]: ...


def compare_with(
    result: NoiseModel | _Fitted | Mapping[str, Any],
    datasheet: Datasheet,
    *,
    unit: str = "result",
    level: float = 0.95,
    factor: float | None = None,
    sided: Sided | None = None,
    bias: Bias | None = None,
) -> Verdict:
    """Compare what was measured with what the maker states, term by term.

    Parameters
    ----------
    result : NoiseModel, Analysis or mapping
        The mapping is the JSON form of `analyze`. A `NoiseModel` without intervals is compared without statistics.
    datasheet : Datasheet
    unit : str, optional
        What the result is of, for the lines that are printed.
    level : float, optional
        One-sided confidence: a unit exactly at its limit is called out in a share of 1 − level of records.
    factor : float, optional
        Where the sheet has a typical value only: the maximum is `factor` times it. Default: there is none, and a value
        above the typical one is said but is not out.
    sided : {"one", "two"}, optional
        What noise densities are of which the sheet does not say it. Default: both are tried, and what depends on it is
        undecided.
    bias : {"minimum", "coefficient"}, optional
        What a bias instability is, likewise: the minimum of the Allan deviation, or B.

    Returns
    -------
    Verdict

    Raises
    ------
    OptionError
        For a level, factor or meaning that cannot be.
    DataError
        If `result` is not a result.

    References
    ----------
    ISO 14253-1:2017, section 5; JCGM 106:2012, section 8.
    """
    check_meanings(sided, bias)
    if not 0.5 <= level < 1:
        raise OptionError(f"`level` must be from 0.5 to below 1, not {level!r}", option="level")
    if factor is not None and not (math.isfinite(factor) and factor >= 1):
        raise OptionError(f"`factor` must be a number from 1 on, not {factor!r}", option="factor")
    models, without = _models(result)
    judged, unsaid = [], []
    for channel, model in models.items():
        claims = datasheet.of(channel)
        for claim in claims:
            readings = tuple(
                _reading(claim, meaning, model, level, factor) for meaning in claim.meanings(sided=sided, bias=bias)
            )
            status, reason = _status(readings)
            judged.append(Judged(channel=channel, claim=claim, readings=readings, status=status, reason=reason))
        said = {claim.term for claim in claims}
        unsaid += [(channel, term) for term in model.terms if term not in said and term not in model.limits]
    sensors = {claim.sensor for claim in datasheet.claims}
    missing = [name for name in without if datasheet.of(name)]
    missing += sorted(
        name
        for name in sensors
        if not any(channel == name or stream_name(channel) == name for channel in models)
        and not any(stream_name(channel) == name or channel == name for channel in without)
    )
    return Verdict(
        unit=unit,
        datasheet=datasheet.name,
        judged=tuple(judged),
        unsaid=tuple(unsaid),
        missing=tuple(missing),
        level=level,
        factor=factor,
    )


def _models(result: NoiseModel | _Fitted | Mapping[str, Any]) -> tuple[dict[str, ChannelModel], list[str]]:
    """The models by channel, and the channels that have none."""
    if isinstance(result, NoiseModel):
        return dict(result.channels), []
    if isinstance(result, Mapping):
        channels: Any = result.get("channels")
        if not isinstance(channels, Mapping) or not channels:
            raise DataError("this is no result of sigmatau analyze: it has no channels")
        fits = {}
        for name, channel in channels.items():
            try:
                fits[str(name)] = (channel["fit"], str(channel["quantity"]), str(channel["curve"]["unit"]))
            except (KeyError, TypeError) as error:
                raise DataError(
                    f"channel {name!r}: not a result of sigmatau analyze with a fit ({error!r} is missing or wrong)"
                ) from None
    elif hasattr(result, "fits"):
        fits = {name: (fit.to_dict(), fit.quantity, fit.rate_unit) for name, fit in result.fits.items()}
    else:
        raise DataError(f"{type(result).__name__} is no result: give an Analysis, its JSON form or a NoiseModel")
    models, without = {}, []
    for name, (fit, quantity, rate_unit) in fits.items():
        if not name.isprintable():
            raise DataError(f"channel {name!r}: a name must print")
        if QUANTITIES.get(stream_name(name), (quantity, rate_unit)) != (quantity, rate_unit):
            raise DataError(f"channel {name!r}: a name like this is not that of {quantity} in {rate_unit}")
        try:
            some = fit["model"] or fit["terms"]["gauss_markov"] or fit["terms"]["sinusoid"]
            if some:
                models[name] = channel_of_fit(fit, quantity=quantity, unit=rate_unit)
            else:
                without.append(name)
        except DataError as error:
            raise DataError(f"channel {name!r}: {error}") from None
        except (KeyError, TypeError, AttributeError, ValueError, OverflowError) as error:
            raise DataError(
                f"channel {name!r}: not a result of sigmatau analyze with a fit ({error!r} is missing or wrong)"
            ) from None
    return models, without


def _reading(claim: Claim, meaning: Meaning, model: ChannelModel, level: float, factor: float | None) -> Reading:
    found = measured(model, meaning.of)
    maximum = claim.maximum
    if maximum is None and factor is not None and claim.typical is not None:
        maximum = factor * claim.typical
    return Reading(
        meaning=meaning,
        measured=found,
        typical=_compared(found, claim.typical, meaning.factor, level),
        maximum=_compared(found, maximum, meaning.factor, level),
    )


def _compared(found: Measured, stated: float | None, factor: float, level: float) -> Comparison | None:
    if stated is None:
        return None
    limit = factor * stated
    if found.value is None:
        # A limit of 95 % shows nothing with 99 %.
        below = found.upper_limit is not None and found.upper_limit < limit and level <= found.level
        return Comparison(limit=limit, side="below" if below else "undecided")
    if found.low is None or found.high is None:
        if math.isclose(found.value, limit, rel_tol=1e-9):
            return Comparison(limit=limit, side="undecided")
        return Comparison(limit=limit, side="above" if found.value > limit else "below")
    sigmas = _sigmas(found.value, found.low, found.high, limit, found.level)
    enough = NormalDist().inv_cdf(level)
    return Comparison(
        limit=limit, side="above" if sigmas > enough else "below" if sigmas < -enough else "undecided", sigmas=sigmas
    )


def _sigmas(value: float, low: float, high: float, limit: float, level: float) -> float:
    """By how many standard errors a value is above a limit, which is that many as the interval's end has at its own place.

    In logarithms, because a coefficient is a scale; intervals need not be symmetrical, and the end towards the limit counts.
    """
    reach = NormalDist().inv_cdf((1 + level) / 2)
    end = low if value > limit else high
    if end <= 0:  # an interval from 0 on: in its own unit
        return reach * (value - limit) / value
    width = abs(math.log(value / end))
    distance = reach * math.log(value / limit)
    return math.copysign(min(abs(distance) / width, _MOST_SIGMAS), distance) if width else _sign(distance)


def _sign(distance: float) -> float:
    return math.copysign(_MOST_SIGMAS, distance) if distance else 0.0


def _status(readings: tuple[Reading, ...]) -> tuple[Status, str]:
    """What all meanings agree on."""
    found = {_of_one(reading) for reading in readings}
    if len(found) == 1:
        status = found.pop()
        return status, readings[0].measured.words if status == "undecided" else ""
    words = " or ".join(reading.meaning.words for reading in readings)
    if found <= {"within", "above typical"}:
        return "above typical", f"it depends on what the sheet does not say: {words}"
    return "undecided", f"it depends on what the sheet does not say: {words}"


def _of_one(reading: Reading) -> Status:
    typical, maximum = reading.typical, reading.maximum
    if not reading.measured.anything:
        return "undecided"
    if maximum is not None and maximum.side == "above":
        return "out"
    if maximum is not None and maximum.side == "undecided":
        return "undecided"
    if typical is not None and typical.side == "above":
        return "above typical"
    # About as large as a typical value is within; only what was not observed may be anything up to its limit.
    if maximum is None and typical is not None and typical.side == "undecided" and reading.measured.value is None:
        return "undecided"
    return "within"


def _by(judged: Judged) -> str:
    for reading in judged.readings:
        comparison = reading.maximum if judged.status in ("out", "undecided") and reading.maximum else reading.typical
        if comparison is not None and comparison.sigmas is not None:
            return f" ({comparison.words()})"
    return ""


def _rows(judged: Judged) -> list[tuple[str, ...]]:
    """Channel, claim, value, limits, status; and why it is undecided in a row of its own."""
    claim = judged.claim
    text, size = claim.display()
    if not any(reading.measured.anything for reading in judged.readings):
        stated = [("typical", claim.typical_text), ("maximum", claim.maximum_text)]
        limits = "; ".join(f"{name} {value}" for name, value in stated if value)
        return [(judged.channel, claim.label, "not measured", limits, judged.status)]
    rows: list[tuple[str, ...]] = []
    for k, reading in enumerate(judged.readings):
        words = f", {reading.meaning.words}" if reading.meaning.words else ""
        against = "; ".join(
            f"{name} {comparison.limit / size:.4g}" + (f": {comparison.words()}" if reading.measured.anything else "")
            for name, comparison in (("typical", reading.typical), ("maximum", reading.maximum))
            if comparison is not None
        )
        label = claim.label + words if k == 0 else f"  or{words[1:]}"
        value = _value_text(reading.measured, text, size)
        rows.append((judged.channel if k == 0 else "", label, value, against, judged.status if k == 0 else ""))
    return [*rows, ("", f"  {judged.reason}")] if judged.reason else rows


def _value_text(found: Measured, text: str, size: float) -> str:
    if found.value is not None:
        low = None if found.low is None else found.low / size
        high = None if found.high is None else found.high / size
        return " ".join(part for part in (*interval_texts(found.value / size, low, high), text) if part)
    return "not measured" if found.upper_limit is None else f"below {two_digits(found.upper_limit / size)} {text}"
