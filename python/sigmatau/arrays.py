"""Helpers for arrays that several rooms share."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

_Scalar = TypeVar("_Scalar", bound=np.generic)
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Runs = tuple[Ints, Ints]  # first indices and lengths

_SHORT = 32  # length up to which Python sorts faster than NumPy

SIGMA_OF_MAD = 1.4826  # standard deviation of normal noise over its median absolute deviation: 1/Φ⁻¹(3/4)


def freeze(result: object, *names: str, dtype: DTypeLike | None = None, copy: bool = False) -> None:
    """Make array fields of a frozen dataclass read-only; a field that is None stays None.

    Parameters
    ----------
    result : object
    *names : str
    dtype : dtype, optional
        Type to convert the arrays to. Default: their own.
    copy : bool
        Whether the arrays are copied. Default: the fields become read-only views.
    """
    for name in names:
        value = getattr(result, name)
        if value is None or (not copy and _is_frozen(value, dtype)):
            continue
        array = np.array(value, dtype=dtype) if copy else np.asarray(value, dtype=dtype).view()
        array.setflags(write=False)
        object.__setattr__(result, name, array)


def _is_frozen(value: object, dtype: DTypeLike | None) -> bool:
    """Whether a field is a read-only array of the type already."""
    return isinstance(value, np.ndarray) and not value.flags.writeable and dtype in (None, value.dtype)


def median(x: NDArray[np.float64]) -> float:
    """The median of a series; NaN if it is empty or contains NaN. NumPy's takes 40 µs more, and imports masked arrays.

    Examples
    --------
    >>> import numpy as np
    >>> median(np.array([4.0, 1.0, 3.0, 2.0]))
    2.5
    """
    n = len(x)
    if n == 0:
        return float("nan")
    if n <= _SHORT:
        numbers = sorted(x.tolist())
        if any(number != number for number in numbers):
            return float("nan")
        return (numbers[(n - 1) // 2] + numbers[n // 2]) / 2 if n % 2 == 0 else float(numbers[n // 2])
    ordered = np.partition(x, ((n - 1) // 2, n // 2, n - 1))  # NaN is last
    if np.isnan(ordered[-1]):
        return float("nan")
    return float(ordered[(n - 1) // 2] + ordered[n // 2]) / 2 if n % 2 == 0 else float(ordered[n // 2])


def quantile(x: NDArray[np.float64], share: float) -> float:
    """A quantile of numbers without NaN, linear between them. NumPy's imports masked arrays.

    Examples
    --------
    >>> import numpy as np
    >>> quantile(np.array([4.0, 1.0, 3.0, 2.0]), 0.9)
    3.7
    """
    place = (len(x) - 1) * share
    first = min(int(place), max(len(x) - 2, 0))
    last = min(first + 1, len(x) - 1)
    ordered = np.partition(x, (first, last))
    low, high = float(ordered[first]), float(ordered[last])
    part = place - first
    return low + (high - low) * part if part < 0.5 else high - (high - low) * (1 - part)


def medians(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Medians over the first axis, which must not be empty; NaN where a value is NaN. NumPy's imports masked arrays.

    Examples
    --------
    >>> import numpy as np
    >>> medians(np.array([[4.0, 1.0], [1.0, 7.0], [3.0, 8.0], [2.0, 2.0]]))
    array([2.5, 4.5])
    """
    n = len(x)
    ordered = np.sort(x, axis=0)
    middle = (ordered[(n - 1) // 2] + ordered[n // 2]) / 2 if n % 2 == 0 else ordered[n // 2]
    return np.where(np.isnan(ordered[-1]), np.nan, middle)


def medians_of_present(rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """The median of each row without NaN; NaN for a row of NaN. NumPy's `nanmedian` imports masked arrays.

    Examples
    --------
    >>> import numpy as np
    >>> medians_of_present(np.array([[4.0, np.nan, 1.0], [np.nan, 7.0, np.nan]]))
    array([2.5, 7. ])
    """
    ordered = np.sort(rows, axis=1)  # NaN is last
    count = np.count_nonzero(~np.isnan(ordered), axis=1)
    low, high = (
        np.take_along_axis(ordered, np.maximum(place, 0)[:, None], axis=1)[:, 0]
        for place in ((count - 1) // 2, count // 2)
    )
    return np.where(count % 2 == 1, high, (low + high) / 2)


def median_and_spread(x: NDArray[np.float64]) -> tuple[float, float]:
    """Median, and the standard deviation of normal noise that has the same median absolute deviation.

    Examples
    --------
    >>> import numpy as np
    >>> median_and_spread(np.array([1.0, 2.0, 3.0, 4.0, 1000.0]))
    (3.0, 1.4826)
    """
    middle = median(x)
    return middle, SIGMA_OF_MAD * median(np.abs(x - middle))


def distinct(values: NDArray[_Scalar]) -> NDArray[_Scalar]:
    """The different values of an array in order, NaN last and once. NumPy's `unique` imports masked arrays.

    Examples
    --------
    >>> import numpy as np
    >>> distinct(np.array([3, 1, 3, 2]))
    array([1, 2, 3])
    """
    ordered = np.sort(values, axis=None)
    if not len(ordered):
        return ordered
    differs = np.concatenate(([True], ordered[1:] != ordered[:-1]))
    if ordered[-1] != ordered[-1]:  # NaN is last, and differs from itself
        differs[1:] &= ordered[:-1] == ordered[:-1]
    return ordered[differs]


def column_counts(mask: Bools) -> Ints:
    """Number of True values in each column, one column after the other; over an axis, NumPy takes 40 times as long.

    Examples
    --------
    >>> import numpy as np
    >>> column_counts(np.array([[True, False], [True, True]]))
    array([2, 1])
    """
    return np.array([np.count_nonzero(column) for column in mask.T], dtype=np.int64)


def runs(mask: ArrayLike) -> list[tuple[int, int]]:
    """Start and stop of each run of True.

    Examples
    --------
    >>> runs([False, True, True, False, True])
    [(1, 3), (4, 5)]
    """
    return [(start, stop) for start, stop in run_edges(np.asarray(mask, dtype=bool)).tolist()]


def run_edges(mask: Bools) -> Ints:
    """Start and stop of each run of True; shape (n, 2)."""
    inside = np.concatenate(([False], mask, [False]))
    return np.flatnonzero(inside[1:] != inside[:-1]).reshape(-1, 2)
