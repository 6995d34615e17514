//! Allan variances of records with missing samples.

use crate::allan::{error_in_channel, sizes};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::allan::{Counting, Overlap};
use sigmatau_core::gaps;

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
        .map_err(|error| error_in_channel(&[column], error))?;
    let of = |value: fn(&sigmatau_core::allan::Estimate) -> f64| {
        found.iter().map(value).collect::<Vec<_>>().into_pyarray(py)
    };
    let pairs: Vec<i64> = found.iter().map(|e| e.pairs as i64).collect();
    Ok((of(|e| e.avar), of(|e| e.ramp), pairs.into_pyarray(py)))
}
