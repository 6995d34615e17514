"""The bytes of a live log as they arrive: on standard input, at the end of a growing file, or on a serial port."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import closing, nullcontext
from pathlib import Path
from typing import IO, Any

from sigmatau.errors import DataError

BAUD = 115200
"""Usual speed of a serial port. [bit/s]"""

_PIECE = 1 << 18  # size of a read [bytes]
_PAUSE = 0.05  # pause before a source without new data is read again [s]
_WAITING = 64  # number of pieces that may be read ahead
# The same for a serial port, whose pieces are short: the system buffers 4 kB of an unread port, and then loses data.
_WAITING_OF_PORT = 1 << 14

_LONGEST_START = 1 << 14  # size of what may arrive from a port before the first end of a line [bytes]
_NEEDS = "a serial port needs pyserial: pip install 'sigmatau[serial]'"

Pieces = queue.Queue["bytes | Exception | None"]


def follow(
    source: str, *, every: float, idle: float | None = None, baud: int | None = None, save: Path | None = None
) -> Iterator[bytes]:
    """Yield the bytes of standard input, of a growing file or of a serial port as they arrive.

    Parameters
    ----------
    source : str
        ``-`` for standard input, the name of a file, or of a serial port if `baud` is given.
    every : float
        An empty piece is yielded after this time without data. [s]
    idle : float, optional
        Time without data after which the input ends. Default: the end of standard input; files and ports have none. [s]
    baud : int, optional
        Speed of the serial port. Data before the first line end are discarded, because they are part of a line. [bit/s]
    save : Path, optional
        A new file to which every piece is written before it is yielded. The last line of a port is removed at the end if
        it is not complete.

    Raises
    ------
    DataError
        If the source cannot be read, a file becomes shorter or is replaced, or `save` exists or cannot be written.
    ImportError
        If a port is to be read and pyserial is not installed.
    """
    pieces: Pieces = queue.Queue(_WAITING if baud is None else _WAITING_OF_PORT)
    stop = threading.Event()
    # Opened here, so that an error is raised before anything is read.
    opened = _opened(source, baud)
    last = time.monotonic()
    try:
        opened_copy = nullcontext() if save is None else closing(_Copy(save, whole_lines=baud is not None))
    except DataError:
        opened.close()
        raise
    with opened_copy as copy:
        reader = threading.Thread(target=_read_all, args=(source, opened, pieces, stop), daemon=True)
        reader.start()
        has_read = source == "-"  # a read of standard input returns with data only
        try:
            while True:
                try:
                    piece = pieces.get(timeout=every if idle is None else min(every, idle))
                except queue.Empty:
                    if idle is not None and has_read and time.monotonic() - last > idle:
                        return
                    yield b""
                    continue
                if piece is None:
                    return
                if isinstance(piece, Exception):
                    raise piece
                has_read = True
                if not piece:
                    continue
                last = time.monotonic()
                if copy is not None:
                    copy.write(piece)
                yield piece
        finally:
            stop.set()
            if source != "-":  # a read of standard input may wait for ever
                reader.join()


def serial_ports() -> list[tuple[str, str]]:
    """Name and description of each serial port of this computer; the description may be empty.

    Raises
    ------
    ImportError
        If pyserial is not installed.
    """
    try:
        from serial.tools import list_ports  # type: ignore[import-untyped, unused-ignore]
    except ImportError:
        raise ImportError(_NEEDS) from None
    ports = sorted((port.device, port.description or "") for port in list_ports.comports())
    return [(device, "" if text == "n/a" else text) for device, text in ports]


class _StandardInput:
    def read(self) -> bytes | None:
        return os.read(sys.stdin.fileno(), _PIECE) or None

    def close(self) -> None:
        """Leave standard input open."""


class _File:
    """The bytes that are appended to a file."""

    def __init__(self, source: str) -> None:
        self.name = source
        self.file = Path(source).open("rb")  # noqa: SIM115  closed by `close`

    def read(self) -> bytes | None:
        piece = self.file.read(_PIECE)
        if not piece:
            self._check_same()
        return piece

    def _check_same(self) -> None:
        """Raise `DataError` if the file was emptied, or replaced by a new one, as loggers do that begin a new file."""
        followed = os.fstat(self.file.fileno())
        if followed.st_size < self.file.tell():
            raise DataError(f"{self.name}: has become shorter while it was read. Start again to follow its new content")
        try:
            replaced = not os.path.samestat(followed, os.stat(self.name))  # noqa: PTH116  Path.stat is slower
        except OSError:  # it was renamed, and there is no new file yet
            return
        if replaced:
            raise DataError(f"{self.name}: was replaced by a new file. Start again to follow the new one")

    def close(self) -> None:
        self.file.close()


class _Port:
    """A serial port from its first end of a line."""

    def __init__(self, source: str, baud: int) -> None:
        try:
            import serial  # type: ignore[import-untyped, unused-ignore]
        except ImportError:
            raise ImportError(_NEEDS) from None
        self.name = source
        self.began = False
        self.skipped = 0
        try:
            self.port: Any = serial.Serial(source, baud, timeout=_PAUSE, exclusive=True)
        except (OSError, ValueError) as error:
            raise DataError(f"{source}: the serial port cannot be opened: {_reason(error)}") from None

    def read(self) -> bytes | None:
        try:
            piece: bytes = self.port.read(max(1, min(self.port.in_waiting, _PIECE)))
        except OSError as error:
            reason = _reason(error)
            raise DataError(
                f"{self.name}: the serial port is gone: {reason}. Check its cable, then start again"
            ) from None
        if not self.began:
            start, end, piece = piece.partition(b"\n")
            self.began = bool(end)
            self.skipped += len(start)
            if self.skipped > _LONGEST_START and not self.began:
                raise DataError(f"{self.name}: {self.skipped} bytes have no end of a line. Check the baud rate")
        return piece

    def close(self) -> None:
        self.port.close()


def _reason(error: Exception) -> str:
    return os.strerror(number) if (number := getattr(error, "errno", None)) else str(error)


def _opened(source: str, baud: int | None) -> _StandardInput | _File | _Port:
    if source == "-":
        return _StandardInput()
    if baud is not None:
        return _Port(source, baud)
    try:
        return _File(source)
    except OSError as error:
        raise DataError(f"{source}: cannot be read: {error.strerror or error}") from None


def _read_all(source: str, opened: _StandardInput | _File | _Port, pieces: Pieces, stop: threading.Event) -> None:
    """Put the data that arrive into the queue, and the result of the first read even if it is empty; None at the end, an
    error if reading fails.
    """
    first = True
    try:
        while not stop.is_set():
            piece = opened.read()
            if piece is None:
                _put(pieces, None, stop)
                return
            if piece or first:
                _put(pieces, piece, stop)
            if not piece:
                time.sleep(_PAUSE)
            first = False
    except DataError as error:
        _put(pieces, error, stop)
    except OSError as error:
        _put(pieces, DataError(f"{source}: cannot be read: {error.strerror or error}"), stop)
    finally:
        opened.close()


def _put(pieces: Pieces, piece: bytes | Exception | None, stop: threading.Event) -> None:
    while not stop.is_set():
        try:
            pieces.put(piece, timeout=0.2)
        except queue.Full:
            continue
        return


def _new(path: Path) -> IO[bytes]:
    try:
        return path.open("xb", buffering=0)
    except FileExistsError:
        raise DataError(f"{path}: exists, and a record is never overwritten; give the name of a new file") from None
    except OSError as error:
        raise DataError(f"{path}: cannot be written: {error.strerror or error}") from None


class _Copy:
    """A new file of what arrives; with `whole_lines`, a line that was cut by the end of the record is removed."""

    def __init__(self, path: Path, *, whole_lines: bool) -> None:
        self._file = _new(path)
        self._size = 0
        self._end_of_lines = 0
        self._whole_lines = whole_lines

    def write(self, piece: bytes) -> None:
        end = piece.rfind(b"\n")
        if end >= 0:
            self._end_of_lines = self._size + end + 1
        try:
            self._file.write(piece)
        except OSError as error:
            raise DataError(f"{self._file.name}: cannot be written any more: {error.strerror or error}") from None
        self._size += len(piece)

    def close(self) -> None:
        if self._whole_lines and 0 < self._end_of_lines < self._size:
            self._file.truncate(self._end_of_lines)
        self._file.close()
