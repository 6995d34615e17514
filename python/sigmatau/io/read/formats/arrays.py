"""Tables from named arrays: common to .npy, MATLAB, HDF5, TDMS and data frames.

A container has named arrays in groups. An array of shape (n,) is a column, and one of shape (n, k) is k columns. The arrays
of one group and one length are a table.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.wording import sentence
from sigmatau.frozen import frozen
from sigmatau.hints import Hint
from sigmatau.io.read.table import Column, Loaded, Table
from sigmatau.record.record import MIN_SAMPLES
from sigmatau.record.sampling import RateSource

MAX_COLUMNS = 64  # Largest number of columns of an array that is read
_AXES = frozenset("xyzXYZ")
_LISTED = 8
_UNIT = re.compile(r"(.*?\S)(\s*(?:\[[^\[\]]*[^\d\[\]][^\[\]]*\]|\([^()]*[^\d()][^()]*\)))\s*")


@frozen
class Leaf:
    """An array of a container, not loaded yet."""

    group: tuple[str, ...]  # Names of the groups, or structs, that contain it, from the top
    name: str
    shape: tuple[int, ...]  # ``(n,)`` or ``(n, k)``
    load: Callable[[], NDArray[Any]]  # Returns the array in that shape; raises only `DataError`
    unit: str | None = None  # unit as the file spells it
    rate: float | None = None  # Sampling rate, if the format states one. [Hz]
    rate_key: str = ""  # The attribute or property that states it
    fill: float | None = None  # The stored number that marks a missing sample
    scale: tuple[float, float] = (1.0, 0.0)  # Factor and offset: value = stored * factor + offset

    def values(self) -> NDArray[Any]:
        """The scaled array with NaN for missing samples."""
        array = self.load()
        if self.fill is not None and (gone := array == self.fill).any():
            array = np.where(gone, np.nan, array)
        factor, offset = self.scale
        return array if self.scale == (1.0, 0.0) else array * factor + offset


def parts(name: str, shape: tuple[int, ...]) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Names and indices of the columns into which an array of shape (n, *shape) is split."""
    if len(shape) == 0 or shape == (1,):
        yield name, (0,) * len(shape)
    elif len(shape) == 1:
        endings: Sequence[str] = "xyz" if shape[0] == 3 else [str(k + 1) for k in range(shape[0])]
        stated = _UNIT.fullmatch(name)  # a unit in brackets stays at the end
        stem, unit = stated.groups() if stated else (name, "")
        for k, ending in enumerate(endings):
            yield f"{stem}_{ending}{unit}", (k,)


def pick(array: NDArray[Any], part: tuple[int, ...]) -> NDArray[Any]:
    """One column of an array, as `parts` numbers it."""
    return array[:, part[0]] if part else array


def squeezed(shape: Sequence[int], *, rows_allowed: bool = False) -> tuple[tuple[int, ...], bool] | None:
    """The shape (n,) or (n, k) of the columns of an array, and whether it is transposed; None if it has no columns.

    `rows_allowed` states whether vectors may be rows, as in MATLAB. An array (k, n) with small k and large n is then read
    as (n, k).
    """
    if len(shape) == 1:
        return (int(shape[0]),), False
    if len(shape) != 2:
        return None
    n, k = int(shape[0]), int(shape[1])
    if k == 1:
        return (n,), False
    if n == 1 and rows_allowed:
        return (k,), True
    if rows_allowed and n <= MAX_COLUMNS < k:
        return (k, n), True
    return ((n, k), False) if 0 < k <= MAX_COLUMNS else None


def real_columns(raw: Mapping[int, NDArray[Any]], columns: Sequence[Column]) -> dict[int, NDArray[Any]]:
    """Convert the columns to real numbers of native byte order. Raises `DataError` for other types and for unequal
    lengths.
    """
    checked: dict[int, NDArray[Any]] = {}
    for index, array in raw.items():
        if array.dtype.kind not in "iuf":
            name = columns[index].name
            raise DataError(f"column {repr(name) if name else index + 1} holds {array.dtype}, not real numbers")
        # The kernels need native byte order and float32 or float64.
        plain = array if array.dtype.kind in "iu" or array.dtype.itemsize in (4, 8) else array.astype(np.float64)
        plain = plain if plain.dtype.isnative else plain.astype(plain.dtype.newbyteorder("="))
        checked[index] = plain if not isinstance(plain, np.ndarray) or plain.flags.aligned else plain.copy()
    lengths = {len(array) for array in raw.values()}
    if len(lengths) > 1:
        listed = ", ".join(f"{columns[i].name} {len(a)}" for i, a in raw.items())
        raise DataError(f"has columns of unequal length ({listed}); cut them alike, or choose by {Hint('channels')}")
    return checked


