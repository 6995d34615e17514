//! Allan variances of records with missing samples, and what noise is expected to show in them.

use crate::allan::{sizes, value_error, wrong};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::allan::{Counting, Overlap};
use sigmatau_core::gaps::covariance::{Process, long_times};
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

/// Seven columns, size after size; the correlation times; the ratios at them, size after size, NaN beyond the last.
#[pyfunction]
pub fn masked_expectations<'py>(
    py: Python<'py>,
    there: PyReadonlyArray1<'py, bool>,
    m: PyReadonlyArray1<'py, i64>,
    threads: usize,
) -> PyResult<(Floats<'py>, Floats<'py>, Floats<'py>)> {
    let there = there.as_slice()?;
    let sizes = sizes(&m)?;
    let threads = (threads > 0).then_some(threads);
    let found =
        detached(py, || expected::expected(there, &sizes, threads)).map_err(|error| value_error(&error))?;
    let times = expected::nodes(there.len() / 2);
    let mut columns = Vec::with_capacity(7 * found.len());
    let mut ratios = vec![f64::NAN; times.len() * found.len()];
    for (e, row) in found.iter().zip(ratios.chunks_mut(times.len().max(1))) {
        columns.extend([
            e.pairs as f64,
            e.quantization,
            e.telescoping,
            e.random_walk,
            e.bias_instability,
            e.rate_random_walk,
            e.square_distance,
        ]);
        row[..e.ratios.len()].copy_from_slice(&e.ratios);
    }
    Ok((columns.into_pyarray(py), times.into_pyarray(py), ratios.into_pyarray(py)))
}

/// Allan variances, noise and slopes; processes in the order random walk, bias instability, rate random walk, and one for
/// each of the correlation times.
#[pyfunction]
pub fn masked_covariance<'py>(
    py: Python<'py>,
    there: PyReadonlyArray1<'py, bool>,
    m: PyReadonlyArray1<'py, i64>,
    block: usize,
    correlation_times: Vec<f64>,
) -> PyResult<(Floats<'py>, Floats<'py>, Floats<'py>)> {
    let there = there.as_slice()?;
    let sizes = sizes(&m)?;
    let linear = [Process::RandomWalk, Process::BiasInstability, Process::RateRandomWalk];
    let others = correlation_times.into_iter().map(|time| Process::GaussMarkov { time });
    let processes: Vec<Process> = linear.into_iter().chain(others).collect();
    let found =
        detached(py, || long_times(there, &sizes, block, &processes)).map_err(|error| value_error(&error))?;
    Ok((
        found.avar.concat().into_pyarray(py),
        found.noise.concat().into_pyarray(py),
        found.slopes.concat().into_pyarray(py),
    ))
}

/// Variance of the ramp that white noise of variance 1 shows at each size.
#[pyfunction]
pub fn masked_white_slopes<'py>(
    py: Python<'py>,
    there: PyReadonlyArray1<'py, bool>,
    m: PyReadonlyArray1<'py, i64>,
    threads: usize,
) -> PyResult<Floats<'py>> {
    let there = there.as_slice()?;
    let sizes = sizes(&m)?;
    let threads = (threads > 0).then_some(threads);
    let found = detached(py, || expected::white_slopes(there, &sizes, threads));
    Ok(found.map_err(|error| value_error(&error))?.into_pyarray(py))
}
