"""Files in folders of logs: which are read, and which are skipped. The rule is the same for all commands.

A file that is named is a log, whatever it contains. Of the files in a folder, or of a pattern in quotes, hidden ones are
ignored; results of sigmatau, stores, pictures, documents and prose are skipped; all others are logs. An empty file is a
log without samples, which fails like a damaged one: a unit was tested, and its record is missing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.formats.split import bag_files
from sigmatau.io.read.registry import NOT_LOGS
from sigmatau.io.written import is_result
from sigmatau.results import printable

_PICTURES = (b"\xff\xd8\xff", b"\x89PNG", b"GIF8", b"%PDF")
_SQLITE, _BAG = b"SQLite format 3\0", ".db3"  # databases are stores of results, unless they are bags
_SQLITE_ENDS = ("-wal", "-shm", "-journal")  # of files beside an open database
# Suffixes of tables and of binary logs: such a file counts as a log even if it is damaged or has no numbers, so that it
# fails and is not skipped like prose.
_TABLES = (".csv", ".tsv", ".dat", ".gz", ".xlsx", ".lvm")
_BINARY = (".npy", ".npz", ".mat", ".h5", ".hdf5", ".parquet", ".arrow", ".tdms", ".bag", ".mcap", ".ulg", ".bin")
_HEAD = 1 << 16  # number of bytes that are read to decide whether a file is a log
_LISTED = 10  # largest number of skipped files that are named


def gather(places: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Collect the logs, including those in folders and subfolders, sorted by name, and the files that are skipped.

    A log that is named directly and in a folder is read once.
    """
    named = [place for place in places if is_single(place)]
    logs: dict[Path, Path] = {}  # logs by resolved path
    skipped: list[Path] = []
    for place in places:
        if is_single(place):
            if named.count(place) > 1:
                raise OptionError(f"{place} is given twice", option="log")
            logs.setdefault(_resolved(place), place)
            continue
        files = list(_files(place, ()))
        inside = [file for file in files if is_log(file)]
        if not inside:
            raise DataError(f"{place}: no log in this folder or its subfolders")
        for log in inside:
            logs.setdefault(_resolved(log), log)
        skipped += [file for file in files if file not in {*inside}]
    asked = {_resolved(place) for place in named}
    return list(logs.values()), [file for file in skipped if _resolved(file) not in asked]


def is_single(place: Path) -> bool:
    """Whether a path is one log: a file, or the folder of a ROS 2 bag or of a Zarr store."""
    return not place.is_dir() or bool(bag_files(place))


def is_log(file: Path) -> bool:
    """Whether a file of a folder is read as a log, and not skipped."""
    if file.is_dir():
        return True
    if file.exists() and not file.is_file():  # opening a pipe would wait for a writer
        return False
    suffix = file.suffix.lower()
    if suffix in NOT_LOGS or file.name.endswith(_SQLITE_ENDS):
        return False
    try:
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except OSError:
        return True  # the reader reports why it cannot be read
    if not head:
        return True  # the reader reports that it is empty
    if head.startswith(_PICTURES) or (head.startswith(_SQLITE) and suffix != _BAG) or is_result(file):
        return False
    if suffix in (*_TABLES, *_BINARY) or b"\0" in head:
        return True
    # A log has a line of mostly digits in its first 64 KiB; prose has none.
    return any(3 * sum(48 <= byte <= 57 for byte in line) >= len(line.strip()) > 0 for line in head.splitlines())


def is_empty(log: Path) -> bool:
    """Whether a log is a file without any byte."""
    try:
        return log.is_file() and log.stat().st_size == 0
    except OSError:
        return False


def skipped_lines(skipped: Sequence[Path]) -> list[str]:
    """What a command says of the skipped files: the first ones by name, and the number of results of sigmatau.

    Examples
    --------
    >>> from pathlib import Path
    >>> skipped_lines([Path("README.txt"), Path("spec.toml")])
    ['skipped, not a log: README.txt, spec.toml']
    """
    foreign = [str(file) for file in skipped if not is_result(file)]
    lines = []
    if foreign:
        rest = f" and {len(foreign) - _LISTED} more" if len(foreign) > _LISTED else ""
        lines.append(f"skipped, not a log: {', '.join(map(printable, foreign[:_LISTED]))}{rest}")
    if results := len(skipped) - len(foreign):
        lines.append(f"skipped, written by sigmatau: {results} file{'s' if results > 1 else ''}")
    return lines


def _resolved(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):  # a loop of links; the reader reports it
        return path.absolute()


def _files(folder: Path, above: tuple[Path, ...]) -> Iterator[Path]:
    """Files of a folder and its subfolders, without hidden files; links to a parent folder are not followed."""
    above = (*above, _resolved(folder))
    try:
        entries = sorted(entry for entry in folder.iterdir() if not entry.name.startswith("."))
    except OSError as error:
        raise DataError(f"{folder}: cannot be read: {error.strerror or error}") from None
    yield from (entry for entry in entries if entry.is_file() or is_single(entry))
    for entry in entries:
        if not is_single(entry) and entry.is_dir() and _resolved(entry) not in above:
            yield from _files(entry, above)
