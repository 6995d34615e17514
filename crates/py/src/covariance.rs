//! The exact covariance of Allan variances, as tensors that Python contracts with its coefficients.

use crate::allan::{sizes, value_error};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::covariance::{Component, Gamma};
use sigmatau_core::terms::Term;

type Tensors<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

#[pyfunction]
pub fn covariance_tensors<'py>(
    py: Python<'py>,
    n: usize,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
    correlation_times: Vec<f64>,
) -> PyResult<Tensors<'py>> {
    let sizes = sizes(&m)?;
    // The core counts in samples.
    let processes = correlation_times.iter().map(|time| Component::GaussMarkov { tc: time / tau0 });
    // The order of the tensors' first indices.
    let components: Vec<Component> = Term::NOISE.into_iter().map(Component::Term).chain(processes).collect();
    let gamma = detached(py, || Gamma::new(n, &sizes, &components)?.at_interval(tau0))
        .map_err(|error| value_error(&error))?;
    let terms = 0..components.len();
    let pairs = terms.clone().flat_map(|p| terms.clone().map(move |q| (p, q)));
    let noise: Vec<f64> = pairs.flat_map(|(p, q)| gamma.noise_part(p, q)).collect();
    let ramp: Vec<f64> = terms.flat_map(|p| gamma.ramp_part(p)).collect();
    Ok((noise.into_pyarray(py), ramp.into_pyarray(py)))
}
