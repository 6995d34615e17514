"""`read`: a file as a `Record`."""

from __future__ import annotations

import contextlib
import os
import stat
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.findings.wording import sentence
from sigmatau.io.read import assemble
from sigmatau.io.read.assemble import choose_tables
from sigmatau.io.read.formats import split
from sigmatau.io.read.formats.damage import expansion_limit
from sigmatau.io.read.instances import state_single_sensor
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.registry import find_reader, may_need_translation, require_text
from sigmatau.io.read.repeated_clocks import separate_clocks
from sigmatau.io.read.table import HEAD, Head, Table
from sigmatau.io.read.thermometers import split_thermometers
from sigmatau.io.read.turn_tables import separate_turns
from sigmatau.options import keywords_of, stated
from sigmatau.record.record import Record

_GZIP = b"\x1f\x8b"


@keywords_of(ReadOptions)
def read(path: str | os.PathLike[str], options: ReadOptions) -> Record:
    """Read a static record from a file.

    The format is detected from the content: text tables (comma, semicolon, tab or spaces; with or without a header),
    names with values (``ax:0.01``), JSON, LabVIEW ``.lvm``, the output of ``ros2 topic echo`` (these texts also as
    ``.gz``, or several in a zip archive), Excel ``.xlsx``, VectorNav lines, NovAtel RAWIMU, MCAP, ROS 1 and 2 bags, PX4 and
    ArduPilot flight logs, MATLAB, HDF5, Zarr, Parquet, Arrow, TDMS, ``.npy`` and ``.npz``. Raw binary files need
    `layout`. Columns are recognised by common names, units are taken from the file, and the rate from the time stamps.
    Nothing is guessed: information that the file does not state must be given by an option.

    Parameters
    ----------
    path : str or path
        The file; or the folder of a ROS 2 bag, whose parts are joined; or the folder or URL of a Zarr store.

    Returns
    -------
    Record
        Streams ``gyro`` (rad/s), ``accel`` (m/s²) and one for each signal (in its own unit); each channel of shape
        (n,), NaN where a value is missing or infinite. `Record.provenance` lists the conversions, `Record.findings`
        the faults of the file and of its time stamps.

    Raises
    ------
    OptionError
        If an option is missing (no rate, no unit, no column recognised, rows that may be of several sensors) or wrong.
    DataError
        If the file is missing, empty, damaged or of an unknown format; if a row has another length or contains a
        non-numeric value; if time goes backwards.
    NonFiniteError
        If more than half of the rows have no time stamp.
    RecordTooShortError
        For fewer than 4 samples.

    See Also
    --------
    from_frame : a record from a data frame.
    inspect : the contents of a file.
    write : writes a record.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import sigmatau as st
    >>> model = st.NoiseModel(channels={"gyro_x": {"random_walk": 1e-4}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     log = pathlib.Path(folder) / "log.csv"
    ...     _ = st.simulate_to(log, model, duration=10, rate=100, rng=1)
    ...     record = st.read(log)
    >>> record
    Record of 1 stream
      gyro: gyro_x [rad/s], 1000 samples at 100 Hz (10 s)
    """
    checked = options.checked()
    with opened(path, options) as (file, tables):
        tables = separate_turns(tables, checked)
        chosen, thermometer = split_thermometers(tables, choose_tables(tables, checked.topic, checked.channels))
        record = assemble.assemble(chosen, file, checked, thermometer)
    source = record.provenance if file is not None else replace(record.provenance, path=os.fsdecode(path))
    return replace(record, provenance=replace(source, options=stated(options)))


@contextlib.contextmanager
def opened(path: str | os.PathLike[str], options: ReadOptions) -> Iterator[tuple[Path | None, Sequence[Table]]]:
    """A file (None for a URL) and its tables; errors are prefixed with the name of the file."""
    single = options.interleaved == 1
    with expansion_limit(options.max_expansion), state_single_sensor(single=single):
        yield from _opened(os.fsdecode(path), options.layout, int(options.skip))


