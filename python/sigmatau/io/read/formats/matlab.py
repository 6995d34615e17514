"""MATLAB files: versions 5, 6 and 7 by `mat5`, version 7.3 as HDF5, tables and timetables by mat-io."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.wording import sentence
from sigmatau.io.read.formats import hdf5, mat5
from sigmatau.io.read.formats.arrays import Leaf, gather
from sigmatau.io.read.formats.damage import fault, library_faults, trailing_bytes
from sigmatau.io.read.table import Head, Table, need

_HDF5_OFFSET = 512

_CLASSES_73 = frozenset(["double", "single", *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64))])


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The tables of a file: variables of equal length form one table; each struct, table and timetable is one."""
    contents = mat5.MatContents()
    if head.data[_HDF5_OFFSET : _HDF5_OFFSET + 8] == b"\x89HDF\r\n\x1a\n":
        version = "7.3"
        _walk_73(path, contents)
        contents.findings.extend(trailing_bytes(path, hdf5.declared_end(path, _HDF5_OFFSET), "the HDF5 file"))
    else:
        version = "5"
        contents.version_5 = True
        mat5.walk(path, head.data, contents)
    if contents.opaque:
        _tables(path, contents)
    notes = [f"MATLAB file, version {version}"]
    if version == "5" and contents.plain:
        notes.append("without compression there is no checksum: a damaged number is not detected")
    if contents.skipped:
        notes.append(f"not numbers of shape (n,) or (n, k): {', '.join(contents.skipped[:12])}")
    if not contents.leaves:
        lost = "".join(f"; {sentence(finding)}" for finding in contents.findings)
        raise DataError(f"has no variable of numbers of shape (n, 1) or (n, k){lost}")
    return gather(
        contents.leaves,
        kind="matlab",
        root="",
        separator=".",
        notes=(*notes, *contents.notes),
        findings=tuple(contents.findings),
    )


# ---- version 7.3 ----


def _walk_73(path: Path, contents: mat5.MatContents) -> None:
    with hdf5.open_file(path) as file, library_faults(hdf5.damaged):
        for name, item in hdf5.hard_items(file):
            kind = hdf5.word(item, "MATLAB_class")
            if kind in mat5.TABLES and "MATLAB_object_decode" in item.attrs:
                contents.opaque.append(name)
        for names, dataset in hdf5.walk(file):
            if names[0].startswith("#") or names[0] in contents.opaque:
                hdf5.refuse_other_files(names, dataset)
                continue
            kind = hdf5.word(dataset, "MATLAB_class")
            if dataset.shape is None or "MATLAB_empty" in dataset.attrs or kind == "char":
                continue
            if dataset.dtype.kind not in "iuf" or kind not in (None, *_CLASSES_73):
                contents.skipped.append(".".join(names))
                continue
            # HDF5 stores the transpose.
            dims = tuple(int(n) for n in reversed(dataset.shape))
            contents.add(names, dims, hdf5.loader(path, names, transposed=True))


# ---- tables and timetables, of both versions ----


def _tables(path: Path, contents: mat5.MatContents) -> None:
    matio = need("matio", "matlab", "a MATLAB file with a table")
    if not contents.version_5:
        hdf5.check_heaps(path)
    import warnings

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # warnings about time zones and display formats
            held = matio.load_from_mat(str(path), variable_names=list(contents.opaque), add_table_attrs=True)
    except MemoryError:
        raise
    except Exception as error:
        reason = str(error).split("\n")[0] or type(error).__name__
        contents.findings.append(fault(what=f"variable {', '.join(contents.opaque)}", reason=reason))
        return
    for name in contents.opaque:
        value = held.get(name)
        if hasattr(value, "columns") and hasattr(value, "attrs"):
            contents.leaves.extend(_frame_leaves(name, value, contents))
        elif isinstance(value, np.ndarray) and value.dtype.kind in "mM" and value.size == max(value.shape):
            contents.leaves.append(_leaf((), name, _nanoseconds(value.reshape(-1)), "ns"))
        else:
            contents.skipped.append(name)


def _frame_leaves(name: str, frame: Any, contents: mat5.MatContents) -> Iterator[Leaf]:  # noqa: ANN401  pandas has no types here
    times = frame.index.to_numpy()
    if times.dtype.kind in "mM":
        yield _leaf((name,), str(frame.index.name or "Time"), _nanoseconds(times), "ns")
    variables = _variables([str(column) for column in frame.columns])
    units = [str(unit) for unit in frame.attrs.get("VariableUnits") or frame.attrs.get("varUnits") or ()]
    if units and len(units) != len(set(variables.values())):
        contents.notes.append(f"{name}: {len(units)} units for {len(frame.columns)} columns, so they are not used")
        units = []
    stems = list(dict.fromkeys(variables.values()))
    for k, (column, stem) in enumerate(variables.items()):
        values = frame.iloc[:, k].to_numpy()
        unit = units[stems.index(stem)] if units else ""
        label = column
        if [v for v in variables.values() if v == stem] == [stem] * 3:
            label = f"{stem}_{'xyz'[int(column[-1]) - 1]}"
        if values.dtype.kind in "mM":
            yield _leaf((name,), label, _nanoseconds(values), "ns")
        elif values.dtype.kind in "iuf":
            yield _leaf((name,), label, values, unit or None)
        else:
            contents.skipped.append(f"{name}.{column}")


def _variables(columns: list[str]) -> dict[str, str]:
    """The variable of each column: mat-io splits a variable of three columns into ``gyro_1``, ``gyro_2``, ``gyro_3``."""
    variables = {column: column for column in columns}
    for column in columns:
        stem = column.removesuffix("_1")
        if stem != column and f"{stem}_2" in columns:
            k = 1
            while f"{stem}_{k}" in columns:
                variables[f"{stem}_{k}"] = stem
                k += 1
    return variables


def _nanoseconds(values: NDArray[Any]) -> NDArray[np.int64]:
    unit = "timedelta64[ns]" if values.dtype.kind == "m" else "datetime64[ns]"
    return values.astype(unit).astype(np.int64)


def _leaf(group: tuple[str, ...], name: str, values: NDArray[Any], unit: str | None) -> Leaf:
    return Leaf(group=group, name=name, shape=values.shape, load=lambda: values, unit=unit)
