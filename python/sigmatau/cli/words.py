"""Further values of options with several values on the command line: ``--unit gyro=deg/s accel=g``.

The parser takes one word after an option, because the next word may be a log. This module repeats the option before each
further word that cannot be a log: KEY=VALUE, a number after ``--rate``, or a word without a file name ending after
``--topic``, unless a file has that name.
"""

from __future__ import annotations

import glob
import os
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sigmatau.errors import DataError, OptionError

if TYPE_CHECKING:
    from cyclopts import App

_NUMBERS = "--rate"  # the option whose further values are numbers, one per log
_NAMES = "--topic"  # the option whose further values are names, one per sensor


def repeat_options(app: App, words: Sequence[str]) -> list[str]:
    """Repeat each option before its second and further values."""
    if not _has_values_in_a_row(words):
        return list(words)
    several = _repeatable_options(app, words)
    result: list[str] = []
    option, waits = "", False
    for k, word in enumerate(words):
        if word == "--":
            return result + list(words[k:])
        if waits:
            waits = False
        elif word.startswith("--"):
            name, equals, _ = word.partition("=")
            option, waits = (name, not equals) if name in several else ("", False)
        elif option and _is_value(word, option):
            result.append(option)
        else:
            option = ""
        result.append(word)
    return result


def with_config(words: Sequence[str]) -> list[str]:
    """Append the options of the file in ``analyze --config FILE`` to the words, except those that are typed."""
    if words[:1] != ["analyze"] or (file := _config_file(words)) is None:
        return list(words)
    from sigmatau.typed.config import LOG, option_words
    from sigmatau.typed.forms import spelled

    typed = {word.partition("=")[0] for word in words if word.startswith("--")}
    table, _ = _read_config(file)
    options = {
        key: value for key, value in table.items() if key != LOG and f"--{spelled(key.replace('-', '_'))}" not in typed
    }
    end = words.index("--") if "--" in words else len(words)
    return [*words[:end], *option_words(options), *words[end:]]


def configured_logs(file: Path) -> tuple[Path, ...]:
    """Log that a configuration file names, relative to its folder; empty without a log."""
    _, log = _read_config(file)
    return () if log is None else (file.parent / log,)


def _config_file(words: Sequence[str]) -> Path | None:
    for k, word in enumerate(words):
        if word == "--":
            return None
        name, equals, value = word.partition("=")
        if name == "--config" and (equals or k + 1 < len(words)):
            return Path(value if equals else words[k + 1])
    return None


def _read_config(file: Path) -> tuple[dict[str, Any], str | None]:
    from sigmatau.typed.config import from_toml

    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise OptionError(f"--config {file}: is not a text file", option="config") from None
    except OSError as error:
        raise DataError(f"{file}: cannot be read: {error.strerror or error}") from None
    try:
        return from_toml(text)
    except OptionError as error:
        raise error.about(str(file)) from None


def check_place(word: str, *, command: str) -> None:
    """Raise the library's error for a mistyped option that a command took for a file, because it also takes ``-``."""
    if not word.startswith("-") or word == "-" or os.path.lexists(word):
        return
    from cyclopts import Token, UnknownOptionError

    from sigmatau.cli.app import app

    token = Token(keyword=word.partition("=")[0], source="cli")
    arguments = app[command].assemble_argument_collection()
    raise UnknownOptionError(token=token, argument_collection=arguments, command_chain=(command,), verbose=False)


def is_number(word: str) -> bool:
    """Whether a word is a number."""
    try:
        float(word)
    except ValueError:
        return False
    return True


def _has_values_in_a_row(words: Sequence[str]) -> bool:
    """Whether a word that may be a further value follows another word without a leading hyphen."""
    pairs = pairwise(words)
    names = any(word.partition("=")[0] == _NAMES for word in words)
    return any(
        not before.startswith("-") or "=" in before
        for before, word in pairs
        if "=" in word or is_number(word) or (names and _is_name(word))
    )


def _is_value(word: str, option: str) -> bool:
    if "=" not in word and not (option == _NUMBERS and is_number(word)) and not (option == _NAMES and _is_name(word)):
        return False
    return not os.path.lexists(word)


def _is_name(word: str) -> bool:
    """Whether a word may be a topic: it is not an option, has no file name ending, and is not a pattern."""
    return not word.startswith("-") and not os.path.splitext(word)[1] and not glob.has_magic(word)  # noqa: PTH122


def _repeatable_options(app: App, words: Sequence[str]) -> set[str]:
    """Options of a command that may be repeated, by their long names."""
    _, apps, _ = app.parse_commands(list(words))
    command = apps[-1]
    if command.default_command is None:
        return set()
    arguments = command.assemble_argument_collection()
    return {
        name
        for argument in arguments
        if argument.token_count() == (1, True)
        for name in argument.names
        if name.startswith("--")
    }
