"""Targets whose file is a short YAML with one number for three axes: its text, with a placeholder in braces for each value.

The placeholders are:

``{gyro N}``, ``{accel K*sqrt(rate)}``
    A sensor and one of `FORMS`: the number in this form, with its unit and origin in a comment.
``{omitted}``
    Remarks on the noise that the format has no field for, with the indent of this line.
``{rate}``
    Rate of the filter [Hz], which is then required, as for forms that contain ``rate``.
``{gyro turn-on 0.01}``
    Standard deviation of the bias at turn-on; the number is its default. The names of the target then need
    `TURN_ON_NAMES`.
``{topic}``, ``{gravity}``
    A name that the user can give with ``--name``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from sigmatau.exporting.statements import pair_remarks
from sigmatau.exporting.target import Target
from sigmatau.exporting.text import comment, digits, number_with_comment, remark, topic
from sigmatau.exporting.turn_on import turn_on, unknown_turn_on
from sigmatau.exporting.values import Numbers
from sigmatau.units import STANDARD_GRAVITY


class Form(NamedTuple):
    """Form in which a program reads a coefficient."""

    # Converts a coefficient [SI] and the sampling rate [Hz] to the number of the file
    convert: Callable[[float, float], float]
    unit: str  # Its unit, where ``{}`` is rad/s or m/s^2 for N and its rate of change for K
    symbol: str  # Symbol in the documentation


# N and K as continuous two-sided densities, as standard deviations of a sample, and as variances of a sample.
FORMS = {
    "N": Form(lambda n, _: n, "N, {}/sqrt(Hz)", "N"),
    "K": Form(lambda k, _: k, "K, {}/sqrt(Hz)", "K"),
    "N*sqrt(2*rate)": Form(lambda n, f: math.sqrt(2 * f) * n, "{} per sample = N*sqrt(2*rate)", "N·√(2f)"),
    "K*sqrt(rate)": Form(lambda k, f: math.sqrt(f) * k, "{} per sample = K*sqrt(rate)", "K·√f"),
    "N^2*rate": Form(lambda n, f: n**2 * f, "({})^2 per sample = N^2*rate", "N²·f"),
    "K^2*rate": Form(lambda k, f: k**2 * f, "({})^2 per sample = K^2*rate", "K²·f"),
}
GRAVITY = digits(STANDARD_GRAVITY)
"""Default of a name for the local gravity. [m/s²]"""

_UNITS = {"gyro": {"N": "rad/s", "K": "rad/s^2"}, "accel": {"N": "m/s^2", "K": "m/s^3"}}
_TURN_ON = "turn-on "  # beginning of the form of a field for the turn-on bias
PLACE = re.compile(r"\{(\w+)(?: ([^}]+))?\}")


def template(
    name: str,
    *,
    program: str,
    summary: str,
    text: str,
    names: Mapping[str, str] | None = None,
    aliases: tuple[str, ...] = (),
) -> Target:
    """Build the target of a template, with the requirements of its text. `names`: defaults of the names that the user can
    give.
    """
    places = PLACE.findall(text)
    scaled = any("rate" in form for _, form in places)
    has_field = any(place == "rate" for place, _ in places)
    noise, walk = (next(FORMS[form].symbol for _, form in places if form.startswith(letter)) for letter in "NK")
    return Target(
        name=name,
        program=program,
        columns=(noise, walk),
        aliases=aliases,
        summary=summary,
        ending=".yaml",
        write=partial(_write, text, names or {}),
        text=text,
        needs_rate=scaled or has_field,
        has_rate_field=has_field and not scaled,
        names=names or {},
        has_walk=True,
    )


def _write(text: str, names: Mapping[str, str], numbers: Numbers) -> str:
    """The text of a file."""

    def value(place: re.Match[str]) -> str:
        name, form = place.groups()
        if form is not None and form.startswith(_TURN_ON):
            return _turn_on_field(numbers, name, form.removeprefix(_TURN_ON))
        if form is not None:
            return _coefficient(numbers, name, form)
        if name == "rate":
            return numbers.rate_text()
        if name == "topic":
            return topic(numbers.name(name, names[name]))
        return digits(numbers.number(name, names[name]))

    lines: list[str] = []
    has_turn_on = _TURN_ON in text
    for line in text.splitlines():
        if line.lstrip() == "{omitted}":
            remarks = pair_remarks(numbers, has_turn_on=has_turn_on)
            lines += [line.replace("{omitted}", remark(sentence)) for sentence in remarks]
        else:
            lines.append(PLACE.sub(value, line))
    return "\n".join(lines) + "\n"


def _coefficient(numbers: Numbers, sensor: str, form: str) -> str:
    """N or K of a sensor in a form, with unit and origin in a comment."""
    number = numbers.noise(sensor) if form[0] == "N" else numbers.walk(sensor)
    rate = numbers.rate() if "rate" in form else math.nan
    unit = FORMS[form].unit.format(_UNITS[sensor][form[0]])
    return number_with_comment(FORMS[form].convert(number.value, rate), f"{unit}; {number.words}")


def _turn_on_field(numbers: Numbers, sensor: str, default: str) -> str:
    """Uncertainty of the initial bias of a sensor, or the number in the sample file of the program."""
    unit = _UNITS[sensor]["N"]
    start = turn_on(numbers, sensor)
    if start is None:
        return f"{default}  # {comment(f'{unit}; from the sample file, {unknown_turn_on(sensor)}')}"
    return number_with_comment(start.value, f"{unit}; {start.words}")
