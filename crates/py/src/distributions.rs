//! Distributions of the elements of arrays.

use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sigmatau_core::distributions as laws;

type Floats<'py> = PyReadonlyArray1<'py, f64>;
type Result<'py> = PyResult<Bound<'py, PyArray1<f64>>>;

/// Applies a function of one variable to each element.
#[pyfunction]
pub fn distribution<'py>(py: Python<'py>, name: &str, x: Floats<'py>) -> Result<'py> {
    let form: fn(f64) -> f64 = match name {
        "normal_below" => laws::normal_below,
        "normal_quantile" => laws::normal_quantile,
        "digamma" => laws::digamma,
        "log_gamma" => laws::log_gamma,
        _ => return Err(PyValueError::new_err(format!("unknown function {name}"))),
    };
    Ok(x.as_slice()?.iter().map(|&x| form(x)).collect::<Vec<_>>().into_pyarray(py))
}

/// Applies a function of two variables to each pair of elements.
#[pyfunction]
pub fn distribution_of_shape<'py>(
    py: Python<'py>,
    name: &str,
    shape: Floats<'py>,
    x: Floats<'py>,
) -> Result<'py> {
    let form: fn(f64, f64) -> f64 = match name {
        "gamma_below" => laws::gamma_below,
        "gamma_above" => laws::gamma_above,
        "gamma_quantile" => laws::gamma_quantile,
        "gamma_quantile_above" => laws::gamma_quantile_above,
        "student_below" => laws::student_below,
        "student_quantile" => laws::student_quantile,
        _ => return Err(PyValueError::new_err(format!("unknown distribution {name}"))),
    };
    let pairs = shape.as_slice()?.iter().zip(x.as_slice()?);
    Ok(pairs.map(|(&shape, &x)| form(shape, x)).collect::<Vec<_>>().into_pyarray(py))
}
