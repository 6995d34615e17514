"""Options of an analysis as a flat table of names and texts: a configuration file, a command line, or the choices of a
page.

A key is the name of an option of ``sigmatau analyze`` without its leading hyphens, ``read_off_at`` or ``read-off-at``. A
value is the typed text, or its equivalent in TOML and JSON: a number, true, a list of texts, or a table such as ``{gyro =
"deg/s"}``.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, get_args

from sigmatau.analysis import AnalysisOptions
from sigmatau.errors import OptionError
from sigmatau.exporting.choices import Choices
from sigmatau.hints import SPELLED
from sigmatau.io.read.options import ReadOptions
from sigmatau.options import Option, declared
from sigmatau.typed.forms import convert, spelled, typed_form

Table = Mapping[str, Any]
"""Options by name, as typed or as values of TOML and JSON."""

LOG = "log"
"""Key of a configuration file for the log."""

EXPORT = "export"
"""The key of a configuration file that names files of other programs, ``["kalibr=imu.yaml"]``."""

_NAMES = {written: name for name, written in SPELLED.items()}
_UNDECLARED = ("note", "show")  # options of ``sigmatau analyze`` that are not declared options


def typable(options: Any) -> dict[str, Option]:  # noqa: ANN401  a class of options
    """Options of a class that can be typed, by name."""
    return {name: about for name, about in declared(options).items() if about.form is not None or about.choices}


def arguments(options: Any, table: Table) -> dict[str, Any]:  # noqa: ANN401  a class of options
    """Convert the options of a class in a table to Python values; options of other classes are ignored.

    Parameters
    ----------
    options : type
        `ReadOptions`, `AnalysisOptions` or `Choices`.
    table : mapping of str to object

    Raises
    ------
    OptionError
        For an invalid value.
    """
    about = typable(options)
    stated = {_name(key): value for key, value in table.items() if value is not None and value is not False}
    return {
        name: convert(name, about[name], _typed(about[name], name, stated[name])) for name in about if name in stated
    }


def check_names(table: Table, *, exports: bool = False) -> None:
    """Raise `OptionError` for a key that is not an option of an analysis or of an export."""
    names = {*typable(ReadOptions), *typable(AnalysisOptions), *_UNDECLARED}
    if exports:
        names = {*typable(Choices)}
    for key in table:
        if _name(key) not in names:
            listed = ", ".join(sorted(SPELLED.get(name, name) for name in names))
            raise OptionError(f"no option {key!r}; options: {listed}", option=str(key))


def split_exports(table: Table) -> tuple[dict[str, Any], list[str], dict[str, Any]]:
    """The options of a table without those of exports, the targets of ``export``, and the options of their files."""
    names = typable(Choices)
    stated = table.get(EXPORT) or []
    targets = [str(text).partition("=")[0] for text in ([stated] if isinstance(stated, str) else stated)]
    rest = {key: value for key, value in table.items() if key != EXPORT}
    choices = {key: value for key, value in rest.items() if _name(key) in names}
    return {key: value for key, value in rest.items() if key not in choices}, targets, choices


def notes(table: Table) -> dict[str, str]:
    """Convert the option ``note``: a table, or texts ``"serial number=A123"``. Raises `OptionError` for other forms."""
    stated = table.get("note")
    if isinstance(stated, Mapping):
        return {str(key): _text(text) for key, text in stated.items()}
    return parse_notes([] if stated is None else [stated] if isinstance(stated, str) else map(_text, stated))


def parse_notes(texts: Iterable[str]) -> dict[str, str]:
    """Convert ``["serial number=A123"]`` to a dictionary. Raises `OptionError` for other forms."""
    parsed = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise OptionError(f'--note {text!r}: must be NAME=TEXT, e.g. --note "serial number=A123"', option="note")
        parsed[name] = value
    return parsed


def option_words(table: Table) -> list[str]:
    """Convert the options of a table to words of a command line."""
    words: list[str] = []
    for key, value in table.items():
        if value is None or value is False:
            continue
        option = f"--{spelled(str(key)).replace('_', '-')}"
        if value is True:
            words.append(option)
            continue
        for text in _texts(_about(key), value):
            words += [f"{option}={text}"] if text.startswith("-") else [option, text]
    return words


def command_line(log: str, table: Table) -> str:
    """Build the command that analyses a log with these options, ready to be typed."""
    place = f"./{log}" if log.startswith("-") else log
    return shlex.join(["sigmatau", "analyze", place, *option_words(table)])


def live_command(source: str, table: Table, *, baud: int | None, save: str | None) -> str:
    """Build the command that watches a live source: a serial port if it has a speed, otherwise a file or ``-``."""
    words = ["--serial", source, "--baud", str(baud)] if baud is not None else [] if source == "-" else [source]
    saved = [] if save is None else ["--save", save]
    return shlex.join(["sigmatau", "watch", *words, *option_words(table), *saved])


def to_toml(table: Table, *, log: str | None = None) -> str:
    """Build the text of a configuration file for ``sigmatau analyze --config``."""
    lines = ["# Options of an analysis: sigmatau analyze --config FILE"]
    lines += [] if log is None else [f"{LOG} = {_toml(log)}"]
    lines += [
        f"{_key(str(key))} = {_toml(value)}" for key, value in table.items() if value is not None and value is not False
    ]
    return "\n".join(lines) + "\n"


def from_toml(text: str) -> tuple[dict[str, Any], str | None]:
    """Parse the options of a configuration file, and its log if it names one. Raises `OptionError` for other texts."""
    import tomllib

    try:
        table: dict[str, Any] = tomllib.loads(text, parse_float=_finite)
    except (ValueError, RecursionError) as error:  # ValueError: also of a number with thousands of digits
        raise OptionError(f"the configuration is not TOML: {error}", option="config") from None
    log = table.pop(LOG, None)
    if log is not None and not isinstance(log, str):
        raise OptionError(f"{LOG} in the configuration must be the name of a file, not {log!r}", option="config")
    return table, log


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not a finite number")
    return value


def _name(key: object) -> str:
    """Python name of an option."""
    name = str(key).removeprefix("--").replace("-", "_")
    return _NAMES.get(name, name)


def _about(key: object) -> Option | None:
    name = _name(key)
    for options in (ReadOptions, AnalysisOptions, Choices):
        if (about := declared(options).get(name)) is not None:
            return about
    return None


def _typed(about: Option, name: str, value: Any) -> Any:  # noqa: ANN401  of any form
    """Convert a value of a table to that of the command-line parser."""
    kind = typed_form(about).kind
    if kind is bool:
        if not isinstance(value, bool):
            raise OptionError(f"--{spelled(name)} must be true or false, not {value!r}", option=name)
        return value
    texts = list(_texts(about, value))
    if kind == list[str]:
        return texts
    if len(texts) != 1:
        raise OptionError(f"--{spelled(name)} takes one value, not {value!r}", option=name)
    if kind in (int, float):
        try:
            return kind(texts[0])
        except ValueError:
            word = "whole number" if kind is int else "number"
            raise OptionError(f"--{spelled(name)} {texts[0]!r}: must be a {word} without a unit", option=name) from None
    if about.form is None and texts[0] not in get_args(kind):
        listed = ", ".join(about.choices)
        raise OptionError(f"--{spelled(name)} must be one of {listed}, not {texts[0]!r}", option=name)
    return texts[0]


def _texts(about: Option | None, value: Any) -> Iterator[str]:  # noqa: ANN401  of any form
    """Words of an option, each after its name; several values of an option that is not repeated are one word."""
    if isinstance(value, Mapping):
        yield ",".join(f"{key}={_text(item)}" for key, item in value.items())
    elif isinstance(value, list | tuple):
        texts = [_text(item) for item in value]
        repeated = about is None or typed_form(about).kind == list[str]
        yield from texts if repeated else [",".join(texts)]
    else:
        yield _text(value)


def _text(value: object) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return repr(value)
    raise OptionError(f"a value must be a text, a number, or several, not {value!r}", option="config")


def _key(key: str) -> str:
    return key if key.replace("_", "").replace("-", "").isalnum() and key.isascii() else _quoted(key)


def _toml(value: Any) -> str:  # noqa: ANN401  of any form
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(str(key))} = {_toml(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return _quoted(str(value))


def _quoted(text: str) -> str:
    """Quote a string for TOML, which is as in JSON except for the control character 7F."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
