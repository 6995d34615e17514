//! Medians and scatter of the neighbours of samples.

use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::neighbours::{self, Limits, Quantile};

type Floats<'py> = Bound<'py, PyArray1<f64>>;
type Ints<'py> = Bound<'py, PyArray1<i64>>;

/// `limits`: threshold, multiple and smallest difference; `quantile`: probability, and its quantile for normal noise.
#[pyfunction]
pub fn outliers<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    limits: [f64; 3],
    side: usize,
    quantile: [f64; 2],
) -> PyResult<Ints<'py>> {
    let x = x.as_slice()?;
    let [threshold, multiple, least] = limits;
    let [part, normal] = quantile;
    let limits = Limits { threshold, multiple, least, side, quantile: Quantile { part, normal } };
    let found: Vec<i64> =
        detached(py, || neighbours::outliers(x, &limits).into_iter().map(|at| at as i64).collect());
    Ok(found.into_pyarray(py))
}

#[pyfunction]
pub fn from_sides<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    at: PyReadonlyArray1<'py, i64>,
    side: usize,
) -> PyResult<Floats<'py>> {
    let (x, at) = (x.as_slice()?, at.as_slice()?);
    let found: Vec<f64> = detached(py, || {
        let mut values = Vec::new();
        at.iter().map(|&k| neighbours::from_sides(x, k as usize, side, &mut values)).collect()
    });
    Ok(found.into_pyarray(py))
}

#[pyfunction]
pub fn neighbour_scatter<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    at: PyReadonlyArray1<'py, i64>,
    quantile: [f64; 2],
) -> PyResult<Floats<'py>> {
    let (x, at) = (x.as_slice()?, at.as_slice()?);
    let [part, normal] = quantile;
    let found: Vec<f64> = detached(py, || {
        let mut values = Vec::new();
        at.iter()
            .map(|&k| neighbours::scatter(x, k as usize, Quantile { part, normal }, &mut values))
            .collect()
    });
    Ok(found.into_pyarray(py))
}

#[pyfunction]
pub fn neighbour_medians<'py>(
    py: Python<'py>,
    x: PyReadonlyArray1<'py, f64>,
    side: usize,
    least: usize,
) -> PyResult<Floats<'py>> {
    let x = x.as_slice()?;
    Ok(detached(py, || neighbours::medians(x, side, least)).into_pyarray(py))
}
