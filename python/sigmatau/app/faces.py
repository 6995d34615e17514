"""Converts the options that a message names to labels of controls of the page, and to buttons that set an option."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sigmatau.exporting.choices import Choices
from sigmatau.findings.finding import Finding, Words
from sigmatau.hints import RATE, Hint, as_options, hints_in, worded
from sigmatau.options import declared
from sigmatau.results import printable
from sigmatau.typed.forms import spelled

LABELS: Mapping[str, str] = {
    "at_rest": "Analyse motion as noise",
    "bandwidth": "Filter of the sensor",
    "baud": "Baud",
    "bias": "Bias instability",
    "channels": "Columns",
    "content": "The figure shows",
    "hours": "Length of the record [h]",
    "input": "The columns are",
    "interleaved": "Sensors whose rows take turns",
    "keep": "Restore",
    "linear": "linear",
    "layout": "Fields of a row",
    "leave_out": "Leave this part out",
    "method": "Method",
    "page": "Page",
    "point_error": "Clicking error",
    "rate": "Sampling rate [Hz]",
    "read_off_at": "By hand",
    "scale": "Scale",
    "sided": "Noise densities",
    "skip": "Lines to skip",
    "taus": "Averaging times",
    "terms": "Terms that may be present",
    "topic": "Topic",
    "unit": "Unit",
    "window": "Window",
    "x_axis": "Ticks of the x axis",
    "y_axis": "Ticks of the y axis",
}
"""Label of the control of each option of analyses, datasheets and ports. Labels of an export are made of option names."""


def export_label(name: str) -> str:
    """Label of the control of an export option, made of its name: ``turn-on`` gives "Turn on"."""
    return spelled(name).replace("-", " ").capitalize()


def as_controls(hints: Sequence[Hint]) -> str:
    """Name the controls of hints. An option without a control is named as it is typed; placeholders are omitted.

    Examples
    --------
    >>> from sigmatau.hints import Hint
    >>> as_controls([Hint("channels", value={"accel": "1:3", "gyro": "4:6"})])
    'accel in columns 1 to 3, gyro in columns 4 to 6'
    >>> as_controls([Hint("unit", value={"gyro": "deg/s"}), Hint("rate", value="HZ")])
    'gyro in deg/s and the sampling rate'
    >>> as_controls([Hint("walk", "gyro", "upper-limit")])
    '“Rate random walk, gyro: upper-limit”'
    >>> as_controls([Hint("horizon", value=10)])
    '“Horizon: 10 s”'
    >>> as_controls([Hint("channels", "time", "…")])
    '“Use as: time”'
    >>> as_controls([Hint("json", value="FILE")])
    '--json FILE'
    """
    return " and ".join(map(_control, hints))


def page_words(finding: Finding) -> Words:
    """Message and action of a finding, in which options are controls of the page."""
    return Words(*(worded(text, as_controls) for text in finding.words()))


def finding_content(finding: Finding) -> dict[str, Any]:
    """A finding as the page shows it: severity, message and action."""
    message, action = page_words(finding)
    return {"severity": finding.severity, "text": printable(message), "action": printable(action)}


def _control(hint: Hint) -> str:
    pairs = hint.pairs()
    if pairs is not None and not _has_placeholder(pairs.values()):
        if hint.option == "channels":
            return ", ".join(f"{channel} in {_columns_text(str(place))}" for channel, place in pairs.items())
        if hint.option == "unit":
            return ", ".join(f"{channel} in {unit}" for channel, unit in pairs.items())
    if hint.option == "channels" and hint.key:
        return _quoted("Use as", hint.key)
    if hint == RATE:
        return "the sampling rate"
    if hint.option == "topic":
        names = [hint.value] if isinstance(hint.value, str) else list(map(str, hint.value or ()))
        return f"topic{'s' * (len(names) > 1)} {' and '.join(names)}" if names else "the topic"
    choices = declared(Choices)
    if hint.option == "names":
        return "; ".join(_quoted(key.replace("_", " "), value) for key, value in (pairs or {"names": None}).items())
    if hint.option in choices:
        label, unit = export_label(hint.option), choices[hint.option].unit
    elif hint.option in LABELS:
        label, unit = LABELS[hint.option], ""
    else:
        return as_options([hint])
    if pairs is not None:
        return "; ".join(_quoted(f"{label}, {key}", value) for key, value in pairs.items())
    return _quoted(label, hint.value, unit)


def _quoted(label: str, value: object, unit: str = "") -> str:
    if value is None or value is True or _has_placeholder([value]):
        return f"“{label}”"
    text = ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
    return f"“{label}: {text}{f' {unit}' if unit and not isinstance(value, str) else ''}”"


def _has_placeholder(values: Iterable[object]) -> bool:
    return any(re.fullmatch(r"[A-Z]+(:[A-Z]+)?|…", str(value)) for value in values)


def _columns_text(place: str) -> str:
    first, separator, last = place.partition(":")
    return f"columns {first} to {last}" if separator else f"column {first}"


def hints_content(text: str) -> list[dict[str, Any]] | None:
    """The options that a message names, for the buttons of the page; None if there are none."""
    hints = [_hint_content(hint) for hint in hints_in(text)]
    return hints or None


def _hint_content(hint: Hint) -> dict[str, Any]:
    return {
        "option": spelled(hint.option),
        "key": hint.key,
        "value": hint.value,
        "text": as_controls([hint]),
        "remark": hint.remark,
    }
