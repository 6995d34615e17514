"""Messages on standard error, as wide as the terminal. A command in a message is not divided."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from collections.abc import Iterator, Sequence

_GLUE = "\x1f"  # placeholder for a non-breaking space
_INDENT, _INDENT_OF_ACTION = 2, 5  # indent of continuation lines: of a message, of an action [characters]
_ENDS = (".", ",", ";", ":", ")")  # ends of a clause, after which a command does not continue
_PREFIX = "sigmatau:"  # prefix of an error; the name of a file follows on the same line
_PROGRAMS = ("sigmatau", "pip")  # first words of commands


def wrapped(lines: Sequence[str]) -> list[str]:
    """Wrap lines at the width of the terminal and indent continuation lines; unchanged in a pipe."""
    if not (sys.stderr.isatty() or "COLUMNS" in os.environ):
        return list(lines)
    width = shutil.get_terminal_size().columns
    return [part for line in lines for part in wrap_message(line, width)]


def wrap_message(line: str, width: int) -> list[str]:
    """Wrap a message at a width. An option and its value remain in one line if they fit; words are never divided."""
    indent = _INDENT_OF_ACTION if line.startswith("  -> ") else _INDENT
    glued = "".join(_glue_commands(line, width - indent))
    parts = textwrap.wrap(glued, width, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False)
    return [part.replace(_GLUE, " ") for part in parts] or [""]


def print_error(text: str, *, rows: str = "") -> None:
    """Print an error, in one line unless standard error is a terminal, followed by the lines that illustrate it."""
    from sigmatau.results import printable

    line = f"sigmatau: {printable(' '.join(text.split()))}"
    lines = wrap_message(line, shutil.get_terminal_size().columns) if sys.stderr.isatty() else [line]
    sys.stderr.write("".join(f"{part}\n" for part in (*lines, *map(printable, rows.splitlines()))))


def _glue_commands(line: str, room: int) -> Iterator[str]:
    """Split a message into words, each with the space or glue before it. A command wider than `room` is divided before
    options.
    """
    words = line.split(" ")
    joins = [False, *(_stays_with_previous(words, k) for k in range(1, len(words)))]
    start = 0
    for k, word in enumerate(words):
        if not joins[k]:
            start = k
        end = next((j for j in range(k + 1, len(words)) if not joins[j]), len(words))
        fits = len(" ".join(words[start:end])) <= room
        yield ("" if k == 0 else _GLUE if joins[k] and (fits or not word.startswith("--")) else " ") + word


def _stays_with_previous(words: Sequence[str], k: int) -> bool:
    """Whether a word must stay on the line of the previous word: the value of an option, or a further value or option."""
    before, word = words[k - 1], words[k]
    if before == _PREFIX:
        return k == 1
    if not before or not word or before.endswith(_ENDS):
        return False
    if before.startswith("--") or before in _PROGRAMS:
        return True
    is_value = k > 1 and _stays_with_previous(words, k - 1)
    return is_value and (word.startswith("--") or "=" in word)
