//! Allan variances of records with missing samples, and what noise is expected to show in them.

use crate::allan::{sizes, value_error, wrong};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::allan::{Counting, Overlap};
use sigmatau_core::gaps::{self, expected};

type Floats<'py> = Bound<'py, PyArray1<f64>>;

#[pyfunction]
pub fn masked_variances<'py>(
    py: Python<'py>,
    column: PyReadonlyArray1<'py, f64>,
    m: PyReadonlyArray1<'py, i64>,
    overlapped: bool,
    paper: bool,
    threads: usize,
) -> PyResult<(Floats<'py>, Floats<'py>, Bound<'py, PyArray1<i64>>)> {
    let column = column.as_slice()?;
    let sizes = sizes(&m)?;
    let overlap = if overlapped { Overlap::Full } else { Overlap::None };
    let counting = if paper { Counting::Paper } else { Counting::Standard };
    let threads = (threads > 0).then_some(threads);
    let found = detached(py, || gaps::allan_variance(column, &sizes, overlap, counting, threads))
        .map_err(|error| wrong(&[column], error))?;
    let of = |value: fn(&sigmatau_core::allan::Estimate) -> f64| {
        found.iter().map(value).collect::<Vec<_>>().into_pyarray(py)
    };
    let pairs: Vec<i64> = found.iter().map(|e| e.pairs as i64).collect();
    Ok((of(|e| e.avar), of(|e| e.ramp), pairs.into_pyarray(py)))
}

/// Seven columns, size after size.
#[pyfunction]
pub fn masked_expectations<'py>(
    py: Python<'py>,
    there: PyReadonlyArray1<'py, bool>,
    m: PyReadonlyArray1<'py, i64>,
    threads: usize,
) -> PyResult<Floats<'py>> {
    let there = there.as_slice()?;
    let sizes = sizes(&m)?;
    let threads = (threads > 0).then_some(threads);
    let found =
        detached(py, || expected::expected(there, &sizes, threads)).map_err(|error| value_error(&error))?;
    let row = |e: &expected::Expected| {
        let walks = [e.random_walk, e.bias_instability, e.rate_random_walk];
        [[e.pairs as f64, e.quantization, e.telescoping].as_slice(), &walks, &[e.square_distance]].concat()
    };
    Ok(found.iter().flat_map(row).collect::<Vec<_>>().into_pyarray(py))
}
