"""Columns of small tables, of a density or a curve: which one is meant, and its unit."""

from __future__ import annotations

import re

from sigmatau.errors import OptionError
from sigmatau.hints import Hint

IN_BRACKETS = re.compile(r"[\[(]((?:[^\[\]()]|\([^()]*\))+)[\])]")
"""A unit in brackets."""

SIDED = re.compile(r"\b(one|single|1|two|double|2)[- _]?sided\b", re.IGNORECASE)
"""The sides of a density."""


def column_place(names: list[str], text: str, listed: str) -> int:
    """Place of a column that an option names, or whose number from 1 it states; `listed`: the columns for a message."""
    if text in names:
        return names.index(text)
    bare = [bare_name(name) for name in names]
    if bare.count(text) == 1:
        return bare.index(text)
    if text.isdigit() and 1 <= int(text) <= len(names):
        return int(text) - 1
    raise OptionError(f"{Hint('columns')}: no column {text!r} among {listed}", option="columns")


def name_words(name: str) -> list[str]:
    """Words of a name in small letters."""
    return [word for word in re.split(r"[^a-z0-9]+", name.lower()) if word]


def bare_name(name: str) -> str:
    """The name of a column without unit and sides."""
    return SIDED.sub("", IN_BRACKETS.sub("", name)).strip(" ,_-")


def unit_in(name: str, unit: str | None) -> str:
    """The unit of a column, from its row of units or in brackets after its name; empty if there is none."""
    if unit:
        return unit.strip()
    texts = [text for text in IN_BRACKETS.findall(name) if not SIDED.fullmatch(text.strip())]
    return SIDED.sub("", texts[-1]).strip(" ,") if texts else ""
