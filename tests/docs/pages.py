"""Run the code blocks of the pages: ``PYTHONPATH=python .venv/bin/python tests/docs/pages.py [--write] PAGE…``.

The ``sh`` and ``python`` blocks of a page run in order in one folder; the python blocks share one namespace. A comment on
the line above a block states how it is treated:

- ``<!-- save: NAME -->``: the block is a file of the reader, and is written into the folder.
- ``<!-- output -->``: the block is what the last block that ran printed. A ``text`` block directly below a block that
  runs needs no comment. Of Python all is shown; of commands lines may be left out, and the standard error of each follows
  its standard output. ``<!-- output: PART -->`` shows the whole part: ``whole`` (standard output), ``first paragraph``,
  ``first N lines``, ``last N lines``, ``messages`` (standard error) or ``screen`` (both).
- ``<!-- file: NAME -->``: the block is a file that the commands wrote.
- ``<!-- not run: REASON -->``: a python block that is only compiled, or a text block that is not the output.

``--write`` writes the outputs and files into the pages; without it they are compared. The folder of a page is made by
``make(folder)`` of tests/docs/files_of/PAGE.py, or of the module of the page's folder (how_to.py for docs/how-to).
``SUBSTITUTED`` of this module replaces what cannot be had in a test; with ``ALONE = True`` each python block has a
namespace of its own. A shell command ends with code 0, or with that of
its comment ``# exit code 3``.
"""

from __future__ import annotations

import argparse
import contextlib
import functools
import importlib.util
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import patch

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FILES_OF = Path(__file__).resolve().parent / "files_of"

RUN = ("sh", "python")
# Other languages of blocks: files, output, and Python that is a file written by a command.
SHOWN = ("text", "toml", "yaml", "csv", "json", "xml", "math", "python-file", "mermaid")

# Programs that are not run, with reasons. `test_pages.py` checks those of their arguments that concern this project.
UNRUN = {
    "make": "builds or tests; the targets are checked",
    "pip": "installs; the extras are checked",
    ".venv/bin/pre-commit": "changes the clone",
    "dask": "starts servers on other hosts",
    "helm": "needs a cluster",
    "openssl": "makes a certificate",
    "kubectl": "needs a cluster",
}

_FENCE = re.compile(r"^( *)(`{3,})([^\s`]*)[^`]*$")
_NOTE = re.compile(r"^ *<!-- (save|output|file|not run)(?:: (.+?))? -->$")
_QUOTED = re.compile(r"'[^']*'|\"[^\"$`\\]*\"")
_COMMENT = re.compile(r"(?:^|\s)#.*$", flags=re.MULTILINE)
_OPERATORS = re.compile(r"[|&;<>()`]")
_WORDS = re.compile(r"[*?\[{$~]")  # text that bash expands
_EXIT_CODE = re.compile(r"# exit code (\d+)")
_KEYWORDS = {"for": "done", "while": "done", "until": "done", "if": "fi", "case": "esac", "{": "}"}


