"""IEEE Std 952: table of all coefficients in units of the standard, with intervals or upper limits, and in SI."""

from __future__ import annotations

from sigmatau.digits import limit_text, round_to_error
from sigmatau.exporting.target import Target, Unused
from sigmatau.exporting.text import comment, measured
from sigmatau.exporting.values import Numbers
from sigmatau.model.channel import ChannelModel
from sigmatau.model.file import doubt_text
from sigmatau.model.turn_on import TurnOn
from sigmatau.noise.terms import TERMS
from sigmatau.units import STANDARD_GRAVITY, find

_HOUR = 3600.0

# Units of the table: text and factor to SI, the unit of the standard first.
_UNITS = {
    "angular_rate": {
        "quantization": (("arcsec", find("arcsec").factor), ("µrad", 1e-6)),
        "random_walk": (("°/√h", find("deg/sqrt(h)").factor),),
        "bias_instability": (("°/h", find("deg/h").factor),),
        "rate_random_walk": (("(°/h)/√h", find("deg/h/sqrt(h)").factor),),
        "rate_ramp": (("(°/h)/h", find("deg/h^2").factor),),
    },
    "acceleration": {
        "quantization": (("m/s", 1.0),),
        "random_walk": (("m/s/√h", find("m/s/sqrt(h)").factor),),
        "bias_instability": (("µg", STANDARD_GRAVITY * 1e-6), ("m/s²", 1.0)),
        "rate_random_walk": (("µg/√h", find("ug/sqrt(h)").factor), ("(m/s²)/√h", find("m/s^2/sqrt(h)").factor)),
        "rate_ramp": (("µg/h", find("ug/h").factor), ("(m/s²)/h", 1 / _HOUR)),
    },
}


_NO_INTERVAL, _UNKNOWN, _NOT_IN_MODEL = "no interval", "unknown", "not in the model"

_FOOT = {
    _NO_INTERVAL: "No interval: the value is from a model file, from another program, or from an axis without a model.",
    _UNKNOWN: "Unknown: the fit excludes the averaging times that would show the term, or no model fits.",
    _NOT_IN_MODEL: "Not in the model: a model file does not show whether the term was searched.",
}


def write(numbers: Numbers) -> str:
    """The text of the table: a block per channel, a row per term."""
    cells_written: set[str] = set()
    blocks = ["Noise coefficients after IEEE Std 952; two-sided densities. The last column is in SI."]
    for name, model in numbers.model.channels.items():
        rows = [row for term in TERMS for row in _rows(model, term)] + _process_rows(model)
        cells_written.update(cell for row in rows for cell in row)
        widths = [max(len(row[column]) for row in rows) for column in range(4)]
        lines = [f"{comment(name)} [{comment(model.unit)}]"]
        for row in rows:
            cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=False)]
            lines.append(f"  {'  '.join([*cells, row[4]])}".rstrip())
        blocks.append("\n".join(lines))
    text = "\n\n".join(blocks)
    foot = [line for cell, line in _FOOT.items() if cell in cells_written]
    return "\n".join([text, *([""] if foot else []), *foot]) + "\n"


def _rows(model: ChannelModel, term: str) -> list[tuple[str, str, str, str, str]]:
    """Symbol, name, value with unit, interval, SI value; one row per unit."""
    letter, label = TERMS[term].symbols[0], TERMS[term].label(model.quantity)
    si = model.unit_of(term)
    units = _UNITS.get(model.quantity, {}).get(term, ((si, 1.0),))
    if term in model:
        value = model[term]
        low, high = model.intervals.get(term, (None, None))
        rows = []
        for text, size in units:
            bounds = (None, None) if low is None or high is None else (low / size, high / size)
            shown, interval = round_to_error(value / size, *bounds).cells
            if not interval and not model.duration:  # stated value, not from a fit
                shown = f"{value / size:.6g}"
            percent = _interval_text(model, term, interval, size)
            rows.append((letter, label, f"{shown} {text}", percent, f"{measured(value)} {si}"))
        return rows
    if term in model.limits:
        limit, percent = model.limits[term], f"not observed ({100 * model.level:g} %)"
        return [
            (letter, label, f"{limit_text(limit / size)} {text}", percent, f"below {measured(limit)} {si}")
            for text, size in units
        ]
    if model.duration or not model.adequate:  # the term was fitted
        return [(letter, label, _UNKNOWN, "" if model.adequate else "no model fits", "")]
    return [(letter, label, _NOT_IN_MODEL, "", "")]


