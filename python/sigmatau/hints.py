"""Hints: the options that a message names, as data, and their words in each user interface (face).

A message is written once, with hints in it: ``f"has no rate; give {Hint('rate', value='HZ')}"``. In the text each hint is a
mark, so texts can be joined before the reader is known. `worded` replaces the marks by words: those of Python, ``rate=HZ``
in backticks, unless `speaking` has set another face. A face is a function of adjacent hints, so a page in a browser can make
buttons of them.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple


class Hint(NamedTuple):
    """An option to state.

    Attributes
    ----------
    option : str
        Name of the argument in Python.
    key : str or None
        Channel or sensor that the value is for, or another key, if the option is a mapping.
    value : object
        What to state: a word, a number, a mapping, or several values; True for a flag. None names the option alone. A word
        in capitals stands for a value: ``"HZ"``.
    remark : str
        What follows from this value; printed after it, in brackets.

    Examples
    --------
    >>> from sigmatau.hints import Hint, as_options, worded
    >>> text = f"give {Hint('unit', 'time', 'ms')} or {Hint('rate', value='HZ')}"
    >>> print(worded(text))
    give `unit={"time": "ms"}` or `rate=HZ`
    >>> print(worded(text, as_options))
    give --unit time=ms or --rate HZ
    """

    option: str
    key: str | None = None
    value: Any = None
    remark: str = ""

    def __str__(self) -> str:
        parts = self if self.remark else self[:-1]
        return f"{MARK_BEGIN}{json.dumps(parts, ensure_ascii=False, default=str)}{_END}"

    def __format__(self, spec: str) -> str:
        return str(self)

    def pairs(self) -> Mapping[str, Any] | None:
        """Values by key; None if the option is not a mapping here."""
        return self.value if isinstance(self.value, Mapping) else None if self.key is None else {self.key: self.value}


Face = Callable[[Sequence[Hint]], str]
"""Converts adjacent hints to words."""

MARK_BEGIN, _END = "\ue000", "\ue001"
"""Characters at which a hint in a text begins and ends. They are private-use characters, which no other text has."""

_MARK = re.compile(f"{MARK_BEGIN}([^{_END}]*){_END}")
_MARKS = re.compile(rf"{_MARK.pattern}(?: {_MARK.pattern})*")

SPELLED: Mapping[str, str] = {"walk": "rate_random_walk", "noise": "random_walk", "names": "name"}
"""Options of the command line by argument, where the names differ."""

_SECONDS = ("horizon",)  # times that the command line only accepts with a unit

RATE = Hint("rate", value="HZ")
TIME_COLUMN = Hint("channels", "time", "…")
WITHOUT_STAMPS = f"{Hint('channels', 'time', 'none')} {RATE}"
"""The options that ignore the time stamps of a log."""


def worded(text: str, face: Face | None = None) -> str:
    """Replace the hints in a text by the words of a face; default: the face set by `speaking`."""

    def words(marks: re.Match[str]) -> str:
        hints = hints_in(marks[0])
        return (face or _face)(hints) if hints else marks[0]

    return _MARKS.sub(words, text) if MARK_BEGIN in text else text


def hints_in(text: str) -> tuple[Hint, ...]:
    """The hints of a message."""
    return tuple(hint for mark in _MARK.finditer(text) if (hint := _hint(mark[1])) is not None)


def _hint(content: str) -> Hint | None:
    """The hint of a mark; None for a mark that comes from the text of a file."""
    try:
        return Hint(*json.loads(content))
    except (ValueError, TypeError):
        return None


@contextlib.contextmanager
def speaking(face: Face) -> Iterator[None]:
    """Set the face that this process words its messages for."""
    global _face
    before, _face = _face, face
    try:
        yield
    finally:
        _face = before


def as_arguments(hints: Sequence[Hint]) -> str:
    """Hints as arguments in Python: ```unit={"time": "ms"}` ``."""
    return f"`{', '.join(map(_argument, hints))}`{_remarks(hints)}"


_face: Face = as_arguments


def as_options(hints: Sequence[Hint]) -> str:
    """Hints as they are typed: ``--unit time=ms``."""
    return " ".join(map(_option, hints)) + _remarks(hints)


def _remarks(hints: Sequence[Hint]) -> str:
    return "".join(f" ({hint.remark})" for hint in hints if hint.remark)


def command(verb: str, *words: str | Hint) -> str:
    """A command as it is typed in a shell, the same in every face."""
    return " ".join(["sigmatau", verb, *(_option(word) if isinstance(word, Hint) else word for word in words)])


def _argument(hint: Hint) -> str:
    pairs = hint.pairs()
    if pairs is not None:
        return f"{hint.option}={{{', '.join(f'{_quoted(key)}: {_value(value)}' for key, value in pairs.items())}}}"
    if hint.value is None:
        return hint.option
    is_placeholder = isinstance(hint.value, str) and hint.value.isupper()
    return f"{hint.option}={hint.value if is_placeholder else _value(hint.value)}"


_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?")


def _value(value: object) -> str:
    if isinstance(value, str):
        return value if _NUMBER.fullmatch(value) else _quoted(value)
    return f"[{', '.join(map(_value, value))}]" if isinstance(value, list | tuple) else str(value)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _option(hint: Hint) -> str:
    name = f"--{SPELLED.get(hint.option, hint.option).replace('_', '-')}"
    if (hint.value is None and hint.key is None) or hint.value is True:
        return name
    pairs = hint.pairs()
    if pairs is not None:
        return f"{name} {_word(','.join(f'{key}={value}' for key, value in pairs.items()))}"
    values = hint.value if isinstance(hint.value, list | tuple) else [hint.value]
    unit = "s" if hint.option in _SECONDS else ""
    return " ".join(f"{name} {_word(f'{value}{unit}')}" for value in values)


_PLAIN_WORD = re.compile(r"[^\s()\[\]&;|<>$`'\"*?!#\\]*")


def _word(text: str) -> str:
    """A word of a command, in quotes if a shell needs them."""
    if _PLAIN_WORD.fullmatch(text):
        return text
    import shlex

    return shlex.quote(text) if any(c in text for c in '"$`\\!') else f'"{text}"'
