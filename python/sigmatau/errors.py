"""The errors of sigmatau: what is wrong, where, what was got, what to do.

Two families, told apart by who can mend it. A wrong or missing *option* (an unknown unit, no sampling rate anywhere,
no such channel) is an `OptionError`: the command line ends with exit code 2. *Data* that cannot be used is a
`DataError`: exit code 1. Both are `ValueError`, so that code which knows nothing of sigmatau can catch them.
"""

from __future__ import annotations

__all__ = ["DataError", "NonFiniteError", "OptionError", "RecordTooShortError"]


class OptionError(ValueError):
    """An option is wrong, or one is missing that neither the file nor a default can supply.

    Attributes
    ----------
    option : str or None
        The option to give, as on the command line without its dashes, e.g. ``"unit"``.
    """

    def __init__(self, message: str, *, option: str | None = None) -> None:
        super().__init__(message)
        self.option = option


class DataError(ValueError):
    """A file or an array that cannot be used as it is."""


class RecordTooShortError(DataError):
    """Too few samples for what was asked.

    Attributes
    ----------
    need, got : int
        Samples needed, samples found.
    """

    def __init__(self, message: str, *, need: int, got: int) -> None:
        super().__init__(message)
        self.need = need
        self.got = got


class NonFiniteError(DataError):
    """A sample is NaN or infinite.

    Attributes
    ----------
    channel : str
        Name of the channel.
    index : int
        Index of the first such sample, counted from 0.
    """

    def __init__(self, message: str, *, channel: str, index: int) -> None:
        super().__init__(message)
        self.channel = channel
        self.index = index
