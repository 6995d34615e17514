//! Reading and writing of text tables.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use sigmatau_formats::date::{Form, Order};
use sigmatau_formats::{self as formats, Delimiter, Dialect, Encoding, Tag, TextError as Refused, Writing};
use std::path::PathBuf;

use crate::pool::detached;

pyo3::create_exception!(sigmatau._core, TextError, PyValueError);

/// Columns, the exact one as integers, comments between the rows, and whether the last line has no line end.
type Columns<'py> = (Vec<Bound<'py, PyArray1<f64>>>, Option<Bound<'py, PyArray1<i64>>>, Passed, bool);

/// Encoding, decimal commas, number of lines, order of the dates, arrows, size limit of a compressed file, column and text
/// that mark the rows to be read.
type Fields<'a> = (&'a str, bool, Option<usize>, Option<&'a str>, bool, u64, Option<(usize, &'a str)>);

/// The fields of [`formats::Remarks`].
type Passed = (usize, usize, Vec<(usize, String)>);

#[pyfunction]
#[allow(clippy::too_many_arguments)] // the fields of a dialect, see `_native.formats`
pub fn read_text<'py>(
    py: Python<'py>,
    path: PathBuf,
    delimiter: Option<&str>,
    comment: Vec<String>,
    skip_lines: usize,
    columns: usize,
    wanted: Vec<usize>,
    exact: Option<usize>,
    writing: Fields<'_>,
) -> PyResult<Columns<'py>> {
    let dialect = dialect(delimiter, comment, skip_lines, columns, writing)?;
    let writing = written(writing)?;
    let table = detached(py, || formats::read_written_file(&path, writing, &dialect, &wanted, exact))
        .map_err(refused)?;
    Ok(to_columns(py, table))
}

/// Reads a table from lines in memory.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn parse_text<'py>(
    py: Python<'py>,
    lines: &[u8],
    delimiter: Option<&str>,
    comment: Vec<String>,
    skip_lines: usize,
    columns: usize,
    wanted: Vec<usize>,
    exact: Option<usize>,
    writing: Fields<'_>,
) -> PyResult<Columns<'py>> {
    let dialect = dialect(delimiter, comment, skip_lines, columns, writing)?;
    let writing = written(writing)?;
    let table =
        detached(py, || formats::read_written(lines, writing, &dialect, &wanted, exact)).map_err(refused)?;
    Ok(to_columns(py, table))
}

/// Writes columns as lines of text.
#[pyfunction]
pub fn format_text<'py>(
    py: Python<'py>,
    delimiter: &str,
    columns: Vec<PyReadonlyArray1<'py, f64>>,
) -> PyResult<Bound<'py, PyBytes>> {
    let delimiter = one_byte(delimiter)?;
    let columns = columns.iter().map(|c| c.as_slice()).collect::<Result<Vec<_>, _>>()?;
    let mut text = Vec::new();
    py.detach(|| formats::write_columns(&mut text, delimiter, &columns))
        .map_err(|error| PyOSError::new_err(error.to_string()))?;
    Ok(PyBytes::new(py, &text))
}

fn to_columns(py: Python<'_>, table: formats::Table) -> Columns<'_> {
    let floats = table.columns.into_iter().map(|c| c.into_pyarray(py)).collect();
    let formats::Remarks { rows, first_row, headers } = table.remarks;
    let integers = table.integers.map(|c| c.into_pyarray(py));
    (floats, integers, (rows, first_row, headers), table.open_end)
}

fn dialect(
    delimiter: Option<&str>,
    comment: Vec<String>,
    skip_lines: usize,
    columns: usize,
    (_, _, _, dates, arrow, most, tag): Fields<'_>,
) -> PyResult<Dialect> {
    let delimiter = delimiter.map_or(Ok(Delimiter::Whitespace), |d| one_byte(d).map(Delimiter::Byte))?;
    let comment = comment.into_iter().map(String::into_bytes).collect();
    let tag = tag.map(|(column, text)| Tag { column, text: text.as_bytes().to_vec() });
    let dates = dates.map(parse_order).transpose()?;
    Ok(Dialect { delimiter, comment, skip_lines, columns, dates, arrow, most, tag })
}

/// The form of a stamp, its nanoseconds, and whether the order of day and month matters; None for other text.
#[pyfunction]
pub fn parse_stamp(text: &str, order: &str) -> PyResult<Option<(&'static str, i64, bool)>> {
    let stamp = formats::date::stamp(text.as_bytes(), parse_order(order)?);
    Ok(stamp.map(|stamp| {
        let form = match stamp.form {
            Form::Date => "date",
            Form::Day => "day",
            Form::Clock => "clock",
            Form::Minutes => "minutes",
        };
        (form, stamp.nanos, stamp.ordered)
    }))
}

fn parse_order(order: &str) -> PyResult<Order> {
    match order {
        "day_first" => Ok(Order::DayFirst),
        "month_first" => Ok(Order::MonthFirst),
        other => Err(PyValueError::new_err(format!("no such order of day and month: {other:?}"))),
    }
}

fn written((encoding, decimal_comma, lines, ..): Fields<'_>) -> PyResult<Writing> {
    let encoding = match encoding {
        "ascii" => Encoding::Ascii,
        "utf-16-le" => Encoding::Utf16Le,
        "utf-16-be" => Encoding::Utf16Be,
        other => return Err(PyValueError::new_err(format!("no such encoding: {other:?}"))),
    };
    Ok(Writing { encoding, decimal_comma, lines })
}

fn one_byte(delimiter: &str) -> PyResult<u8> {
    match delimiter.as_bytes() {
        [byte] => Ok(*byte),
        _ => Err(PyValueError::new_err(format!(
            "the delimiter must be one ASCII character, not {delimiter:?}"
        ))),
    }
}

/// The fields of `_native.formats.TextReadError`: kind, line, row, column, text, got, expected.
pub fn refused(error: Refused) -> PyErr {
    let message = error.to_string();
    let fields = match error {
        Refused::Ragged { line, row, got, expected } => {
            ("ragged", line, row, 0, String::new(), got, expected)
        }
        Refused::NotANumber { line, row, column, text } => ("not_a_number", line, row, column, text, 0, 0),
        Refused::TooLong { line } => ("too_long", line, 0, 0, String::new(), 0, 0),
        Refused::Truncated { line } => ("truncated", line, 0, 0, message, 0, 0),
        Refused::Damaged { line } => ("damaged", line, 0, 0, message, 0, 0),
        Refused::TooLarge { .. } => ("too_large", 0, 0, 0, message, 0, 0),
        Refused::Memory { rows } => ("memory", 0, rows, 0, message, 0, 0),
        Refused::Io(text) => ("io", 0, 0, 0, text, 0, 0),
        Refused::Empty => ("empty", 0, 0, 0, String::new(), 0, 0),
    };
    TextError::new_err(fields)
}

/// Number of bytes that the readers of this process have read.
#[pyfunction]
pub fn bytes_read() -> u64 {
    sigmatau_formats::bytes_read()
}
