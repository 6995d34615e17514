"""Results of an earlier run: they are not read as logs, and a failed run removes those in the place of its outputs."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from sigmatau.results import printable


def curves_path(path: Path) -> Path:
    """File of the curves that --csv writes in addition to the coefficients."""
    return path.with_name(f"{path.stem}-curves{path.suffix}")


_State = tuple[int, int]
_expected: ContextVar[dict[Path, _State]] = ContextVar("expected")


@contextlib.contextmanager
def removing_stale_outputs() -> Iterator[None]:
    """Run a command, then remove those files that `expect` names and the command did not replace."""
    token = _expected.set({})
    try:
        yield
    finally:
        _remove([path for path, state in _expected.get().items() if _state(path) == state])
        _expected.reset(token)


def expect(*paths: Path | None, csv: Path | None = None) -> None:
    """Declare the outputs of this command after its options were checked. If the command fails, results of an earlier run
    in these places are removed; other files remain.

    With `csv`, the file of the curves is an output too.
    """
    from sigmatau.io.written import is_result

    before = _expected.get(None)
    for path in (*paths, csv, None if csv is None else curves_path(csv)):
        if before is not None and path is not None and path.is_file() and is_result(path):
            file = path.resolve()
            if state := _state(file):
                before[file] = state


def _remove(files: Iterable[Path]) -> None:
    removed = []
    for file in files:
        with contextlib.suppress(OSError):
            file.unlink()
            removed.append(file.name)
    if removed:
        sys.stderr.write(printable(f"removed, because an earlier run wrote it: {', '.join(removed)}") + "\n")


def _state(path: Path) -> _State | None:
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_ino, status.st_mtime_ns
