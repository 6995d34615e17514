"""What a specification and the findings say of one unit, as remarks; before it is compared with the rest of the lot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from sigmatau.datasheets.claims import Claim
from sigmatau.datasheets.verdict import Judged, Verdict
from sigmatau.findings.finding import Finding
from sigmatau.lots.lot_remark import Remark
from sigmatau.lots.lot_unit import UnitResult
from sigmatau.model.file import NOT_ADEQUATE, ONLY_LIMITS

DEFECTS = ("spikes", "saturation", "dropout", "stuck_samples", "implausible_unit")
"""Findings about a sensor or its unit that no unit passes with, even where the analysis could leave the samples out."""

ALLOWED_FOR = ("widened",)
"""Warnings that the intervals allow for, so that they keep no unit from passing."""

_FAR_FROM_TYPICAL = 10.0
"""Ratio to a typical value from which on a value is implausible: units of a type differ by far less, mistaken units
(57.3, 9.81 · 9.81, 1000, 3600) by more, but for g and m/s², which the mean of the accelerometer shows."""

_FAR_FROM_MAXIMUM = 30.0  # the same below a maximum, which makers set several times above the typical value


def of_verdict(verdict: Verdict) -> list[Remark]:
    """The remarks of a comparison with a specification: what is out, what cannot be judged, what is implausible."""
    found = [_above(judged) for judged in verdict.of("out")]
    open_: dict[str, list[Judged]] = {}
    for judged in verdict.judged:
        if judged.status == "out":
            continue
        if not any(reading.maximum is not None for reading in judged.readings):
            open_.setdefault(f"{_sensor(judged.channel)} {judged.claim.label}", []).append(judged)
        elif not judged.may_be_out:
            continue  # below its maximum in every convention; the typical value decides nothing
        elif judged.reason in (NOT_ADEQUATE, ONLY_LIMITS):
            found.append(Remark(code="no_model", kind="judging", channels=(judged.channel,)))
        elif not any(reading.measured.anything for reading in judged.readings):
            found.append(
                Remark(code="not_measured", kind="judging", channels=(judged.channel,), what=judged.claim.label)
            )
        elif judged.status == "undecided":
            found.append(_undecided(judged))
    if open_:
        found.append(Remark(code="no_maximum", kind="judging", what=", ".join(open_)))
    found += [Remark(code="not_measured", kind="judging", channels=(name,)) for name in verdict.missing]
    if not verdict.judged and not verdict.missing:
        found.append(Remark(code="no_maximum", kind="judging", what="the noise of the measured channels"))
    return [*_merged(found), *_implausible(verdict)]


def _sensor(channel: str) -> str:
    return channel.partition("_")[0]


def _merged(remarks: Iterable[Remark]) -> list[Remark]:
    """Remarks that differ in their channel alone as one."""
    found: dict[tuple[object, ...], Remark] = {}
    for one in remarks:
        key = (one.code, one.what, one.text) if one.code in ("no_model", "not_measured") else (id(one),)
        before = found.get(key)
        channels = one.channels if before is None else (*before.channels, *one.channels)
        found[key] = (
            Remark(code=one.code, kind=one.kind, channels=channels, what=one.what, text=one.text)
            if (before is not None)
            else one
        )
    return list(found.values())


def _above(judged: Judged) -> Remark:
    # Of two readings of a claim, the one that is nearer to its limit: it is out by both.
    reading = min(
        (one for one in judged.readings if one.maximum is not None),
        key=lambda one: (
            (one.measured.value or one.measured.lower_limit or math.inf) / (one.maximum.limit if one.maximum else 1)
        ),
    )
    assert reading.maximum is not None
    text, factor = judged.claim.display()
    value = reading.measured.value if reading.measured.value is not None else reading.measured.lower_limit
    return Remark(
        code="above_maximum",
        kind="limit",
        channels=(judged.channel,),
        what=judged.claim.label,
        value=value,
        limit=reading.maximum.limit,
        ratio=None if value is None else value / reading.maximum.limit,
        unit=text,
        factor=factor * reading.meaning.factor,
    )


def _undecided(judged: Judged) -> Remark:
    reading = next(one for one in judged.readings if one.maximum is not None)
    assert reading.maximum is not None
    text, factor = judged.claim.display()
    several = len(judged.readings) > 1 and len({one.maximum and one.maximum.side for one in judged.readings}) > 1
    return Remark(
        code="undecided",
        kind="judging",
        channels=(judged.channel,),
        what=judged.claim.label,
        value=reading.measured.value,
        limit=reading.maximum.limit,
        unit=text,
        factor=factor * reading.meaning.factor,
        text=f"{judged.reason}; {_convention(judged.claim)}" if several and judged.reason else "",
    )


def _convention(claim: Claim) -> str:
    return "give --sided one or two" if claim.key == "noise_density" else "give --bias minimum or coefficient"


def _implausible(verdict: Verdict) -> list[Remark]:
    """The worst value of each sensor that is far from what is stated."""
    worst: dict[str, Remark] = {}
    for judged in verdict.judged:
        for near in _ratios(judged):
            sensor, known = _sensor(judged.channel), worst.get(_sensor(judged.channel))
            if known is None or abs(math.log(near.ratio or 1)) > abs(math.log(known.ratio or 1)):
                worst[sensor] = near
    return list(worst.values())


def _ratios(judged: Judged) -> Iterator[Remark]:
    claim = judged.claim
    ratios = []
    for reading in judged.readings:
        value = reading.measured.value
        stated = claim.typical if claim.typical is not None else claim.maximum
        if value is None or stated is None or not value > 0:
            return
        ratios.append(value / (stated * reading.meaning.factor))
    if not ratios:
        return
    ratio = min(ratios, key=lambda one: abs(math.log(one)))  # of two readings, the better one
    most = _FAR_FROM_TYPICAL if claim.typical is not None else _FAR_FROM_MAXIMUM
    if ratio < 1 / most or (ratio > _FAR_FROM_TYPICAL and (claim.typical is not None or ratio > most)):
        name = claim.usual if claim.typical is not None else "maximum"
        yield Remark(
            code="implausible_value",
            kind="lot",
            channels=(judged.channel,),
            what=claim.label,
            ratio=ratio,
            text=name,
        )


def of_findings(unit: UnitResult) -> list[Remark]:
    """The warnings about a record, and the defects that the analysis could leave out; others as notes."""
    reason = unit.reason
    remarks = [Remark(code=unit.rest, kind="judging", text=reason)] if reason else []
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for one in unit.findings:
        if one.code == unit.rest and reason:
            continue
        kinds.setdefault((one.code, one.severity), []).append(one)
    for (code, severity), alike in kinds.items():
        channels = tuple(dict.fromkeys(channel for one in alike for channel in one.channels))
        grave = (severity != "info" and code not in ALLOWED_FOR) or code in DEFECTS
        remarks.append(Remark(code=code, kind="data" if grave else "note", channels=channels, text=alike[0].message))
    return remarks


def channels_text(unit: UnitResult, usual: Mapping[str, int]) -> str:
    """Which channels a unit lacks, or has beyond those of the lot."""
    lacking = [name for name in usual if name not in unit.channels]
    more = [name for name in unit.channels if name not in usual]
    parts = [f"no {', '.join(lacking)}"] if lacking else []
    parts += [f"also {', '.join(more)}"] if more else []
    return "; ".join(parts)
