"""Rows of tables, in words, that the page, the PDF and the workbook of a lot share."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from sigmatau import __version__
from sigmatau.digits import round_to_error, significant
from sigmatau.lab.datasheets.claims import Claim
from sigmatau.lab.lots.lot_result import JudgedUnit, JudgingOptions, Lot
from sigmatau.lab.lots.lot_statistics import Distribution
from sigmatau.lab.lots.lot_words import listed, order_text, percent, what_text, what_unit, without_curves_text
from sigmatau.record import stream_name
from sigmatau.results import printable

MARKS = {"passed": "good", "failed": "poor", "not_judged": "partial", "unreadable": "error", "missing": "error"}
"""Colours of the states, the same as those of trust."""

DISTRIBUTION_HEADS = (
    *(
        "Axis",
        "Coefficient",
        "Units",
        "Median",
        "± %",
        "Smallest",
        "Largest",
        "Maximum",
        "Unit",
        "Cpk",
        "Drift or batch",
    ),
    "Outliers",
)

Column = tuple[str, str, str, float]
"""Sensor, coefficient, heading and factor to SI of a column in the table of units; the column of shares has no sensor."""

_COLUMNS = ("random_walk", "bias_instability", "means_10")  # coefficients that have a column
_MOST_COLUMNS = 6  # largest number of columns of coefficients
_SHORT = {"random_walk": "random walk", "bias_instability": "bias instability", "means_10": "10 s means"}
_MAXIMUM = "% of maximum"


_CONVENTIONS = {
    "one": "one-sided",
    "two": "two-sided",
    "minimum": "Allan minimum",
    "coefficient": "coefficient B",
    "unknown": "not stated",
}


def moment_text(date: datetime) -> str:
    """A date in words."""
    return date.strftime("%Y-%m-%d %H:%M UTC" if date.tzinfo is UTC else "%Y-%m-%d %H:%M")


def claim_rows(lot: Lot) -> list[list[str]]:
    """Rows of the claims of the specification: sensor, value, maximum, typical value, convention."""
    factor = lot.settings.factor
    rows = []
    for claim in () if lot.spec is None else lot.spec.claims:
        maximum = claim.maximum_text
        if not maximum:
            maximum = "none: not judged" if factor is None else f"{factor:g} × {claim.usual}"
        usual = f"{claim.typical_text} ({claim.usual})" if claim.typical_text else "–"
        rows.append([claim.sensor, claim.label, maximum, usual, _convention(claim, lot.settings)])
    return rows


def _convention(claim: Claim, settings: JudgingOptions) -> str:
    """The convention that the specification or an option states."""
    chosen = settings.sided if claim.key == "noise_density" else settings.bias
    if claim.convention == "unknown" and chosen is not None:
        return f"{_CONVENTIONS[chosen]} (chosen)"
    return _CONVENTIONS.get(claim.convention, claim.convention)


def number_columns(lot: Lot) -> list[Column]:
    """The columns of numbers in the table of units."""
    heads: dict[tuple[str, str], tuple[str, float]] = {}
    for distribution in lot.distributions:
        if distribution.what in _COLUMNS:
            text, factor = what_unit(distribution.what, *lot.quantity_of(distribution.channel), [distribution.median])
            sensor = stream_name(distribution.channel)
            heads.setdefault((sensor, distribution.what), (f"{sensor} {_SHORT[distribution.what]} [{text}]", factor))
    columns = [(*key, *value) for key, value in heads.items()][:_MOST_COLUMNS]
    return [("", "", _MAXIMUM, 1.0), *columns] if lot.spec is not None else columns


def unit_values(unit: JudgedUnit, columns: Sequence[Column]) -> list[str]:
    """The numbers of a unit, each the largest of the axes of a sensor; empty if no axis has a value."""
    cells = []
    for sensor, what, _, factor in columns:
        if not what:
            share = worst_share(unit)
            cells.append("" if share is None else _percent(share))
            continue
        values = [
            coefficient.value
            for channel, part in unit.result.channels.items()
            if stream_name(channel) == sensor and (coefficient := part.coefficients.get(what)) is not None
            if coefficient.value is not None
        ]
        cells.append(significant(max(values) / factor, zeros=True) if values else "")
    return cells


def _percent(share: float) -> str:
    return f"{100 * share:.0f}" if share >= 1 else f"{100 * share:.3g}"


def worst_share(unit: JudgedUnit) -> float | None:
    """Largest ratio of a value of a unit to its maximum; None if there is none. An upper limit is not a value."""
    shares = [
        reading.measured.value / reading.maximum.limit
        for judged in (unit.verdict.judged if unit.verdict is not None else ())
        for reading in judged.readings
        if reading.maximum is not None and reading.measured.value is not None and reading.maximum.limit > 0
    ]
    return max(shares) if shares else None


def distribution_rows(lot: Lot) -> list[list[str]]:
    """Cells of the rows below `DISTRIBUTION_HEADS`."""
    rows = []
    for distribution in lot.distributions:
        quantity, unit = lot.quantity_of(distribution.channel)
        text, factor = what_unit(distribution.what, quantity, unit, [distribution.median])
        limits = (
            " or ".join(f"{limit / factor:.3g}" for limit in lot.limits(distribution.channel, distribution.what)) or "–"
        )
        rows.append(
            [
                printable(distribution.channel),
                what_text(distribution.what, quantity),
                f"{len(distribution.units)}"
                + (f" of {len(distribution.units) + distribution.below}" if distribution.below else ""),
                significant(distribution.median / factor, zeros=True),
                percent(distribution.spread),
                significant(distribution.low / factor, zeros=True),
                significant(distribution.high / factor, zeros=True),
                limits,
                text,
                _capability(lot, distribution),
                "–" if distribution.order is None else order_text(distribution.order),
                listed(distribution.outliers) or "–",
            ]
        )
    return rows


def _capability(lot: Lot, distribution: Distribution) -> str:
    number = lot.capability(distribution)
    return "–" if number is None else round_to_error(number.value, number.low, number.high).with_unit("")


def done_rows(lot: Lot, command: str | None, moment: str) -> list[tuple[str, str]]:
    """Settings of the comparison, command, date and version: names and texts."""
    settings = lot.settings
    shown = {
        "Specification": "none" if lot.spec is None else f"{lot.spec.name} ({lot.spec.maker}); {lot.spec.source}",
        "Expected": "not stated" if lot.expected is None else f"{lot.expected} units",
        "Confidence level": f"{100 * settings.level:g} % for above a maximum, and for below it",
        "Without a maximum": "not judged" if settings.factor is None else f"{settings.factor:g} × typical or 1 σ value",
        "Undecided": settings.undecided.replace("-", " "),
        "Warnings": "the unit fails" if settings.fail_on else "the unit is not judged",
        "Accepted": ", ".join(settings.accept) or "nothing",
        "Curves": without_curves_text([unit.remarks for unit in lot.units]),
        "Exit code": str(lot.exit_code),
        "Command": command or "",
        "Date": moment,
        "Version": f"sigmatau {__version__}",
    }
    return [(key, printable(text)) for key, text in shown.items() if text]
