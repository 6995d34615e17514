"""Write into the pages of docs/how-to what their commands write: ``PYTHONPATH=python .venv/bin/python docs/how_to.py``.

The model is `imu.toml` of docs/how-to/README.md; tests/export/test_how_to.py holds the pages to it.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import tempfile
from pathlib import Path

from sigmatau.cli import main
from sigmatau.exporting.targets import NAMES

HOW_TO = Path(__file__).resolve().parent / "how-to"
_SHOWN = re.compile(r"^(```(?:yaml|python-file|text)\n)(.*?)^```", flags=re.DOTALL | re.MULTILINE)


def model() -> str:
    """The model of the pages, as the index prints it."""
    (block,) = re.findall(
        r"^```toml\n(.*?)^```", (HOW_TO / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    return str(block)


def commands(page: str) -> list[list[str]]:
    """The export commands of a page that take the model, as lists of arguments."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)
    lines = [shlex.split(line, comments=True) for block in blocks for line in block.splitlines()]
    return [line for line in lines if line[:3] == ["sigmatau", "export", "imu.toml"]]


def written(argv: list[str], folder: Path) -> str:
    """What a command writes, in a folder that has the model; comments of XML left out."""
    (folder / "imu.toml").write_text(model(), encoding="utf-8")
    before = Path.cwd()
    os.chdir(folder)
    try:
        if main([*argv[1:], "-q"]) != 0:
            sys.exit(f"{shlex.join(argv)} failed")
    finally:
        os.chdir(before)
    text = (folder / argv[argv.index("-o") + 1]).read_text(encoding="utf-8")
    return re.sub(r"^ *<!--.*?-->\n", "", text, flags=re.DOTALL | re.MULTILINE)


def pages() -> None:
    """Write all of them."""
    for name in NAMES:
        path = HOW_TO / f"{name}.md"
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if len(_SHOWN.findall(text)) != 1:
            continue  # matrices are shown nowhere, a model file has a page of another kind
        with tempfile.TemporaryDirectory() as folder:
            content = written(commands(text)[-1], Path(folder))
        path.write_text(_SHOWN.sub(lambda block, content=content: f"{block[1]}{content}```", text), encoding="utf-8")


if __name__ == "__main__":
    pages()
