"""Logs of a fleet: files and objects by pattern, with a version that shows whether they have changed."""

from __future__ import annotations

import glob
import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen


@frozen
class Log:
    """A log, in a form that a worker can locate."""

    place: str  # path or URL
    size: int | None  # size; None if the storage does not state it [bytes]
    changed: str  # time of the last change, or tag of the object, as text

    @property
    def version(self) -> str:
        """Version of the content, as text: size and last change."""
        return f"{self.size}/{self.changed}"


def find(patterns: Iterable[str], *, skip: Callable[[str], None] | None = None) -> list[Log]:
    """List the logs of paths, patterns (``logs/**/*.csv``) and URLs (``s3://bucket/night*``), each once, sorted by name.

    Parameters
    ----------
    patterns : iterable of str
        A folder includes all logs below it. Zarr stores and ROS 2 bags are folders that count as one log.
    skip : callable, optional
        Is called with the place of each file of a folder or pattern that is not a log, see `sigmatau.io.folders`; objects
        are distinguished by their names alone.

    Raises
    ------
    DataError
        For a pattern without a log, or a place that cannot be listed.
    OptionError
        Without a pattern.
    ImportError
        For a URL without fsspec or the package of its protocol.
    """
    logs_by_place: dict[str, Log] = {}
    pattern_list = list(patterns)
    if not pattern_list:
        raise OptionError("name logs, patterns such as 'logs/**', or URLs", option="logs")
    for pattern in pattern_list:
        logs = list(_remote(pattern, skip) if "://" in pattern else _local(pattern, skip))
        if not logs:
            raise DataError(f"{pattern}: no log there")
        logs_by_place.update((log.place, log) for log in logs)
    return [logs_by_place[place] for place in sorted(logs_by_place)]


def _local(pattern: str, skip: Callable[[str], None] | None) -> Iterator[Log]:
    from sigmatau.io import is_log

    is_pattern = glob.has_magic(pattern)
    inside: dict[Path, bool] = {}  # whether a folder is a log or inside a log, by folder
    for name in sorted(_matching(pattern)) if is_pattern else [pattern]:
        path = Path(name)
        if is_pattern and _within(path.parent, inside):
            continue
        if path.is_dir() and _is_listed(path):
            if _is_one_log(path):
                yield _folder(path)
            elif not is_pattern:
                yield from _local(os.path.join(glob.escape(name), "**"), skip)  # noqa: PTH118  Path drops the **
            continue
        if is_pattern and not is_log(path):
            if skip is not None:
                skip(str(path))
            continue
        try:
            state = path.stat()
        except OSError as error:
            if not is_pattern:
                raise DataError(f"{path}: {error.strerror or error}") from None
            yield Log(place=str(path), size=None, changed="")  # a broken link; the reader reports it
            continue
        yield Log(place=str(path), size=state.st_size, changed=str(state.st_mtime_ns))


def _matching(pattern: str) -> Iterator[str]:
    """Like `glob.glob`, but does not follow links to a parent folder, which would list each log forty times."""
    parts = pattern.split("/")
    if parts.count("**") != 1:
        yield from glob.glob(pattern, recursive=True)  # noqa: PTH207  Path.glob needs a root
        return
    position = parts.index("**")
    above, rest = "/".join(parts[:position]), "/".join(parts[position + 1 :])
    if position == 1 and not above:
        above = "/"
    for root in glob.glob(above) if above else [""]:  # noqa: PTH207
        if root and not rest:
            yield root
        for folder in _folders(root):
            if rest:
                yield from glob.glob(os.path.join(glob.escape(folder), rest))  # noqa: PTH118, PTH207
            else:
                yield from (os.path.join(folder, name) for name in _names(folder))  # noqa: PTH118


def _folders(root: str, above: frozenset[str] = frozenset()) -> Iterator[str]:
    """List a folder and its subfolders, except hidden ones."""
    real = os.path.realpath(root)
    if real in above:
        return
    yield root
    for name in _names(root):
        path = os.path.join(root, name)  # noqa: PTH118
        if os.path.isdir(path):  # noqa: PTH112
            yield from _folders(path, above | {real})


