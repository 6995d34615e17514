"""Errors of sigmatau: what is wrong, where, what was found, what to do.

There are two families. A wrong or missing *option* (an unknown unit, no sampling rate, no such channel) is an `OptionError`:
the command line ends with exit code 2. *Data* that cannot be used are a `DataError`: exit code 1. Both are `ValueError`, so
that code which does not know sigmatau can catch them. All of them can be pickled, with their fields.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, Self


class _SourcedError(ValueError):
    """Base of all errors: a message, and the file or object that it is about.

    Attributes
    ----------
    source : str
        Name of the file or object, printed in front of the message; empty if not known.
    """

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.source: str = ""

    @property
    def message(self) -> str:
        """The message without the source."""
        return str(self.args[0])

    def about(self, source: str) -> Self:
        """The same error, with the file or object that it is about put in front.

        Parameters
        ----------
        source : str
            Name of the file or object. A source that the error has already is put behind it.

        Returns
        -------
        DataError or OptionError
            The error itself, changed.
        """
        self.source = _joined(source, self.source) if self.source else source
        return self

    def __str__(self) -> str:
        return _joined(self.source, self.message)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.args, self.__dict__)


def _joined(source: str, message: str) -> str:
    """A message that begins with a place, ``", line 5: …"``, follows the name of the file without a colon."""
    return f"{source}{'' if message.startswith(',') else ': '}{message}" if source else message


def _rebuilt(kind: type[_SourcedError], args: tuple[Any, ...], fields: dict[str, Any]) -> _SourcedError:
    """An error from its fields, for `pickle`, without the keyword arguments of its class."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(fields)
    return error


_PLACEHOLDER = re.compile(r'\{(?:option|@(\w+)(?:\[(\w+)\])?(?:=("[^"]*"|[^"}]*))?)\}')


def argument(name: str, value: object = None, *, key: str | None = None) -> str:
    """A placeholder for an argument in the message of an `OptionError`, in Python and on the command line.

    ``argument("walk")`` is printed as ```walk` `` or ``--walk``, ``argument("walk", "horizon", key="gyro")`` as
    ```walk={"gyro": "horizon"}` `` or ``--walk gyro=horizon``.
    """
    of = "" if key is None else f"[{key}]"
    text = "" if value is None else f'="{value}"' if isinstance(value, str) else f"={value}"
    return f"{{@{name}{of}{text}}}"


_PAIR = r"[a-z]\w*=[^\s,;)]+"
_TYPED = re.compile(rf"--([a-z][a-z-]*)((?: {_PAIR}(?:,{_PAIR})*(?: --\1(?= [a-z]\w*=))?)+|=\w+| HZ\b)?")


def as_arguments(message: str) -> str:
    """Options as they are typed, as arguments: ``--unit gyro=deg/s`` as ``unit={"gyro": "deg/s"}``."""

    def argument_of(match: re.Match[str]) -> str:
        name, value = match[1].replace("-", "_"), (match[2] or "").strip()
        if "=" not in value.lstrip("="):
            return f"`{name}={value.lstrip('=')}`" if value else f"`{name}`"
        pairs = [part.partition("=")[::2] for part in value.replace(",", " ").split() if "=" in part]
        quoted = (f'"{key}": {text if _NUMBER.fullmatch(text) else chr(34) + text + chr(34)}' for key, text in pairs)
        return f"`{name}={{{', '.join(quoted)}}}`"

    return _TYPED.sub(argument_of, message)


_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?")


