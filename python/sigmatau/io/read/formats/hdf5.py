"""HDF5: each group whose numeric datasets have one length is a topic, and each compound dataset is a table."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.io.read.formats import damage
from sigmatau.io.read.formats.arrays import MAX_COLUMNS, Leaf, gather, squeezed
from sigmatau.io.read.formats.damage import find_mark, first_line, library_faults, refuse_expansion, trailing_bytes
from sigmatau.io.read.table import Head, Table, need

_CUT = re.compile(r"truncated file: eof = (\d+), .*stored_eof = (\d+)")
_UNITS = ("unit", "units")
_MAX_OBJECTS = 10_000  # largest number of objects in a file; a log has far fewer
_MAX_DEPTH = 32  # largest depth of nested groups


def read(path: Path, head: Head) -> tuple[Table, ...]:
    """The tables of a file; raises `DataError`."""
    leaves: list[Leaf] = []
    notes: list[str] = []
    with open_file(path) as file, library_faults(damaged):
        for names, dataset in walk(file):
            leaves.extend(_leaves(path, names, dataset))
            if (scale := _scale(dataset)) != (1.0, 0.0):
                name = "/".join(names)
                notes.append(f"{name}: stored * {scale[0]:g} + {scale[1]:g}, by its scale_factor and add_offset")
    if not leaves:
        raise DataError("has no dataset of numbers of shape (n,) or (n, k)")
    return gather(
        leaves,
        kind="hdf5",
        root="/",
        separator="/",
        notes=tuple(dict.fromkeys(notes)),
        findings=trailing_bytes(path, declared_end(path, 0), "the HDF5 file"),
    )


def declared_end(path: Path, start: int) -> int:
    """The end of a file by its superblock (HDF5 file format specification, version 3, section II.A). [bytes] `start`:
    offset of the superblock, which follows the user block [bytes].
    """
    with path.open("rb") as stream:
        stream.seek(start)
        block = stream.read(64)
    version = block[8] if len(block) == 64 else 0
    if (
        len(block) < 64 or block[13 if version < 2 else 9] != 8
    ):  # only offsets of 8 bytes are read, which all current libraries write
        return path.stat().st_size
    position = 40 if version == 0 else 44 if version == 1 else 28
    return int.from_bytes(block[position : position + 8], "little")


def open_file(path: Path) -> Any:  # noqa: ANN401  h5py has no types
    """The file, for a ``with``; raises `DataError`."""
    h5py = need("h5py", "hdf5", "an HDF5 file")
    with library_faults(damaged):
        # Without a lock: some network shares do not support locks.
        return h5py.File(os.fsencode(path), "r", locking=False)


def damaged(error: Exception) -> DataError:
    """A `DataError` from an error of h5py."""
    if match := _CUT.search(first_line(error)):
        return DataError(
            f"is truncated: it has {match[1]} of {match[2]} bytes, and an HDF5 file is only readable whole; copy or record"
            " the file again"
        )
    return damage.damaged(error)


def walk(file: Any) -> Iterator[tuple[tuple[str, ...], Any]]:  # noqa: ANN401
    """Datasets with their path of names. Each object is listed once, and links to other files are not followed."""
    import h5py

    visited: set[bytes] = set()
    waiting: list[tuple[tuple[str, ...], Any]] = [((), file)]
    while waiting:
        names, group = waiting.pop(0)
        for name, item in hard_items(group):
            if len(visited) > _MAX_OBJECTS:
                raise DataError(f"has more than {_MAX_OBJECTS} objects, too many for a log")
            number = bytes(h5py.h5o.get_info(item.id).addr.to_bytes(8, "little", signed=False))
            if number in visited:
                continue
            visited.add(number)
            if isinstance(item, h5py.Group) and len(names) < _MAX_DEPTH:
                waiting.append(((*names, name), item))
            elif isinstance(item, h5py.Dataset):
                yield (*names, name), item


def hard_items(group: Any) -> Iterator[tuple[str, Any]]:  # noqa: ANN401
    """Objects of a group with their names, without links, which may lead to other files."""
    import h5py

    for name in group:
        if isinstance(group.get(name, getlink=True), h5py.HardLink):
            yield name, group[name]


def refuse_other_files(names: tuple[str, ...], dataset: Any) -> None:  # noqa: ANN401
    """Raise `DataError` for a dataset whose samples are in other files: a log must not choose files to be read."""
    if dataset.is_virtual or dataset.external is not None:
        name = "/".join(names)
        raise DataError(
            f"dataset {name} has its samples in other files, which are not opened; copy them into this file"
        )


def _refuse_filters(name: str, dataset: Any) -> None:  # noqa: ANN401
    """Raise `DataError` for a dataset that needs a filter that is not installed."""
    import h5py

    plan = dataset.id.get_create_plist()
    for place in range(plan.get_nfilters()):
        code = plan.get_filter(place)[0]
        if not h5py.h5z.filter_avail(code):
            raise DataError(
                f"dataset {name} needs the HDF5 filter {code}, which is not installed; write it with gzip or uncompressed"
            )


def _leaves(path: Path, names: tuple[str, ...], dataset: Any) -> Iterator[Leaf]:  # noqa: ANN401
    dtype = dataset.dtype
    if dataset.shape is None:
        return
    if dtype.names and len(dataset.shape) == 1:
        for field in dtype.names:
            inner = dtype[field]
            if inner.base.kind in "iuf" and len(inner.shape) <= 1:
                yield Leaf(
                    group=names,
                    name=field,
                    shape=(dataset.shape[0], *inner.shape),
                    load=loader(path, names, field=field),
                    unit=_unit(dataset, field),
                )
        return
    dims = squeezed(dataset.shape)
    if dims is None or dtype.kind not in "iuf":
        return
    shape, _ = dims
    yield Leaf(
        group=names[:-1],
        name=names[-1],
        shape=shape,
        load=loader(path, names, shape=shape),
        unit=_unit(dataset),
        fill=_number(dataset, "_FillValue"),
        scale=_scale(dataset),
    )


def _scale(dataset: Any) -> tuple[float, float]:  # noqa: ANN401
    """Factor and offset of packed data: value = stored * scale_factor + add_offset (CF conventions 1.11, section 8.1)."""
    factor, offset = _number(dataset, "scale_factor"), _number(dataset, "add_offset")
    return 1.0 if factor is None else factor, 0.0 if offset is None else offset


def _number(item: Any, key: str) -> float | None:  # noqa: ANN401
    """The value of an attribute with a single number."""
    value = _attribute(item, key) if key in item.attrs else None
    return float(value.item()) if value is not None and value.dtype.kind in "iuf" else None


def _fits(size: int, names: tuple[str, ...], dataset: Any) -> None:  # noqa: ANN401
    """Raise `DataError` if a dataset declares more than the file stores: h5py returns zeros for missing parts."""
    if dataset.shape is None or dataset.dtype.kind == "O":
        return
    refuse_other_files(names, dataset)
    declared = int(np.prod([int(n) for n in dataset.shape], dtype=object)) * dataset.dtype.itemsize
    stored = int(dataset.id.get_storage_size())
    name = "/".join(names)
    if stored == 0:
        raise DataError(f"dataset {name} was never written; copy or record the file again")
    if stored > size:
        raise DataError(f"dataset {name} declares {declared} bytes but the file stores {stored}; it is damaged")
    refuse_expansion(stored, declared, f"dataset {name}")
    if dataset.chunks is None:
        if stored < declared:
            raise DataError(f"dataset {name} has {stored} of {declared} bytes; copy or record the file again")
        return
    _refuse_filters(name, dataset)
    want = 1
    for n, chunk in zip(dataset.shape, dataset.chunks, strict=True):
        want *= -(-n // chunk)
    if (got := dataset.id.get_num_chunks()) < want:
        raise DataError(f"dataset {name} has {got} of {want} chunks; copy or record the file again")


def loader(
    path: Path,
    names: tuple[str, ...],
    *,
    shape: tuple[int, ...] | None = None,
    field: str | None = None,
    transposed: bool = False,
) -> Callable[[], NDArray[Any]]:
    """A function that reads a dataset, or a field of it; the file is open only during the call."""

    def load() -> NDArray[Any]:
        with open_file(path) as file, library_faults(damaged):
            dataset = file["/".join(names)]
            _fits(path.stat().st_size, names, dataset)
            array: NDArray[Any] = np.asarray(dataset[()] if field is None else dataset.fields(field)[()])
        array = array.T if transposed else array
        return array if shape is None else array.reshape(shape)

    return load


def _unit(item: Any, field: str = "") -> str | None:  # noqa: ANN401
    wanted = [f"{field}_{name}".lower() if field else name for name in _UNITS]
    for key in list(item.attrs)[:MAX_COLUMNS]:
        if key.lower() in wanted and (text := word(item, key)) is not None:
            return text
    return None


def word(item: Any, key: str) -> str | None:  # noqa: ANN401
    """A text attribute of a group or dataset."""
    value = _attribute(item, key) if key in item.attrs else None
    text = None if value is None else value.item()
    return text.decode("utf-8", "replace") if isinstance(text, bytes) else text if isinstance(text, str) else None


def _attribute(item: Any, key: str) -> NDArray[Any] | None:  # noqa: ANN401
    """An attribute with one value; None if it has several, or cannot be read safely."""
    handle = item.attrs.get_id(key)
    if int(np.prod(handle.shape, dtype=object)) != 1:
        return None
    if handle.dtype.kind == "O":
        import h5py

        if (
            h5py.check_string_dtype(handle.dtype) is None
        ):  # references and lists are not units, and damage can turn text into them
            return None
        check_heaps(Path(item.file.filename))
    value = np.asarray(item.attrs[key])
    return value if value.size == 1 else None


def check_heaps(path: Path) -> None:
    """Raise `DataError` if a damaged heap would make the library search for a string without end."""
    status = path.stat()
    if not _heaps_are_sound(str(path), status.st_size, status.st_mtime_ns):
        raise DataError("is damaged: the sizes of a global heap are wrong; copy or record the file again")


@lru_cache(maxsize=4)
def _heaps_are_sound(name: str, size: int, changed: int) -> bool:
    """Whether the objects of every global heap fill it: after an object of size 0 the library searches without end.
    Layout: HDF5 file format specification, version 3, section III.E.
    """
    del changed  # part of the cache key
    for start in find_mark(Path(name), b"GCOL\x01\0\0\0"):
        with Path(name).open("rb") as stream:
            stream.seek(start + 8)
            length = int.from_bytes(stream.read(8), "little")
            if start > size - 16:
                break
            if start + length > size:
                return False
            heap = stream.read(max(length - 16, 0))
        place = 0
        while place + 16 <= len(heap):
            index = int.from_bytes(heap[place : place + 2], "little")
            held = int.from_bytes(heap[place + 8 : place + 16], "little")
            step = held if index == 0 else 16 + held + -held % 8  # free space counts its own header
            if step < 16 or place + step > len(heap):
                return False
            place += step
    return True
