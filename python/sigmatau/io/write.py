"""Write records as tables, piece by piece, so that the data need not fit in memory. There is one writer per format.

Each writer takes the names and units of the columns, then pieces of all columns. The number of rows is unknown until
the end.
"""

from __future__ import annotations

import contextlib
import gzip
import io
import shutil
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np

from sigmatau._native import formats
from sigmatau.errors import DataError, OptionError
from sigmatau.io import write_bags
from sigmatau.io.atomic import PARTS, atomic
from sigmatau.io.write_bags import Piece, Put
from sigmatau.record.record import Record
from sigmatau.record.streams import CHUNK

_ROWS = 1 << 16  # number of rows of a row group


def column_headers(columns: Sequence[tuple[str, str]]) -> list[str]:
    """Names of columns with their units: ``"gyro_x [rad/s]"``."""
    return [f"{name} [{unit}]" for name, unit in columns]


def _lines(stream: IO[bytes], columns: Sequence[tuple[str, str]]) -> Put:
    for name, unit in columns:
        for mark in ',"\n':
            if mark in name or mark in unit:
                where = "name" if mark in name else "unit"
                raise DataError(
                    f"the channel {name!r} cannot be written in this format, because of {mark!r} in its {where}"
                )
    stream.write((",".join(column_headers(columns)) + "\n").encode())

    def put(piece: Piece) -> None:
        stream.write(formats.format_text(",", piece))

    return put


