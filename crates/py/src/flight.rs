//! Flight logs.

use numpy::{IntoPyArray, PyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use sigmatau_formats::{self as formats, Break, DataFlashRows, UlogError, UlogTopic};
use std::fs::File;
use std::path::PathBuf;

type Bytes<'py> = Vec<Bound<'py, PyArray1<u8>>>;

/// Content of a `ULog` file: a dictionary, see `_native.logs.scan_ulog`.
#[pyfunction]
pub fn scan_ulog(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let scan = py.detach(|| formats::scan_ulog(File::open(path)?)).map_err(refused)?;
    let bytes = |b: &Vec<u8>| PyBytes::new(py, b);
    let dict = PyDict::new(py);
    dict.set_item("formats", scan.formats.iter().map(bytes).collect::<Vec<_>>())?;
    let topics: Vec<_> =
        scan.topics.iter().map(|t| (t.id, t.instance, bytes(&t.name), t.rows, t.size)).collect();
    dict.set_item("topics", topics)?;
    dict.set_item("dropouts", scan.dropouts)?;
    dict.set_item("unknown", scan.unknown)?;
    dict.set_item("unfinished", scan.unfinished)?;
    dict.set_item("messages", scan.messages)?;
    dict.set_item("end", scan.end)?;
    dict.set_item("broken", broken(scan.broken))?;
    Ok(dict)
}

#[pyfunction]
pub fn ulog_columns(
    py: Python<'_>,
    path: PathBuf,
    end: u64,
    number: u16,
    rows: usize,
    size: usize,
    fields: Vec<(usize, usize)>,
) -> PyResult<Bytes<'_>> {
    let topic = UlogTopic { id: number, instance: 0, name: Vec::new(), rows, size };
    let read = || formats::ulog_columns(File::open(path)?, end, &topic, &fields);
    let columns = py.detach(read).map_err(refused)?;
    Ok(columns.into_iter().map(|column| column.into_pyarray(py)).collect())
}

/// Content of a `DataFlash` file: a dictionary, see `_native.logs.scan_dataflash`.
#[pyfunction]
pub fn scan_dataflash(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let scan = py.detach(|| formats::scan_dataflash(File::open(path)?))?;
    let dict = PyDict::new(py);
    let kinds: Vec<_> =
        scan.kinds.into_iter().map(|k| (k.id, k.name, k.fields, k.size, k.instance, k.rows)).collect();
    dict.set_item("kinds", kinds)?;
    let definitions: Vec<_> =
        scan.definitions.iter().map(|(place, body)| (place, PyBytes::new(py, body))).collect();
    dict.set_item("definitions", definitions)?;
    dict.set_item("messages", scan.messages)?;
    dict.set_item("end", scan.end)?;
    dict.set_item("filler", scan.filler)?;
    dict.set_item("broken", broken(scan.broken))?;
    Ok(dict)
}

#[pyfunction]
#[allow(clippy::too_many_arguments)] // the result of a scan, see `_native.logs`
pub fn dataflash_columns(
    py: Python<'_>,
    path: PathBuf,
    end: u64,
    kind: u8,
    instance: Option<(usize, u8)>,
    rows: usize,
    size: usize,
    fields: Vec<(usize, usize)>,
) -> PyResult<Bytes<'_>> {
    let wanted = DataFlashRows { id: kind, instance, size, rows, end };
    let columns = py.detach(|| formats::dataflash_columns(File::open(path)?, &wanted, &fields))?;
    Ok(columns.into_iter().map(|column| column.into_pyarray(py)).collect())
}

fn broken(dict: Option<Break>) -> Option<(u64, Option<String>)> {
    dict.map(|b| match b {
        Break::Cut { at } => (at, None),
        Break::Damaged { at, what } => (at, Some(what)),
    })
}

fn refused(error: UlogError) -> PyErr {
    match error {
        UlogError::Io(error) => error.into(),
        other => PyValueError::new_err(other.to_string()),
    }
}
