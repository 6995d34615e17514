"""Read the visible paths and texts of a page of a PDF file, by PDFium."""

from __future__ import annotations

import contextlib
import ctypes
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from sigmatau.errors import DataError, OptionError
from sigmatau.hints import Hint
from sigmatau.io.read.figure.drawing import (
    EVERYWHERE,
    MAX_DEPTH,
    MAX_OBJECTS,
    MAX_VERTICES,
    TOO_COMPLEX,
    Box,
    FigurePage,
    Path,
    TextPiece,
    bounding_box,
)
from sigmatau.io.read.figure.geometry import Matrix, Pen, applied, combined

_UPRIGHT = 0.02  # largest angle of a text [rad]


def read(data: bytes, page: int | None) -> FigurePage:
    """The drawing of a page, numbered from 1."""
    from pypdfium2 import raw  # in the call, because it is an extra

    with opened_page(data, page) as content:
        return _Page(content, raw).drawing()


@contextlib.contextmanager
def opened_page(data: bytes, page: int | None) -> Iterator[Any]:
    """The page of PDFium, numbered from 1; None stands for the only one."""
    import pypdfium2
    from pypdfium2 import raw

    try:
        document = pypdfium2.PdfDocument(data)
    except pypdfium2.PdfiumError:
        if raw.FPDF_GetLastError() == raw.FPDF_ERR_PASSWORD or b"/Encrypt" in data[-4096:]:
            raise DataError("is encrypted. Save it without a password") from None
        raise DataError("is damaged, or is not a PDF file. Download or export it again") from None
    try:
        count = len(document)
        if count == 0:
            raise DataError("has no pages. Download or export it again")
        if page is None and count > 1:
            hint = Hint("page", value=min(2, count))
            raise OptionError(f"has {count} pages. Give the page of the figure, e.g. {hint}", option="page")
        if page is not None and not 1 <= page <= count:
            raise OptionError(f"{Hint('page')} must be from 1 to {count}, not {page}", option="page")
        try:
            content = document[(page or 1) - 1]
        except pypdfium2.PdfiumError:
            raise DataError(f"page {page or 1} is damaged. Download or export the file again") from None
        yield content
    finally:
        document.close()


