"""Controls of the page for the options of an export, made of their declarations; each target lists those that it uses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from sigmatau.app.faces import LABELS, as_controls, export_label
from sigmatau.exporting.choices import KINDS, Choices
from sigmatau.exporting.export import find_unplaced
from sigmatau.exporting.target import Target
from sigmatau.hints import worded
from sigmatau.options import Option
from sigmatau.typed.config import typable
from sigmatau.typed.forms import spelled

_NAMES = "names"  # option whose fields differ from target to target
_PROBE = 2.0  # value with which options that are numbers are tried


def labels() -> dict[str, str]:
    """Labels of the options of an analysis, by the name that is typed on the command line."""
    return {spelled(name): label for name, label in LABELS.items()}


def export_controls() -> list[dict[str, Any]]:
    """The options of an export, each with what its control needs."""
    default = Choices()
    return [
        {
            "name": spelled(name),
            "label": export_label(name),
            "text": worded(" ".join(filter(None, (about.text, about.typed, about.otherwise))), as_controls),
            "form": about.form or "choice",
            "choices": list(about.choices),
            "default": _plain(getattr(default, name)),
            "unit": about.unit,
            "sensors": list(KINDS) if about.form in ("pairs", "factors") else [],
        }
        for name, about in typable(Choices).items()
        if name != _NAMES
    ]


def default_file(target: Target) -> str:
    """The name of the file of a target, unless the user chooses another."""
    return f"{target.name}{target.ending}"


def target_content(target: Target) -> dict[str, Any]:
    """A target with the options that it uses, each with its allowed words, or True if any value is allowed."""
    return {
        "name": target.name,
        "summary": worded(target.summary, as_controls),
        "ending": target.ending,
        "file": default_file(target),
        "needs_rate": target.needs_rate,
        "has_walk": target.has_walk,
        "names": [
            {"key": key, "default": default, "choices": list(target.name_values.get(key, ()))}
            for key, default in target.names.items()
        ],
        "choices": {
            spelled(name): allowed
            for name, about in typable(Choices).items()
            if name != _NAMES and (allowed := _allowed(target, name, about))
        },
    }


def _allowed(target: Target, name: str, about: Option) -> list[str] | bool:
    """What can be chosen for an option: the words that the target uses, or True for any value. False: no control."""
    if not about.choices:
        return _is_used(target, name, True if about.form == "flag" else _PROBE)
    is_pairs = about.form == "pairs"
    words = [word for word in about.choices if _is_used(target, name, {"gyro": word} if is_pairs else word)]
    return words if len(words) > (0 if is_pairs else 1) else False


def _is_used(target: Target, name: str, value: Any) -> bool:  # noqa: ANN401  of any form
    stated: Iterable[tuple[str, Any]] = [(name, value)]
    if value == {"gyro": "horizon"}:
        stated = [*stated, ("horizon", _PROBE)]
    return all(each.choice != name for each in find_unplaced(target, Choices(**dict(stated))))


def _plain(value: object) -> str | float | bool | None:
    return value if isinstance(value, str | int | float) else None
