"""Read a measured density from a table: columns, unit, one- or two-sided. What the table does not state is asked of the
user.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from os import PathLike
from typing import Literal, cast

import numpy as np

from sigmatau import units
from sigmatau.arrays import Floats, freeze
from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read import opened
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.small_table import SIDED, bare_name, column_place, name_words, unit_in
from sigmatau.io.read.table import Table

Sided = Literal["one", "two"]

_FREQUENCIES = {"f", "freq", "freqs", "frequency", "frequencies", "fourier", "hz"}
_TIMES = {"t", "time", "timestamp", "stamp", "seconds"}
_HERTZ = {"Hz": 1.0, "kHz": 1e3, "mHz": 1e-3, "MHz": 1e6}
_POWER = re.compile(r"(.+?)\s*\^2\s*/\s*Hz", re.IGNORECASE)
_ROOT = re.compile(
    r"(.+?)\s*(?:/\s*(?:√\s*\(?Hz\)?|(?:rt|root|sqrt)[ -]?\(?Hz\)?|Hz\^\(?(?:1/2|0?\.5)\)?)|[·* ]Hz\^\(?-(?:1/2|0?\.5)\)?)",
    re.IGNORECASE,
)
_EXPANDED = {"rad^2/s^2/Hz": "rad/s", "deg^2/s^2/Hz": "deg/s", "m^2/s^4/Hz": "m/s^2"}
_SI_RATES = ("rad/s", "m/s^2")
_WALKS = {"rad/sqrt(s)": "rad/s", "m/s/sqrt(s)": "m/s^2"}
_EXAMPLES = '"(rad/s)^2/Hz", mdps/rtHz, ug/rtHz or "nT^2/Hz"'
_LISTED = 12  # largest number of columns in a message


@frozen(eq=False)
class MeasuredDensity:
    """A density of a table.

    Attributes
    ----------
    name : str
        Name of the column.
    frequency, density : ndarray, shape (n_f,)
        Rising frequencies above 0 [Hz], and the density [unit²/Hz]
    unit : str
        Unit of the rate: rad/s, m/s^2, or that of another signal.
    sided : {"one", "two"}
    without_zero : bool
        Whether a value at frequency 0 was left out.
    """

    name: str
    frequency: Floats
    density: Floats
    unit: str
    sided: Sided
    without_zero: bool

    def __post_init__(self) -> None:
        freeze(self, "frequency", "density", dtype=np.float64)


def read_density(
    path: str | PathLike[str],
    *,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    sided: Sided | None = None,
) -> MeasuredDensity:
    """Read a density from a table of any supported format.

    Parameters
    ----------
    path : path
    columns : mapping of str to str, optional
        Names or numbers from 1 of the columns ``"frequency"`` and ``"density"``. Default: by their names.
    unit : str, optional
        Unit of the density, or of its root: ``"(deg/s)^2/Hz"``, ``"mdps/rtHz"``. Default: that of the header.
    sided : {"one", "two"}, optional
        Default: that of the header.

    Returns
    -------
    MeasuredDensity

    Raises
    ------
    OptionError
        If the columns, the unit or the sides are not stated, or are stated differently.
    DataError
        For a file that cannot be read, or values that are not those of a density.
    """
    with opened(path, ReadOptions()) as (_, tables):
        if len(tables) != 1:
            raise DataError(f"has {len(tables)} tables; write frequency and density as the columns of one")
        (table,) = tables
        places = _chosen(table, columns or {})
        names = {key: table.columns[k].name for key, k in places.items()}
        loaded = table.load(sorted(set(places.values())), None)
        for finding in loaded.findings:
            raise DataError(f"is damaged: {finding}")
        values = {key: np.asarray(loaded.columns[k], dtype=np.float64) for key, k in places.items()}
        hertz = _hertz(names["frequency"], table.columns[places["frequency"]].unit)
        stated = _find_unit(names["density"], table.columns[places["density"]].unit, unit)
        sides = _sides(names["density"], sided, walk=stated.is_walk)
        _check(table, values["frequency"], values["density"], bare_name(names["density"]) or "the density")
    f = values["frequency"] * hertz
    used = f > 0
    return MeasuredDensity(
        name=bare_name(names["density"]),
        frequency=f[used],
        density=stated.density(values["density"])[used],
        unit=stated.rate_unit,
        sided=sides,
        without_zero=not used.all(),
    )


def _chosen(table: Table, columns: Mapping[str, str]) -> dict[str, int]:
    """Places of the columns of frequency and density. Raises the question for a column that no name identifies."""
    names = [column.name for column in table.columns]
    listed = ", ".join(name or f"column {k}" for k, name in enumerate(names[:_LISTED], 1))
    for key in columns:
        if key not in ("frequency", "density"):
            raise OptionError(f"{Hint('columns')}: {key!r} is not frequency or density", option="columns")
    places = {key: column_place(names, text, listed) for key, text in columns.items()}
    if "frequency" not in places:
        if any(name_words(name)[:1] and name_words(name)[0] in _TIMES for name in names):
            raise DataError("has times, not frequencies. sigmatau psd FILE computes the density of a log")
        matching = [
            k
            for k, name in enumerate(names)
            if name_words(bare_name(name))[:1] and name_words(bare_name(name))[0] in _FREQUENCIES
        ]
        if len(matching) != 1:
            raise _ask_for_columns("frequency", names, listed)
        places["frequency"] = matching[0]
    if "density" not in places:
        rest = [k for k in range(len(names)) if k != places["frequency"]]
        if len(rest) != 1:
            raise _ask_for_columns("density", names, listed)
        places["density"] = rest[0]
    if places["frequency"] == places["density"]:
        raise OptionError(f"{Hint('columns')}: frequency and density are one column", option="columns")
    return places


def _ask_for_columns(what: str, names: list[str], listed: str) -> OptionError:
    if len(names) == 1:
        return OptionError(f"has one column, {listed}. Give frequency and density, in two columns", option="columns")
    hint = Hint("columns", value={"frequency": names[0] or "1", "density": names[1] or "2"})
    return OptionError(f"has no single column of the {what}: {listed}. Name the columns, e.g. {hint}", option="columns")


def _hertz(name: str, unit: str | None) -> float:
    """One unit of the frequencies, in Hz. Frequencies without a unit are in Hz."""
    text = unit_in(name, unit)
    if text and text not in _HERTZ:
        matching = [symbol for symbol in _HERTZ if symbol.lower() == text.lower() and symbol != "mHz"]
        if len(matching) != 1:
            raise DataError(f"{name!r}: the frequency is in {text!r}. Write it in {', '.join(_HERTZ)}")
        return _HERTZ[matching[0]]
    return _HERTZ[text or "Hz"]


@frozen
class _DensityUnit:
    """The unit of a density or of its root."""

    rate_unit: str  # rad/s, m/s^2, or that of another signal
    factor: float  # This unit of the rate, in `rate_unit`
    is_root: bool  # Whether the values are roots of a density, in unit/√Hz
    is_walk: bool = False  # Whether the values are a random walk, in unit/√h: the root of the two-sided density

    def density(self, values: Floats) -> Floats:
        """Densities in SI of values in this unit."""
        return (values * self.factor) ** 2 if self.is_root else values * self.factor**2


def _find_unit(name: str, column_unit: str | None, stated: str | None) -> _DensityUnit:
    """The unit from the option or the header. Raises the question for the unit if both are absent."""
    header = unit_in(name, column_unit)
    if not (header or stated):
        raise OptionError(
            f"does not state the unit of {name or 'the density'}. Give it, e.g. {Hint('unit', value='(rad/s)^2/Hz')},"
            " mdps/rtHz, ug/rtHz or nT^2/Hz",
            option="unit",
        )
    read = [_parse(text) for text in (stated, header) if text]
    if len(read) == 2 and read[0] != read[1]:
        raise OptionError(
            f"{Hint('unit', value=stated)} is not the unit {header!r} of {name}. Leave it out, or correct the header",
            option="unit",
        )
    return read[0]


def _parse(text: str) -> _DensityUnit:
    if text.strip().lower().startswith("db"):
        raise OptionError(
            f"{text!r} is in decibels: convert it, 10^(dB/10) is a density and 10^(dB/20) its root", option="unit"
        )
    walk = units.find_unit(text)
    if walk is not None and walk.si in _WALKS and "Hz" not in walk.symbol:
        return _DensityUnit(rate_unit=_WALKS[walk.si], factor=walk.factor, is_root=True, is_walk=True)
    plain = text.strip().replace("²", "^2").replace("⁴", "^4").replace("**", "^")
    root, power = _ROOT.fullmatch(plain), _POWER.fullmatch(plain)
    if plain in _EXPANDED:
        base = _EXPANDED[plain]
    elif root is None and power is None:
        raise OptionError(f"{text!r} is not the unit of a density. Give one such as {_EXAMPLES}", option="unit")
    else:
        spelled = (root or power or [""])[1].strip()
        in_brackets = spelled.startswith("(") and spelled.endswith(")")
        base = spelled[1:-1].strip() if in_brackets else spelled
        if root is None and "/" in base and not in_brackets:
            raise OptionError(f"{text!r} is ambiguous. Write ({base})^2/Hz for the square of {base}", option="unit")
    unit = units.find_unit(base)
    if unit is not None and unit.si not in _SI_RATES:
        raise OptionError(
            f"{text!r} is not the density of a rate. Give that of rad/s or m/s^2, or of another signal: {_EXAMPLES}",
            option="unit",
        )
    if unit is None:
        return _DensityUnit(rate_unit=base, factor=1.0, is_root=root is not None)
    return _DensityUnit(rate_unit=unit.si, factor=unit.factor, is_root=root is not None)


def _sides(name: str, stated: Sided | None, *, walk: bool) -> Sided:
    """One- or two-sided, by the option or the header; a random walk is the root of the two-sided density."""
    match = SIDED.search(name)
    header = "" if match is None else "one" if match[1].lower() in ("one", "single", "1") else "two"
    sides = {text for text in (stated, header, "two" if walk else "") if text}
    if len(sides) == 2:
        raise OptionError(
            f"{Hint('sided', value=stated or 'one')} is not that of {name}, which is {header or 'two'}-sided."
            " Leave it out, or correct the header",
            option="sided",
        )
    if not sides:
        raise OptionError(
            f"does not state whether {name or 'the density'} is one- or two-sided. Give {Hint('sided', value='one')}, as in"
            f" most analysers and in SciPy, or {Hint('sided', value='two')}: their N differs by √2",
            option="sided",
        )
    return cast("Sided", sides.pop())


def _check(table: Table, frequency: Floats, density: Floats, name: str) -> None:
    """Raise `DataError`, with the row, for a value that a density cannot have."""
    zero = frequency == 0
    wrong = (
        (~np.isfinite(frequency), "the frequency is not a finite number. Remove this row"),
        (frequency < 0, "the frequency is negative. Write the positive ones only"),
        (np.diff(frequency, prepend=-np.inf) <= 0, "the frequency does not rise. Sort the rows, remove repeated ones"),
        (~np.isfinite(density) & ~zero, f"{name} is not a finite number. Remove this row"),
        ((density <= 0) & ~zero, f"{name} is not positive. A density in dB is converted first; remove empty rows"),
    )
    for rows, text in wrong:
        if rows.any():
            raise DataError(text, place=table.where(int(np.flatnonzero(rows)[0])))
