"""Data frames in memory, of any library: columns by name, as in a file."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sigmatau.errors import DataError, OptionError
from sigmatau.io.read import assemble
from sigmatau.io.read.formats.arrays import parts, pick, table_of_columns
from sigmatau.io.read.instance_tables import separate_instances
from sigmatau.io.read.instances import state_single_sensor
from sigmatau.io.read.options import TableOptions
from sigmatau.io.read.repeated_clocks import separate_clocks
from sigmatau.io.read.table import Column, Table
from sigmatau.io.read.turn_tables import separate_turns
from sigmatau.options import keywords_of
from sigmatau.record.record import Record

_STAMPS = ("s", "ms", "us", "ns")
_Get = Callable[[], NDArray[Any]]


@keywords_of(TableOptions)
def from_frame(frame: object, options: TableOptions) -> Record:
    """A static record from a data frame.

    Columns are recognised by common names, as in `read`: ``gyro_x``, ``wx``, ``acc_x [g]``, ``t_ns`` … Information that the
    frame does not state must be given by an argument. A variable of xarray has samples along one dimension, and may have
    axes along another one, whose labels become part of the names: ``gyro`` with ``axis`` x, y, z.

    Parameters
    ----------
    frame : data frame
        Of pandas, polars or pyarrow, a Dataset or DataArray of xarray, a structured array, or a mapping of names to arrays
        of shape (n,) or (n, 3). Dates and durations are time stamps, also in the index of pandas; so is an index with a
        name. Units are taken from the names, from the metadata of fields (pyarrow), from ``frame.attrs["units"]``
        (pandas), and from the attribute ``units`` of a variable (xarray).

    Returns
    -------
    Record
        Streams ``gyro`` (rad/s), ``accel`` (m/s²) and one for each signal; each channel of shape (n,). NumPy arrays are not
        copied: do not change them while the record is in use.

    Raises
    ------
    OptionError
        If an argument is missing or wrong.
    DataError
        If columns have unequal lengths or non-numeric values, or time goes backwards.
    NonFiniteError
        If more than half of the rows have no time stamp.
    RecordTooShortError
        For fewer than 4 samples.
    TypeError
        If `frame` is not a data frame.

    See Also
    --------
    read : a record from a file.
    Record.from_arrays : a record from arrays.

    Examples
    --------
    >>> import numpy as np
    >>> import sigmatau as st
    >>> frame = {"time [s]": np.arange(1000) / 100, "gyro_x [deg/s]": np.zeros(1000)}
    >>> st.from_frame(frame)
    Record of 1 stream
      gyro: gyro_x [rad/s], 1000 samples at 100 Hz (10 s)
    """
    checked = options.checked()
    try:
        with state_single_sensor(single=checked.interleaved == 1):
            tables = separate_turns(separate_instances(separate_clocks([_table(frame)])), checked)
        return assemble.assemble(assemble.choose_tables(tables, checked.topic, checked.channels), None, checked)
    except OptionError as error:
        raise error.about("the frame") from None
    except DataError as error:
        raise error.about("the frame").with_traceback(None) from None


def _table(frame: Any) -> Table:  # noqa: ANN401
    pairs = list(_columns(frame))
    if not pairs:
        raise DataError("has no columns")
    kind = type(frame).__module__.split(".")[0]
    note = f"{kind} {type(frame).__name__}" if kind != "builtins" else type(frame).__name__
    table = table_of_columns("frame", [column for column, _ in pairs], [get for _, get in pairs], (note,))
    words = {column.name: get for column, get in pairs if column.unit is None and get().dtype.kind in "OUST"}
    return replace(table, words=words)


def _columns(frame: Any) -> Iterator[tuple[Column, _Get]]:  # noqa: ANN401
    if isinstance(frame, np.ndarray) and frame.dtype.names and frame.ndim == 1:
        frame = {name: frame[name] for name in frame.dtype.names}
    library = type(frame).__module__.split(".")[0]
    if library == "polars" and hasattr(frame, "collect"):
        frame = frame.collect()
    if library == "pyarrow" and hasattr(frame, "schema") and hasattr(frame, "column"):
        yield from _arrow_columns(frame)
    elif library == "pandas" and hasattr(frame, "iloc") and hasattr(frame, "columns"):
        yield from _pandas_columns(frame)
    elif library == "xarray" and hasattr(frame, "coords") and hasattr(frame, "dims"):
        yield from _xarray_columns(frame)
    elif isinstance(frame, Mapping):
        for name, values in frame.items():
            yield from _array_columns(str(name), _unmasked(values))
    elif hasattr(frame, "columns") and hasattr(frame, "__getitem__"):
        for name in frame.columns:  # polars and similar libraries
            yield from _array_columns(str(name), np.asarray(frame[name]))
    elif hasattr(frame, "__arrow_c_stream__"):
        if not hasattr(frame, "schema") and hasattr(frame, "dtype"):  # a series
            raise DataError("is one column without a name; give a frame, or a mapping such as {'gyro_x': column}")
        try:
            import pyarrow as pa
        except ImportError:
            raise ImportError("a frame of this kind needs pyarrow: pip install 'sigmatau[parquet]'") from None
        yield from _arrow_columns(pa.table(frame))
    else:
        raise TypeError(f"`frame` must be a data frame or a mapping of names to arrays, not {type(frame).__name__}")


def _array_columns(name: str, array: NDArray[Any], unit: str | None = None) -> Iterator[tuple[Column, _Get]]:
    if not 1 <= array.ndim <= 2:
        return
    unit = _stamp_unit(array.dtype) or unit
    for label, part in parts(name, array.shape[1:]):
        yield Column(name=label, unit=unit), _stamps(lambda part=part: pick(array, part))  # type: ignore[misc]


def _pandas_columns(frame: Any) -> Iterator[tuple[Column, _Get]]:  # noqa: ANN401
    stated = frame.attrs.get("units")
    units = stated if isinstance(stated, Mapping) else {}
    index = frame.index
    if _stamp_unit(index.dtype) or getattr(index, "tz", None) is not None:
        yield from _array_columns(str(index.name or "time"), _naive(index))
    elif isinstance(index.name, str) and getattr(index.dtype, "kind", "O") in "iuf":
        yield from _array_columns(index.name, index.to_numpy())
    for k, label in enumerate(frame.columns):
        name = ".".join(map(str, label)) if isinstance(label, tuple) else str(label)
        unit = units.get(label)
        series = frame.iloc[:, k]
        yield from _array_columns(name, _naive(series), unit if isinstance(unit, str) else None)


def _xarray_columns(data: Any) -> Iterator[tuple[Column, _Get]]:  # noqa: ANN401
    """Find the coordinate of the samples, and the variables along it. A DataArray is treated as a Dataset with one
    variable.
    """
    if not hasattr(data, "data_vars"):
        data = data.to_dataset(name=data.name if data.name is not None else "signal")
    lengths = {dimension: size for variable in data.data_vars.values() for dimension, size in variable.sizes.items()}
    if not lengths:
        return
    samples = max(lengths, key=lambda dimension: lengths[dimension])
    apart = [str(name) for name, variable in data.data_vars.items() if samples not in variable.dims and variable.ndim]
    if apart:
        raise DataError(
            f"has variables without the dimension {samples} of the samples: {', '.join(apart)}."
            f" Select those along it, data[{[str(n) for n, v in data.data_vars.items() if samples in v.dims]}]"
        )
    if samples in data.coords:
        stamps = data.coords[samples]
        yield from _array_columns(str(samples), stamps.to_numpy(), _stated_unit(stamps))
    for name, variable in data.data_vars.items():
        if not variable.ndim:
            continue
        array = variable.transpose(samples, ...).to_numpy()
        for label, part in _labelled(str(name), variable, samples, array):
            yield from _array_columns(label, part, _stated_unit(variable))


def _labelled(name: str, variable: Any, samples: Any, array: NDArray[Any]) -> Iterator[tuple[str, NDArray[Any]]]:  # noqa: ANN401
    """Split a variable into columns named by the labels of its other dimension, if it has text labels."""
    across = [dimension for dimension in variable.dims if dimension != samples]
    labels = variable.coords[across[0]].to_numpy() if len(across) == 1 and across[0] in variable.coords else None
    if labels is None or labels.dtype.kind not in "OUT":
        yield name, array
        return
    for k, label in enumerate(labels):
        # an array without a name: its labels are the names, gyro_x
        whole = len(str(label)) > 1 and name == "signal"
        yield str(label) if whole else f"{name}_{label}", array[:, k]


def _stated_unit(variable: Any) -> str | None:  # noqa: ANN401
    """The unit attribute of a variable, as defined by the conventions of netCDF."""
    unit = variable.attrs.get("units")
    return unit if isinstance(unit, str) else None


def _naive(values: Any) -> NDArray[Any]:  # noqa: ANN401
    """Convert a series to plain numbers or dates: NaN for missing ones, UTC for times with a zone."""
    clock = getattr(values, "dt", values)
    if getattr(clock, "tz", None) is not None:
        values = clock.tz_convert(None)
    array: NDArray[Any] = values.to_numpy()
    if array.dtype == object and getattr(values.dtype, "kind", "O") in "iuf":  # numbers, some of them missing
        array = values.to_numpy(dtype=np.float64, na_value=np.nan)
    return array


def _arrow_columns(frame: Any) -> Iterator[tuple[Column, _Get]]:  # noqa: ANN401
    from sigmatau.io.read.formats.arrow_table import find_numeric_columns, numbers

    chosen, skipped = find_numeric_columns(frame.schema)
    for column in chosen:
        yield column.column, lambda column=column: numbers(frame.column(column.path[0]), column)  # type: ignore[misc]
    for name in skipped:
        yield Column(name=name), lambda name=name: np.asarray(frame.column(name.split(".")[0]))  # type: ignore[misc]


def _unmasked(values: Any) -> NDArray[Any]:  # noqa: ANN401
    """An array with NaN (or NaT) in place of masked values."""
    if not isinstance(values, np.ma.MaskedArray):
        return np.asarray(values)
    if not np.ma.is_masked(values):
        return values.data
    if values.dtype.kind not in "iufmM":
        return np.asarray(values)
    filled = values.data.astype(np.float64) if values.dtype.kind in "iu" else values.data.copy()
    filled[np.ma.getmaskarray(values)] = np.nan if filled.dtype.kind == "f" else "NaT"
    return filled


def _stamp_unit(dtype: Any) -> str | None:  # noqa: ANN401
    """The resolution of dates or durations; None for other types."""
    if not isinstance(dtype, np.dtype) or dtype.kind not in "mM":
        return None
    unit, step = np.datetime_data(dtype)
    return unit if unit in _STAMPS and step == 1 else "ns"


def _stamps(get: _Get) -> _Get:
    """Dates and durations as integers of their unit, the smallest integer for NaT; other numbers unchanged."""

    def numbers() -> NDArray[Any]:
        array = get()
        unit = _stamp_unit(array.dtype)
        if unit is None:
            return array
        whole: NDArray[Any] = array.astype(f"{array.dtype.kind}8[{unit}]").view(np.int64)
        return whole

    return numbers