def _interval_text(model: ChannelModel, term: str, interval: str, size: float) -> str:
    """Interval of a value with its level, the limit of a value that the record does not determine alone, or the reason
    for neither.
    """
    if interval or (term in model.limits and model.adequate):
        text = interval or f"or less: {limit_text(model.limits[term] / size)}"
        return f"{text} ({100 * model.level:g} %)"
    return _NO_INTERVAL if model.adequate else doubt_text(model)


def _process_rows(model: ChannelModel) -> list[tuple[str, str, str, str, str]]:
    """Gauss-Markov processes with q_c of the standard, resonances, sinusoids and the bandwidth."""
    units = _UNITS.get(model.quantity, {}).get("bias_instability", ((model.unit, 1.0),))
    text, size = units[0]
    rows = []
    for k, process in enumerate(model.gauss_markov, 1):
        drive = process.sigma * (2 / process.time) ** 0.5
        rows += [
            (
                f"σ{k}",
                "Gauss-Markov",
                f"{process.sigma / size:.6g} {text}",
                "",
                f"{measured(process.sigma)} {model.unit}",
            ),
            (f"Tc{k}", "correlation time", f"{process.time:.6g} s", "", f"{measured(process.time)} s"),
            (f"qc{k}", "driving noise", f"{drive:.6g} {model.unit}/√s", "", f"{measured(drive)} {model.unit}/sqrt(s)"),
        ]
    for k, resonance in enumerate(model.resonance, 1):
        rows += [
            (
                f"σr{k}",
                "resonance",
                f"{resonance.sigma / size:.6g} {text}",
                "",
                f"{measured(resonance.sigma)} {model.unit}",
            ),
            (f"fr{k}", "its centre", f"{resonance.frequency:.6g} Hz", "", f"{measured(resonance.frequency)} Hz"),
            (f"Δf{k}", "its half width", f"{resonance.width:.6g} Hz", "", f"{measured(resonance.width)} Hz"),
        ]
    for k, line in enumerate(model.sinusoid, 1):
        rows += [
            (
                f"Ω{k}",
                "sinusoid",
                f"{line.amplitude / size:.6g} {text}",
                "",
                f"{measured(line.amplitude)} {model.unit}",
            ),
            (f"f{k}", "its frequency", f"{line.frequency:.6g} Hz", "", f"{measured(line.frequency)} Hz"),
        ]
    if model.turn_on is not None:
        rows.append(_turn_on_row(model.turn_on, text, size, model.unit))
    if model.bandwidth is not None:
        corner = model.bandwidth.corner
        rows.append(
            ("fc", f"bandwidth, order {model.bandwidth.order}", f"{corner:.6g} Hz", "", f"{measured(corner)} Hz")
        )
    return rows


def _turn_on_row(spread: TurnOn, text: str, size: float, si: str) -> tuple[str, str, str, str, str]:
    """Turn-on repeatability of the bias, 1 σ."""
    low, high = (None if end is None else end / size for end in (spread.low, spread.high))
    shown, interval = round_to_error(spread.sigma / size, low, high).cells
    how = f"{interval} ({100 * spread.level:g} %), {spread.power_ups} power-ups" if interval else "stated"
    return ("σt", "turn-on bias", f"{shown} {text}", how, f"{measured(spread.sigma)} {si}")


TARGET = Target(
    name="ieee952",
    program="IEEE Std 952",
    columns=("Q, N, B, K, R with intervals", "nothing"),
    summary="table of Q, N, B, K, R of every channel in units of IEEE Std 952, with intervals",
    ending=".txt",
    write=write,
    sensors="any",
    every_axis=True,
    unused=(Unused(choices=("walk", "noise", "walk_factor", "noise_factor"), why="the table has what was found"),),
)
