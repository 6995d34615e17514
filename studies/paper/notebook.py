"""Run docs/paper/paper.ipynb and store its outputs, which are the same on every run."""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
from collections.abc import Iterator
from typing import Any

from studies.paper.tables import PAGES

__all__ = ["NOTEBOOK", "executed", "write"]

NOTEBOOK = PAGES / "paper.ipynb"

_COLOURS = 64  # number of colours of a figure


def executed(notebook: dict[str, Any]) -> dict[str, Any]:
    """Execute the notebook; return it with outputs and cell numbers."""
    import matplotlib as mpl

    mpl.use("agg")
    scope: dict[str, Any] = {"__name__": "__main__"}
    cells, number = [], 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            cells.append(cell)
            continue
        number += 1
        outputs = list(_outputs("".join(cell["source"]), scope, number))
        cells.append(cell | {"execution_count": number, "outputs": outputs})
    return notebook | {"cells": cells}


def _outputs(source: str, scope: dict[str, Any], number: int) -> Iterator[dict[str, Any]]:
    """Run a cell; return its printed text and its last value."""
    tree = ast.parse(source)
    last = tree.body[-1] if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    if last is not None:
        tree.body.pop()
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), scope)
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), scope)
    if printed.getvalue():
        text = printed.getvalue().splitlines(keepends=True)
        yield {"name": "stdout", "output_type": "stream", "text": text}
    if value is not None:
        yield {
            "data": _shown(value), "execution_count": number, "metadata": {}, "output_type": "execute_result",
        }  # fmt: skip


def _shown(value: object) -> dict[str, Any]:
    """Representation of a value in Jupyter, by media type: a figure as a picture, without the address of the object."""
    from matplotlib.figure import Figure

    if isinstance(value, Figure):
        return {"image/png": _png(value), "text/plain": ["Figure"]}
    shown: dict[str, Any] = {"text/plain": repr(value).splitlines(keepends=True)}
    html = getattr(value, "_repr_html_", None)
    if callable(html) and (content := html()):
        shown = {"text/html": content.splitlines(keepends=True)} | shown
    return shown


def _png(figure: Any) -> str:  # noqa: ANN401  a figure of matplotlib
    """PNG in few colours, without date and version."""
    from PIL import Image

    drawn, smaller = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, format="png", dpi=100, metadata={"Software": None})
    with Image.open(drawn) as image:
        image.convert("RGB").quantize(_COLOURS).save(smaller, format="png", optimize=True)
    return base64.b64encode(smaller.getvalue()).decode()


def write() -> None:
    """Run the notebook and store it."""
    notebook = executed(json.loads(NOTEBOOK.read_text(encoding="utf-8")))
    NOTEBOOK.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
