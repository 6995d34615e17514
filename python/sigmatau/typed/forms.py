"""Typed forms of declared options, for the command line, configuration files and the workbench."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

from sigmatau.hints import SPELLED
from sigmatau.options import Form, Option
from sigmatau.quality.selection.time_text import parse_seconds, parse_time
from sigmatau.typed.pairs import averaging_times, bandwidths, factors, key_numbers, key_values
from sigmatau.typed.ranges import read_off_ranges
from sigmatau.typed.rates import parse_rate


class Typed(NamedTuple):
    """Typed form of an option: the type for the parser, the conversion to a value, and whether it may begin with a minus."""

    kind: Any
    convert: Callable[[Any, str, str], Any]
    with_minus: bool = False


_TIME = "want a value with its unit, e.g. 10s, 5min, 2h"


def _as_it_is(typed: Any, name: str, example: str) -> Any:  # noqa: ANN401  of any form
    return typed


FORMS: Mapping[Form, Typed] = {
    "text": Typed(str, _as_it_is),
    "texts": Typed(list[str], _as_it_is),
    "flag": Typed(bool, _as_it_is),
    "count": Typed(int, _as_it_is),
    "number": Typed(float, _as_it_is),
    "seconds": Typed(str, lambda text, name, _: parse_seconds(text, option=name), with_minus=True),
    "time": Typed(str, lambda text, name, _: parse_time(text, text, option=name, forms=_TIME)),
    "times": Typed(str, lambda text, *_: averaging_times(text)),
    "ranges": Typed(list[str], lambda texts, *_: read_off_ranges(texts)),
    "span": Typed(str, _as_it_is, with_minus=True),
    "spans": Typed(list[str], _as_it_is, with_minus=True),
    "names": Typed(str, lambda text, *_: [name.strip() for name in text.split(",")]),
    "rates": Typed(list[str], lambda texts, *_: parse_rate(texts), with_minus=True),
    "pairs": Typed(list[str], key_values),
    "numbers": Typed(list[str], key_numbers),
    "factors": Typed(str, factors),
    "bandwidths": Typed(list[str], lambda texts, *_: bandwidths(texts)),
}


def typed_form(about: Option) -> Typed:
    """Typed form of an option; by default, one of its choices."""
    return Typed(Literal[about.choices], _as_it_is) if about.form is None else FORMS[about.form]


def convert(name: str, about: Option, typed: Any) -> Any:  # noqa: ANN401  of any form
    """Convert a typed option to its Python value. Raises `OptionError`."""
    return typed_form(about).convert(typed, spelled(name), about.example)


def spelled(name: str) -> str:
    """Name of the option of an argument, without leading hyphens."""
    return SPELLED.get(name, name).replace("_", "-")
