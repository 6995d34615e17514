"""Make the notebook and the figure of docs/tutorial: ``PYTHONPATH=python .venv/bin/python docs/tutorial.py``.

Both come from docs/tutorial/README.md: the notebook has its text, commands and outputs. tests/docs/test_tutorial.py compares
it, and runs the page.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shlex
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sigmatau.cli import main

HERE = Path(__file__).resolve().parent
PAGE = HERE / "tutorial" / "README.md"
NOTEBOOK = HERE / "tutorial" / "tutorial.ipynb"
FIGURE = HERE / "figures" / "tutorial-allan.png"

_LINK = "; [a notebook](tutorial.ipynb) has the same steps"  # of the page to the notebook
_BLOCK = re.compile(r"(?:^<!-- (save|file|output)(?:: (.+?))? -->\n)?^```(\w+)\n(.*?)^```\n", re.DOTALL | re.MULTILINE)
# First cell of the notebook
_SETTINGS = """\
# A terminal of 80 columns without progress bars
%env TERM=dumb
%env COLUMNS=80
"""
_COLOURS = 64  # of the figure

Cell = dict[str, Any]


def _lines(text: str) -> list[str]:
    return text.strip("\n").splitlines(keepends=True)


def cells(page: str) -> list[Cell]:
    """The cells of the notebook: text, files, commands and Python, with what the page shows of their output."""
    made: list[Cell] = []

    def text(content: str) -> None:
        if content.strip():
            made.append({"cell_type": "markdown", "metadata": {}, "source": _lines(content)})

    def code(content: str) -> None:
        made.append(
            {"cell_type": "code", "execution_count": None, "metadata": {}, "outputs": [], "source": _lines(content)}
        )

    def output(content: str, stream: str) -> None:
        last = next(cell for cell in reversed(made) if cell["cell_type"] == "code")
        last["outputs"].append({"name": stream, "output_type": "stream", "text": content.splitlines(keepends=True)})

    end = 0
    page = page.replace(_LINK, "")
    code(_SETTINGS)
    for block in _BLOCK.finditer(page):
        text(page[end : block.start()])
        end = block.end()
        note, name, language, content = block.groups()
        if note == "save":
            code(f"%%writefile {name}\n{content}")
        elif note == "file":
            code(f"!cat {name}")
            output(content, "stdout")
        elif language == "text":
            output(content, "stderr" if name == "messages" else "stdout")
        elif language == "sh":
            code(re.sub(r"^(?=\S)", "!", content, flags=re.MULTILINE))
        else:
            code(content)
    text(page[end:])
    for k, cell in enumerate(made):
        cell["id"] = f"cell-{k}"
    return made


def notebook() -> str:
    """The notebook as a file."""
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": kernel, "language_info": {"name": "python"}}
    whole = {"cells": cells(PAGE.read_text(encoding="utf-8")), "metadata": metadata, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(whole, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


@contextlib.contextmanager
def _inside(folder: Path) -> Iterator[None]:
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


def steps(made: list[Cell]) -> Iterator[tuple[str, str]]:
    """What Jupyter does with the cells: a file's name and its content, `!` and a command, or `python` and a source."""
    for cell in made:
        source = "".join(cell["source"]) + "\n"
        if cell["cell_type"] == "markdown" or source == _SETTINGS:
            continue
        if saved := re.fullmatch(r"%%writefile (\S+)\n(.*)", source, flags=re.DOTALL):
            yield saved[1], saved[2]
        elif source.startswith("!"):
            for command in source.replace("\\\n", " ").splitlines():
                yield "!", command.removeprefix("!")
        else:
            yield "python", source


def run(made: list[Cell], folder: Path) -> dict[str, Any]:
    """Run the cells as Jupyter does, in a folder and in this process; the names that they define."""
    scope: dict[str, Any] = {}
    with _inside(folder):
        for kind, content in steps(made):
            if kind == "!":
                _command(content)
            elif kind == "python":
                exec(content, scope)
            else:
                Path(kind).write_text(content, encoding="utf-8")
    return scope


def _command(line: str) -> None:
    if line.startswith("sigmatau "):
        if main(shlex.split(line)[1:]) != 0:
            raise RuntimeError(f"{line} failed")
    else:
        subprocess.run(["bash", "-e", "-c", line], check=True)


def figure(folder: Path) -> None:
    """Keep the figure that the commands wrote, in few colours."""
    from PIL import Image

    with Image.open(folder / "allan.png") as drawn:
        drawn.convert("RGB").quantize(_COLOURS).save(FIGURE, optimize=True)


if __name__ == "__main__":
    NOTEBOOK.write_text(notebook(), encoding="utf-8")
    with tempfile.TemporaryDirectory() as scratch:
        run(cells(PAGE.read_text(encoding="utf-8")), Path(scratch))
        figure(Path(scratch))
