"""Results of an earlier run: they are not logs, and a run that fails leaves none in place of its own."""

from __future__ import annotations

import contextlib
import re
import sys
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path

from sigmatau.results import printable

_HEAD, _TAIL = 4096, 16384  # bytes that name the program; the end, because a PDF names it there

# Of JSON, text and exports, figures, reports, the coefficients and curves of --csv, tables and JUnit XML of a lot, and
# arrays of a state space.
_WRITTEN = re.compile(
    rb'\A\{\s*(?:"(?:schema|lot)": \d+,\s*)?"sigmatau": "'
    rb"|\A(?:[^\n]{0,200}\n){0,2}[^\n]{0,200}written by sigmatau \d"
    rb'|\A\{\s*"value0": \{[^}]*\},\s*"about": \[\s*"[^"]*written by sigmatau \d'
    rb"|\A\x89PNG.*Software\0sigmatau \d"
    rb"|<svg.*<dc:title>sigmatau \d"
    rb"|\A%PDF.*/Creator \(sigmatau \d"
    rb'|\A<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><meta name="generator" content="sigmatau \d'
    rb"|\Achannel,(?:term,(?:observed,)?value,|tau_s,adev,)[a-z_,]*\n"
    rb"|\Aunit,state,reason,[a-z_,]*\n"
    rb'|\A<\?xml [^\n]*\n<testsuites name="sigmatau'
    rb"|\APK\x03\x04.{26}[a-z_]+\.F\.npy",
    re.DOTALL,
)


def curves_path(path: Path) -> Path:
    """The file of the curves that --csv writes beside the coefficients."""
    return path.with_name(f"{path.stem}-curves{path.suffix}")


def is_result(path: Path) -> bool:
    """Whether a file is a result of sigmatau, by its content; a simulated log or a pipe is not."""
    if not path.is_file():
        return False
    try:
        with path.open("rb") as stream:
            head = stream.read(_HEAD)
            if head.startswith(b"%PDF"):
                stream.seek(max(path.stat().st_size - _TAIL, 0))
                head += stream.read()
    except OSError:
        return False
    return _WRITTEN.search(head) is not None


_State = tuple[int, int]
_expected: ContextVar[dict[Path, _State]] = ContextVar("expected")


@contextlib.contextmanager
def settled() -> Iterator[None]:
    """Run a command, then remove the files of `expect` that it did not replace."""
    token = _expected.set({})
    try:
        yield
    finally:
        _remove([path for path, state in _expected.get().items() if _state(path) == state])
        _expected.reset(token)


def expect(*paths: Path | None, csv: Path | None = None) -> None:
    """Outputs of this command, once no option is wrong: what an earlier run left there is no result of this one. Files that
    sigmatau did not write stay. Beside `csv` are the curves.
    """
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
