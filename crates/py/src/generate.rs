//! Simulated records.

use crate::allan::value_error;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use sigmatau_core::generate::{self, Coefficients};

#[pyfunction]
#[allow(clippy::too_many_arguments)] // one a coefficient: their names are checked on the Python side
pub fn simulate(
    py: Python<'_>,
    n: usize,
    tau0: f64,
    quantization: f64,
    random_walk: f64,
    bias_instability: f64,
    rate_random_walk: f64,
    rate_ramp: f64,
    seed: u64,
    stream: u64,
) -> PyResult<Bound<'_, PyArray1<f64>>> {
    let c = Coefficients { quantization, random_walk, bias_instability, rate_random_walk, rate_ramp };
    let rate = py.detach(|| generate::simulate(n, tau0, &c, seed, stream)).map_err(|e| value_error(&e))?;
    Ok(rate.into_pyarray(py))
}