class OptionError(_SourcedError):
    """An option is wrong, or a required option is missing.

    Parameters
    ----------
    message : str
        Message with the placeholder ``{option}`` for the option; `argument` makes placeholders for other options. They
        are printed as arguments in backticks in Python, and as ``--option`` on the command line.
    option : str or None
        Name of the option, e.g. ``"unit"``.
    rows : str
        Lines that show what the question is about, such as the first rows of a table.

    Attributes
    ----------
    option : str or None
        Name of the option.
    rows : str
        Lines below the message; empty if there are none.

    See Also
    --------
    DataError : data that cannot be used.

    Examples
    --------
    >>> from sigmatau import OptionError
    >>> error = OptionError("{option} must be between 0 and 1, not 95", option="level")
    >>> print(error)
    `level` must be between 0 and 1, not 95
    >>> error.for_command_line()
    '--level must be between 0 and 1, not 95'
    """

    def __init__(self, message: str, *, option: str | None = None, rows: str = "") -> None:
        super().__init__(message)
        self.option = option
        self.rows = rows
        if rows:
            self.add_note(rows)

    def __str__(self) -> str:
        def python(name: str, key: str | None, value: str | None) -> str:
            if value is None:
                return f"`{name}`"
            return f"`{name}={value}`" if key is None else f'`{name}={{"{key}": {value}}}`'

        return _joined(self.source, as_arguments(self._filled(python)))

    def for_command_line(
        self, names: Mapping[str, str] = MappingProxyType({}), units: Mapping[str, str] = MappingProxyType({})
    ) -> str:
        """The error with options as they are typed, without its rows.

        Parameters
        ----------
        names : mapping of str to str
            Options by argument, where the name differs by more than underscores.
        units : mapping of str to str
            Units of values by argument, where the command line needs one.

        Returns
        -------
        str
        """

        def typed(name: str, key: str | None, value: str | None) -> str:
            option = f"--{names.get(name, name).replace('_', '-')}"
            if value is None:
                return option
            pair = ("" if key is None else f"{key}=") + value.strip('"') + units.get(name, "")
            return f'{option} "{pair}"' if " " in pair else f"{option} {pair}"

        return _joined(self.source, self._filled(typed))

    def _filled(self, worded: Callable[[str, str | None, str | None], str]) -> str:
        return _PLACEHOLDER.sub(lambda match: worded(match[1] or str(self.option), match[2], match[3]), self.message)


class DataError(_SourcedError):
    """A file or an array cannot be used.

    Parameters
    ----------
    message : str
        The fault, its place, and the action to take.

    See Also
    --------
    OptionError : an option is wrong or missing.

    Examples
    --------
    >>> import sigmatau as st
    >>> try:
    ...     st.Record.from_arrays(rate=100)
    ... except st.DataError as error:
    ...     print(error)
    no channel was given; give at least one array, e.g. gyro_x=…
    """


class StampError(DataError):
    """The time stamps of a log do not give a grid, or time goes backwards in them."""


class RecordTooShortError(DataError):
    """There are too few samples.

    Parameters
    ----------
    message : str
        Description of the record that is too short, and the action to take.
    need, got : int
        Samples needed, and samples found.

    Attributes
    ----------
    need, got : int
        Samples needed, and samples found.

    See Also
    --------
    DataError : all data that cannot be used.

    Examples
    --------
    >>> import sigmatau as st
    >>> try:
    ...     st.Record.from_arrays(rate=100, gyro_x=[0.0, 0.1])
    ... except st.RecordTooShortError as error:
    ...     print(error.need, error.got)
    4 2
    """

    def __init__(self, message: str, *, need: int, got: int) -> None:
        super().__init__(message)
        self.need = need
        self.got = got


class NonFiniteError(DataError):
    """A sample is NaN or infinite.

    Parameters
    ----------
    message : str
        Place of the sample, and the action to take.
    channel : str
        Name of the channel.
    index : int
        Index of the first such sample, from 0.

    Attributes
    ----------
    channel : str
        Name of the channel.
    index : int
        Index of the first such sample, from 0.

    See Also
    --------
    DataError : all data that cannot be used.

    Examples
    --------
    >>> import math
    >>> import sigmatau as st
    >>> try:
    ...     st.Record.from_arrays(rate=100, gyro_x=[0.0, 0.1, math.inf, 0.2])
    ... except st.NonFiniteError as error:
    ...     print(error.channel, error.index)
    gyro_x 2
    """

    def __init__(self, message: str, *, channel: str, index: int) -> None:
        super().__init__(message)
        self.channel = channel
        self.index = index
