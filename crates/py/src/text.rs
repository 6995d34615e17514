//! Text tables, read and written.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use sigmatau_formats::{self as formats, Delimiter, Dialect, TextError as Refused};
use std::path::PathBuf;

pyo3::create_exception!(sigmatau._core, TextError, PyValueError);

type Columns<'py> = (Vec<Bound<'py, PyArray1<f64>>>, Option<Bound<'py, PyArray1<i64>>>);

#[pyfunction]
#[allow(clippy::too_many_arguments)] // the fields of a dialect, which _kernels names
pub fn read_text<'py>(
    py: Python<'py>,
    path: PathBuf,
    delimiter: Option<&str>,
    comment: Vec<String>,
    skip_lines: usize,
    columns: usize,
    wanted: Vec<usize>,
    exact: Option<usize>,
) -> PyResult<Columns<'py>> {
    let delimiter = delimiter.map_or(Ok(Delimiter::Whitespace), |d| one_byte(d).map(Delimiter::Byte))?;
    let comment = comment.into_iter().map(String::into_bytes).collect();
    let dialect = Dialect { delimiter, comment, skip_lines, columns };
    let table = py.detach(|| formats::read_file(&path, &dialect, &wanted, exact)).map_err(refused)?;
    let floats = table.columns.into_iter().map(|c| c.into_pyarray(py)).collect();
    Ok((floats, table.integers.map(|c| c.into_pyarray(py))))
}

/// The same from lines in memory.
#[pyfunction]
pub fn parse_text<'py>(
    py: Python<'py>,
    lines: &[u8],
    delimiter: Option<&str>,
    comment: Vec<String>,
    columns: usize,
    wanted: Vec<usize>,
) -> PyResult<Vec<Bound<'py, PyArray1<f64>>>> {
    let delimiter = delimiter.map_or(Ok(Delimiter::Whitespace), |d| one_byte(d).map(Delimiter::Byte))?;
    let comment = comment.into_iter().map(String::into_bytes).collect();
    let dialect = Dialect { delimiter, comment, skip_lines: 0, columns };
    let table = py.detach(|| formats::read_columns(lines, &dialect, &wanted, None)).map_err(refused)?;
    Ok(table.columns.into_iter().map(|c| c.into_pyarray(py)).collect())
}

#[pyfunction]
pub fn write_text(
    py: Python<'_>,
    path: PathBuf,
    header: Option<&str>,
    delimiter: &str,
    columns: Vec<PyReadonlyArray1<'_, f64>>,
    gzip: bool,
) -> PyResult<()> {
    let delimiter = one_byte(delimiter)?;
    let columns = columns.iter().map(|c| c.as_slice()).collect::<Result<Vec<_>, _>>()?;
    py.detach(|| formats::write_file(&path, header, delimiter, &columns, gzip))
        .map_err(|error| PyOSError::new_err(error.to_string()))
}

fn one_byte(delimiter: &str) -> PyResult<u8> {
    match delimiter.as_bytes() {
        [byte] => Ok(*byte),
        _ => Err(PyValueError::new_err(format!(
            "the delimiter must be one ASCII character, not {delimiter:?}"
        ))),
    }
}

/// The fields of `_kernels.TextReadError`: kind, line, row, column, text, got, expected.
fn refused(error: Refused) -> PyErr {
    let message = error.to_string();
    let fields = match error {
        Refused::Ragged { line, row, got, expected } => {
            ("ragged", line, row, 0, String::new(), got, expected)
        }
        Refused::NotANumber { line, row, column, text } => ("not_a_number", line, row, column, text, 0, 0),
        Refused::NonFinite { line, row, column, text } => ("non_finite", line, row, column, text, 0, 0),
        Refused::TooLong { line } => ("too_long", line, 0, 0, String::new(), 0, 0),
        Refused::Truncated { line } => ("truncated", line, 0, 0, message, 0, 0),
        Refused::Io(text) => ("io", 0, 0, 0, text, 0, 0),
        Refused::Empty => ("empty", 0, 0, 0, String::new(), 0, 0),
    };
    TextError::new_err(fields)
}
