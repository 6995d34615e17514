"""Update the output blocks of docs/how-to: ``PYTHONPATH=python .venv/bin/python docs/how_to.py``.

The model is `imu.toml` of docs/how-to/README.md; tests/exporting/test_how_to.py checks the pages.
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
    """The model of the pages, from the index."""
    (block,) = re.findall(
        r"^```toml\n(.*?)^```", (HOW_TO / "README.md").read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE
    )
    return str(block)


def commands(page: str) -> list[list[str]]:
    """The export commands of a page that read the model, as argument lists."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page, flags=re.DOTALL | re.MULTILINE)
    lines = [shlex.split(line, comments=True) for block in blocks for line in block.splitlines()]
    return [line for line in lines if line[:3] == ["sigmatau", "export", "imu.toml"]]


def written(argv: list[str], folder: Path) -> str:
    """The file that a command writes in a folder with the model, without XML comments."""
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
    """Update all pages."""
    for name in NAMES:
        path = HOW_TO / f"{name}.md"
        text = path.read_text(encoding="utf-8") if path.exists() else ""
        if len(_SHOWN.findall(text)) != 1:
            continue  # no output block
        with tempfile.TemporaryDirectory() as folder:
            content = written(commands(text)[-1], Path(folder))
        path.write_text(_SHOWN.sub(lambda block, content=content: f"{block[1]}{content}```", text), encoding="utf-8")


if __name__ == "__main__":
    pages()
