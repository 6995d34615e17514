"""Files that the page may name: those below the folders of the command line, and those that were uploaded."""

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
SQLITE_ENDS = ("-wal", "-shm", "-journal")  # ends of the names of files that belong to a database, which removes them
_LONGEST_NAME = 200  # characters of the name of an uploaded file that are shown


class Roots:
    """The folders and files of the command line.

    Parameters
    ----------
    places : iterable of Path
        Folders, and files alone.
    stores : sequence of str
        URLs of stores. The page names them by their place in this list, and does not see their passwords.
    """

    def __init__(self, places: Iterable[Path], stores: Sequence[str] = ()) -> None:
        self._stores = tuple(stores)
        self.places: tuple[Path, ...] = tuple(dict.fromkeys(place.resolve() for place in places))

    def find(self, path: object) -> Path:
        """A place below the roots, with all links resolved; raises `CallError` for any other, whether it exists or not."""
        text = str(path)
        refused = missing(f"{text[:_LONGEST_NAME]}: no such file below the folders of this workbench")
        if not isinstance(path, str) or "\0" in text or "://" in text:
            raise refused
        try:
            resolved = Path(text).resolve()
            is_below = any(resolved == root or root in resolved.parents for root in self.places)
            exists = is_below and (resolved.is_file() or resolved.is_dir())  # a pipe would be waited for
        except (OSError, RuntimeError, ValueError):  # a loop of links, a name that is too long
            raise refused from None
        if not exists:
            raise refused
        return resolved

    def find_store(self, number: object) -> tuple[str, str]:
        """URL of a store, and the URL without its password; raises `CallError`."""
        if not isinstance(number, int) or isinstance(number, bool) or not 0 <= number < len(self._stores):
            raise missing("no such store was named at the start of this workbench")
        return self._stores[number], self.stores[number]

    @property
    def stores(self) -> list[str]:
        """URLs of the stores without their passwords."""
        hidden = (re.sub(r"(://[^:/@]*):.*@", r"\1:…@", url) for url in self._stores)
        return [re.sub(r"([?&]password=)[^&]*", r"\1…", url) for url in hidden]

    def new_file(self, name: str) -> Path:
        """The place of a new file in the first folder; raises `CallError` for the name of a path."""
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
        """The folder above, if it is below the roots too."""
        above = path.parent
        return above if any(above == root or root in above.parents for root in self.places) else None


@dataclass(frozen=True, kw_only=True)
class Upload:
    """A file that the page sent.

    Attributes
    ----------
    name : str
        What the page calls it: shown, and never the name of a file here.
    path : Path
        Where it is until the end.
    size : int
        [bytes]
    """

    name: str
    path: Path
    size: int


class Uploads:
    """Files that the page sent, in a temporary folder that is removed at the end.

    Parameters
    ----------
    limit : int
        Bytes of one file, and of all of them.
    """

    def __init__(self, limit: int) -> None:
        self.limit = limit
        self._folder: Path | None = None
        self._files: dict[str, Upload] = {}
        self._coming: dict[str, int] = {}  # bytes so far of files that are being sent

    def begin(self, name: str) -> tuple[str, str, Path]:
        """Identifier, shown name, and place of a file that is about to be sent."""
        if self._folder is None:
            self._folder = Path(tempfile.mkdtemp(prefix="sigmatau-app-"))
        shown = name.replace("\\", "/").rpartition("/")[2][:_LONGEST_NAME] or "log"
        ending = _ENDINGS.search(shown)
        id_ = secrets.token_urlsafe(12)
        return id_, shown, self._folder / f"{secrets.token_hex(8)}{ending[0] if ending else ''}"

    def room(self) -> int:
        """Bytes that may still be sent."""
        free = shutil.disk_usage(self._folder or tempfile.gettempdir()).free
        sizes = (*(file.size for file in self._files.values()), *self._coming.values())
        return min(self.limit - sum(sizes), free // 2)

    def receive(self, id_: str, size: int) -> None:
        """Count a part of a file that is being sent; raises `CallError` if there is no room for it."""
        room = self.room()
        if size > room:
            raise too_large(self._coming.get(id_, 0) + room)
        self._coming[id_] = self._coming.get(id_, 0) + size

    def end(self, id_: str, upload: Upload | None) -> None:
        """Keep a file that was sent, or forget one that was not."""
        self._coming.pop(id_, None)
        if upload is not None:
            self._files[id_] = upload

    def find(self, id_: object) -> Upload:
        """The file of an identifier; raises `CallError`."""
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
    """The error about a file that is larger than what is left."""
    size = f"{limit / 1e6:.0f} MB" if limit > 0 else "nothing"
    message = f"the file is too large to upload ({size} left); start sigmatau app with its folder, and choose it there"
    return CallError({"message": message, "hint": None, "code": "size"})
