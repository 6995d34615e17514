"""Zarr, formats 2 and 3: a folder or a URL whose arrays are stored in chunks. Columns stay there, and are read by chunk.

Each group whose arrays have one length is a table; an array of shape (n, k) is k columns, named by its attribute
``columns`` if it has one. The attributes ``rate`` (of an array or a group above it, in Hz) and ``unit`` are used.

The library returns the fill value for a chunk that is not stored, without an error. Here the samples of such a chunk are
missing samples: arrays of floating-point numbers are read with NaN as the fill value, and chunks of integers that hold
nothing but the fill value are read again with another one.
"""

from __future__ import annotations

import itertools
import math
import threading
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError
from sigmatau.findings.finding import Finding
from sigmatau.findings.reading import MissingChunks
from sigmatau.io.read.formats.arrays import MAX_COLUMNS, Leaf, gather, parts
from sigmatau.io.read.formats.damage import fault, first_line, library_faults
from sigmatau.io.read.table import Table, need
from sigmatau.record.memory import available
from sigmatau.record.on_disk import StoredRows

_RATES = ("rate", "rate_hz", "sample_rate", "sampling_rate", "sample_rate_hz", "fs")
_UNITS = ("unit", "units")
_MAX_ARRAYS = 10_000  # largest number of arrays of a store; a log has far fewer
_MAX_CHUNKS = 1_000_000  # largest number of stored files of an array; one of 10¹² samples has some 30 000
_BLOCK_BYTES = 1 << 20  # smallest size of a read: a call of the library takes half a millisecond [bytes]
_KEPT_BLOCKS = 4  # number of decoded blocks of an array in memory: parallel readers read different blocks
_KEPT_BYTES = 1 << 25  # largest memory of these blocks, if there are several [bytes]


def read(place: str) -> tuple[Table, ...]:
    """The tables of a folder or a URL.

    Raises
    ------
    DataError
        If it is not a Zarr store, is damaged, or a library is missing.
    """
    zarr = need("zarr", "cluster", "a Zarr store")
    _silence_tasks()
    with library_faults(_damaged):
        try:
            root = zarr.open(_store(place), mode="r")
        except FileNotFoundError:
            raise DataError("is not a Zarr store: it has no zarr.json, .zgroup or .zarray") from None
        members, findings = _members(root)
        arrays = list(_arrays(members))
        findings += tuple(finding for _, array in arrays for finding in _missing_chunks(array))
        leaves = [leaf for names, array in arrays for leaf in _leaves(root, names, array)]
    if not leaves:
        raise DataError("has no array of numbers of shape (n,) or (n, k)")
    return gather(leaves, kind="zarr", root="/", separator="/", findings=findings)


def _silence_tasks() -> None:
    """The library reads in parallel and raises the first error; asyncio would print a traceback of each further one."""
    from zarr.core.sync import _get_loop

    _get_loop().set_exception_handler(lambda loop, context: None)


def _store(place: str) -> Any:  # noqa: ANN401  zarr is optional
    if "://" not in place:
        return place
    need("fsspec", "cluster", "at a URL")
    from zarr.storage import FsspecStore

    return FsspecStore.from_url(place, read_only=True)


def _damaged(error: Exception) -> DataError:
    return DataError(f"is a damaged Zarr store ({first_line(error)}); copy or record it again")


def _members(root: Any) -> tuple[list[tuple[str, Any]], tuple[Finding, ...]]:  # noqa: ANN401
    """Arrays and groups with their paths, and a finding for each array without metadata.

    The library reports a missing array only by a warning, which other files in the folder cause too.
    """
    from zarr.core.sync import sync

    if hasattr(root, "shape"):
        return [(root.path or "signal", root)], ()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Object at .* is not recognized")
        members = list(itertools.islice(root.members(max_depth=None), _MAX_ARRAYS + 1))
    if len(members) > _MAX_ARRAYS:
        raise DataError(f"has more than {_MAX_ARRAYS} arrays, too many for a log")
    arrays = {name for name, member in members if hasattr(member, "shape")}
    present = {name for name, _ in members}
    prefix = f"{root.path}/" if root.path else ""
    lost: set[str] = set()
    for key in sync(_keys(root.store_path.store, prefix)):
        folders = itertools.accumulate(key.removeprefix(prefix).split("/")[:-1], "{}/{}".format)
        above = next((name for name in folders if name in arrays or name not in present), None)
        if above is not None and above not in arrays:
            lost.add(above)
    metadata = ".zarray" if root.metadata.zarr_format == 2 else "zarr.json"
    findings = [fault(what=f"array {name}", reason=f"it has no {metadata}") for name in sorted(lost)]
    return members, tuple(findings)


