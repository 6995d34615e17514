//! The Cholesky factor of a covariance, as an object that Python holds on to.

use crate::allan::value_error;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sigmatau_core::cholesky;

#[pyclass(frozen, module = "sigmatau._core")]
pub struct Factor(cholesky::Factor);

#[pymethods]
impl Factor {
    #[new]
    fn new(covariance: PyReadonlyArray1<'_, f64>, order: usize) -> PyResult<Self> {
        let covariance = covariance.as_slice()?;
        if order == 0 || covariance.len() != order * order {
            return Err(PyValueError::new_err("the covariance is not square"));
        }
        cholesky::Factor::new(covariance, order).map(Self).map_err(|error| value_error(&error))
    }

    fn whiten<'py>(
        &self,
        py: Python<'py>,
        columns: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut columns = columns.as_slice()?.to_vec();
        if columns.len() % self.0.sd().len() != 0 {
            return Err(PyValueError::new_err("columns and covariance differ in length"));
        }
        self.0.whiten(&mut columns);
        Ok(columns.into_pyarray(py))
    }

    fn unwhiten<'py>(
        &self,
        py: Python<'py>,
        weights: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let mut weights = weights.as_slice()?.to_vec();
        if weights.len() != self.0.sd().len() {
            return Err(PyValueError::new_err("weights and covariance differ in length"));
        }
        self.0.unwhiten(&mut weights);
        Ok(weights.into_pyarray(py))
    }
}
