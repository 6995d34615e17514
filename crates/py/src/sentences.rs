//! Sentences with checksums.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use sigmatau_formats as formats;
use std::path::PathBuf;

use crate::text::refused;

/// Columns; number of broken lines, of those after the first row, and the first ones; other sentences (number, longest run
/// and its line, name); and whether the file was cut.
type Others = (usize, (usize, usize), String);
type Found<'py> = (Vec<Bound<'py, PyArray1<f64>>>, usize, usize, Vec<(usize, String)>, Others, bool);

#[pyfunction]
pub fn read_sentences<'py>(
    py: Python<'py>,
    path: PathBuf,
    name: &str,
    fields: usize,
    wanted: Vec<usize>,
    most: u64,
) -> PyResult<Found<'py>> {
    let read =
        || formats::read_sentences(formats::open(&path, most)?, name.as_bytes(), fields, &wanted, most);
    let sentences = py.detach(read).map_err(refused)?;
    let columns = sentences.columns.into_iter().map(|c| c.into_pyarray(py)).collect();
    let skipped = (sentences.others, sentences.gap, sentences.other);
    Ok((columns, sentences.broken, sentences.inner, sentences.examples, skipped, sentences.cut))
}
