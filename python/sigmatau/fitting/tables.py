"""Tables of results as aligned text, for the command line."""

from __future__ import annotations

from collections.abc import Mapping

from sigmatau.estimators.deviation import Deviation
from sigmatau.fitting.noise_fit import NoiseFit
from sigmatau.fitting.read_off import ReadOff
from sigmatau.noise.terms import TERMS
from sigmatau.results import seconds

_LEGEND = (
    "Read off as in El-Sheimy, Hou & Niu (2008). ± is their eq. (26) at the longest τ of each region: a rule of thumb,",
    "not a confidence interval; it ignores the bias where terms meet. A term that is not listed has no region of its slope.",
)


_COLUMNS = 5

_FITTED = {
    "likelihood": "Fitted: maximum likelihood of the spectrum. [ ]: 95 % confidence interval;",
    "gls": "Fitted: least squares on the Allan variances with their exact covariance. [ ]: 95 % confidence interval;",
}
_FIT_LEGEND = (
    '"below": 95 % upper limit of a term that is not observed; `sigmatau plan` tells how long a record would show it.',
    "p: p-value of the model; with p < 0.002 it does not fit.",
    "Read off: lines with the term's slope, ± by eq. (26), as in El-Sheimy, Hou & Niu (2008). The columns differ:",
    "a line includes the other terms at its averaging times, and its ± is a rule of thumb.",
)


def fit_table(fits: Mapping[str, NoiseFit], read_offs: Mapping[str, ReadOff]) -> str:
    """The fitted coefficients as aligned text, in the field's units, beside those read off."""
    rows: list[tuple[str, ...]] = [("", "fitted", "95 % interval", "", "read off")]
    notes: dict[str, str] = {}
    plateau = False
    for channel, fitted in fits.items():
        read = read_offs[channel]
        rows.append((channel, fitted.headline(method=False)))
        for name in fitted:
            term = TERMS[name]
            reading = read.texts(name)[0] if name in read else None
            texts = fitted.texts(name)
            if fitted[name].value is not None:
                for k, (value, interval, unit) in enumerate(texts):
                    label = term.label(fitted.quantity) if k == 0 else "  ="
                    rows.append((f"  {label}", value, interval, unit, reading[0] if reading and k == 0 else ""))
                if term.look_alikes:
                    notes.setdefault(term.look_alikes, term.label(fitted.quantity))
                plateau = plateau or name == "bias_instability"
            elif fitted.quantified:
                value, _, unit = texts[0]
                text = f"{value} {unit}: {fitted.why_not(name)}" if value else fitted.why_not(name)
                also = f"; read off {' '.join(reading)}" if reading else ""
                rows.append((f"  {term.label(fitted.quantity)}", text + also))
        rows += [("  " + text,) for text in fitted.notes()]
    full = [row for row in rows if len(row) == _COLUMNS]
    widths = [max(len(row[k]) for row in full) for k in range(_COLUMNS)]
    labels = max(len(row[0]) for row in rows if len(row) > 1)
    widths[0] = labels
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=False)).rstrip() for row in rows]
    methods = dict.fromkeys(fitted.method for fitted in fits.values())
    lines += ["", *(_FITTED[method] for method in methods), *_FIT_LEGEND]
    if plateau:
        lines.append("Bias instability B: most datasheets state the flat part of the curve instead, 0.664·B.")
    lines += [f"{term.capitalize()} has the same slope as {others}." for others, term in notes.items()]
    return "\n".join(lines)


def read_off_table(read_off: Mapping[str, ReadOff]) -> str:
    """The coefficients as aligned text, channel by channel, in the paper's form and the field's units."""
    rows: list[tuple[str, str, str, str]] = []
    notes: dict[str, str] = {}
    for channel, result in read_off.items():
        if not result and not result.refused:
            rows.append((channel, "no term has a region", "", ""))
        first = channel
        for name, c in result.items():
            texts = result.texts(name)
            region = f"τ {seconds(c.tau_min)} … {seconds(c.tau_max)} s"
            for k, (value, unit) in enumerate(texts):
                label = TERMS[name].label(result.quantity) if k == 0 else "  ="
                rows.append((first, label, f"{value} {unit}", region if k == 0 else ""))
                first = ""
            if TERMS[name].look_alikes:
                notes.setdefault(TERMS[name].look_alikes, TERMS[name].label(result.quantity))
        for refusal in result.refused:
            label = f"no {TERMS[refusal.term].label(result.quantity)}"
            rows.append(
                (first, label, "", f"τ {seconds(refusal.tau_min)} … {seconds(refusal.tau_max)} s: {refusal.reason}")
            )
            first = ""
    widths = [max((len(row[k]) for row in rows), default=0) for k in range(3)]
    lines = ["  ".join((*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3])).rstrip() for row in rows]
    lines += ["", *_LEGEND]
    lines += [f"{term.capitalize()} has the same slope as {others}." for others, term in notes.items()]
    return "\n".join(lines)


def deviation_table(deviations: Mapping[str, Deviation], *, noise: str | Mapping[str, float] | None = None) -> str:
    """Deviations by channel in SI, with their 95 % intervals if the `noise` is given."""
    lines: list[str] = []
    for channel, curve in deviations.items():
        lines.append(f"{channel}: {curve.label} [{curve.unit}], {curve.n} samples at {1 / curve.tau0:.6g} Hz")
        rows = [(f"{tau:.6g} s", f"{value:.5g}") for tau, value in zip(curve.tau, curve.deviation, strict=True)]
        texts = [f"{terms} terms" for terms in curve.n_terms]
        if noise is not None:
            low, high = curve.interval(noise=noise)
            texts = [f"[{a:.5g}, {b:.5g}]" for a, b in zip(low, high, strict=True)]
        lines += [f"  {tau:>12}  {value:<11}  {text}" for (tau, value), text in zip(rows, texts, strict=True)]
    if noise is not None:
        shown = noise if isinstance(noise, str) else ", ".join(noise)
        lines += ["", f"[ ]: 95 % interval by χ² with the degrees of freedom of {shown.replace('_', ' ')}."]
    return "\n".join(lines)
