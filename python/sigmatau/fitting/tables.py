"""Tables of results as aligned text, for the command line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from sigmatau.digits import round_to_error
from sigmatau.fitting.mean_stability import MeanStability
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.read_off import ReadOff
from sigmatau.noise.terms import TERMS, asked_rate_unit, display_units
from sigmatau.results import seconds, wrapped

if TYPE_CHECKING:
    from sigmatau.estimators.deviation import Deviation
    from sigmatau.estimators.deviation_kinds import Noise
    from sigmatau.estimators.noise_identification import NoiseIdentifications

_LEGEND = (
    "Read off as in El-Sheimy, Hou & Niu (2008): lines with the slopes of the terms, which together follow the curve. ± is"
    " their eq. (26) at the longest τ of each region: a rule of thumb, not a confidence interval. A term that is not listed"
    " has no region."
)
_BESIDE_FIT = "Each line is laid where the fitted model says that its term is most of the variance."
_BY_RULES = "By rules on the curve alone, without a model"

_COLUMNS = 4

_FITTED = {
    "likelihood": "Fitted: maximum likelihood of the spectrum. [ ], ±: 95 % confidence interval.",
    "gls": "Fitted: least squares on the Allan variances with their exact covariance. [ ], ±: 95 % confidence interval.",
}
_FIT_LEGEND = (
    '"below": 95 % upper limit of a term that is not observed; `sigmatau plan` tells how long a record would show it.',
    "p: p-value of the model; with p < 0.002 it does not fit.",
    "Read off: as in El-Sheimy, Hou & Niu (2008), by lines with the slopes of the terms, each laid where its term is most of"
    " the variance; ± by their eq. (26) at the longest τ, a rule of thumb.",
)


def fit_table(
    fits: Mapping[str, NoiseFit],
    read_offs: Mapping[str, ReadOff],
    means: Mapping[str, Sequence[MeanStability]] = MappingProxyType({}),
) -> str:
    """Fitted and read-off coefficients as aligned text, in the field's units; `fit_legend` explains them.

    Parameters
    ----------
    fits, read_offs : mapping
        By channel.
    means : mapping of str to sequence of MeanStability
        Standard deviations of means by channel.
    """
    rows: list[tuple[str, ...]] = [("", "fitted", "95 % interval", "")]
    for channel, fitted in fits.items():
        trust_words = f"trust: {fitted.trust}; " if fitted.trust else ""
        rows.append((f"{channel}  {trust_words}{fitted.headline(method=False)}",))
        for name in fitted:
            term = TERMS[name]
            texts = fitted.texts(name)
            if fitted[name].value is not None:
                for k, (value, interval, unit) in enumerate(texts):
                    label = term.label(fitted.quantity) if k == 0 else "  ="
                    rows.append((f"  {label}", value, interval, unit))
            elif fitted.has_limits:
                value, _, unit = texts[-1]
                text = f"{value} {unit}: {fitted.why_not(name)}" if value else fitted.why_not(name)
                rows.append((f"  {term.label(fitted.quantity)}", text))
        rows += [_mean_row(fitted, stability) for stability in means.get(channel, ())]
        rows += [("  " + text,) for text in (*fitted.notes(), *_readings(fitted, read_offs[channel]))]
    full = [row for row in rows if len(row) == _COLUMNS]
    widths = [max(len(row[k]) for row in full) for k in range(_COLUMNS)]
    widths[0] = max(len(row[0]) for row in rows if len(row) > 1)
    return "\n".join(_aligned(rows, widths))


def _mean_row(fitted: NoiseFit, stability: MeanStability) -> tuple[str, ...]:
    """The standard deviation of means, in the unit of a bias."""
    text, factor = display_units("bias_instability", fitted.quantity, fitted.rate_unit, [stability.value])[-1]
    return (
        f"  STD of {seconds(stability.average)} s means",
        *round_to_error(stability.value, stability.low, stability.high, size=factor).cells,
        text,
    )


def _readings(fitted: NoiseFit, read: ReadOff) -> list[str]:
    """Read-off coefficients with their ranges, and observed terms that other noise hides, in words."""
    rows = [
        f"{TERMS[name].label(fitted.quantity)} {' '.join(read.texts(name)[-1])} ({read[name].region})"
        for name in fitted
        if name in read
    ]
    hidden = [TERMS[refusal.term].label(fitted.quantity) for refusal in read.refused if refusal.hidden]
    lines = [f"read off: {', '.join(rows)}"] if rows else []
    return [*lines, *([f"not read off, hidden by other noise: {', '.join(hidden)}"] if hidden else [])]


def _aligned(rows: Iterable[Sequence[str]], widths: Sequence[int]) -> list[str]:
    """Align rows in columns. A row wider than the terminal continues below its last cell."""
    lines = []
    for row in rows:
        line = "  ".join((*(cell.ljust(w) for cell, w in zip(row[:-1], widths, strict=False)), row[-1])).rstrip()
        indent = sum(widths[: len(row) - 1]) + 2 * (len(row) - 1) if len(row) > 1 else 4
        lines += wrapped([line], indent=indent)
    return lines


_MEANS_LEGEND = (
    "STD of means: standard deviation (ddof = 1) of the means of consecutive stretches; slow noise makes it grow with the"
    " length of the record."
)


def fit_legend(fits: Mapping[str, NoiseFit], *, means: object = ()) -> str:
    """Explain the numbers of `fit_table`. `means`: whether it contains standard deviations of means."""
    pairs = [(fitted.quantity, name) for fitted in fits.values() for name in fitted if fitted[name].value is not None]
    lines = [*(_FITTED[method] for method in dict.fromkeys(fitted.method for fitted in fits.values())), *_FIT_LEGEND]
    lines += [_MEANS_LEGEND] if means else []
    if any(name == "bias_instability" for _, name in pairs):
        lines.append("Bias instability B: most datasheets state the flat part of the curve instead, 0.664·B.")
    return "\n".join(wrapped([*lines, *_look_alikes(pairs)]))


def _look_alikes(pairs: Iterable[tuple[str, str]]) -> list[str]:
    """Other effects with the slope of the terms, by quantity and name."""
    notes: dict[str, str] = {}
    for quantity, name in pairs:
        if TERMS[name].look_alikes:
            notes.setdefault(TERMS[name].look_alikes, TERMS[name].label(quantity))
    return [f"{term.capitalize()} has the same slope as {names}." for names, term in notes.items()]


def read_off_table(read_off: Mapping[str, ReadOff]) -> str:
    """The coefficients as aligned text, channel by channel, in the paper's form and the field's units."""
    rows: list[tuple[str, str, str, str]] = []
    for channel, result in read_off.items():
        if not result and not result.refused:
            rows.append((channel, "no term has a region", "", ""))
        first = channel
        for name, c in result.items():
            for k, (value, unit) in enumerate(result.texts(name)):
                label = TERMS[name].label(result.quantity) if k == 0 else "  ="
                rows.append((first, label, f"{value} {unit}", c.region if k == 0 else ""))
                first = ""
        for refusal in result.refused:
            label = f"no {TERMS[refusal.term].label(result.quantity)}"
            region = f"τ {seconds(refusal.tau_min)} … {seconds(refusal.tau_max)} s"
            rows.append((first, f"{label}, {region}: {refusal.reason}", "", ""))
            first = ""
    full = [row for row in rows if row[2]] or rows
    widths = [max((len(row[k]) for row in (full if k else rows)), default=0) for k in range(4)]
    return "\n".join(_aligned((row if row[2] else row[:2] for row in rows), widths))


def read_off_legend(read_off: Mapping[str, ReadOff]) -> str:
    """Explain the numbers of `read_off_table`."""
    pairs = [(result.quantity, name) for result in read_off.values() for name in result]
    sources = {channel: {line.range_from for line in result.values()} for channel, result in read_off.items()}
    by_rules = [channel for channel, origins in sources.items() if "rules" in origins]
    ranges = [_BESIDE_FIT] if any("fit" in origins for origins in sources.values()) else []
    ranges += [f"{_BY_RULES}: {', '.join(by_rules)}."] if by_rules else []
    return "\n".join(wrapped([_LEGEND, *ranges, *_look_alikes(pairs)]))


def deviation_table(deviations: Mapping[str, Deviation], *, noise: Noise | NoiseIdentifications | None = None) -> str:
    """Deviations by channel in the units of figures, with their 95 % intervals if the `noise` is given."""
    from sigmatau.estimators.noise_identification import NoiseIdentifications, channel_noise
    from sigmatau.plot.curves import curve_unit

    lines: list[str] = []
    for channel, curve in deviations.items():
        middle = float(np.median(curve.deviation)) if len(curve.deviation) else 0.0
        prefixed = asked_rate_unit(curve.quantity, curve.unit, [middle])
        factor, unit = curve_unit(curve, None) if prefixed is None else (prefixed[1], prefixed[0])
        lines.append(f"{channel}: {curve.label} [{unit}], {curve.n} samples at {1 / curve.tau0:.6g} Hz")
        rows = [
            (f"{tau:.6g} s", f"{value:.5g}") for tau, value in zip(curve.tau, curve.deviation / factor, strict=True)
        ]
        texts = [f"{terms} terms" for terms in curve.n_terms]
        if noise is not None:
            low, high = (ends / factor for ends in curve.interval(noise=channel_noise(noise, channel, curve.tau)))
            cells = [round_to_error(*ends).cells for ends in zip(curve.deviation / factor, low, high, strict=True)]
            rows = [(tau, value) for (tau, _), (value, _) in zip(rows, cells, strict=True)]
            texts = [interval for _, interval in cells]
        lines += [f"  {tau:>12}  {value:<11}  {text}" for (tau, value), text in zip(rows, texts, strict=True)]
    if noise is not None:
        identified = isinstance(noise, NoiseIdentifications)
        shown = (
            "the noise identified at each time" if identified else noise if isinstance(noise, str) else ", ".join(noise)
        )
        lines += ["", f"[ ]: 95 % interval by χ² with the degrees of freedom of {shown.replace('_', ' ')}."]
    return "\n".join(lines)
