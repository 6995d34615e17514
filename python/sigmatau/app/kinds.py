"""The kind of a file, by its name and its content: what the page can do with it."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from sigmatau.app.files import SQLITE_ENDS
from sigmatau.io import NOT_LOGS, bag_files
from sigmatau.io.written import is_result
from sigmatau.lab.store.connect import is_store

FileKind = Literal["folder", "log", "result", "store", "model", "datasheet", "session", "figure"]

_FIGURES = (".png", ".jpg", ".jpeg", ".webp", ".gif", ".svg", ".pdf")
_LONGEST_TOML = 1 << 20  # largest size of a model, a datasheet or a session [bytes]


def file_kind(path: Path) -> FileKind | None:
    """The kind of a file; None if the page cannot use it."""
    if path.is_dir():
        return "log" if bag_files(path) else "folder"
    if not path.is_file() or path.name.endswith(SQLITE_ENDS):
        return None
    ending = path.suffix.lower()
    if is_result(path):
        return "result" if ending == ".json" else None
    if ending in _FIGURES:
        return "figure"
    if ending == ".toml":
        return _toml_kind(path)
    if is_store(path):
        return "store"
    return None if ending in NOT_LOGS and ending != ".json" else "log"


def _toml_kind(path: Path) -> FileKind | None:
    """A noise model has tables of channels, a datasheet its sensor and its maker; options of an analysis are a session."""
    try:
        if path.stat().st_size > _LONGEST_TOML:
            return None
        content: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return "session"  # the error is reported when it is opened
    channels = content.get("channels")
    if isinstance(channels, Mapping) and any(isinstance(channel, Mapping) for channel in channels.values()):
        return "model"
    return "datasheet" if "name" in content and "maker" in content else "session"
