"""A temperature calibration in words: the tables of the terminal and of the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.digits import limit_text, round_to_error, significant
from sigmatau.fitting import FittedTerm
from sigmatau.lab.lots.comparison_text import usual_unit
from sigmatau.lab.temperature.polynomial import WORDS
from sigmatau.results import aligned, duration_text, lines_text

if TYPE_CHECKING:
    from sigmatau.lab.temperature.result import ChannelCalibration, TemperatureCalibration, TemperatureWindow

_SHORT = {"random_walk": "random walk", "bias_instability": "bias instability", "rate_random_walk": "rate random walk"}
_POINTS = 200  # points at which the range of a polynomial is searched
_ARROWS = {"rising": "↑", "falling": "↓", "": ""}


def headline(result: TemperatureCalibration) -> str:
    """Range of temperatures, directions and length in one line."""
    windows = [window for channel in result.values() for window in channel.windows]
    length = max((window.stop for window in windows), default=0.0)
    branches = {window.branch for window in windows} - {""}
    names = {window.name for window in windows} - {""}
    how = f"{len(names)} runs" if names else " and ".join(sorted(branches, reverse=True))
    parts = [f"{result.low:.3g} to {result.high:.3g} °C", how]
    if not names:
        parts += ["in steps" if any(window.held for window in windows) else "ramp", duration_text(length)]
    return ", ".join(filter(None, parts))


def printed(result: TemperatureCalibration) -> str:
    """The calibration for a terminal."""
    lines = [f"{result.source or 'record'}   {headline(result)}"]
    for channel in result.values():
        lines += ["", channel.channel, *(f"  {line}" for line in summary_lines(channel))]
        lines += [f"  {line}" for line in aligned([heads(channel), *rows(channel)])]
    arrows = " ↑ rising, ↓ falling." if any(channel.run_spread is None for channel in result.values()) else ""
    lines += ["", f"Intervals: {100 * result.level:g} %.{arrows} The mean is the bias with gravity."]
    lines += [f"! {remark}" for remark in result.remarks]
    return lines_text(lines)


def mean_unit(channel: ChannelCalibration) -> tuple[str, float]:
    """Usual unit of the bias of a channel, and its size in SI."""
    return usual_unit("bias_instability", channel.quantity, channel.unit, [window.mean for window in channel.windows])


def term_unit(channel: ChannelCalibration, name: str) -> tuple[str, float]:
    """Usual unit of a coefficient of a channel, and its size in SI."""
    terms = [part[name] for part in (channel.overall, *(window.terms for window in channel.windows)) if name in part]
    values = [value for term in terms for value in (term.value, term.upper_limit)]
    return usual_unit(name, channel.quantity, channel.unit, values)


def summary_lines(channel: ChannelCalibration) -> list[str]:
    """Polynomial, hysteresis and gain of the compensation."""
    unit, size = mean_unit(channel)
    polynomial = channel.polynomial
    lines = [
        f"mean {coefficient_texts(channel)[0]} at {polynomial.reference:g} °C, changes by"
        f" {significant(polynomial_range(channel) / size)} {unit} over the range"
    ]
    slopes = ", ".join(coefficient_texts(channel)[1:])
    lines += [f"{WORDS[polynomial.degree]}: {slopes}"] if slopes else ["no change with temperature is observed"]
    if channel.hysteresis is not None:
        h = channel.hysteresis
        worst = int(abs(h.value).argmax())
        average = round_to_error(h.mean, h.mean_low, h.mean_high, size=size).with_unit(unit)
        largest = round_to_error(float(h.value[worst]), float(h.low[worst]), float(h.high[worst]), size=size)
        lines.append(
            f"hysteresis (falling - rising) {average} on average, {largest.with_unit(unit)} at {h.temperature[worst]:.3g} °C"
        )
    if channel.run_spread is not None:
        lines.append(f"spread of the runs about the polynomial {significant(channel.run_spread / size)} {unit}")
    if (gain := compensation_gain(channel)) is not None:
        tau, before, after = gain
        lines.append(
            f"Allan deviation at {duration_text(tau)}: {significant(before / size)} {unit},"
            f" compensated {significant(after / size)} {unit}"
        )
    return lines


def polynomial_range(channel: ChannelCalibration) -> float:
    """Difference of the largest and the smallest value of the polynomial. [unit]"""
    polynomial = channel.polynomial
    return float(np.ptp(polynomial.values(np.linspace(polynomial.low, polynomial.high, _POINTS)).value))


def coefficient_texts(channel: ChannelCalibration) -> list[str]:
    """The coefficients of the polynomial with their intervals, in the usual unit per power of a kelvin."""
    unit, size = mean_unit(channel)
    polynomial = channel.polynomial
    return [
        round_to_error(value, error=error, size=size).with_unit(f"{unit}{'/K' if k == 1 else f'/K^{k}' if k else ''}")
        for k, (value, error) in enumerate(
            zip(polynomial.coefficients.tolist(), polynomial.errors.tolist(), strict=True)
        )
    ]


def compensation_gain(channel: ChannelCalibration) -> tuple[float, float, float] | None:
    """Averaging time with the largest gain, and the deviations before and after the compensation. [s], [unit]"""
    if channel.raw is None or channel.compensated is None:
        return None
    before = dict(zip(channel.raw.tau.tolist(), channel.raw.adev.tolist(), strict=True))
    after = dict(zip(channel.compensated.tau.tolist(), channel.compensated.adev.tolist(), strict=True))
    common = [tau for tau in before if after.get(tau)]
    if not common:
        return None
    best = max(common, key=lambda tau: before[tau] / after[tau])
    return best, before[best], after[best]


def heads(channel: ChannelCalibration) -> list[str]:
    """Heads of the table of windows."""
    has_runs = any(window.name for window in channel.windows)
    first = ["run"] if has_runs else []
    units = [term_unit(channel, name)[0] for name in _SHORT]
    noise = [f"{_SHORT[name]} [{unit}]" for name, unit in zip(_SHORT, units, strict=True)]
    return [*first, "T [°C]", "", f"mean [{mean_unit(channel)[0]}]", *noise]


def rows(channel: ChannelCalibration) -> list[list[str]]:
    """Cells of the table of windows."""
    has_runs = any(window.name for window in channel.windows)
    table = [([window.name] if has_runs else []) + _row(channel, window) for window in channel.windows]
    if channel.overall:
        table.append(["all", "", "", *(term_text(channel, channel.overall.get(name), name) for name in _SHORT)])
    return table


def _row(channel: ChannelCalibration, window: TemperatureWindow) -> list[str]:
    _, size = mean_unit(channel)
    mean = round_to_error(window.mean, window.low, window.high, size=size).text
    place = f"{window.temperature:.1f}"
    return [place, _ARROWS[window.branch], mean, *(term_text(channel, window.terms.get(name), name) for name in _SHORT)]


def term_text(channel: ChannelCalibration, term: FittedTerm | None, name: str) -> str:
    """A coefficient with its interval, or its limit, in its usual unit."""
    if term is None:
        return "–"
    _, factor = term_unit(channel, name)
    if term.value is None:
        return "–" if term.upper_limit is None else limit_text(term.upper_limit / factor)
    return round_to_error(term.value, term.low, term.high, size=factor).text


def mean_text(result: TemperatureCalibration, temperatures: Floats) -> str:
    """The mean of each channel at some temperatures, as a table.

    Raises `OptionError` for a temperature outside the observed range.
    """
    table = [["channel", *(f"{t:g} °C" for t in temperatures)]]
    for channel in result.values():
        unit, size = mean_unit(channel)
        curve = channel.polynomial.values(temperatures)
        ends = zip(curve.value.tolist(), curve.low.tolist(), curve.high.tolist(), strict=True)
        texts = [round_to_error(value, low, high, size=size).text for value, low, high in ends]
        table.append([f"{channel.channel} [{unit}]", *texts])
    return lines_text(aligned(table))
