//! Allan variances of arrays.

use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyMemoryError, PyValueError};
use pyo3::prelude::*;
use sigmatau_core::allan::{self, Counting, Estimate, Overlap};
use sigmatau_core::error::Error;
use sigmatau_core::finite;

pyo3::create_exception!(sigmatau._core, NonFinite, PyValueError);

type Arrays<'py> = Vec<Bound<'py, PyArray1<f64>>>;
/// Variances and ramps by channel, and pairs.
type Variances<'py> = (Arrays<'py>, Arrays<'py>, Bound<'py, PyArray1<i64>>);

#[pyfunction]
pub fn allan_variances<'py>(
    py: Python<'py>,
    columns: Vec<PyReadonlyArray1<'py, f64>>,
    m: PyReadonlyArray1<'py, i64>,
    overlapped: bool,
    paper: bool,
    threads: usize,
) -> PyResult<Variances<'py>> {
    let columns = columns.iter().map(|c| c.as_slice()).collect::<Result<Vec<_>, _>>()?;
    let sizes = sizes(&m)?;
    let overlap = if overlapped { Overlap::Full } else { Overlap::None };
    let counting = if paper { Counting::Paper } else { Counting::Standard };
    let threads = (threads > 0).then_some(threads);
    let channels = detached(py, || allan::allan_variances(&columns, &sizes, overlap, counting, threads))
        .map_err(|error| error_in_channel(&columns, error))?;
    let pairs: Vec<i64> = channels.first().into_iter().flatten().map(|e| e.pairs as i64).collect();
    let by_channel = |of: fn(&Estimate) -> f64| -> Arrays<'py> {
        channels.iter().map(|c| c.iter().map(of).collect::<Vec<_>>().into_pyarray(py)).collect()
    };
    Ok((by_channel(|e| e.avar), by_channel(|e| e.ramp), pairs.into_pyarray(py)))
}

#[pyfunction]
pub fn all_finite(py: Python<'_>, columns: Vec<PyReadonlyArray1<'_, f64>>) -> PyResult<Vec<bool>> {
    let columns = columns.iter().map(|c| c.as_slice()).collect::<Result<Vec<_>, _>>()?;
    Ok(detached(py, || finite::all_finite(&columns)))
}

/// Cluster sizes for the core; `_native.kernels` has checked that they are positive.
pub fn sizes(m: &PyReadonlyArray1<'_, i64>) -> PyResult<Vec<usize>> {
    m.as_slice()?
        .iter()
        .map(|&size| usize::try_from(size).map_err(|_| PyValueError::new_err(format!("cluster size {size}"))))
        .collect()
}

pub fn value_error(error: &Error) -> PyErr {
    match error {
        Error::Memory { .. } => PyMemoryError::new_err(error.to_string()),
        _ => PyValueError::new_err(error.to_string()),
    }
}

/// The error with the channel: the core reports only the index of the sample.
pub fn error_in_channel(columns: &[&[f64]], error: Error) -> PyErr {
    let Error::NonFinite { index } = error else {
        return value_error(&error);
    };
    let refused = |column: &&[f64]| column.get(index).is_some_and(|y| !y.is_finite() || y.abs() > 1e130);
    let channel = columns.iter().position(refused).unwrap_or_default();
    NonFinite::new_err((error.to_string(), channel, index))
}
