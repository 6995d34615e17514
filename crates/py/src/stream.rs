//! The accumulator of one channel of a stream, as a Python object.

use crate::allan::{sizes, value_error};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use sigmatau_core::stream::{self, Long, Strided};

type Floats<'py> = Bound<'py, PyArray1<f64>>;
type Integers<'py> = Bound<'py, PyArray1<i64>>;

#[pyclass(module = "sigmatau._core")]
#[derive(Clone)]
pub struct Accumulator(stream::Accumulator);

#[pymethods]
impl Accumulator {
    #[new]
    fn new(m: PyReadonlyArray1<'_, i64>, strided: bool, start: u64) -> PyResult<Self> {
        let long = if strided { Long::Strided } else { Long::Exact };
        stream::Accumulator::new(&sizes(&m)?, long, start).map(Self).map_err(|error| value_error(&error))
    }

    #[staticmethod]
    fn restored(
        m: PyReadonlyArray1<'_, i64>,
        strided: bool,
        start: u64,
        state: PyReadonlyArray1<'_, u64>,
    ) -> PyResult<Self> {
        let long = if strided { Long::Strided } else { Long::Exact };
        stream::Accumulator::restored(&sizes(&m)?, long, start, state.as_slice()?)
            .map(Self)
            .map_err(|error| value_error(&error))
    }

    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.0.state().into_pyarray(py)
    }

    #[getter]
    fn start(&self) -> u64 {
        self.0.start()
    }

    #[getter]
    fn samples(&self) -> u64 {
        self.0.samples()
    }

    fn push(&mut self, py: Python<'_>, rate: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let rate = rate.as_slice()?;
        detached(py, || self.0.push(rate)).map_err(|error| value_error(&error))
    }

    /// Index of the first sample that `push` would refuse.
    #[staticmethod]
    fn first_unusable(rate: PyReadonlyArray1<'_, f64>) -> PyResult<Option<usize>> {
        Ok(stream::first_unusable(rate.as_slice()?))
    }

    fn merge(&mut self, py: Python<'_>, later: &Self) -> PyResult<()> {
        detached(py, || self.0.merge(&later.0)).map_err(|error| value_error(&error))
    }

    fn copy(&self) -> Self {
        self.clone()
    }

    /// Cluster sizes, variances, ramps, pairs and strides.
    #[allow(clippy::type_complexity)] // a tuple of columns
    fn snapshot<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Integers<'py>, Floats<'py>, Floats<'py>, Integers<'py>, Integers<'py>)> {
        let found = detached(py, || self.0.snapshot()).map_err(|error| value_error(&error))?;
        let integers = |of: fn(&Strided) -> usize| {
            found.iter().map(|s| of(s) as i64).collect::<Vec<_>>().into_pyarray(py)
        };
        let floats = |of: fn(&Strided) -> f64| found.iter().map(of).collect::<Vec<_>>().into_pyarray(py);
        Ok((
            integers(|s| s.estimate.m),
            floats(|s| s.estimate.avar),
            floats(|s| s.estimate.ramp),
            integers(|s| s.estimate.pairs),
            integers(|s| s.stride),
        ))
    }
}

/// Stride of the starts at each cluster size.
#[pyfunction]
pub fn strides<'py>(py: Python<'py>, m: PyReadonlyArray1<'py, i64>) -> PyResult<Integers<'py>> {
    Ok(sizes(&m)?.into_iter().map(|m| stream::stride(m) as i64).collect::<Vec<_>>().into_pyarray(py))
}
