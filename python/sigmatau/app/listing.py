"""Files of a folder, as the page lists them."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

from sigmatau.app.calls import Progress
from sigmatau.app.kinds import file_kind

_MOST_ENTRIES = 5000  # largest number of entries of a folder that are listed, or files whose sizes are added


def list_folder(*, folder: str, parent: str | None, progress: Progress) -> str:
    """Entries of a folder by name, as JSON; hidden files and files that the page cannot use are omitted."""
    entries: list[dict[str, Any]] = []
    with os.scandir(folder) as files:
        names = sorted((entry.name for entry in files if not entry.name.startswith(".")), key=str.casefold)
    for name in names:
        if len(entries) < _MOST_ENTRIES and (entry := _entry(Path(folder) / name)) is not None:
            entries.append(entry)
    content = {"path": folder, "parent": parent, "entries": entries, "more": max(len(names) - _MOST_ENTRIES, 0)}
    return json.dumps(content)


def list_arguments(*, places: Sequence[str], stores: Sequence[str], progress: Progress) -> str:
    """The folders, files and stores that the command line names, in the form of `list_folder`, without a path."""
    entries = [entry for place in places if (entry := _entry(Path(place))) is not None]
    entries += [
        {"name": url, "path": None, "store": number, "kind": "store", "bytes": None, "modified": None}
        for number, url in enumerate(stores)
    ]
    return json.dumps({"path": None, "parent": None, "entries": entries, "more": 0})


def _entry(path: Path) -> dict[str, Any] | None:
    try:
        status = path.stat()
    except OSError:
        return None
    kind = file_kind(path)
    if kind is None:
        return None
    size = None if kind == "folder" else _folder_size(path) if path.is_dir() else status.st_size
    return {"name": path.name, "path": str(path), "kind": kind, "bytes": size, "modified": round(status.st_mtime, 3)}


def _folder_size(folder: Path) -> int:
    """Size of the files of a bag or a Zarr store. [bytes]"""
    size, files = 0, (Path(place) / name for place, _, names in os.walk(folder) for name in names)
    for file in islice(files, _MOST_ENTRIES):
        with suppress(OSError):
            size += file.stat().st_size
    return size
