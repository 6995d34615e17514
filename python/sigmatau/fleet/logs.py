"""The logs of a fleet: files and objects by pattern, with what tells whether they have changed."""

from __future__ import annotations

import glob
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from sigmatau.errors import DataError, OptionError
from sigmatau.frozen import frozen


@frozen
class Log:
    """A log, as a worker finds it again."""

    place: str  # path or URL
    size: int | None  # bytes; None if the storage does not say
    changed: str  # time of its last change, or its tag, as text

    @property
    def version(self) -> str:
        """Equal for the same content: size and last change."""
        return f"{self.size}/{self.changed}"


def find(patterns: Iterable[str]) -> list[Log]:
    """The logs of paths, patterns (``logs/**/*.csv``) and URLs (``s3://bucket/night*``), each once, by name.

    Raises
    ------
    DataError
        For a pattern without a log, or a place that cannot be listed.
    OptionError
        Without a pattern.
    ImportError
        For a URL without fsspec or the package of its protocol.
    """
    found: dict[str, Log] = {}
    given = list(patterns)
    if not given:
        raise OptionError("name logs, patterns such as 'logs/**', or URLs", option="logs")
    for pattern in given:
        logs = list(_remote(pattern) if "://" in pattern else _local(pattern))
        if not logs:
            raise DataError(f"{pattern}: no log there")
        found.update((log.place, log) for log in logs)
    return [found[place] for place in sorted(found)]


def _local(pattern: str) -> Iterator[Log]:
    for name in glob.iglob(pattern, recursive=True) if glob.has_magic(pattern) else [pattern]:
        path = Path(name)
        hidden = any(part.startswith(".") and part not in (".", "..") for part in path.parts)
        if path.is_dir() and not _is_one_log(path):
            if not glob.has_magic(pattern):
                yield from _local(os.path.join(glob.escape(name), "**"))  # noqa: PTH118  Path drops the **
            continue
        if hidden or (_inside_a_log(path) and glob.has_magic(pattern)):
            continue
        try:
            state = path.stat()
        except OSError as error:
            raise DataError(f"{path}: {error.strerror or error}") from None
        yield Log(place=str(path), size=state.st_size, changed=str(state.st_mtime_ns))


def _is_one_log(path: Path) -> bool:
    """Whether a folder is a log: a Zarr store, or a ROS 2 bag."""
    from sigmatau.io.read.formats.split import files_of

    return bool(files_of(path))


def _inside_a_log(path: Path) -> bool:
    return any(_is_one_log(parent) for parent in path.parents if parent != Path())


def _remote(pattern: str) -> Iterator[Log]:
    try:
        import fsspec
    except ImportError:
        raise ImportError("a URL needs fsspec: pip install 'sigmatau[cluster]'") from None
    try:
        system, path = fsspec.core.url_to_fs(pattern)
        places = system.glob(path, detail=True) if glob.has_magic(path) else {path: system.info(path)}
        for name, entry in sorted(places.items()):
            if entry.get("type") == "directory" and not name.endswith(".zarr"):
                continue
            yield Log(place=system.unstrip_protocol(name), size=entry.get("size"), changed=_tag(entry))
    except (OSError, ValueError) as error:
        raise DataError(f"{pattern}: {error}") from None


def _tag(entry: dict[str, Any]) -> str:
    """What an object's storage says of its version."""
    for key in ("ETag", "etag", "LastModified", "last_modified", "mtime", "created"):
        if entry.get(key) is not None:
            return str(entry[key])
    return ""