class BrokenPageError(AssertionError):
    """A block of a page does not do what the page states."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Block:
    """A fenced block of a page."""

    language: str
    content: str
    note: str  # kind of the comment above the block, or empty
    of: str  # name in the comment
    line: int  # first line of the content, from 1
    indent: str
    below: bool  # whether only blank lines are between this block and a block that runs, above

    @property
    def shows(self) -> str:
        """``output`` or ``file`` if the block shows the result of the commands above it; otherwise empty."""
        if self.note in ("output", "file"):
            return self.note
        return "output" if self.language == "text" and self.below and not self.note else ""


def blocks(text: str) -> list[Block]:
    """The fenced blocks of a page."""
    parsed: list[Block] = []
    lines = text.split("\n")
    last, below = "", False  # the last line that is not blank; whether it ended a block that runs
    k = 0
    while k < len(lines):
        if not (fence := _FENCE.match(lines[k])):
            if lines[k].strip():
                last, below = lines[k], below and bool(_NOTE.match(lines[k]))
            k += 1
            continue
        indent, marks, language = fence.groups()
        end = next((i for i in range(k + 1, len(lines)) if lines[i].strip() == marks), None)
        if end is None:
            raise BrokenPageError(f"line {k + 1}: the block has no end")
        content = "".join(line.removeprefix(indent) + "\n" for line in lines[k + 1 : end])
        note = _NOTE.match(last)
        parsed.append(
            Block(
                language=language, content=content, note=note[1] if note else "", of=(note[2] or "") if note else "",
                line=k + 2, indent=indent, below=below,
            )
        )  # fmt: skip
        last, below, k = "", language in RUN, end + 1
    return parsed


def prose(text: str) -> str:
    """A page without its blocks."""
    text_lines, marks = [], ""
    for line in text.split("\n"):
        fence = _FENCE.match(line)
        if marks:
            marks = "" if line.strip() == marks else marks
        elif fence:
            marks = fence[2]
        else:
            text_lines.append(line)
    return "\n".join(text_lines)


def statements(content: str) -> list[str]:
    """The commands of a block: a line, or several that belong together."""
    complete, waiting = [], ""
    for line in content.splitlines():
        waiting += line + "\n"
        if _complete(waiting):
            complete.append(waiting)
            waiting = ""
    if waiting:
        raise BrokenPageError(f"a command without an end: {waiting.strip()}")
    return [statement for statement in complete if without_comments(statement).strip()]


def without_comments(statement: str) -> str:
    """A command without its comments."""
    masked, result, position = _masked(statement), "", 0
    for comment in _COMMENT.finditer(masked):
        result, position = result + statement[position : comment.start()], comment.end()
    return result + statement[position:]


def _masked(text: str) -> str:
    """Replace quoted text by letters."""
    return _QUOTED.sub(lambda quoted: "Q" * len(quoted[0]), text)


def _complete(text: str) -> bool:
    lines = text.rstrip("\n").split("\n")
    if lines[-1].endswith("\\"):
        return False
    if document := re.search(r"<<\s*['\"]?(\w+)", text):
        return len(lines) > 1 and lines[-1] == document[1]
    end = _KEYWORDS.get(text.split(None, 1)[0]) if text.strip() else None
    if end is not None:
        return re.search(rf"(?:^|[\s;]){re.escape(end)}(?=[\s;|>]|$)", without_comments(lines[-1])) is not None
    try:
        shlex.split(text, comments=True)
    except ValueError:  # a quotation continues
        return False
    return True


def program_of(statement: str) -> str:
    """The first word of a command, without assignments before it."""
    words = without_comments(statement).split()
    return next((word for word in words if not re.match(r"\w+=", word)), "")


@dataclass(slots=True)
class Page:
    """A page, and the results of its blocks."""

    path: Path
    text: str
    folder: Path
    substituted: dict[str, str] = field(default_factory=dict)
    alone: bool = False  # whether each python block has a separate namespace
    scope: dict[str, Any] = field(default_factory=dict)
    printed: tuple[str, str] | None = None  # standard output and standard error of the last block that ran
    of_commands: str = ""  # the same by command, if it was a block of commands
    shown: list[tuple[Block, str]] = field(default_factory=list)  # blocks that show a result, and the current result

    def run(self) -> None:
        """Run all blocks in order."""
        for old in self.substituted:
            if old not in self.text:
                raise BrokenPageError(f"{self.path.name}: its substitution of {old!r} is not needed")
        for block in blocks(self.text):
            try:
                self._do(block)
            except BrokenPageError as error:
                raise BrokenPageError(f"{self.path.name}, block of line {block.line}: {error}") from None
            except BaseException as error:
                error.add_note(f"{self.path.name}, block of line {block.line}")
                raise

    def _do(self, block: Block) -> None:
        content = block.content
        for old, new in self.substituted.items():
            content = content.replace(old, new)
        if block.note == "save":
            place = self.folder / block.of
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(content, encoding="utf-8")
        elif block.shows == "file":
            self.shown.append((block, file_of(self.folder / block.of)))
        elif block.shows == "output":
            if self.printed is None:
                raise BrokenPageError("nothing ran whose output this could be")
            out, err = self.printed
            now = (
                part(out, err, block.of)
                if block.of or not self.of_commands
                else excerpt(self.of_commands, block.content)
            )
            self.shown.append((block, now))
        elif block.language == "python":
            code = compile("\n" * (block.line - 1) + content, str(self.path), "exec")
            if block.note != "not run":
                scope = {} if self.alone else self.scope
                with _printed() as out:
                    exec(code, scope)
                self.printed, self.of_commands = out(), ""
        elif block.language == "sh":
            if block.note:
                raise BrokenPageError(f"shell commands run: no comment '{block.note}'")
            printed = [self._command(statement) for statement in statements(content)]
            self.printed = "".join(out for out, _ in printed), "".join(err for _, err in printed)
            self.of_commands = "".join(out + err for out, err in printed)

    def _command(self, statement: str) -> tuple[str, str]:
        """Run a shell command; return its output."""
        wanted = int(match[1]) if (match := _EXIT_CODE.search(statement)) else 0
        line = without_comments(statement).strip().replace("\\\n", " ")
        masked = _masked(line)
        program = program_of(statement)
        if program in UNRUN:
            if re.search(r"[;&|]\s*sigmatau ", masked):
                raise BrokenPageError(f"{line}\n{program} does not run; put sigmatau on a line of its own")
            return "", ""
        if program in ("cd", "export") and not _OPERATORS.search(masked):
            self._change(_words(line))
            return "", ""
        target = re.fullmatch(r"[^|&;<>()`]* > ([\w./-]+)", masked)
        if program == "sigmatau" and line.startswith("sigmatau") and (target or not _OPERATORS.search(masked)):
            words = _words(line[: target.start(1) - 3] if target else line)
            with _printed() as printed:
                code = _sigmatau(words[1:])
            out, err = printed()
            if target:
                Path(target[1]).write_text(out, encoding="utf-8")
                out = ""
        else:
            done = subprocess.run(
                ["bash", "-e", "-o", "pipefail", "-c", statement],
                capture_output=True, text=True, timeout=120, check=False, env=os.environ | _path(self.folder),
            )  # fmt: skip
            code, out, err = done.returncode, done.stdout, done.stderr
        if code != wanted:
            raise BrokenPageError(f"{line}\nends with exit code {code}, not {wanted}:\n{err or out}")
        return out, err

    def _change(self, words: list[str]) -> None:
        if words[0] == "cd":
            os.chdir(words[1])
            return
        for word in words[1:]:
            name, _, value = word.partition("=")
            os.environ[name] = value

    def check(self) -> None:
        """Raise `BrokenPageError` if a block does not show the result of the commands."""
        for block, now in self.shown:
            same = now == block.content if block.shows == "file" else alike(now, block.content)
            if not same:
                raise BrokenPageError(
                    f"{self.path.name}, line {block.line}: shown is\n{block.content}\nbut today it is\n{now}\n"
                    f"tests/docs/pages.py --write {self.path.name} writes it"
                )

    def written(self) -> str:
        """The text of the page with the current results."""
        lines = self.text.split("\n")
        for block, now in reversed(self.shown):
            first, count = block.line - 1, block.content.count("\n")
            lines[first : first + count] = [f"{block.indent}{line}".rstrip() for line in now.splitlines()]
        return "\n".join(lines)


def _words(line: str) -> list[str]:
    """The words of a command, expanded by bash if necessary."""
    if not _WORDS.search(_QUOTED.sub("", line)):
        return shlex.split(line)
    done = subprocess.run(["bash", "-e", "-c", rf"printf '%s\0' {line}"], capture_output=True, text=True, check=True)
    return done.stdout.split("\0")[:-1]


def _sigmatau(argv: list[str]) -> int:
    from sigmatau.cli import main

    return main(argv)


@contextlib.contextmanager
def _printed() -> Iterator[Any]:
    """Keep what is printed; the value returns both streams."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))

    def both() -> tuple[str, str]:
        for stream in (out, err):
            stream.flush()
        return tuple(stream.buffer.getvalue().decode() for stream in (out, err))

    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            yield both
    except Exception as error:
        error.add_note("".join(both())[-2000:])
        raise