def table_of_columns(
    kind: str,
    columns: Sequence[Column],
    getters: Sequence[Callable[[], NDArray[Any]]],
    notes: tuple[str, ...],
    findings: tuple[Finding, ...] = (),
) -> Table:
    """Build a table whose columns are loaded one by one."""

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        return Loaded(columns=real_columns({index: getters[index]() for index in wanted}, columns))

    return Table(format=kind, columns=tuple(columns), notes=notes, load=load, findings=findings)


def gather(
    leaves: Sequence[Leaf],
    *,
    kind: str,
    root: str,
    separator: str,
    notes: tuple[str, ...] = (),
    findings: tuple[Finding, ...] = (),
) -> tuple[Table, ...]:
    """Build the tables of a container: the arrays of one group and one length are a table.

    `root`: beginning of the names of topics, and name of the topic of arrays that are in no group; `notes`, `findings`:
    facts about the file that every table gets.
    """
    long = [leaf for leaf in leaves if leaf.shape[0] >= MIN_SAMPLES]
    left_out = [leaf for leaf in leaves if leaf.shape[0] < MIN_SAMPLES]
    if not long:
        held = _names([f"{separator.join((*leaf.group, leaf.name))} {leaf.shape}" for leaf in left_out])
        lost = "".join(f" ({sentence(finding)})" for finding in findings)
        raise DataError(f"has no array of at least {MIN_SAMPLES} numbers{f', only {held}' if held else ''}{lost}")
    if left_out:
        short = _names([separator.join((*leaf.group, leaf.name)) for leaf in left_out])
        notes = (*notes, f"arrays of fewer than {MIN_SAMPLES} rows are not read: {short}")
    by_home: dict[tuple[tuple[str, ...], int], list[Leaf]] = {}
    present = {(leaf.group, leaf.shape[0]) for leaf in long}
    for leaf in long:
        by_home.setdefault((_home(leaf, present), leaf.shape[0]), []).append(leaf)
    groups = [group for group, _ in by_home]
    tables = []
    for (group, rows), members in by_home.items():
        # Tables of one group with different lengths are named by their first array.
        last = (members[0].name,) if groups.count(group) > 1 or (not group and not root) else ()
        topic = root + separator.join((*group, *last)) if len(by_home) > 1 or group or root else ""
        table = _table(kind, topic, group, rows, members, separator, notes, findings)
        rates = {leaf.rate for leaf in members}
        if len(rates) == 1 and None not in rates:
            table = replace(table, rate=rates.pop(), rate_source=RateSource(kind="file", place=members[0].rate_key))
        tables.append(table)
    return tuple(tables)


def _is_axis(leaf: Leaf) -> bool:
    return leaf.name in _AXES and len(leaf.shape) == 1 and bool(leaf.group)


def _home(leaf: Leaf, present: set[tuple[tuple[str, ...], int]]) -> tuple[str, ...]:
    """The group whose table an array joins: the highest group above it that has arrays of its length.

    One time vector thus serves all sensors in the groups below it.
    """
    for depth in range(len(leaf.group)):
        if (leaf.group[:depth], leaf.shape[0]) in present:
            return leaf.group[:depth]
    return leaf.group


def _table(
    kind: str,
    topic: str,
    group: tuple[str, ...],
    rows: int,
    members: Sequence[Leaf],
    separator: str,
    notes: tuple[str, ...],
    findings: tuple[Finding, ...],
) -> Table:
    columns: list[Column] = []
    sources: list[tuple[Leaf, tuple[int, ...]]] = []
    for leaf in members:
        path = [*leaf.group[len(group) :], leaf.name]
        if _is_axis(leaf):
            path = [*path[:-2], f"{leaf.group[-1]}_{leaf.name}"]  # group gyro, array x
        for label, part in parts(separator.join(path), leaf.shape[1:]):
            columns.append(Column(name=label, unit=leaf.unit))
            sources.append((leaf, part))

    def load(wanted: Sequence[int], exact: int | None) -> Loaded:
        by_leaf: dict[int, list[int]] = {}
        for index in wanted:
            by_leaf.setdefault(id(sources[index][0]), []).append(index)
        raw: dict[int, NDArray[Any]] = {}
        for indices in by_leaf.values():
            leaf = sources[indices[0]][0]
            array = leaf.values()
            if array.shape != leaf.shape:
                raise DataError(f"{leaf.name} has shape {array.shape} where {leaf.shape} is declared; it is damaged")
            whole = len(leaf.shape) == 1 or len(indices) == leaf.shape[1]
            # a view keeps the whole array in memory, so it is used only if all columns are wanted
            for index in indices:
                column = pick(array, sources[index][1])
                raw[index] = column if whole else column.copy()
        return Loaded(columns=real_columns(raw, columns))

    return Table(format=kind, columns=tuple(columns), notes=notes, load=load, topic=topic, rows=rows, findings=findings)


def _names(names: Sequence[str]) -> str:
    return ", ".join(names[:_LISTED]) + (f", … {len(names)} in all" if len(names) > _LISTED else "")
