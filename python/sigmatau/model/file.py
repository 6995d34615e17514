"""Model files: TOML with a unit for each value.

.. code-block:: toml

    [channels.gyro_x]
    random_walk = "0.3 deg/sqrt(h)"            # or noise_density = "0.005 deg/s/sqrt(Hz)", sided = "one"
    bias_instability = "12 deg/h"
    rate_random_walk = "20 deg/h/sqrt(h)"
    gauss_markov = [{ sigma = "5 deg/h", time = "300 s" }]
    alike_from = { sigma = "600 deg/h", time = "1800 s" }  # explains the rate random walk as well, as do slower ones
    alternatives = [{ random_walk = "0.3 deg/sqrt(h)", gauss_markov = [{ sigma = "9 deg/h", time = "80 s" }] }]  # or
    matern = [{ sigma = "9 deg/h", time = "600 s", smoothness = 0.2 }]
    resonance = [{ sigma = "2 deg/h", frequency = "0.004 Hz", width = "0.001 Hz" }]
    sinusoid = [{ amplitude = "0.01 deg/s", frequency = "0.55 Hz" }]
    turn_on = { sigma = "0.2 deg/s" }          # spread between power-ups; with low, high, level and power_ups if measured
    bandwidth = { order = 1, corner = "30 Hz" }  # with rate = "100 Hz": random_walk is that of the samples
    adequate = false                           # no model fits this axis: no value has an interval

    [correlation.random_walk]
    gyro_x = { gyro_y = 0.3 }
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

from sigmatau import units
from sigmatau.digits import round_to_error, significant
from sigmatau.errors import DataError, OptionError
from sigmatau.model.channel import PROCESSES, ChannelModel, alike_text
from sigmatau.model.matern import Matern
from sigmatau.model.processes import GaussMarkov, LowPass, Resonance, Sinusoid, real
from sigmatau.model.turn_on import TurnOn
from sigmatau.noise.terms import TERMS, coefficient_unit, display_units
from sigmatau.record.record import stream_name
from sigmatau.results import printable
from sigmatau.units import usual

NOT_ADEQUATE = "no model fits this axis: no interval"  # comment on a value from a fit that is not adequate
ONLY_LIMITS = "at most: vibration or rounding hides the noise of this axis"  # comment on a value that is an upper limit


def doubt_text(channel: ChannelModel) -> str:
    """Comment on the values of a channel whose fit is not adequate; otherwise empty."""
    if channel.adequate:
        return ""
    return ONLY_LIMITS if channel.has_only_limits else NOT_ADEQUATE


_QUANTITIES = {"gyro": ("angular_rate", "rad/s"), "accel": ("acceleration", "m/s^2")}
_VALUE = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?+)\s*([^\d\s.].*?)\s*")
_UNITS_OF_PARTS = {
    "time": "s",
    "frequency": "Hz",
    "width": "Hz",
    "smoothness": "",
}  # units of the parts of a process; other parts have the unit of the rate
_DENSITY_UNITS = {"rad/sqrt(s)": "deg/s/sqrt(Hz)", "m/s/sqrt(s)": "ug/sqrt(Hz)"}
_OTHER_KEYS = (
    "noise_density",
    "sided",
    *PROCESSES,
    "alike_from",
    "alternatives",
    "turn_on",
    "bandwidth",
    "unit",
    "adequate",
)


def read_channels(content: Mapping[str, Any]) -> dict[str, ChannelModel]:
    """The channels of a parsed model file; raises `DataError` that names channel and key."""
    channels = content.get("channels", {})
    if not isinstance(channels, Mapping) or not all(isinstance(c, Mapping) for c in channels.values()):
        raise DataError("a model file has tables [channels.NAME], e.g. [channels.gyro_x]")
    read = {}
    for name, table in channels.items():
        try:
            read[name] = _channel(name, table)
        except DataError as error:
            raise error.about(f"channel {name!r}") from None
    return read


def read_correlation(content: Mapping[str, Any]) -> dict[str, dict[tuple[str, str], float]]:
    """The correlations of a parsed model file: ``[correlation.random_walk]``, ``gyro_x = { gyro_y = 0.3 }``."""
    result: dict[str, dict[tuple[str, str], float]] = {}
    tables = content.get("correlation", {})
    example = "[correlation.random_walk] has lines such as gyro_x = { gyro_y = 0.3 }"
    if not isinstance(tables, Mapping) or not all(isinstance(t, Mapping) for t in tables.values()):
        raise DataError(example)
    for term, table in tables.items():
        pairs = result.setdefault(term, {})
        for first, partners in table.items():
            if not isinstance(partners, Mapping):
                raise DataError(f"correlation of {term}: {first} = {partners!r}; {example}")
            for second, value in partners.items():
                if isinstance(value, bool) or not isinstance(value, int | float):
                    raise DataError(f"correlation of {term} between {first} and {second}: {value!r} is not a number")
                pairs[first, second] = float(value)
    return result


def toml(channels: Mapping[str, ChannelModel], correlation: Mapping[str, Mapping[tuple[str, str], float]]) -> str:
    """A model as the text of a model file, in SI. Intervals and limits, for which the file has no key, are comments."""
    blocks = []
    for name, channel in channels.items():
        lines = [f"[channels.{_key(name)}]"]
        if channel.quantity == "signal":
            lines.append(f"unit = {_escaped(channel.unit)}")
        lines += [
            f"{term} = {_quoted(value, channel.unit_of(term))}{_interval_comment(channel, term)}"
            for term, value in channel.terms.items()
        ]
        for kind in PROCESSES:
            if several := getattr(channel, kind):
                rows = (_written(process, channel.unit) for process in several)
                lines.append(f"{kind} = [{', '.join(rows)}]")
        if channel.alike_from is not None:
            written = _written(channel.alike_from, channel.unit)
            lines.append(f"alike_from = {written}  # {alike_text(channel.alike_from.time)}")
        if channel.alternatives:
            lines += [
                "alternatives = [  # explain the record as well",
                *(f"    {_alternative(alternative)}," for alternative in channel.alternatives),
                "]",
            ]
        if channel.turn_on is not None:
            lines.append(f"turn_on = {_turn_on_written(channel.turn_on, channel)}")
        if channel.bandwidth is not None:
            corner = _quoted(channel.bandwidth.corner, "Hz")
            rate = "" if channel.bandwidth.rate is None else f", rate = {_quoted(channel.bandwidth.rate, 'Hz')}"
            lines.append(f"bandwidth = {{ order = {channel.bandwidth.order}, corner = {corner}{rate} }}")
        if not channel.adequate:
            doubt = (
                ONLY_LIMITS if channel.has_only_limits else "no model fits this axis: no value above has an interval"
            )
            lines.append(f"adequate = false  # {doubt}")
        lines += _comments_on_omissions(channel)
        blocks.append("\n".join(lines))
    for term, pairs in correlation.items():
        rows_by_channel: dict[str, list[str]] = {}
        for (first, second), value in pairs.items():
            rows_by_channel.setdefault(first, []).append(f"{_key(second)} = {value!r}")
        lines = [f"{_key(first)} = {{ {', '.join(rows)} }}" for first, rows in rows_by_channel.items()]
        blocks.append("\n".join([f"[correlation.{term}]", *lines]))
    return "\n\n".join(blocks) + "\n"


def _written(process: GaussMarkov | Matern | Resonance | Sinusoid, unit: str) -> str:
    """A process as a table: each part with its unit."""
    parts = ((part.name, getattr(process, part.name)) for part in fields(process))
    written = ", ".join(f"{name} = {_quoted(x, _UNITS_OF_PARTS.get(name, unit))}" for name, x in parts)
    return f"{{ {written} }}"


def _turn_on_written(spread: TurnOn, channel: ChannelModel) -> str:
    """A turn-on bias as a table, and in a usual unit as a comment."""
    ends = (("sigma", spread.sigma), ("low", spread.low), ("high", spread.high))
    parts = [f"{name} = {_quoted(value, channel.unit)}" for name, value in ends if value is not None]
    if spread.power_ups is not None:
        parts += [f"level = {spread.level!r}", f"power_ups = {spread.power_ups}"]
    return printable(f"{{ {', '.join(parts)} }}  # {spread.text(channel.quantity, channel.unit)}")


def _alternative(model: ChannelModel) -> str:
    """Another model of a channel as a table: its terms and Gauss-Markov processes."""
    parts = [f"{term} = {_quoted(value, model.unit_of(term))}" for term, value in model.terms.items()]
    if model.gauss_markov:
        processes = ", ".join(_written(process, model.unit) for process in model.gauss_markov)
        parts.append(f"gauss_markov = [{processes}]")
    return f"{{ {', '.join(parts)} }}"


def _interval_comment(channel: ChannelModel, term: str) -> str:
    """The value and its interval in a usual unit, as a comment; empty for a value without interval."""
    if not channel.adequate:
        return f"  # {doubt_text(channel)}"
    unit, factor = display_units(term, channel.quantity, channel.unit, [channel.terms.get(term)])[0]
    if term in channel.limits:
        return printable(f"  # or less: below {_limit(channel, term)}")
    if term not in channel.intervals:
        return ""
    low, high = channel.intervals[term]
    text = round_to_error(channel.terms[term] / factor, low / factor, high / factor).with_unit(unit)
    return printable(f"  # {text}, {_percent(channel.level)} interval")


def _comments_on_omissions(channel: ChannelModel) -> list[str]:
    """Lines of comments: limits of terms that were not observed, and correlated errors."""
    lines = []
    for term in channel.limits:
        if term in channel.terms:
            continue
        lines.append(printable(f"# {term}: not seen, and left out; below {_limit(channel, term)}"))
    names = [each.part for each in channel.covariance.parameters if each.part in channel.terms]
    if len(names) > 1:
        lines.append(printable(f"# The correlation of the errors of {', '.join(names)} is only in the result."))
    return lines


def _limit(channel: ChannelModel, term: str) -> str:
    """The upper limit of a term in a usual unit and in SI."""
    limit = channel.limits[term]
    unit, factor = display_units(term, channel.quantity, channel.unit, [limit])[0]
    in_si = "" if factor == 1 else f" = {limit:.2g} {channel.unit_of(term)}"
    return f"{significant(limit / factor, 2, zeros=True)} {unit}{in_si}, {_percent(channel.level)} limit"


def _percent(level: float) -> str:
    return f"{100 * level:.4g} %"


def value_in_si(text: str, si: str, what: str) -> float:
    """Value of ``"0.5 deg/h"`` in the SI unit `si`; raises `OptionError`, whose message begins with `what`."""
    match = _VALUE.fullmatch(text)
    if match is None:
        raise OptionError(f'{what} {text!r}: want a value with its unit, e.g. "1 {usual(si)}"', option="value")
    try:
        value = float(match[1]) * _factor(match[2], si)
    except OptionError as error:
        raise error.about(what) from None
    if not math.isfinite(value):
        raise OptionError(f"{what} {text!r}: is more than a double holds", option="value")
    return value


def has_unit(text: str, si: str) -> bool:
    """Whether a text is a value in a unit of the kind of the SI unit `si`."""
    match = _VALUE.fullmatch(text)
    unit = None if match is None else units.find_unit(match[2])
    is_si = match is not None and match[2].strip() == si
    return is_si or (unit is not None and (unit.si == si or not units.symbols(si)))


def _channel(name: str, table: Mapping[str, Any]) -> ChannelModel:
    quantity, unit = _quantity(name, table)
    unknown = next((key for key in table if key not in TERMS and key not in _OTHER_KEYS), None)
    if unknown is not None:
        listed = ", ".join((*TERMS, *(key for key in _OTHER_KEYS if key not in ("sided", "unit", "adequate"))))
        raise DataError(f"unknown term {unknown!r}; terms: {listed}")
    terms: dict[str, float] = {}
    for key, text in table.items():
        term = "random_walk" if key == "noise_density" else key
        if term not in TERMS:
            continue
        if term in terms:
            raise DataError("random_walk and noise_density are the same coefficient; give one")
        value = _value(key, text, coefficient_unit(term, quantity, unit))
        terms[term] = value * _two_sided(table) if key == "noise_density" else value
    if "sided" in table and "noise_density" not in table:
        raise DataError("`sided` belongs to noise_density, which is not given")
    return ChannelModel(
        terms=terms,
        gauss_markov=tuple(_processes(table, "gauss_markov", unit)),
        matern=tuple(_processes(table, "matern", unit)),
        resonance=tuple(_processes(table, "resonance", unit)),
        sinusoid=tuple(_processes(table, "sinusoid", unit)),
        alternatives=_alternatives(name, table),
        alike_from=next(_processes(table, "alike_from", unit), None),
        turn_on=_turn_on(table, unit),
        bandwidth=_bandwidth(table),
        quantity=quantity,
        unit=unit,
        adequate=_adequate(table),
    )


def _alternatives(name: str, table: Mapping[str, Any]) -> tuple[ChannelModel, ...]:
    rows = table.get("alternatives", [])
    if not isinstance(rows, list) or not all(isinstance(row, Mapping) for row in rows):
        raise DataError(
            "alternatives is a list of tables, each with terms or gauss_markov,"
            ' e.g. [{ bias_instability = "12 deg/h" }]'
        )
    unit = {"unit": table["unit"]} if "unit" in table else {}
    return tuple(_channel(name, {**row, **unit}) for row in rows)


def _quantity(name: str, table: Mapping[str, Any]) -> tuple[str, str]:
    quantity = _QUANTITIES.get(stream_name(name))
    unit = table.get("unit")
    if quantity is not None:
        if unit is not None:
            raise DataError("`unit` is for other signals; each value here has its unit")
        return quantity
    if not isinstance(unit, str) or not unit.strip():
        raise DataError('names begin with gyro_ or accel_; another signal says its unit, unit = "V"')
    return "signal", unit.strip()


def _processes(table: Mapping[str, Any], key: str, unit: str) -> Iterator[Any]:
    """The processes of a key: a list of tables, or a single one."""
    kind = PROCESSES.get(key, GaussMarkov)
    units = {part.name: _UNITS_OF_PARTS.get(part.name, unit) for part in fields(kind)}
    rows = table.get(key, [])
    rows = [rows] if isinstance(rows, Mapping) else rows
    alone = key not in PROCESSES and isinstance(rows, list) and len(rows) > 1
    written = ", ".join(f'{part} = "1 {usual(si)}"' if si else f"{part} = 0.3" for part, si in units.items())
    if alone or not isinstance(rows, list) or not all(isinstance(row, Mapping) for row in rows):
        form = f"is a list, {key} = [{{ {written} }}]" if key in PROCESSES else f"is {{ {written} }}"
        raise DataError(f"{key} {form}, not {table[key]!r}")
    for row in rows:
        if missing := [part for part in units if part not in row]:
            raise DataError(f"{key} lacks {' and '.join(missing)}; write {{ {written} }}")
        if unknown := [part for part in row if part not in units]:
            raise DataError(f"{key} has an unknown part {unknown[0]!r}; write {{ {written} }}")
    return (kind(**{part: _part(key, row, part, si) for part, si in units.items()}) for row in rows)


def _part(key: str, row: Mapping[str, Any], part: str, si: str) -> float:
    if not si:
        if math.isnan(number := real(row[part])):
            raise DataError(f"{part} of {key} is a number without a unit, {part} = 0.3, not {row[part]!r}")
        return number
    return _value(f"{part} of {key}", row[part], si, written=part)


def _turn_on(table: Mapping[str, Any], unit: str) -> TurnOn | None:
    row = table.get("turn_on")
    if row is None:
        return None
    measured = {"low", "high", "level", "power_ups"}
    if not isinstance(row, Mapping) or not {"sigma"} <= set(row) <= {"sigma", *measured}:
        example = f'{{ sigma = "1 {usual(unit)}" }}'
        raise DataError(f"turn_on is {example}, with low, high, level and power_ups if it was measured, not {row!r}")
    spreads = {part: row[part] for part in ("sigma", "low", "high") if part in row}
    read: dict[str, Any] = {
        part: _value(f"{part} of turn_on", text, unit, written=part) for part, text in spreads.items()
    }
    return TurnOn(**read, **{part: row[part] for part in ("level", "power_ups") if part in row})


def _bandwidth(table: Mapping[str, Any]) -> LowPass | None:
    row = table.get("bandwidth")
    if row is None:
        return None
    if not isinstance(row, Mapping) or set(row) - {"rate"} != {"order", "corner"}:
        raise DataError(f'bandwidth is {{ order = 1, corner = "30 Hz" }}, not {row!r}')
    rate = _part("bandwidth", row, "rate", "Hz") if "rate" in row else None
    return LowPass(order=row["order"], corner=_part("bandwidth", row, "corner", "Hz"), rate=rate)


def _adequate(table: Mapping[str, Any]) -> bool:
    adequate = table.get("adequate", True)
    if not isinstance(adequate, bool):
        raise DataError(f"adequate = {adequate!r}; want true or false, without quotes")
    return adequate


def _two_sided(table: Mapping[str, Any]) -> float:
    sided = table.get("sided")
    if sided not in ("one", "two"):
        raise DataError(
            'noise_density needs sided = "one" or "two", because a one-sided density is √2 larger'
            " (most datasheets state it one-sided)"
        )
    return 1 / math.sqrt(2) if sided == "one" else 1.0


def _value(key: str, text: object, si: str, *, written: str | None = None) -> float:
    example = f'{written or key} = "1 {_DENSITY_UNITS.get(si, si) if key == "noise_density" else usual(si)}"'
    match = _VALUE.fullmatch(text) if isinstance(text, str) else None
    if match is None:
        raise DataError(f"{key} = {text!r} is not a value with a unit; write e.g. {example}")
    try:
        return float(match[1]) * _factor(match[2], si)
    except OptionError as error:
        raise DataError(f"{key}: {error}") from None


def _factor(unit: str, si: str) -> float:
    """One `unit` in `si`; 1 for the unit of a signal that is not in the table of units."""
    return 1.0 if unit.strip() == si else units.find(unit, si=si if units.symbols(si) else None).factor


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _escaped(name)


def _quoted(value: float, unit: str) -> str:
    if not unit:
        return repr(value)
    return _escaped(f"{value!r} {unit}")


def _escaped(text: str) -> str:
    """A text as TOML: a JSON string without surrogate pairs."""
    if any("\ud800" <= c <= "\udfff" for c in text):
        raise DataError(f"{text!r} cannot be written: it has an unpaired UTF-16 surrogate")
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007F")
