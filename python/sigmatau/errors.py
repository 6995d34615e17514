"""Errors of sigmatau: what is wrong, where, what was found, what to do.

There are two families. A wrong or missing *option* (an unknown unit, no sampling rate, no such channel) is an `OptionError`:
the command line ends with exit code 2. *Data* that cannot be used are a `DataError`: exit code 1. Both are `ValueError`, so
that code which does not know sigmatau can catch them. All of them can be pickled, with their fields.
"""

from __future__ import annotations

import unicodedata
from typing import Any, Self

from sigmatau.hints import Face, Hint, as_options, hints_in, worded


class _SourcedError(ValueError):
    """Base of all errors: a message, the file or object that it is about, and the place in it.

    The options that it names are hints in the message; see `sigmatau.hints`.

    Attributes
    ----------
    source : str
        Name of the file or object, printed in front of the message; empty if not known.
    place : str
        Where it is in the source, ``"line 5"``; empty for the whole.
    """

    def __init__(self, message: str, *, place: str = "") -> None:
        super().__init__(message)
        self.source: str = ""
        self.place = place

    @property
    def message(self) -> str:
        """The message without source and place, with hints in it."""
        return str(self.args[0])

    @property
    def text(self) -> str:
        """The message after its source and place, with hints in it."""
        return ": ".join(filter(None, [", ".join(filter(None, [self.source, self.place])), self.message]))

    @property
    def reason(self) -> str:
        """The message after its place, for callers that name the source themselves."""
        return self.without(self.source)

    @property
    def hints(self) -> tuple[Hint, ...]:
        """The options that the message names."""
        return hints_in(self.message)

    def for_command_line(self) -> str:
        """The error with options as they are typed."""
        return worded(self.text, as_options)

    def without(self, source: str, face: Face | None = None) -> str:
        """The error for callers that name this source themselves. Any other source remains in the message.

        Parameters
        ----------
        source : str
            Name of the file or object, as passed to `about`.
        face : callable, optional
            Face that words the options. Default: that of this process.

        Returns
        -------
        str
        """
        about = "" if self.source == source else self.source
        return worded(": ".join(filter(None, [about, self.place, self.message])), face)

    def about(self, source: str) -> Self:
        """Prefix the file or object to the error.

        Parameters
        ----------
        source : str
            Name of the file or object. An existing source follows it.

        Returns
        -------
        DataError or OptionError
            The error itself, changed.
        """
        self.source = f"{source}: {self.source}" if self.source else source
        return self

    def at(self, place: str) -> Self:
        """The same error, at a place of its source.

        Parameters
        ----------
        place : str
            ``"line 5"``. An existing place follows it.

        Returns
        -------
        DataError or OptionError
            The error itself, changed.
        """
        self.place = f"{place}, {self.place}" if self.place else place
        return self

    def __str__(self) -> str:
        return "\n".join(map(printable, worded(self.text).split("\n")))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({str(self)!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuilt, (type(self), self.args, self.__dict__)


def printable(text: str) -> str:
    r"""Text from a file in one line for a terminal: any other character that does not print as ``\n``, ``\x1b``.

    Examples
    --------
    >>> print(printable("gyro_x\nforged: 1"))
    gyro_x\nforged: 1
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else " " if unicodedata.category(c) == "Zs" else ascii(c)[1:-1] for c in text)


def _rebuilt(kind: type[_SourcedError], args: tuple[Any, ...], fields: dict[str, Any]) -> _SourcedError:
    """An error from its fields, for `pickle`, without the keyword arguments of its class."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(fields)
    return error


class OptionError(_SourcedError):
    """An option is wrong, or a required option is missing.

    Parameters
    ----------
    message : str
        Message with the placeholder ``{option}`` for the option, and a `Hint` for other options. They are printed as
        arguments in backticks in Python, and as ``--option`` on the command line.
    option : str or None
        Name of the option, e.g. ``"unit"``.
    rows : str
        Lines that show what the question is about, such as the first rows of a table.
    question : str
        The message without the answers, for a page that has a button for each. Default: the message.

    Attributes
    ----------
    option : str or None
        Name of the option.
    question : str
        The message without the answers.
    key : str
        Part of the option that is wrong, printed after its name; usually empty.
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

    def __init__(self, message: str, *, option: str | None = None, rows: str = "", question: str = "") -> None:
        super().__init__(message)
        self.option = option
        self.question = question
        self.key = ""
        self.rows = rows
        if rows:
            self.add_note(rows)

    @property
    def message(self) -> str:
        """The message without source and place, with hints in it."""
        return super().message.replace("{option}", " ".join(filter(None, [str(Hint(str(self.option))), self.key])))

    def named(self, option: str, key: str = "") -> Self:
        """The same error about another option: that of the function that the user called.

        Parameters
        ----------
        option : str
            Name of the option.
        key : str
            Part of it that is wrong, printed after its name: ``"of gyro"``.

        Returns
        -------
        OptionError
            The error itself, changed.
        """
        self.option, self.key = option, key
        return self


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
    """The time stamps of a log do not form a grid, or go backwards."""


class NotAtRestError(DataError):
    """A sensor that is not at rest, or a record that is too short to tell, where coefficients are needed."""


class RecordTooShortError(DataError):
    """There are too few samples.

    Parameters
    ----------
    message : str
        Description of the record that is too short, and the action to take.
    need, got : int
        Samples needed, and samples found.
    place : str
        Where it is in the source.

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

    def __init__(self, message: str, *, need: int, got: int, place: str = "") -> None:
        super().__init__(message, place=place)
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
    place : str
        Where it is in the source, ``"line 5"``.

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

    def __init__(self, message: str, *, channel: str, index: int, place: str = "") -> None:
        super().__init__(message, place=place)
        self.channel = channel
        self.index = index