class _Page:
    """A page, with its transform to coordinates with y downwards."""

    def __init__(self, page: Any, raw: Any) -> None:  # noqa: ANN401  the library has no types
        self._raw = raw
        self._page = page
        x_min, y_min, x_max, y_max = page.get_mediabox()
        width, height = x_max - x_min, y_max - y_min
        turned = page.get_rotation()
        self._size = (height, width) if turned in (90, 270) else (width, height)
        self._matrix: Matrix = {
            90: (0.0, 1.0, 1.0, 0.0, -y_min, -x_min),
            180: (-1.0, 0.0, 0.0, 1.0, x_max, -y_min),
            270: (0.0, -1.0, -1.0, 0.0, y_max, x_max),
        }.get(turned, (1.0, 0.0, 0.0, -1.0, -x_min, y_max))
        self._paths: list[Path] = []
        self._has_image = False
        self._titles = ""
        self._objects = self._vertices = 0

    def drawing(self) -> FigurePage:
        """All that is visible on the page."""
        raw, page = self._raw, self._page.raw
        for k in range(raw.FPDFPage_CountObjects(page)):
            self._add(raw.FPDFPage_GetObject(page, k), self._matrix, 0)
        texts = tuple(self._texts())
        return FigurePage(
            width=self._size[0],
            height=self._size[1],
            paths=tuple(self._paths),
            texts=texts,
            titles=tuple(line.strip() for line in self._titles.splitlines() if line.strip()),
            has_image=self._has_image,
        )

    def _add(self, item: Any, outer: Matrix, depth: int) -> None:  # noqa: ANN401
        """Add an object; `outer`: transform of the coordinates of the form that contains it."""
        raw = self._raw
        self._objects += 1
        if self._objects > MAX_OBJECTS or self._vertices > MAX_VERTICES or depth > MAX_DEPTH:
            raise DataError(TOO_COMPLEX)
        kind = raw.FPDFPageObj_GetType(item)
        if kind == raw.FPDF_PAGEOBJ_IMAGE:
            self._has_image = True
        elif kind in (raw.FPDF_PAGEOBJ_PATH, raw.FPDF_PAGEOBJ_FORM):
            cells = raw.FS_MATRIX()
            if not raw.FPDFPageObj_GetMatrix(item, cells):
                return
            matrix = combined(outer, (cells.a, cells.b, cells.c, cells.d, cells.e, cells.f))
            if kind == raw.FPDF_PAGEOBJ_PATH:
                self._paths += self._path(item, matrix, outer)
            else:
                for k in range(raw.FPDFFormObj_CountObjects(item)):
                    self._add(raw.FPDFFormObj_GetObject(item, k), matrix, depth + 1)

    def _path(self, item: Any, matrix: Matrix, outer: Matrix) -> list[Path]:  # noqa: ANN401
        raw = self._raw
        fill, stroke = ctypes.c_int(), ctypes.c_int()
        raw.FPDFPath_GetDrawMode(item, fill, stroke)
        width, line, inside = ctypes.c_float(), "", ""
        if stroke.value:
            line = _color(raw.FPDFPageObj_GetStrokeColor, item)
            raw.FPDFPageObj_GetStrokeWidth(item, width)
        if fill.value and not line:
            inside = _color(raw.FPDFPageObj_GetFillColor, item)
        if not (line or inside):
            return []
        pen = Pen()
        count = raw.FPDFPath_CountSegments(item)
        self._vertices += max(count, 0)
        if self._vertices > MAX_VERTICES:
            raise DataError(TOO_COMPLEX)
        self._draw(pen, (raw.FPDFPath_GetPathSegment(item, k) for k in range(count)))
        return pen.paths(matrix, color=line or inside, width=width.value if line else 0.0, clip=self._clip(item, outer))

    def _draw(self, pen: Pen, segments: Iterator[Any]) -> None:
        raw = self._raw
        x, y = ctypes.c_float(), ctypes.c_float()
        controls: list[tuple[float, float]] = []
        for segment in segments:
            raw.FPDFPathSegment_GetPoint(segment, x, y)
            kind, place = raw.FPDFPathSegment_GetType(segment), (x.value, y.value)
            if kind == raw.FPDF_SEGMENT_MOVETO:
                pen.move(*place)
            elif kind == raw.FPDF_SEGMENT_LINETO:
                pen.line(*place)
            elif len(controls) < 2:
                controls.append(place)
                continue
            else:
                pen.curve((controls[0], controls[1]), place)
                controls = []
            if raw.FPDFPathSegment_GetClose(segment):
                pen.close()

    def _clip(self, item: Any, outer: Matrix) -> Box:  # noqa: ANN401
        """The visible region: the common part of the rectangles around all clip paths."""
        raw = self._raw
        region, result = raw.FPDFPageObj_GetClipPath(item), EVERYWHERE
        if not region:
            return result
        x, y = ctypes.c_float(), ctypes.c_float()
        for k in range(max(raw.FPDFClipPath_CountPaths(region), 0)):
            points = []
            for j in range(min(max(raw.FPDFClipPath_CountPathSegments(region, k), 0), 10_000)):
                raw.FPDFPathSegment_GetPoint(raw.FPDFClipPath_GetPathSegment(region, k, j), x, y)
                points.append((x.value, y.value))
            if points:
                result = result.cut(bounding_box(applied(outer, np.array(points))))
        return result

    def _texts(self) -> Iterator[TextPiece]:
        """The letters of the page that are upright. The others become titles."""
        raw = self._raw
        letters = raw.FPDFText_LoadPage(self._page.raw)
        if not letters:
            return
        try:
            x_min, x_max, y_min, y_max, x, y = (ctypes.c_double() for _ in range(6))
            for k in range(min(raw.FPDFText_CountChars(letters), MAX_OBJECTS)):
                code = raw.FPDFText_GetUnicode(letters, k)
                cells = raw.FS_MATRIX()
                if code <= 32 or not raw.FPDFText_GetMatrix(letters, k, cells):
                    self._titles += " " if code == 32 else ""
                    continue
                raw.FPDFText_GetCharBox(letters, k, x_min, x_max, y_min, y_max)
                raw.FPDFText_GetCharOrigin(letters, k, x, y)
                matrix = combined(self._matrix, (cells.a, cells.b, cells.c, cells.d, 0.0, 0.0))
                if abs(math.atan2(matrix[1], matrix[0])) > _UPRIGHT:
                    self._titles += chr(code)
                    continue
                self._titles += "\n"
                corners = np.array([(x_min.value, y_min.value), (x_max.value, y_max.value), (x.value, y.value)])
                places = applied(self._matrix, corners)
                yield TextPiece(
                    text=chr(code),
                    start=float(places[:2, 0].min()),
                    end=float(places[:2, 0].max()),
                    baseline=float(places[2, 1]),
                    size=raw.FPDFText_GetFontSize(letters, k) * math.hypot(cells.c, cells.d),
                )
        finally:
            raw.FPDFText_ClosePage(letters)


def _color(function: Any, item: Any) -> str:  # noqa: ANN401
    """The color of an object; empty if it is transparent."""
    red, green, blue, alpha = (ctypes.c_uint() for _ in range(4))
    if not function(item, red, green, blue, alpha) or alpha.value == 0:
        return ""
    return f"#{red.value:02x}{green.value:02x}{blue.value:02x}"
