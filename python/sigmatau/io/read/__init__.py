"""Reading: any log in, one `Record` out.

Which reader a file needs is found by `known`; the reader hands over columns. All that follows is common to all formats:
which column is which channel (`columns`), the sampling rate (`stamps`), units and the record itself (`assemble`).
"""

from __future__ import annotations

import contextlib
import os
import stat
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import assemble
from sigmatau.io.read.formats import split
from sigmatau.io.read.options import Options
from sigmatau.io.read.registry import reader_of
from sigmatau.io.read.table import HEAD, Head, Table
from sigmatau.io.read.topics import choose_tables
from sigmatau.record.record import Record
from sigmatau.record.streams import InputKind

__all__ = ["opened", "read"]

_GZIP = b"\x1f\x8b"


def read(
    path: str | os.PathLike[str],
    *,
    rate: float | None = None,
    unit: Mapping[str, str] | None = None,
    channels: Mapping[str, str | int] | None = None,
    input: InputKind = "rate",  # noqa: A002  the word users know from --input
    scale: Mapping[str, float] | None = None,
    offset: Mapping[str, float] | None = None,
    topic: str | Sequence[str] | None = None,
    layout: str | None = None,
) -> Record:
    """The static record that a file holds.

    What it is, is told by its content: text tables (comma, semicolon, tab or spaces; with or without a header; ``.gz`` too,
    or several in a zip archive), VectorNav lines, NovAtel RAWIMU, MCAP, ROS 1 and 2 bags, PX4 and ArduPilot flight logs,
    MATLAB, HDF5, Parquet, Arrow, TDMS, ``.npy`` and ``.npz``; raw binary files need `layout`. Columns are recognised by the
    names that people use, units by what the file says, the rate by the time stamps; what the file does not say is asked
    for, never guessed.

    Parameters
    ----------
    path : str or path
        The file; or the folder of a ROS 2 bag, whose parts are read as one.
    rate : float, optional
        Sampling rate, if the file has no time column or its stamps are not to be trusted. [Hz]
    unit : mapping, optional
        Unit by channel (``"gyro_x"``), by sensor (``"gyro"``, ``"accel"``) or of the stamps (``"time"``), for what the
        file does not say; it also overrules the file. A signal may have any unit, ``"1"`` for none.
    channels : mapping, optional
        Channel to column: a name, a number counted from 1, or three numbers for a sensor, e.g. ``{"time": "stamp",
        "gyro_x": 2, "accel": "5:7", "phase": "x"}``. Names that do not begin with ``gyro`` or ``accel`` are signals.
        Then only these are read, and a time column that is recognised; a mapping of ``"time"`` alone leaves the sensors
        to be recognised, and ``"none"`` for it leaves the stamps out, for a file whose stamps are wrong. By default all are.
    input : {"rate", "increments", "accumulated"}
        What the numbers are: rates; the angle or velocity of one sample interval; or their running sum, of which N points
        give N-1 rates.
    scale, offset : mapping, optional
        By channel or sensor, for counts or volts: value = (raw - offset) * scale, in the stated unit. A scale is taken for
        ``"time"`` too.
    topic : str or sequence of str, optional
        Which of the topics, messages or variables of a file that holds several; one, or one for each sensor. By default the
        only one that has a gyro and an accelerometer by the names of its columns, or the only one of each.
    layout : str, optional
        Of a raw binary file: the fields of a row, in order, such as ``"<u4 time[us],3f4 gyro[rad/s],3f4 accel[m/s^2]"``.
        A field is how many (if several), a type as NumPy names it (i1 to i8, u1 to u8, f4, f8), a name, and a unit in
        brackets if it has one; three of a name are its x, y and z. ``<`` is the low byte first, as nearly always, ``>`` the
        high one, for all fields that follow. ``4x`` passes four bytes over; ``header 512`` in front passes over what stands
        before the first row.

    Returns
    -------
    Record
        Streams ``gyro`` (rad/s), ``accel`` (m/s²) and each signal by itself (its own unit); each channel of shape (n,).
        `Record.provenance` says what was done, `Record.findings` what looks wrong with the stamps.

    Raises
    ------
    OptionError
        If something must be said that the file does not say (no rate, no unit, no column recognised), or was said wrongly.
    DataError
        If the file cannot be read or used: missing, empty, damaged, of an unknown format; a row of another length; a word
        among the numbers; time going backwards. Its children are `NonFiniteError` for an infinity and
        `RecordTooShortError`.
    """
    options = Options.check(
        rate=rate, unit=unit, channels=channels, input=input, scale=scale, offset=offset, topic=topic
    )
    with opened(path, layout) as (file, tables):
        return assemble.assemble(choose_tables(tables, options.topic), file, options)


@contextlib.contextmanager
def opened(path: str | os.PathLike[str], layout: str | None = None) -> Iterator[tuple[Path, Sequence[Table]]]:
    """A file and its tables; errors on the way get the name of the file."""
    name = os.fsdecode(path)
    tables: Sequence[Table] = ()
    try:
        file = Path(name)
        files = () if "\0" in name else split.files_of(file)
        if len(files) > 1:
            tables = split.joined(file, files, _tables)
        else:
            file = _regular(os.fsdecode(files[0]) if files else name)
            tables = _tables(file) if layout is None else _raw(file, layout)
            if beside := split.part_of(file):
                tables = [replace(table, findings=(*table.findings, *beside)) for table in tables]
        yield file, tables
    except OSError as error:
        raise DataError(f"{name}: cannot be read: {error.strerror or error}") from None
    except MemoryError:
        raise DataError(
            f"{name}: does not fit in memory; cut it, or save it as .npy, which is not loaded whole"
        ) from None
    except OptionError as error:
        lost = [f.message for table in tables for f in table.findings if f.severity == "error"]
        if lost:  # what was asked for may have been in what is lost: no option can mend that
            raise DataError(f"{name}: {lost[0]}; of what is left: {error}") from None
        raise error.about(name) from None
    except DataError as error:
        raise error.about(name).with_traceback(None) from None


def _tables(file: Path) -> Sequence[Table]:
    head = _head(_regular(os.fsdecode(file)))
    return reader_of(head, file).read(file, head)


def _raw(file: Path, layout: str) -> Sequence[Table]:
    from sigmatau.io.read.formats import raw

    return raw.read(file, _head(file), layout)


def _regular(name: str) -> Path:
    if "\0" in name:
        raise DataError("no file has such a name")
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
                if decoder.eof:  # one of several compressed files, one after the other
                    data = decoder.unused_data
                    decoder = zlib.decompressobj(31)
                else:
                    data = decoder.unconsumed_tail
                data = data or stream.read(HEAD)
        except zlib.error:
            if not unpacked:
                raise DataError("the compressed data are damaged; get or make the file again") from None
    if not unpacked:
        raise DataError("holds nothing once decompressed, or is cut off; get or make the file again")
    return Head(data=unpacked[:HEAD], whole=len(unpacked) <= HEAD, gzip=True)
