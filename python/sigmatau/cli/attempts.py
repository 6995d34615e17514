"""Outputs of an analysis. Each is attempted, even if another output fails."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from sigmatau.cli.messages import print_error
from sigmatau.errors import DataError, OptionError


class Attempts:
    """Outputs that are written in sequence; the errors are reported at the end."""

    def __init__(self) -> None:
        self.errors: list[OptionError | DataError | ImportError | OSError] = []

    @contextlib.contextmanager
    def attempt(self) -> Iterator[None]:
        """Write one output. An error does not prevent the next output."""
        try:
            yield
        except (OptionError, DataError, ImportError, OSError) as error:
            self.errors.append(error)

    def raise_first(self) -> None:
        """Raise the first error, if there is one."""
        if self.errors:
            raise self.errors[0]

    def finish(self, code: int) -> int:
        """Print all errors except the last, which is raised and printed by `main`; without errors, return the code."""
        if not self.errors:
            return code
        *earlier, last = sorted(self.errors, key=lambda error: isinstance(error, OptionError))
        for error in earlier:
            print_error(str(error))
        raise last
