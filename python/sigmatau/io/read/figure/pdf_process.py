"""Read or render a page of a PDF file in a process of its own, with limits of time and memory.

PDFium is a library in C++, in which a crash or an endless reading of a malicious file cannot be caught.
"""

from __future__ import annotations

import base64
import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path as File
from typing import Any

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read.figure.drawing import Box, FigurePage, Path, TextPiece

_SECONDS = 20  # of processor time
_WAIT = 120.0  # longest wait, on a busy machine [s]
_MEMORY = 2 << 30  # [bytes]
_MODULE = "sigmatau.io.read.figure.pdf_process"


def read(path: File, page: int | None) -> FigurePage:
    """The drawing of a page, numbered from 1. Raises `DataError`, `OptionError` and ImportError as `pdf.read`."""
    answer = _ask("read", path, page)
    return FigurePage(
        width=answer["width"],
        height=answer["height"],
        paths=tuple(_path(each) for each in answer["paths"]),
        texts=tuple(TextPiece(**each) for each in answer["texts"]),
        titles=tuple(answer["titles"]),
        has_image=answer["has_image"],
    )


def render(path: File, page: int | None) -> bytes:
    """The picture of a page as PNG; errors as of `read`."""
    return base64.b64decode(_ask("render", path, page)["png"])


def _ask(task: str, path: File, page: int | None) -> dict[str, Any]:
    """The answer of the process."""
    if find_spec("pypdfium2") is None:
        raise ImportError("a figure of a PDF file needs pypdfium2: pip install 'sigmatau[figure]'")
    command = [sys.executable, "-m", _MODULE, task, str(path), str(page or "")]
    try:
        done = subprocess.run(command, capture_output=True, timeout=_WAIT, check=False)
        answer: dict[str, Any] = json.loads(done.stdout)
    except (subprocess.TimeoutExpired, ValueError):
        raise DataError("needs too much time or memory, or is damaged. Save the page or the figure alone") from None
    if "error" in answer:
        kind, message, option = answer["error"]
        if kind == "OptionError":
            raise OptionError(message, option=option)
        raise DataError(message)
    return answer


def _path(fields: dict[str, Any]) -> Path:
    points = np.array(fields.pop("points"), dtype=np.float64).reshape(-1, 2)
    is_end = np.array(fields.pop("is_end"), dtype=np.bool_)
    return Path(points=points, is_end=is_end, clip=Box(**fields.pop("clip")), **fields)


def _limit() -> None:
    """Limit this process, where the system can do so."""
    try:
        import resource
    except ImportError:  # Windows; the wait is limited there too
        return
    for limit, value in ((resource.RLIMIT_AS, _MEMORY), (resource.RLIMIT_CPU, _SECONDS), (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(limit, (value, value))


def _read(data: bytes, page: int | None) -> dict[str, Any]:
    from dataclasses import asdict

    from sigmatau.io.read.figure import pdf

    drawing = pdf.read(data, page)
    return {
        "width": drawing.width,
        "height": drawing.height,
        "paths": [
            {**asdict(each), "points": each.points.tolist(), "is_end": each.is_end.tolist()} for each in drawing.paths
        ],
        "texts": [asdict(each) for each in drawing.texts],
        "titles": drawing.titles,
        "has_image": drawing.has_image,
    }


def _render(data: bytes, page: int | None) -> dict[str, Any]:
    from sigmatau.io.read.figure.pdf_picture import render as rendered

    return {"png": base64.b64encode(rendered(data, page)).decode()}


def _main(task: str, path: str, page: str) -> None:
    """Write the drawing, the picture or the error of a file to standard output."""
    _limit()
    answer: dict[str, Any]
    try:
        data, number = File(path).read_bytes(), int(page) if page else None
        answer = _render(data, number) if task == "render" else _read(data, number)
    except (DataError, OptionError) as error:
        answer = {"error": [type(error).__name__, error.message, getattr(error, "option", "")]}
    sys.stdout.write(json.dumps(answer))


if __name__ == "__main__":
    _main(*sys.argv[1:])