@contextlib.contextmanager
def _csv(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Text. Each number has the fewest digits that read back to the same bits."""
    with path.open("wb") as stream:
        yield _lines(stream, columns)


@contextlib.contextmanager
def _csv_gz(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A CSV file in gzip. No time is stored in it, so that the same numbers give the same bytes."""
    with (
        path.open("wb") as stream,
        gzip.GzipFile("", "wb", compresslevel=6, fileobj=stream, mtime=0) as packed,
        io.BufferedWriter(packed, 1 << 20) as buffer,
    ):
        yield _lines(buffer, columns)


@contextlib.contextmanager
def _npy(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """A structured array. Each column is a field, named with its unit."""
    dtype = np.dtype([(header, "<f8") for header in column_headers(columns)])
    rows = 0

    def put(piece: Piece) -> None:
        nonlocal rows
        table = np.empty(len(piece[0]), dtype=dtype)
        for name, values in zip(dtype.names or (), piece, strict=True):
            table[name] = values
        stream.write(table.data)
        rows += len(table)

    with path.open("wb") as stream:
        stream.write(_npy_head(dtype, 0))
        yield put
        stream.seek(0)
        stream.write(_npy_head(dtype, rows))


def _npy_head(dtype: np.dtype[Any], rows: int) -> bytes:
    """The header of an array with this number of rows. NumPy pads it, so its length does not depend on the number."""
    memory = io.BytesIO()
    np.save(memory, np.empty(0, dtype=dtype), allow_pickle=False)
    empty = memory.getvalue()
    before, mark, _ = empty.rpartition(b"(0,)")
    written = before + mark.replace(b"0", str(rows).encode()) + b", }"
    if len(written) >= len(empty):
        raise OverflowError(f"the head of an array has no room for {rows} rows")
    return written + b" " * (len(empty) - len(written) - 1) + b"\n"


@contextlib.contextmanager
def _npz(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """One array per column, named with its unit. The arrays are written to separate files until all rows are there."""
    headers = column_headers(columns)
    dtype = np.dtype("<f8")
    rows = 0
    folder = path.with_name(path.name + PARTS)
    folder.mkdir()
    with contextlib.ExitStack() as open_:
        open_.callback(shutil.rmtree, folder, ignore_errors=True)
        parts = [folder / str(k) for k in range(len(headers))]
        streams = [open_.enter_context(part.open("wb")) for part in parts]

        def put(piece: Piece) -> None:
            nonlocal rows
            for stream, values in zip(streams, piece, strict=True):
                stream.write(np.ascontiguousarray(values, dtype=dtype).data)
            rows += len(piece[0])

        yield put
        for stream in streams:
            stream.close()
        with zipfile.ZipFile(path, "w", zipfile.ZIP_STORED, allowZip64=True) as archive:
            for header, part in zip(headers, parts, strict=True):
                member = zipfile.ZipInfo(f"{header}.npy")  # dated 1980, so that the same numbers give the same bytes
                with archive.open(member, "w", force_zip64=True) as packed, part.open("rb") as stored:
                    packed.write(_npy_head(dtype, rows))
                    shutil.copyfileobj(stored, packed, 1 << 20)
                part.unlink()


@contextlib.contextmanager
def _parquet(path: Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Columns named with their unit, in pages with checksums."""
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise DataError(
            "writing .parquet needs a library that is not installed: pip install 'sigmatau[parquet]'"
        ) from None
    schema = pa.schema([pa.field(header, pa.float64(), nullable=False) for header in column_headers(columns)])
    with pq.ParquetWriter(path, schema, use_dictionary=False, compression="snappy", write_page_checksum=True) as writer:

        def put(piece: Piece) -> None:
            writer.write_batch(pa.record_batch([pa.array(values) for values in piece], schema=schema), _ROWS)

        yield put


_Writer = Callable[[Path, Sequence[tuple[str, str]]], contextlib.AbstractContextManager[Put]]
_TABLES: dict[str, _Writer] = {
    ".csv": _csv,
    ".csv.gz": _csv_gz,
    ".npy": _npy,
    ".npz": _npz,
    ".parquet": _parquet,
}
_BAGS: dict[str, _Writer] = {".bag": write_bags.bag, ".mcap": write_bags.mcap, ".db3": write_bags.db3}
WRITERS = {**_TABLES, **_BAGS}
"""By the ending of the file's name. Columns are named with their units, as ``"gyro_x [rad/s]"``."""

TABLE_ENDINGS = tuple(_TABLES)  # Endings of files that may have any columns
RECORD_ENDINGS = tuple(WRITERS)  # Endings of a record's file name, each with its format


@contextlib.contextmanager
def table_writer(path: str | Path, columns: Sequence[tuple[str, str]]) -> Iterator[Put]:
    """Open a table that is written piece by piece. The file exists under its name only if the block succeeds.

    `path`: its ending is one of `RECORD_ENDINGS`.
    """
    target = Path(path)
    ending = find_ending(target)
    _check_names(columns)
    with contextlib.ExitStack() as stack:
        temporary = stack.enter_context(atomic(target))
        yield stack.enter_context(WRITERS[ending](temporary, columns))


def _check_names(columns: Sequence[tuple[str, str]]) -> None:
    """Raise `DataError` for names that the reader would not return unchanged, whatever the format."""
    from sigmatau.io.read.names import LONGEST_NAME, recognise
    from sigmatau.io.read.table import Column

    headers = column_headers(columns)
    taken: dict[str, str] = {}
    for (name, unit), header, match in zip(columns, headers, recognise([Column(name=h) for h in headers]), strict=True):
        if not name.strip():
            raise DataError(f"a channel needs a name to be written, and one has {name!r}")
        if not header.isprintable():
            raise DataError(
                f"the channel {name!r} in {unit!r} cannot be written: its name and unit must be printable text"
            )
        if len(header) > LONGEST_NAME:
            raise DataError(
                f"the channel {name[:20]!r}… cannot be written: with its unit the name has {len(header)} characters, and"
                f" at most {LONGEST_NAME} are allowed"
            )
        means = match[0] if match else name
        if means in taken:
            raise DataError(
                f"the channel {name!r} cannot be written together with {taken[means]!r}: a reader reads both as {means};"
                " give the channel another name"
            )
        taken[means] = name


def find_ending(path: Path) -> str:
    """Find the ending of a name among `RECORD_ENDINGS`. Raises `OptionError` if there is none."""
    ending = next((e for e in sorted(RECORD_ENDINGS, key=len, reverse=True) if path.name.endswith(e)), None)
    if ending is None:
        raise OptionError(f"{path}: a record is written as {', '.join(RECORD_ENDINGS)}", option="output")
    return ending


def write(record: Record, path: str | Path) -> None:
    """Write a record as a table: time and every channel, rates in SI, with units in the names.

    Parameters
    ----------
    record : Record
        All streams on one grid.
    path : str or Path
        ``.csv``, ``.csv.gz`` (shortest digits that read back to the same bits), ``.npy`` (a structured array, one field
        per channel), ``.npz`` (one array per channel), ``.parquet``. For a gyro, an accelerometer, or both, with three
        axes: ``.bag`` (ROS 1), ``.mcap`` and ``.db3`` (ROS 2), ``sensor_msgs/Imu`` on ``/imu``.

    Raises
    ------
    OptionError
        For another ending.
    DataError
        If the streams have different grids, the file cannot be written, or a library is not installed that the format needs.

    See Also
    --------
    read : reads the file.
    simulate_to : simulates into a file.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> record = st.simulate(model, duration=10, rate=100, rng=1)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     log = pathlib.Path(folder) / "log.csv"
    ...     st.write(record, log)
    ...     again = st.read(log)
    >>> bool((again.streams[0].column("gyro_x") == record.streams[0].column("gyro_x")).all())
    True
    """
    target = Path(path)
    find_ending(target)
    grid = record.streams[0].grid
    if any(s.grid.n != grid.n or s.grid.tau0 != grid.tau0 for s in record.streams):
        raise DataError("streams with different grids do not fit in one table; write them one by one")
    columns = [("time", "s"), *((channel, s.unit) for s in record.streams for channel in s.channels)]
    with table_writer(target, columns) as put:
        for start in range(0, grid.n, CHUNK):
            stop = min(start + CHUNK, grid.n)
            # Times are written as k/rate, which prints short (0.07); k·tau0 does not (0.07000000000000001).
            piece = [grid.start + np.arange(start, stop) / grid.rate]
            for stream in record.streams:
                piece += [stream.samples.read(k, start, stop) for k in range(len(stream.channels))]
            put(piece)
