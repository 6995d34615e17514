"""Points that were clicked along a curve, from a table."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from sigmatau.arrays import Floats
from sigmatau.errors import DataError, OptionError
from sigmatau.hints import Hint
from sigmatau.io.read import opened
from sigmatau.io.read.figure.candidates import MIN_POINTS
from sigmatau.io.read.options import ReadOptions
from sigmatau.io.read.small_table import column_place

X_NAMES = ("tau", "x")
"""Keys of the column of the first coordinate."""

_LISTED = 12  # largest number of columns in a message


def read(path: Path, columns: Mapping[str, str] | None) -> dict[str, Floats]:
    """The points of each curve by the name of its channel, empty if none is stated: arrays of shape (n, 2) in order of x.

    In a table of several curves the cell of a curve may be empty.
    """
    with opened(path, ReadOptions()) as (_, tables):
        if len(tables) != 1:
            raise DataError(f"has {len(tables)} tables. Write the points as two columns of one, x and y")
        (table,) = tables
        names = [column.name for column in table.columns]
        listed = ", ".join(name or f"column {k}" for k, name in enumerate(names[:_LISTED], 1))
        places = {key: column_place(names, text, listed) for key, text in (columns or {}).items()}
        if not places:
            if len(names) != 2:
                hint = Hint("columns", value={"x": "1", "gyro_x": "2"})
                raise OptionError(f"has {len(names)} columns: {listed}. Name two, e.g. {hint}", option="columns")
            places = {"x": 0, "": 1}
        x_key = next((key for key in X_NAMES if key in places), None)
        if x_key is None or len(places) < 2:
            hint = Hint("columns", value={"x": "1", "gyro_x": "2"})
            raise OptionError(f"{{option}} must name x and a curve: {hint}", option="columns")
        loaded = table.load(sorted(set(places.values())), None)
        for finding in loaded.findings:
            raise DataError(f"is damaged: {finding}")
        values = {key: np.asarray(loaded.columns[k], dtype=np.float64) for key, k in places.items()}
        x = values.pop(x_key)
        curves = {}
        for key, y in values.items():
            points = np.stack([x, y], axis=1)
            is_empty = np.isnan(y) if len(names) > 2 else np.zeros(len(y), dtype=np.bool_)
            is_empty &= np.isfinite(x)
            wrong = ~np.isfinite(points).all(axis=1) & ~is_empty
            if wrong.any():
                raise DataError(
                    "the point is not two numbers. Remove this row", place=table.where(int(np.flatnonzero(wrong)[0]))
                )
            points = points[~is_empty]
            points = points[np.argsort(points[:, 0], kind="stable")]
            repeated = np.flatnonzero(np.diff(points[:, 0]) == 0)
            if len(repeated):
                raise DataError(f"has two points at x = {points[repeated[0], 0]:g}. Remove all but one")
            if len(points) < MIN_POINTS:
                curve = f" of {key}" if len(values) > 1 else ""
                raise DataError(f"has {len(points)} points{curve}. Click {MIN_POINTS} or more along the curve")
            curves["" if key == "y" else key] = points
    return curves
