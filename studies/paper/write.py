"""Fill docs/paper: ``make paper``. Tables between marks, and the output below each block of Python or command line.

A page is its own template. ``<!-- made: NAME -->`` … ``<!-- end -->`` holds a table of `rows`; a block ``text`` below a
block ``python`` holds what this prints, below ``sh`` what the commands print.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

from sigmatau.cli import main as sigmatau
from studies.paper import days, figures
from studies.paper.rows import TABLES_OF, Days

__all__ = ["PAGES", "blocks", "made", "output_of", "printed_by", "updated"]

PAGES = Path(__file__).resolve().parents[2] / "docs" / "paper"

_MADE = re.compile(r"^(<!-- made: ([\w -]+) -->\n).*?^(<!-- end -->)", flags=re.DOTALL | re.MULTILINE)
_SHOWN = re.compile(r"^```(python|sh)\n(.*?)^```\n\n```text\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)


def made(page: str, found: Days) -> str:
    """A page with its tables."""
    return _MADE.sub(lambda mark: f"{mark[1]}\n{TABLES_OF[mark[2]](found)}\n\n{mark[3]}", page)


def printed_by(code: str) -> str:
    """What a block of Python prints."""
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(code, "docs/paper", "exec"), {})
    return _trimmed(out.getvalue())


def output_of(commands: str) -> str:
    """What commands print in an empty folder, on standard output."""
    out, before = io.StringIO(), Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for line in commands.splitlines():
                with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
                    code = sigmatau(shlex.split(line, comments=True)[1:])
                if code:
                    sys.exit(f"{line}: exit code {code}")
        finally:
            os.chdir(before)
    return _trimmed(out.getvalue())


def _trimmed(text: str) -> str:
    return "".join(f"{line.rstrip()}\n" for line in text.splitlines())


def blocks(page: str) -> list[tuple[str, str, str]]:
    """Language, content and shown output of the blocks of a page whose output is shown."""
    return [(block[1], block[2], block[3]) for block in _SHOWN.finditer(page)]


def updated(page: str, found: Days) -> str:
    """A page with its tables and outputs."""

    def shown(block: re.Match[str]) -> str:
        output = printed_by(block[2]) if block[1] == "python" else output_of(block[2])
        return f"```{block[1]}\n{block[2]}```\n\n```text\n{output}```"

    return made(_SHOWN.sub(shown, page), found)


def main() -> None:
    """Simulate what is not in the cache, draw the figures, and fill all pages."""
    days.save(days.results())
    found = days.load()
    figures.draw()
    for path in sorted(PAGES.glob("*.md")):
        sys.stderr.write(f"{path.name}\n")
        path.write_text(updated(path.read_text(encoding="utf-8"), found), encoding="utf-8")


if __name__ == "__main__":
    main()
