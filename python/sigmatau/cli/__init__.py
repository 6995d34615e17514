"""The command line: data on standard output, messages on standard error, exit codes 0, 1 (data), 2 (options) and others."""

from __future__ import annotations

import atexit
import contextlib
import gc
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextvars import copy_context
from typing import TYPE_CHECKING

from sigmatau.hints import as_options, speaking
from sigmatau.process import keep_freed

if TYPE_CHECKING:
    from cyclopts import CycloptsError

_UNUSED_HINT = "Write the values of an option directly after it (gyro=… accel=…); run the command once for each file."
_OTHER_NAMES = {
    ("lot", "--datasheet"): "the specification is --spec",
    ("analyze", "--datasheet"): "after analyze --json RESULT.json: sigmatau lot RESULT.json --spec NAME",
    ("analyze", "--spec"): "after analyze --json RESULT.json: sigmatau lot RESULT.json --spec NAME",
    ("compare", "--spec"): "sigmatau lot RESULTS --spec NAME compares with a specification",
    ("export", "--datasheet"): "the values of a datasheet are --from-datasheet NAME",
    (
        "analyze",
        "--output",
    ): "outputs are --report r.html, --json r.json, --csv r.csv, --plot p.png and --export TARGET=FILE",
    ("analyze", "-o"): "outputs are --report r.html, --json r.json, --csv r.csv, --plot p.png and --export TARGET=FILE",
    ("analyze", "--to"): "the file of a filter is --export TARGET=FILE, e.g. --export kalibr=imu.yaml",
    ("analyze", "--duration"): "a part of the record is --window 0s:600s",
    ("fleet", "--export"): "the file of a filter is written by sigmatau analyze LOG --export TARGET=FILE",
    ("fleet", "--json"): "the results go into --store PLACE",
    ("fleet", "--joint"): "sigmatau analyze --joint takes the logs of one sensor",
    ("simulate", "--minutes"): "the length is --hours, 0.1667 for ten minutes",
    ("simulate", "--duration"): "the length is --hours, 0.1667 for ten minutes",
    ("analyze", "--freq"): "the sampling rate is --rate",
    ("analyze", "--fs"): "the sampling rate is --rate",
}
"""Hints for options that belong to another command or program."""


@speaking(as_options)
def main(argv: Sequence[str] | None = None) -> int:
    """Run ``sigmatau`` with the given arguments and return its exit code.

    Returns
    -------
    int
        0: done; 1: a file or its data cannot be used; 2: an option is wrong or missing; 3: a unit does not meet its
        specification; 4: done with the readable part of a damaged file; 5: the sensor is not at rest, or the record is
        too short to tell; 130: interrupted; 143: terminated (SIGTERM).
    """
    # The matrices are small, so that threads of BLAS would only wait for each other. NumPy reads this when it is imported.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if "matplotlib" not in sys.modules:
        os.environ.pop("MPLBACKEND", None)  # no window is opened; the backend that Jupyter sets may not be installed
    keep_freed()
    atexit.register(gc.freeze)  # skip the garbage collection at the end, which took as long as an import
    from cyclopts import CycloptsError

    from sigmatau.cli.app import app
    from sigmatau.cli.earlier import removing_stale_outputs
    from sigmatau.cli.symbols import plain_streams
    from sigmatau.cli.words import repeat_options, with_config
    from sigmatau.errors import DataError, OptionError

    plain_streams()
    words = sys.argv[1:] if argv is None else list(argv)
    try:
        with _termination(), removing_stale_outputs():
            result = copy_context().run(  # the units of ``--show`` are reset after the command
                app,
                [*words[1:], "--help"] if words[:1] == ["help"] else repeat_options(app, with_config(words)),
                exit_on_error=False,
                print_error=False,
                result_action="return_value",
            )
            sys.stdout.flush()
    except CycloptsError as error:
        return _fail(_error_text(error), 2)
    except OptionError as error:
        return _fail(str(error), 2, rows=error.rows)
    except (DataError, ImportError) as error:
        return _fail(str(error), 1)
    except MemoryError:
        return _fail(
            "not enough memory for this record; analyse a part of it (--window), or save it as .npy, which stays on disk,"
            " and take --long strided",
            1,
        )
    except _Terminated:
        return _fail("terminated", 128 + signal.SIGTERM)
    except KeyboardInterrupt:
        return _fail("interrupted", 130)
    except (BrokenPipeError, SystemExit) as error:
        # The reader of the output has stopped (`sigmatau … | head`). Rich then raises SystemExit.
        if isinstance(error, SystemExit) and not isinstance(error.__context__, BrokenPipeError):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        if error.filename is not None:  # an invalid file name, such as one that is too long
            return _fail(f"{str(error.filename)[:80]}: {error.strerror or error}", 1)
        # Errors of other files are a DataError; the remaining case is standard output, for instance on a full disk.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return _fail(f"standard output cannot be written: {error.strerror or error}", 1)
    return result if isinstance(result, int) else 0


