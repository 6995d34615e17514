"""Expected units of a lot: by number, by name, or by a serial number inside the name of a log."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from sigmatau.errors import OptionError
from sigmatau.frozen import frozen
from sigmatau.lab.lots.dates import without_days

_MOST_EXPECTED = 1_000_000  # largest number of expected units, because each missing one has a row


@frozen
class ExpectedUnits:
    """Comparison of the units with the expected ones.

    Attributes
    ----------
    absent : tuple of str
        Names of the expected units that are missing.
    surplus : int
        Number of units beyond the expected number.
    listed : frozenset of str
        Units that are expected.
    inside : bool
        Whether a unit was matched by a part of its name.
    """

    absent: tuple[str, ...]
    surplus: int
    listed: frozenset[str]
    inside: bool = False


def match_expected(names: Iterable[str], expect: int | Sequence[str] | None) -> ExpectedUnits:
    """Compare the names of units with the expected number or names.

    The name ``unit1`` matches the units ``unit1.csv.gz``, ``unit1.csv`` and ``unit1``. If there is none, a name matches the
    only unit that contains it as a whole word, as ``SN7`` in ``SN7_2026-05-04.csv``.

    Raises
    ------
    OptionError
        For a number below 1, or a list with an empty or repeated name.
    """
    units = list(names)
    if expect is None:
        return ExpectedUnits(absent=(), surplus=0, listed=frozenset(units))
    if isinstance(expect, int):
        if isinstance(expect, bool) or expect < 1:
            raise OptionError(f"{{option}} must be a number of units, at least 1, not {expect!r}", option="expect")
        if expect > _MOST_EXPECTED:
            raise OptionError(f"{{option}} {expect}: a lot has at most {_MOST_EXPECTED} units", option="expect")
        lacking = expect - len(units)
        absent = tuple(f"(missing {k + 1})" for k in range(max(lacking, 0)))
        return ExpectedUnits(absent=absent, surplus=max(-lacking, 0), listed=frozenset(units))
    if isinstance(expect, str) or not all(isinstance(name, str) and name for name in expect):
        raise OptionError("{option} must be a number of units or a list of their names", option="expect")
    if len({*expect}) < len(expect):
        twice = next(name for name in expect if list(expect).count(name) > 1)
        raise OptionError(f"{{option}} names {twice!r} twice", option="expect")
    by_form: dict[str, set[str]] = {}
    for unit in units:
        for form in _forms(unit):
            by_form.setdefault(form, set()).add(unit)
    listed = {unit for name in expect for unit in by_form.get(name, ())}
    lacking_names: set[str] = set()
    inside = False
    without_date = {unit: without_days(unit) for unit in units}
    for name in sorted(expect, key=len, reverse=True):  # SN7-2 before SN7
        if name in by_form:
            continue
        word = re.compile(rf"(?<![A-Za-z0-9]){re.escape(name)}(?![A-Za-z0-9])")
        with_word = [unit for unit, text in without_date.items() if unit not in listed and word.search(text)]
        if len(with_word) == 1:
            listed.add(with_word[0])
            inside = True
        else:
            lacking_names.add(name)
    absent = tuple(name for name in expect if name in lacking_names)
    return ExpectedUnits(absent=absent, surplus=0, listed=frozenset(listed), inside=inside)


def _forms(name: str) -> set[str]:
    """Names that a list may use for a unit: ``unit1.csv.gz``, ``unit1.csv`` and ``unit1``."""
    forms = {name}
    path = Path(name)
    while path.suffix:
        path = path.with_suffix("")
        forms |= {str(path), path.name}
    return forms | {Path(name).name}