def _names(folder: str) -> list[str]:
    """Entries of a folder that are not hidden; empty without permission to list it."""
    try:
        return [name for name in os.listdir(folder or ".") if not name.startswith(".")]  # noqa: PTH208
    except OSError:
        return []


def _is_listed(folder: Path) -> bool:
    """Whether a folder may be listed. A folder that may not is taken for a log, so that the reader reports it."""
    return os.access(folder, os.R_OK | os.X_OK, effective_ids=os.access in os.supports_effective_ids)


def _folder(path: Path) -> Log:
    """Version of a folder that is a log: the sum of its sizes, and a checksum of the names, sizes and times of its files."""
    size, digest = 0, hashlib.sha256()
    for folder, folders, files in os.walk(path):
        folders.sort()
        for name in sorted(files):
            state = (Path(folder) / name).stat()
            size += state.st_size
            digest.update(f"{folder}/{name}\0{state.st_size}\0{state.st_mtime_ns}\n".encode(errors="surrogateescape"))
    return Log(place=str(path), size=size, changed=digest.hexdigest()[:32])


def _is_one_log(path: Path) -> bool:
    """Whether a folder is a single log: a Zarr store, or a ROS 2 bag."""
    from sigmatau.io import bag_files

    return bool(bag_files(path))


def _within(folder: Path, is_in_log: dict[Path, bool]) -> bool:
    """Whether a folder is a log, or is inside one."""
    if folder not in is_in_log:
        above = folder.parent != folder and _within(folder.parent, is_in_log)
        is_in_log[folder] = above or _is_one_log(folder)
    return is_in_log[folder]


def _remote(pattern: str, skip: Callable[[str], None] | None) -> Iterator[Log]:
    try:
        import fsspec
    except ImportError:
        raise ImportError("a URL needs fsspec: pip install 'sigmatau[cluster]'") from None
    from sigmatau.io import NOT_LOGS

    if "::" in pattern:
        raise DataError(f"{pattern}: a URL in another one is not read; unpack the archive and name its folder")
    try:
        system, path = fsspec.core.url_to_fs(pattern)
        is_pattern = glob.has_magic(path)
        places = system.glob(path, detail=True) if is_pattern else {path: system.info(path)}
        if not is_pattern and places[path].get("type") == "directory" and not _zarr_name(path):
            places, is_pattern = system.find(path, detail=True), True
        stores: set[str] = set()
        for name, entry in sorted(places.items()):
            inside = next((part for part in _above(name) if _zarr_name(part)), None)
            if inside is not None:
                if inside not in stores:
                    stores.add(inside)
                    yield _remote_folder(system, inside)
            elif entry.get("type") != "directory":
                place = system.unstrip_protocol(name)
                if is_pattern and PurePath(name).suffix.lower() in NOT_LOGS:
                    if skip is not None:
                        skip(place)
                    continue
                yield Log(place=place, size=entry.get("size"), changed=_tag(entry))
    except (OSError, ValueError, ImportError) as error:
        raise DataError(f"{pattern}: {str(error) or type(error).__name__}") from None


def _zarr_name(name: str) -> bool:
    return name.rstrip("/").endswith(".zarr")


def _above(name: str) -> Iterator[str]:
    """List the folders of a path: ``a``, ``a/b`` and ``a/b/c`` for ``a/b/c``."""
    parts = name.rstrip("/").split("/")
    return ("/".join(parts[: k + 1]) for k in range(len(parts)))


def _remote_folder(system: Any, path: str) -> Log:  # noqa: ANN401
    entries: Mapping[str, Mapping[str, Any]] = system.find(path, detail=True)
    digest = hashlib.sha256()
    for name, entry in sorted(entries.items()):
        digest.update(f"{name}\0{entry.get('size')}\0{_tag(entry)}\n".encode())
    size = sum(entry.get("size") or 0 for entry in entries.values())
    return Log(place=system.unstrip_protocol(path), size=size, changed=digest.hexdigest()[:32])


def _tag(entry: Mapping[str, Any]) -> str:
    """Version of an object as stated by its storage."""
    for key in ("ETag", "etag", "LastModified", "last_modified", "mtime", "created"):
        if entry.get(key) is not None:
            return str(entry[key])
    return ""