def _error_text(error: CycloptsError) -> str:
    """Describe an error of the command line, with the text to type."""
    from cyclopts import CoercionError, MissingArgumentError, UnknownOptionError, UnusedCliTokensError

    command = error.command_chain[0] if error.command_chain else ""
    if command == "datasheet" and isinstance(error, MissingArgumentError):
        return "sigmatau datasheet list, or sigmatau datasheet show NAME"
    if command == "datasheet" and isinstance(error, CoercionError) and error.token and not error.token.keyword:
        return f"datasheet takes list or show: sigmatau datasheet show {error.token.value}"
    words = " ".join(error.command_chain or ())
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        name = error.argument.name
        if error.keyword or error.argument.tokens:
            return f"{words}: {error.keyword or name} needs a value; see sigmatau {words} --help"
        unknown = [token for token in error.unused_tokens or () if token.startswith("--")]
        option = unknown[0].partition("=")[0] if unknown else ""
        hint = _OTHER_NAMES.get((command, option))
        unknown_words = f"; unknown option {option}{f': {hint}' if hint else ''}" if option else ""
        return f"{words}: {name} is missing{unknown_words}; see sigmatau {words} --help"
    if isinstance(error, CoercionError) and error.token and (command, error.token.keyword) == ("deviation", "--kind"):
        return _explain_kind(error.token.value)
    if command == "fleet" and isinstance(error, CoercionError) and error.token and not error.token.keyword:
        return f"the logs follow the word analyze: sigmatau fleet analyze {error.token.value}"
    if isinstance(error, UnknownOptionError):
        option = (error.token.keyword or error.token.value).partition("=")[0]
        if option == "-":
            return f"sigmatau {command} reads files. Save the samples first; live samples: … | sigmatau watch"
        if hint := _OTHER_NAMES.get((command, option)):
            return f"unknown option {option}: {hint}"
        if command == "export" and (name := _as_target(option.lstrip("-"))):
            return f"unknown option {option}: the target is --to {name}"
    if isinstance(error, UnusedCliTokensError):
        unused = error.unused_tokens or []
        if command == "export" and unused and (name := _as_target(unused[0])):
            return f"{unused[0]!r} is not expected here: the target is --to {name}"
        if all(map(os.path.lexists, unused)):
            return f"sigmatau {words} takes one file, and {', '.join(unused)} is one more. Run it once for each file"
        return f"{', '.join(map(repr, unused))} not expected here. {_UNUSED_HINT}"
    if isinstance(error, CoercionError) and error.target_type in (int, float) and error.token and error.token.keyword:
        kind = "whole number" if error.target_type is int else "number"
        return (
            f"{error.token.keyword} {error.token.value!r}: must be a {kind} without a unit; see sigmatau {words} --help"
        )
    return str(error)


def _explain_kind(kind: str) -> str:
    """Message for a word that is not a kind of deviation."""
    from sigmatau.errors import OptionError
    from sigmatau.estimators.deviation_kinds import estimator

    try:
        estimator(kind)
    except OptionError as error:
        return str(error)
    return ""


def _as_target(name: str) -> str:
    """Name of an export target; empty if there is no such target."""
    from sigmatau.errors import OptionError
    from sigmatau.exporting.targets import target

    try:
        return target(name).name
    except OptionError:
        return ""


class _Terminated(KeyboardInterrupt):
    """SIGTERM as an exception, handled like an interruption, so that temporary files are removed."""


def _terminated(*_: object) -> None:
    raise _Terminated


@contextlib.contextmanager
def _termination() -> Iterator[None]:
    """Turn SIGTERM into an exception, so that half-written files are removed; this is only possible in the main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, _terminated)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL if before is None else before)


def _fail(message: str, code: int, *, rows: str = "") -> int:
    from sigmatau.cli.messages import print_error

    print_error(message, rows=rows)
    return code
