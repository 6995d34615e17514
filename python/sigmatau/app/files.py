"""Files that the page may use: those in the folders that the command line names, and uploaded files."""

from __future__ import annotations

import re
import secrets
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from sigmatau.app.answers import CallError, missing

_ENDINGS = re.compile(r"(\.[A-Za-z0-9]{1,8}){1,2}$")
SQLITE_ENDS = ("-wal", "-shm", "-journal")  # ends of the names of temporary files of SQLite
_LONGEST_NAME = 200  # largest number of characters of a file name


class Roots:
    """The folders, files and stores that the command line names.

    Parameters
    ----------
    places : iterable of Path
        Folders and single files.
    stores : sequence of str
        URLs of stores. The page identifies a store by its position in this list, and does not receive its password.
    """

    def __init__(self, places: Iterable[Path], stores: Sequence[str] = ()) -> None:
        self._stores = tuple(stores)
        self.places: tuple[Path, ...] = tuple(dict.fromkeys(place.resolve() for place in places))

    def find(self, path: object) -> Path:
        """A path below the roots, with links resolved; raises `CallError` for any other path, whether it exists or not."""
        text = str(path)
        refused = missing(f"{text[:_LONGEST_NAME]}: no such file below the folders of this workbench")
        if not isinstance(path, str) or "\0" in text or "://" in text:
            raise refused
        try:
            resolved = Path(text).resolve()
            is_below = any(resolved == root or root in resolved.parents for root in self.places)
            exists = is_below and (resolved.is_file() or resolved.is_dir())  # reading a pipe would not end
        except (OSError, RuntimeError, ValueError):  # a loop of links, a name that is too long
            raise refused from None
        if not exists:
            raise refused
        return resolved

    def find_store(self, number: object) -> tuple[str, str]:
        """URL of a store, and the URL without its password; raises `CallError` for an unknown number."""
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < len(self._stores):
            raise missing("no such store was named at the start of this workbench")
        return self._stores[number], self.stores[number]

    @property
    def stores(self) -> list[str]:
        """URLs of the stores without their passwords."""
        hidden = (re.sub(r"(://[^:/@]*):.*@", r"\1:…@", url) for url in self._stores)
        return [re.sub(r"([?&]password=)[^&]*", r"\1…", url) for url in hidden]

    def new_file(self, name: str) -> Path:
        """Path of a new file in the first folder; raises `CallError` unless `name` is a plain file name."""
        folder = self.folder()
        if folder is None:
            raise missing("no folder was opened in which the record can be saved; start sigmatau app FOLDER")
        is_plain = name == Path(name).name and 0 < len(name) <= _LONGEST_NAME and not set("\0\\") & set(name)
        is_shown = name.isprintable() and bool(name.strip())
        if not (is_plain and is_shown) or name.startswith(".") or name.endswith(SQLITE_ENDS):
            message = "the record is saved in the opened folder: give the name of a new file, without a folder"
            raise CallError({"message": message, "hint": None, "code": "option"})
        return folder / name

    def folder(self) -> Path | None:
        """The first folder; None if only files were named."""
        return next((place for place in self.places if place.is_dir()), None)

    def parent(self, path: Path) -> Path | None:
        """The parent folder, if the page may list it; otherwise None."""
        above = path.parent
        return above if any(above == root or root in above.parents for root in self.places) else None


@dataclass(frozen=True, kw_only=True)
class Upload:
    """A file that the page sent.

    Attributes
    ----------
    name : str
        Name on the user's computer, for display only; `path` has another name.
    path : Path
        Temporary file.
    size : int
        [bytes]
    """

    name: str
    path: Path
    size: int


class Uploads:
    """Uploaded files, in a temporary folder that `close` removes.

    Parameters
    ----------
    limit : int
        Largest size of all uploaded files together. [bytes]
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self._folder: Path | None = None
        self._files: dict[str, Upload] = {}
        self._coming: dict[str, int] = {}  # received bytes of files whose upload has not ended

    def begin(self, name: str) -> tuple[str, str, Path]:
        """Identifier, displayed name, and temporary path of a new upload."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="sigmatau-app-"))
        shown = name.replace("\\", "/").rpartition("/")[2][:_LONGEST_NAME] or "log"
        ending = _ENDINGS.search(shown)
        id_ = secrets.token_urlsafe(12)
        return id_, shown, self._folder / f"{secrets.token_hex(8)}{ending[0] if ending else ''}"

    def room(self) -> int:
        """Number of bytes that may still be uploaded."""
        free = shutil.disk_usage(self._folder or tempfile.gettempdir()).free
        sizes = (*(file.size for file in self._files.values()), *self._coming.values())
        return min(self.limit - sum(sizes), free // 2)

    def receive(self, id_: str, size: int) -> None:
        """Count a received part of a file; raises `CallError` if it exceeds the limit or the free space."""
        room = self.room()
        if size > room:
            raise too_large(self._coming.get(id_, 0) + room)
        self._coming[id_] = self._coming.get(id_, 0) + size

    def end(self, id_: str, upload: Upload | None) -> None:
        """End an upload; `upload` is None if it failed."""
        self._coming.pop(id_, None)
        if upload is not None:
            self._files[id_] = upload

    def find(self, id_: object) -> Upload:
        """The file of an identifier; raises `CallError` for an unknown one."""
        if not isinstance(id_, str) or id_ not in self._files:
            raise missing("this file was not uploaded, or has been removed")
        return self._files[id_]

    def remove(self, id_: str) -> None:
        """Remove a file; raises `CallError` if there is none."""
        self.find(id_).path.unlink(missing_ok=True)
        del self._files[id_]

    def close(self) -> None:
        """Remove all files."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


def too_large(limit: int) -> CallError:
    """The error of a file that exceeds the remaining space."""
    size = f"{limit / 1e6:.0f} MB" if limit > 0 else "nothing"
    message = f"the file is too large to upload ({size} left); start sigmatau app with its folder, and choose it there"
    return CallError({"message": message, "hint": None, "code": "size"})