def _opened(name: str, layout: str | None, skip: int) -> Iterator[tuple[Path | None, Sequence[Table]]]:
    tables: Sequence[Table] = ()
    try:
        if "://" in name:
            yield None, _zarr_tables(name, layout, skip)
            return
        file = Path(name)
        if "\0" not in name and split.zarr_head(file):
            yield file, (tables := _zarr_tables(name, layout, skip))
            return
        files = () if "\0" in name else split.bag_files(file)
        if len(files) > 1:
            tables = split.joined(file, files, lambda part: _tables(part, skip))
        else:
            file = _regular(os.fsdecode(files[0]) if files else name)
            tables = _tables(file, skip) if layout is None else _raw(file, layout, skip)
            if missing := split.missing_parts(file):
                tables = [replace(table, findings=(*table.findings, *missing)) for table in tables]
        yield file, tables
    except OSError as error:
        raise DataError(f"cannot be read: {error.strerror or error}").about(name) from None
    except MemoryError:
        what = "does not fit in memory; cut it, or save it as .npy, which is not loaded whole"
        raise DataError(what).about(name) from None
    except OptionError as error:
        damage = [finding for table in tables for finding in table.findings if finding.severity == "error"]
        if damage:  # the lost part may have contained the requested columns, and no option restores them
            raise DataError(f"{error} (the file is damaged: {sentence(damage[0])})").about(name) from None
        raise error.about(name) from None
    except DataError as error:
        raise error.about(name).with_traceback(None) from None


def _tables(file: Path, skip: int) -> Sequence[Table]:
    head = _head(_regular(os.fsdecode(file)))
    if skip:
        from sigmatau.io.read.formats import text

        require_text(head, file)
        return separate_clocks(text.read(file, head, skip=skip))
    tables: Sequence[Table] = ()
    if may_need_translation(head.data):
        from sigmatau.io.read.formats.translations import read_translated

        tables = read_translated(file, head)
    tables = separate_clocks(tables or find_reader(head, file).read(file, head))
    if len(tables) != 1 or tables[0].format == "text":
        return tables  # the reader of text separates the rows itself
    from sigmatau.io.read.instance_tables import separate_instances

    return separate_instances(tables)


def _zarr_tables(place: str, layout: str | None, skip: int) -> Sequence[Table]:
    for option, files in (("layout", "raw binary files"), ("skip", "text tables")):
        if layout if option == "layout" else skip:
            raise OptionError(f"{{option}} is for {files}, and this is a Zarr store", option=option)
    from sigmatau.io.read.formats import zarr_store

    return zarr_store.read(place)


def _raw(file: Path, layout: str, skip: int) -> Sequence[Table]:
    if skip:
        raise OptionError("{option} is for text tables; skip bytes by `header` in the layout", option="skip")
    from sigmatau.io.read.formats import raw

    return raw.read(file, _head(file), layout)


def _regular(name: str) -> Path:
    if "\0" in name:
        raise DataError("a file name cannot contain a null character")
    file = Path(name)
    try:
        mode = file.stat().st_mode
    except FileNotFoundError:
        raise DataError("there is no such file") from None
    if stat.S_ISDIR(mode):
        raise DataError("is a directory; give the file in it")
    if not stat.S_ISREG(mode):
        raise DataError("is not a regular file (a pipe, a socket or a device); save the data to a file first")
    return file


def _head(file: Path) -> Head:
    with file.open("rb") as stream:
        data = stream.read(HEAD + 1)
        if not data:
            raise DataError("is empty")
        if not data.startswith(_GZIP):
            return Head(data=data[:HEAD], whole=len(data) <= HEAD, gzip=False)
        unpacked = b""
        decoder = zlib.decompressobj(31)
        try:
            while data and len(unpacked) <= HEAD:
                unpacked += decoder.decompress(data, HEAD + 1 - len(unpacked))
                if decoder.eof:  # several compressed files may be joined
                    data = decoder.unused_data
                    decoder = zlib.decompressobj(31)
                else:
                    data = decoder.unconsumed_tail
                data = data or stream.read(HEAD)
        except zlib.error:
            if not unpacked:
                raise DataError("the compressed data are damaged; copy or record the file again") from None
    if not unpacked:
        raise DataError("is empty after decompression, or is truncated; copy or record the file again")
    return Head(data=unpacked[:HEAD], whole=len(unpacked) <= HEAD, gzip=True)
