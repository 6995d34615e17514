"""The command line: data on standard output, messages on standard error, exit codes 0, 1 (data) and 2 (options)."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run ``sigmatau`` with the given arguments and return its exit code.

    Returns
    -------
    int
        0 done; 1 a file or its data cannot be used; 2 an option is wrong or missing; 3 a unit is out of its specification;
        4 done with what could be read of a damaged file; 130 interrupted; 143 terminated (SIGTERM).
    """
    # The matrices are small: threads of BLAS would only wait for each other. Read when NumPy is first imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    from cyclopts import CycloptsError

    from sigmatau.cli.app import app
    from sigmatau.errors import DataError, OptionError

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without √ gets a ?, not a traceback
    try:
        with _termination():
            result = app(
                sys.argv[1:] if argv is None else list(argv),
                exit_on_error=False,
                print_error=False,
                result_action="return_value",
            )
            sys.stdout.flush()
    except CycloptsError as error:
        return _fail(f"{error}{_hint(getattr(error, 'unused_tokens', None))}", 2)
    except OptionError as error:
        return _fail(_as_typed(str(error), error.option), 2)
    except (DataError, ImportError) as error:
        return _fail(str(error), 1)
    except MemoryError:
        return _fail("not enough memory for this record", 1)
    except _Terminated:
        return _fail("terminated", 128 + signal.SIGTERM)
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except BrokenPipeError:
        # The reader of our output has gone (`sigmatau … | head`): nothing to say, and nobody to say it to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if error.filename is not None:  # a name that no file can have, such as one that is too long
            return _fail(f"{str(error.filename)[:80]}: {error.strerror or error}", 1)
        # Other files name themselves in a DataError; what is left is standard output, on a full disk for instance.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _fail(f"standard output cannot be written: {error.strerror or error}", 1)
    return result if isinstance(result, int) else 0


def _hint(unused: Sequence[str] | None) -> str:
    """What to do about words that are left over: values of an option have commas between them, and export takes one file."""
    if not unused:
        return ""
    if all("=" in token for token in unused):
        return f" Several values of one option have commas between them: gyro=…,{unused[0]}"
    if all("." in token and not token.startswith("-") for token in unused):
        return " It takes no more files than that; for several, call it once for each."
    return ""


def _as_typed(message: str, option: str | None) -> str:
    """With the option as it is typed here, where a function names its argument."""
    return message if option is None else message.replace(f"`{option}`", f"--{option.replace('_', '-')}")


class _Terminated(KeyboardInterrupt):
    """SIGTERM: what cleans up after an interruption cleans up after this."""


def _terminated(*_: object) -> None:
    raise _Terminated


@contextlib.contextmanager
def _termination() -> Iterator[None]:
    """SIGTERM is an exception here, so that no half-written file is left behind; only the main thread may say so."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _terminated)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if before is None else before)


def _fail(message: str, code: int) -> int:
    from sigmatau.results import printable

    line = printable(" ".join(message.split()))
    sys.stderr.write(f"sigmatau: {line}\n")
    return code
