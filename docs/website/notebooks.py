"""Notebooks as pages: their text and code, with the outputs of executing their cells."""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import os
import re
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

_MAGIC = re.compile(r"^[%!]", flags=re.MULTILINE)  # commands of Jupyter


def markdown(path: Path) -> str:
    """Convert a notebook to a page in Markdown, with the outputs of its cells unless it has shell commands."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    scope: dict[str, Any] = {"__name__": "__main__"}
    runs = not any(_MAGIC.search("".join(cell["source"])) for cell in cells if cell["cell_type"] == "code")
    parts = []
    with tempfile.TemporaryDirectory() as folder, _inside(folder):
        for cell in cells:
            source = "".join(cell["source"])
            if cell["cell_type"] == "markdown":
                parts.append(source if parts else f"{source}\n\nTo run it yourself: {{download}}`{path.name}`.")
            elif cell["cell_type"] == "code":
                parts += [f"```python\n{source}\n```", *(_outputs(source, scope) if runs else ())]
    return "\n\n".join(parts) + "\n"


@contextlib.contextmanager
def _inside(folder: str) -> Iterator[None]:
    import matplotlib as mpl

    mpl.use("agg")
    before = Path.cwd()
    os.chdir(folder)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        os.chdir(before)


def _outputs(source: str, scope: dict[str, Any]) -> Iterator[str]:
    """Run a cell; return its printed text, its figures, and its last value."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), scope)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), scope)
    if printed.getvalue():
        yield f"```text\n{printed.getvalue().rstrip()}\n```"
    import matplotlib.pyplot as plt

    drawn = [plt.figure(number) for number in plt.get_fignums()]
    for figure in drawn:
        yield _picture(_png(figure))
    plt.close("all")
    if last is None or value is None or source.rstrip().endswith(";"):
        return
    if callable(png := getattr(value, "_repr_png_", None)) and (content := png()):
        yield _picture(content)
    elif callable(html := getattr(value, "_repr_html_", None)) and (content := html()):
        yield f'```{{raw}} html\n<div class="cell-output">{content}</div>\n```'
    elif not drawn:
        yield f"```text\n{value!r}\n```"


def _png(figure: Any) -> bytes:  # noqa: ANN401  a figure of matplotlib
    out = io.BytesIO()
    figure.savefig(out, format="png")
    return out.getvalue()


def _picture(png: bytes) -> str:
    data = base64.b64encode(png).decode()
    return (
        f'```{{raw}} html\n<img class="cell-output" alt="output of the cell" src="data:image/png;base64,{data}">\n```'
    )
