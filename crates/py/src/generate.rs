//! Simulated records in pieces.

use crate::allan::value_error;
use crate::terms::named_term;
use numpy::{IntoPyArray, PyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use sigmatau_core::generate::{self, Component};
use sigmatau_core::pole_bank;
use sigmatau_core::terms::Term;

/// The noise of one channel, generated in pieces.
#[pyclass(module = "sigmatau._core")]
pub struct Generator(generate::Generator);

impl Generator {
    fn with(&mut self, py: Python<'_>, component: &Component, channel: u64) -> PyResult<()> {
        py.detach(|| self.0.add(component, channel)).map_err(|error| value_error(&error))
    }
}

#[pymethods]
impl Generator {
    #[new]
    fn new(n: usize, tau0: f64, seed: u64) -> PyResult<Self> {
        generate::Generator::new(n, tau0, seed).map(Self).map_err(|error| value_error(&error))
    }

    /// Adds a term by name; bias instability is exact or a sum of poles.
    fn add_term(
        &mut self,
        py: Python<'_>,
        term: &str,
        value: f64,
        channel: u64,
        poles: bool,
    ) -> PyResult<()> {
        let component = match named_term(term)? {
            Term::BiasInstability if poles => Component::PoleBank(value),
            term => Component::Term(term, value),
        };
        self.with(py, &component, channel)
    }

    /// Adds filtered white noise; matrices are in row order.
    fn add_filtered(
        &mut self,
        py: Python<'_>,
        scale: f64,
        transition: Vec<f64>,
        noise: Vec<f64>,
        start: Vec<f64>,
        channel: u64,
    ) -> PyResult<()> {
        self.with(py, &Component::Filtered { scale, transition, noise, start }, channel)
    }

    fn add_gauss_markov(
        &mut self,
        py: Python<'_>,
        sigma: f64,
        time: f64,
        index: u32,
        channel: u64,
    ) -> PyResult<()> {
        self.with(py, &Component::GaussMarkov { sigma, time, index }, channel)
    }

    fn add_sinusoid(
        &mut self,
        py: Python<'_>,
        amplitude: f64,
        frequency: f64,
        index: u32,
        channel: u64,
    ) -> PyResult<()> {
        self.with(py, &Component::Sinusoid { amplitude, frequency, index }, channel)
    }

    /// Writes the next samples into an array.
    fn fill(&mut self, py: Python<'_>, mut rate: PyReadwriteArray1<'_, f64>) -> PyResult<()> {
        let rate = rate.as_slice_mut()?;
        py.detach(|| self.0.fill(rate)).map_err(|error| value_error(&error))
    }
}

/// Losses 1 − p and weights of the poles of flicker noise in records of `n` samples.
#[pyfunction]
#[allow(clippy::type_complexity)] // two columns
pub fn flicker_poles(py: Python<'_>, n: usize) -> (Bound<'_, PyArray1<f64>>, Bound<'_, PyArray1<f64>>) {
    let (losses, weights): (Vec<f64>, Vec<f64>) =
        pole_bank::poles(n).into_iter().map(|pole| (pole.loss, pole.weight)).unzip();
    (losses.into_pyarray(py), weights.into_pyarray(py))
}
