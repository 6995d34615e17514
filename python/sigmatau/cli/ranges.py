"""Ranges of averaging times on the command line."""

from __future__ import annotations

from sigmatau.analysis import Analysis
from sigmatau.errors import OptionError
from sigmatau.noise.terms import TERMS
from sigmatau.results import seconds, wrapped
from sigmatau.typed.ranges import parse_ends


def slope_range(text: str) -> tuple[float, float]:
    """Parse the option ``--slope``: ``"1s:10s"`` becomes ``(1.0, 10.0)``, in s."""
    return parse_ends(text, text, option="slope", example="1s:10s")


def slopes(analysis: Analysis, span: tuple[float, float]) -> list[str]:
    """Slope of each curve between two averaging times, and the terms with this slope; one line per channel."""
    from sigmatau.fitting.curve_slope import fit_slope

    try:
        fitted = [fit_slope(curve, tau_min=span[0], tau_max=span[1]) for curve in analysis.curves.values()]
    except OptionError as error:
        raise error.named("slope") from None
    legend = (
        "±: standard error of the slope for a curve of the named term; mostly: the slope is not that of the term alone."
    )
    return wrapped([*map(repr, fitted), legend])


_FORCE = "--force draws a refused line"


def lines_by_hand(analysis: Analysis) -> list[str]:
    """Coefficients read off in given ranges in addition to a fit, one line per channel. A read-off without a fit is
    printed as a table.
    """
    lines = []
    for channel, read in analysis.read_off.items() if analysis.fits else ():
        texts = [
            f"{TERMS[name].label(read.quantity)} {' '.join(read.texts(name)[-1])} ({coefficient.region})"
            for name, coefficient in read.items()
            if coefficient.range_from == "given"
        ]
        if texts:
            lines.append(f"{channel} read off: {', '.join(texts)}")
    return wrapped(lines)


def refused_by_hand(analysis: Analysis, *, in_table: bool) -> list[str]:
    """Refused lines of given ranges with reasons, one line each, unless they are in the table."""
    lines = [
        f"{channel} {TERMS[refusal.term].label(read.quantity)} not read off from {seconds(refusal.tau_min)} to"
        f" {seconds(refusal.tau_max)} s: {refusal.reason}"
        for channel, read in analysis.read_off.items()
        for refusal in read.refused
        if refusal.by_hand
    ]
    return [*(() if in_table else lines), _FORCE] if lines else []
