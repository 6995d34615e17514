"""Remarks on one unit, from a specification and the findings, before the unit is compared with the rest of the lot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from sigmatau import Finding
from sigmatau.findings.finding import Stated
from sigmatau.lab.datasheets.verdict import Judged, Verdict
from sigmatau.lab.lots.lot_findings import AboveMaximum, ImplausibleValue, NoMaximum, NoModel, NotMeasured, Undecided
from sigmatau.lab.lots.lot_remark import Kind, Remark, remark
from sigmatau.lab.lots.lot_unit import UnitResult

DEFECTS = ("spikes", "saturation", "dropout", "stuck_samples", "implausible_unit")
"""Defects of a sensor: a unit with such a finding does not pass, even if the analysis could leave the samples out."""

ALLOWED_FOR = ("widened",)
"""Warnings that the intervals already allow for, so that a unit with them can pass."""

_FAR_FROM_TYPICAL = 10.0
"""Ratio to the typical value above which a value is implausible. Sensors of one type differ by far less. A mistaken unit
of measurement changes a value by more (57.3, 9.81², 1000, 3600), except g and m/s², where the mean acceleration decides.
"""

_FAR_FROM_MAXIMUM = 30.0  # the same ratio below a maximum: makers set maxima several times above the typical value


def remarks_on_verdict(verdict: Verdict) -> list[Remark]:
    """Remarks on a comparison with a specification: values that exceed a maximum, cannot be judged, or are implausible."""
    remarks = [_above(judged) for judged in verdict.of("out")]
    without_maximum: dict[str, list[Judged]] = {}
    for judged in verdict.judged:
        if judged.status == "out":
            continue
        if not any(reading.maximum is not None for reading in judged.readings):
            without_maximum.setdefault(f"{_sensor(judged.channel)} {judged.claim.label}", []).append(judged)
        elif not judged.may_be_out:
            continue  # below its maximum in every convention; the typical value decides nothing
        elif judged.doubt is not None and judged.doubt.of_model:
            remarks.append(remark(NoModel(), "judging", (judged.channel,)))
        elif not any(reading.measured.anything for reading in judged.readings):
            remarks.append(remark(NotMeasured(what=judged.claim.label), "judging", (judged.channel,)))
        elif judged.status == "undecided":
            remarks.append(_undecided(judged))
    if without_maximum:
        remarks.append(remark(NoMaximum(what=", ".join(without_maximum)), "judging"))
    remarks += [remark(NotMeasured(), "judging", (name,)) for name in verdict.missing]
    if not verdict.judged and not verdict.missing:
        remarks.append(remark(NoMaximum(what="the noise of the measured channels"), "judging"))
    return [*_merged(remarks), *_implausible(verdict)]


def _sensor(channel: str) -> str:
    return channel.partition("_")[0]


def _merged(remarks: Iterable[Remark]) -> list[Remark]:
    """Merge remarks that differ only in their channel."""
    merged: dict[tuple[object, ...], Remark] = {}
    for single in remarks:
        details = single.details
        key = (details,) if isinstance(details, NoModel | NotMeasured) else (id(single),)
        before = merged.get(key)
        merged[key] = single if before is None else remark(details, single.kind, (*before.channels, *single.channels))
    return list(merged.values())


def _above(judged: Judged) -> Remark:
    # If a claim has two meanings, the value exceeds both limits; the closer limit is reported.
    reading = min(
        (reading for reading in judged.readings if reading.maximum is not None),
        key=lambda reading: (
            (reading.measured.value or reading.measured.lower_limit or math.inf)
            / (reading.maximum.limit if reading.maximum else 1)
        ),
    )
    assert reading.maximum is not None
    text, factor = judged.claim.display()
    value = reading.measured.value if reading.measured.value is not None else reading.measured.lower_limit
    details = AboveMaximum(
        what=judged.claim.label,
        value=value,
        limit=reading.maximum.limit,
        ratio=None if value is None else value / reading.maximum.limit,
        unit=text,
        factor=factor * reading.meaning.factor,
        low=reading.measured.low,
        high=reading.measured.high,
    )
    return remark(details, "limit", (judged.channel,))


def _undecided(judged: Judged) -> Remark:
    reading = next(reading for reading in judged.readings if reading.maximum is not None)
    assert reading.maximum is not None
    text, factor = judged.claim.display()
    depends = (
        len(judged.readings) > 1 and len({reading.maximum and reading.maximum.side for reading in judged.readings}) > 1
    )
    details = Undecided(
        what=judged.claim.label,
        value=reading.measured.value,
        limit=reading.maximum.limit,
        unit=text,
        factor=factor * reading.meaning.factor,
        low=reading.measured.low,
        high=reading.measured.high,
        convention=None if not depends else "sided" if judged.claim.key == "noise_density" else "bias",
    )
    return remark(details, "judging", (judged.channel,))


def _implausible(verdict: Verdict) -> list[Remark]:
    """The worst value of each sensor that is far from the specification."""
    worst: dict[str, tuple[float, Remark]] = {}
    for judged in verdict.judged:
        sensor = _sensor(judged.channel)
        for details in _ratios(judged):
            off = abs(math.log(details.ratio or 1))
            if sensor not in worst or off > worst[sensor][0]:
                worst[sensor] = off, remark(details, "lot", (judged.channel,))
    return [worst_remark for _, worst_remark in worst.values()]


def _ratios(judged: Judged) -> Iterator[ImplausibleValue]:
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
    ratio = min(ratios, key=lambda ratio: abs(math.log(ratio)))  # if a claim has two meanings, the more plausible one
    tolerance = _FAR_FROM_TYPICAL if claim.typical is not None else _FAR_FROM_MAXIMUM
    if ratio < 1 / tolerance or (ratio > _FAR_FROM_TYPICAL and (claim.typical is not None or ratio > tolerance)):
        name = claim.usual if claim.typical is not None else "maximum"
        yield ImplausibleValue(what=claim.label, ratio=ratio, stated=name)


def remarks_on_findings(unit: UnitResult) -> list[Remark]:
    """Remarks on warnings about a record and on defects that the analysis could leave out; other findings become notes."""
    kinds: dict[tuple[str, str], list[Finding]] = {}
    for finding in unit.findings:
        kinds.setdefault((finding.code, finding.severity), []).append(finding)
    remarks = []
    if unit.reason and all(code != unit.rest for code, _ in kinds):  # a result built by hand
        remarks.append(remark(Stated(stated_code=unit.rest, message=unit.reason), "judging"))
    for (code, severity), alike in kinds.items():
        channels = tuple(dict.fromkeys(channel for finding in alike for channel in finding.channels))
        grave = (severity != "info" and code not in ALLOWED_FOR) or code in DEFECTS
        kind: Kind = "judging" if unit.reason and code == unit.rest else "data" if grave else "note"
        remarks.append(Remark(finding=alike[0], kind=kind, channels=channels))
    return remarks