@functools.cache
def _shim() -> Path:
    """A folder with the command `sigmatau`, for shells."""
    folder = Path(tempfile.mkdtemp(prefix="sigmatau-bin-"))
    (folder / "sigmatau").write_text(f'#!/bin/sh\nexec "{sys.executable}" -m sigmatau "$@"\n')
    (folder / "python").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    for program in folder.iterdir():
        program.chmod(0o755)
    import atexit

    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _path(folder: Path) -> dict[str, str]:
    import sigmatau

    package = str(Path(sigmatau.__file__).parents[1])
    return {"PATH": os.pathsep.join([str(_shim()), str(folder), os.environ["PATH"]]), "PYTHONPATH": package}


def part(out: str, err: str, of: str) -> str:
    """Part of an output that a page shows; see the module."""
    printed = {"messages": err, "screen": out + err}.get(of, out)
    lines = [f"{line.rstrip()}\n" for line in printed.splitlines()]
    if of == "first paragraph":
        lines = lines[: lines.index("\n")] if "\n" in lines else lines
    elif match := re.fullmatch(r"(first|last) (\d+) lines?", of):
        count = int(match[2])
        lines = lines[:count] if match[1] == "first" else lines[-count:]
    elif of not in ("", "whole", "messages", "screen"):
        raise BrokenPageError(f"unknown part of an output: {of}")
    return "".join(lines)


def excerpt(printed: str, shown: str) -> str:
    """Current lines of an output that a page shows; all lines if the page shows none."""
    lines = [line.rstrip() for line in printed.splitlines()]
    if not shown.strip():
        return "".join(f"{line}\n" for line in lines)
    lines_shown, position = [], 0
    for line in shown.splitlines():
        if line.strip() in ("", "…"):  # omitted lines
            lines_shown.append(line)
            continue
        k = next((k for k in range(position, len(lines)) if alike(lines[k], line)), None)
        if k is None:
            k = next((k for k in range(position, len(lines)) if _words_of(lines[k]) == _words_of(line)), None)
        if k is None:
            raise BrokenPageError(f"shown, but not printed:\n{line}\nprinted is:\n{printed}")
        lines_shown.append(lines[k])
        position = k + 1
    return "".join(f"{line}\n" for line in lines_shown)