def _arrays(members: list[tuple[str, Any]]) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Arrays that may become columns, by name, with their path of names."""
    for name, array in sorted(members, key=lambda member: member[0]):
        if (
            hasattr(array, "shape")
            and array.dtype.kind in "iuf"
            and (len(array.shape) == 1 or (len(array.shape) == 2 and 0 < array.shape[1] <= MAX_COLUMNS))
        ):
            yield tuple(name.split("/")), array


def _leaves(root: Any, names: tuple[str, ...], array: Any) -> Iterator[Leaf]:  # noqa: ANN401
    attributes = dict(array.attrs)
    rows = ChunkedRows(array, "/".join(names), scale=_scale(attributes))
    labels = [(names[-1], ())] if len(array.shape) == 1 else list(parts(names[-1], array.shape[1:]))
    stated = attributes.get("columns")
    if isinstance(stated, Sequence) and len(stated) == len(labels) and all(isinstance(name, str) for name in stated):
        labels = [(name, part) for name, (_, part) in zip(stated, labels, strict=True)]
    units = next((attributes[key] for key in _UNITS if key in attributes), None)
    rate, rate_key = _rate(root, names, attributes)
    for k, (label, part) in enumerate(labels):
        unit = units[k] if isinstance(units, list) and len(units) == len(labels) else units
        unit = unit.get(label) if isinstance(unit, Mapping) else unit
        yield Leaf(
            group=names[:-1],
            name=label,
            shape=(array.shape[0],),
            load=lambda part=part: rows.column(None, part[0] if part else None),  # type: ignore[misc]
            unit=unit if isinstance(unit, str) else None,
            rate=rate,
            rate_key=rate_key,
        )


def _rate(
    root: Any,  # noqa: ANN401
    names: tuple[str, ...],
    attributes: Mapping[str, Any],
) -> tuple[float | None, str]:
    """The rate of an array, or of the nearest group above it that states one, and the key that states it. [Hz]"""
    groups = (
        [] if hasattr(root, "shape") else [root["/".join(names[:k])] for k in range(len(names) - 1, 0, -1)] + [root]
    )
    for level in (attributes, *(dict(group.attrs) for group in groups)):
        for key in _RATES:
            value = level.get(key)
            if isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value) and value > 0:
                return float(value), key
    return None, ""


def _scale(attributes: Mapping[str, Any]) -> tuple[float, float]:
    """Factor and offset of packed data: value = stored * scale_factor + add_offset (CF conventions 1.11, section 8.1)."""

    def number(key: str, default: float) -> float:
        value = attributes.get(key)
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else default

    return number("scale_factor", 1.0), number("add_offset", 0.0)


def _missing_chunks(array: Any) -> tuple[Finding, ...]:  # noqa: ANN401
    """A finding about chunks that are not stored. Raises `DataError` if no chunk is stored."""
    from zarr.core.sync import sync

    store, prefix = array.store_path.store, array.store_path.path
    stored = sync(_keys(store, f"{prefix}/" if prefix else ""))
    sizes = getattr(array, "shards", None) or array.chunks
    grid = [range(-(-n // size)) for n, size in zip(array.shape, sizes, strict=True)]
    total = math.prod(map(len, grid))
    if total > _MAX_CHUNKS:
        raise DataError(f"array {array.path} has more than {_MAX_CHUNKS} chunks; write it with larger chunks")
    names = ((place, array.metadata.encode_chunk_key(place)) for place in itertools.product(*grid))
    lost = [place for place, name in names if (f"{prefix}/{name}" if prefix else name) not in stored]
    if not lost:
        return ()
    name = array.path or "the array"
    if len(lost) == total:
        raise DataError(f"array {name} was never written; copy or record it again")
    first = lost[0][0] * sizes[0]
    details = MissingChunks(array=name, count=len(lost), of=total, first=first)
    return (Finding(details=details, severity="error"),)


async def _keys(store: Any, prefix: str) -> set[str]:  # noqa: ANN401
    return {key async for key in store.list_prefix(prefix)}


class ChunkedRows(StoredRows):
    """Rows of an array in chunks; some decoded chunks stay in memory.

    Parameters
    ----------
    array : zarr.Array
        Array of numbers with the shape (n,) or (n, k).
    name : str
        For errors.
    scale : tuple of float
        Factor and offset: value = stored * factor + offset.
    """

    def __init__(self, array: Any, name: str, *, scale: tuple[float, float] = (1.0, 0.0)) -> None:  # noqa: ANN401
        self._array, self._scale = array, scale
        self.name = name
        self._whole = array.dtype.kind in "iu"
        self._blosc = _uses_blosc(array)
        self._twins = [_with_fill(array, fill) for fill in ((0, 1) if self._whole else (math.nan,))]
        with_gaps = self._whole and (getattr(array, "shards", None) is not None or bool(_missing_chunks(array)))
        plain = array.dtype.newbyteorder("=") if scale == (1.0, 0.0) and not with_gaps else np.dtype(np.float64)
        super().__init__(np.dtype((plain, array.shape[1:])), int(array.shape[0]))
        self._plain, self._shape = plain, tuple(array.shape[1:])
        row = array.dtype.itemsize * math.prod(self._shape)
        chunk = int(array.chunks[0])
        free = available()
        if free is not None and 2 * chunk * row > free:
            raise DataError(
                f"array {name} has chunks of {chunk * row / 1e9:.3g} GB, too large for the memory that is free"
            )
        self._chunk = chunk
        self._step: int = chunk * max(_BLOCK_BYTES // max(chunk * row, 1), 1)
        self._max_blocks = max(min(_KEPT_BLOCKS, _KEPT_BYTES // max(self._step * row, 1)), 1)
        self._blocks: dict[int, NDArray[Any]] = {}
        self._lock = threading.Lock()

    @property
    def step(self) -> int:
        """Number of rows that are read at a time: whole chunks."""
        return self._step

    def read(self, start: int, stop: int) -> NDArray[Any]:
        """Read rows. Those of chunks that are not stored are NaN."""
        pieces = []
        while start < stop:
            first = start // self._step * self._step
            block = self._block(first)
            end = min(stop, first + len(block))
            pieces.append(block[start - first : end - first])
            start = end
        return pieces[0] if len(pieces) == 1 else np.concatenate([np.empty((0, *self._shape), self._plain), *pieces])

    def _block(self, first: int) -> NDArray[Any]:
        with self._lock:
            block = self._blocks.get(first)
        if block is None:
            block = self._decoded(first, min(first + self._step, self.count))
            with self._lock:
                while len(self._blocks) >= self._max_blocks:
                    del self._blocks[next(iter(self._blocks))]
                self._blocks[first] = block
        return block

    def _decoded(self, start: int, stop: int) -> NDArray[Any]:
        raw = self._stored(0, start, stop)
        if self._whole and self._plain.kind == "f":
            gone = np.zeros(len(raw), dtype=bool)
            for first in range(start, stop, self._chunk):
                part = slice(first - start, min(first + self._chunk, stop) - start)
                # A row is missing if any of its chunks is missing, because chunks may divide columns too.
                if not raw[part].any(axis=0).all():
                    again = self._stored(1, first, min(first + self._chunk, stop))
                    gone[part] = (again != raw[part]).reshape(len(again), -1).any(axis=1)
            raw = raw.astype(np.float64)
            raw[gone] = np.nan
        if self._scale != (1.0, 0.0):
            raw = raw * self._scale[0] + self._scale[1]
        raw = np.ascontiguousarray(raw, dtype=self._plain)
        raw.flags.writeable = False
        return raw

    def _stored(self, twin: int, start: int, stop: int) -> NDArray[Any]:
        try:
            if self._blosc:
                for key in self._chunk_keys(start, stop):
                    _check_length(self._array.store_path, key)
            return np.asarray(self._twins[twin][start:stop])
        except (MemoryError, KeyboardInterrupt):
            raise
        except Exception as error:
            if stop - start > self._chunk:  # determine which of the chunks are missing
                for first in range(start, stop, self._chunk):
                    self._stored(twin, first, min(first + self._chunk, stop))
            key = next(self._chunk_keys(start, stop))
            raise DataError(
                f"chunk {key} of array {self.name} is damaged ({first_line(error)}); copy it again, or delete it to treat"
                " its samples as missing"
            ) from None

    def _chunk_keys(self, start: int, stop: int) -> Iterator[str]:
        """Keys of the stored chunks that contain some rows."""
        rows, *columns = getattr(self._array, "shards", None) or self._array.chunks
        across = (range(-(-n // size)) for n, size in zip(self._shape, columns, strict=True))
        for place in itertools.product(range(start // rows, (stop - 1) // rows + 1), *across):
            yield self._array.metadata.encode_chunk_key(place)


def _uses_blosc(array: Any) -> bool:  # noqa: ANN401
    codecs = getattr(array.metadata, "codecs", None) or (getattr(array.metadata, "compressor", None),)
    return "blosc" in type(codecs[-1]).__name__.lower()


def _check_length(array: Any, key: str) -> None:  # noqa: ANN401
    """Raise `ValueError` for a truncated chunk of Blosc: the decoder would read beyond its end.

    Bytes 12 to 15 of a Blosc buffer are its length (C-Blosc, README_CHUNK_FORMAT).
    """
    from zarr.abc.store import RangeByteRequest
    from zarr.core.buffer import default_buffer_prototype
    from zarr.core.sync import sync

    name = f"{array.path}/{key}" if array.path else key
    head = sync(array.store.get(name, default_buffer_prototype(), RangeByteRequest(0, 16)))
    if head is None:  # not stored
        return
    size, stated = sync(array.store.getsize(name)), int.from_bytes(head.to_bytes()[12:16], "little")
    if size != stated:
        raise ValueError(f"it has {size} of {stated} bytes")


def _with_fill(array: Any, fill: float) -> Any:  # noqa: ANN401
    """A view of an array in which missing chunks read as `fill`. The attributes in the store are not changed."""
    import zarr

    wrapped = array.async_array
    metadata = replace(array.metadata, fill_value=array.dtype.type(fill))
    return zarr.Array(type(wrapped)(metadata=metadata, store_path=array.store_path, config=wrapped.config))