def file_of(place: Path) -> str:
    """The text of a written file, without comments of XML."""
    if not place.exists():
        raise BrokenPageError(f"{place.name} is not written")
    return re.sub(r"^ *<!--.*?-->\n", "", place.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


_NUMBER = r"[-+]?\d[\d.]*(?:e[-+]?\d+)?"


def alike(first: str, second: str) -> bool:
    """Whether the words are equal, and the numbers to a last digit that may depend on the processor."""
    pairs = zip(re.findall(_NUMBER, first), re.findall(_NUMBER, second), strict=False)
    return _words_of(first) == _words_of(second) and all(a == b or _close(a, b) for a, b in pairs)


def _words_of(text: str) -> list[str]:
    return re.sub(_NUMBER, "#", text).split()


def _close(a: str, b: str) -> bool:
    try:
        return bool(np.isclose(float(a), float(b), rtol=2e-3, atol=1e-18))
    except ValueError:  # a date or a version
        return False


def module_of(page: Path) -> ModuleType | None:
    """The module that makes the files of a page, or of the pages of its folder."""
    parts = page.resolve().relative_to(ROOT).with_suffix("").parts
    parts = parts[1:] if parts[0] == "docs" else parts
    names = ["_".join(parts[:k]).replace("-", "_").lower() for k in (len(parts), len(parts) - 1) if k]
    places = {place.stem.lower(): place for place in FILES_OF.glob("*.py")}
    return next((_loaded(places[name]) for name in names if name in places), None)


@functools.cache
def _loaded(place: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"files_of_{place.stem}", place)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@functools.cache
def _made(module: ModuleType) -> Path:
    """The files of a module, made once for all pages; pages run in copies."""
    import atexit

    folder = Path(tempfile.mkdtemp(prefix="sigmatau-pages-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    with _in_this_process(folder), _printed():
        module.make(folder)
    return folder


@contextlib.contextmanager
def _in_this_process(folder: Path) -> Iterator[None]:
    """A terminal of 80 columns in a folder; several logs are analysed in this process, which costs less than to start
    others: tests/cli/test_batch.py and tests/fleet start them.
    """
    from sigmatau.cli import batch

    def run(logs, work, *, jobs, keep=None):
        for log in logs:
            yield batch._outcome(log, work, keep)

    @contextlib.contextmanager
    def cluster(**_):
        from distributed import Client

        with Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0") as client:
            yield client

    variables = {"COLUMNS": "80", "LC_ALL": "C.UTF-8", "MPLBACKEND": "Agg"}
    before = Path.cwd()
    with (
        patch.object(batch, "run", run),
        patch("sigmatau.lab.fleet.run.cluster", cluster),
        patch.dict(os.environ, variables),
    ):
        os.environ.pop("SIGMATAU_STORE", None)
        os.chdir(folder)
        try:
            yield
        finally:
            os.chdir(before)


def run_page(path: Path, folder: Path, text: str | None = None) -> Page:
    """Run a page in a folder, with its files."""
    module = module_of(path)
    if module is not None and hasattr(module, "make"):
        shutil.copytree(_made(module), folder, dirs_exist_ok=True, symlinks=True)
    page = Page(
        path=path, text=path.read_text(encoding="utf-8") if text is None else text, folder=folder,
        substituted=getattr(module, "SUBSTITUTED", {}) if text is None else {},
        alone=getattr(module, "ALONE", False),
    )  # fmt: skip
    with _in_this_process(folder):
        page.run()
    return page


def main() -> int:
    """Run pages; compare or write their outputs."""
    parser = argparse.ArgumentParser(description="Run the code blocks of pages, and compare what the pages show.")
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--write", action="store_true", help="write outputs and files into the pages")
    chosen = parser.parse_args()
    failed = 0
    for path in chosen.pages:
        with tempfile.TemporaryDirectory() as folder:
            try:
                page = run_page(path, Path(folder))
                if chosen.write:
                    path.write_text(page.written(), encoding="utf-8")
                page.check() if not chosen.write else None
            except BrokenPageError as error:
                sys.stderr.write(f"{error}\n")
                failed += 1
    return min(failed, 1)


if __name__ == "__main__":
    sys.path[:0] = [str(ROOT / "tests"), str(ROOT)]  # files_of imports the helpers of tests, and benches
    raise SystemExit(main())
