//! The likelihood of a channel: one pass over its samples, then the analysis of what it keeps.

use crate::allan::value_error;
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sigmatau_core::likelihood::{self, Bounds, Drift, Options, Outcome, Part, analyse, analyse_jointly};

enum Walk {
    Complete(Box<likelihood::Pass>),
    Masked(Box<likelihood::MaskedPass>),
}

#[pyclass(module = "sigmatau._core")]
pub struct LikelihoodPass(Option<Walk>);

#[pymethods]
impl LikelihoodPass {
    #[new]
    fn new(samples: usize, tau0: f64) -> PyResult<Self> {
        let pass = likelihood::Pass::new(samples, tau0).map_err(|error| value_error(&error))?;
        Ok(Self(Some(Walk::Complete(Box::new(pass)))))
    }

    /// A pass over a record with missing samples.
    #[staticmethod]
    #[pyo3(signature = (present, tau0, taper=0.0, differences=None))]
    fn masked(
        present: PyReadonlyArray1<'_, bool>,
        tau0: f64,
        taper: f64,
        differences: Option<f64>,
    ) -> PyResult<Self> {
        let weighting = likelihood::Weighting { taper, differences };
        let pass = likelihood::MaskedPass::new(present.as_slice()?.to_vec(), tau0, weighting)
            .map_err(|error| value_error(&error))?;
        Ok(Self(Some(Walk::Masked(Box::new(pass)))))
    }

    fn push(&mut self, py: Python<'_>, rate: PyReadonlyArray1<'_, f64>) -> PyResult<()> {
        let rate = rate.as_slice()?;
        let pass = self.0.as_mut().ok_or_else(finished)?;
        detached(py, || match pass {
            Walk::Complete(pass) => pass.push(rate),
            Walk::Masked(pass) => pass.push(rate),
        })
        .map_err(|error| value_error(&error))
    }

    fn finish(&mut self, py: Python<'_>) -> PyResult<LikelihoodSummary> {
        let pass = self.0.take().ok_or_else(finished)?;
        detached(py, || match pass {
            Walk::Complete(pass) => pass.finish(),
            Walk::Masked(pass) => pass.finish(),
        })
        .map(LikelihoodSummary)
        .map_err(|error| value_error(&error))
    }
}

fn finished() -> PyErr {
    PyValueError::new_err("the pass is finished")
}

/// What one pass keeps of a channel.
#[pyclass(module = "sigmatau._core", frozen)]
pub struct LikelihoodSummary(likelihood::Summary);

impl LikelihoodSummary {
    /// Curves at the blocks of the record.
    fn curves(&self, regressors: &[PyReadonlyArray1<'_, f64>]) -> PyResult<Vec<Vec<f64>>> {
        let mut curves = Vec::new();
        for curve in regressors {
            let curve = curve.as_slice()?.to_vec();
            if curve.len() != self.0.blocks {
                return Err(PyValueError::new_err(format!(
                    "a regressor has {} values, the record {} blocks",
                    curve.len(),
                    self.0.blocks
                )));
            }
            curves.push(curve);
        }
        Ok(curves)
    }
}

#[pymethods]
impl LikelihoodSummary {
    #[getter]
    fn samples(&self) -> usize {
        self.0.samples
    }

    /// Length of the record. [s]
    #[getter]
    fn duration(&self) -> f64 {
        self.0.duration()
    }

    /// Times of the centres of the blocks, from the first sample. [s]
    #[getter]
    fn centres<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.0.centres().into_pyarray(py)
    }

    /// Samples over which the weights of a run should fall to 0 at its ends in another pass, and those of a run of
    /// differences if they should take the place of the samples.
    fn weighting(&self, py: Python<'_>) -> (f64, Option<f64>) {
        let found = detached(py, || self.0.weighting());
        (found.taper, found.differences)
    }

    /// Frequencies and densities of the periodogram.
    #[getter]
    fn periodogram<'py>(&self, py: Python<'py>) -> (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>) {
        let frequency: Vec<f64> = (0..self.0.density.len()).map(|k| self.0.frequency(k)).collect();
        (frequency.into_pyarray(py), self.0.density.clone().into_pyarray(py))
    }

    #[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools)] // one for each option
    #[pyo3(signature = (terms, filter, processes, resonances, lines, drifts, times, regressors, level))]
    fn analyse<'py>(
        &self,
        py: Python<'py>,
        terms: [bool; 4],
        filter: bool,
        processes: bool,
        resonances: bool,
        lines: bool,
        drifts: bool,
        times: Vec<f64>,
        regressors: Vec<PyReadonlyArray1<'py, f64>>,
        level: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let curves = self.curves(&regressors)?;
        let options =
            Options { terms, filter, processes, resonances, lines, drifts, times, regressors: curves, level };
        let found = detached(py, || analyse(&self.0, &options));
        stated(py, &found)
    }
}

/// Analyses several runs of a channel; `regressors` are those of each run.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // one for each option
#[pyo3(signature = (summaries, regressors, terms, common, processes, drifts, times, level))]
pub fn likelihood_jointly<'py>(
    py: Python<'py>,
    summaries: Vec<PyRef<'py, LikelihoodSummary>>,
    regressors: Vec<Vec<PyReadonlyArray1<'py, f64>>>,
    terms: [bool; 4],
    common: [bool; 4],
    processes: bool,
    drifts: bool,
    times: Vec<f64>,
    level: f64,
) -> PyResult<Bound<'py, PyDict>> {
    if summaries.is_empty() || summaries.len() != regressors.len() {
        return Err(PyValueError::new_err(format!(
            "{} runs with regressors for {}",
            summaries.len(),
            regressors.len()
        )));
    }
    let mut curves = Vec::new();
    for (summary, own) in summaries.iter().zip(&regressors) {
        curves.push(summary.curves(own)?);
    }
    let options =
        Options { terms, processes, resonances: processes, drifts, times, level, ..Options::default() };
    let records: Vec<&likelihood::Summary> = summaries.iter().map(|summary| &summary.0).collect();
    let found = detached(py, || analyse_jointly(&records, &curves, &options, common));
    let result = stated(py, &found.outcome)?;
    result.set_item("ramps", found.ramps)?;
    let ramps: Vec<_> = found.ramps_of.iter().map(|ramp| (ramp.value, ramp.error)).collect();
    result.set_item("ramps_of", ramps)?;
    let levels: Vec<_> = found.levels.iter().map(|l| (l.term, l.spread, l.p_value, l.runs.clone())).collect();
    result.set_item("levels", levels)?;
    result.set_item("homogeneity", found.homogeneity.to_vec())?;
    let others: Vec<_> = found
        .others
        .iter()
        .map(|o| {
            (
                o.terms
                    .map(|own| own.map(|[theta, error, others, fall]| (theta, error, others, fall)))
                    .to_vec(),
                o.all,
            )
        })
        .collect();
    result.set_item("others", others)?;
    result.set_item("bin_counts", found.bins)?;
    Ok(result)
}

fn stated<'py>(py: Python<'py>, found: &Outcome) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    let bounds = |b: &Bounds| (b.value, b.low, b.high, b.observed, b.loss);
    let drift = |d: &Drift| (d.value, d.error);
    result.set_item("terms", found.terms.iter().map(|t| t.as_ref().map(bounds)).collect::<Vec<_>>())?;
    result.set_item("reduced", found.reduced.to_vec())?;
    let mut processes = Vec::new();
    for process in &found.processes {
        let kind = match process.part {
            Part::GaussMarkov { .. } => "gauss_markov",
            _ => "resonance",
        };
        let shape: Vec<_> = process.shape.iter().flatten().map(bounds).collect();
        processes.push((kind, bounds(&process.variance), shape));
    }
    result.set_item("processes", processes)?;
    result.set_item("filter", found.filter.clone())?;
    result.set_item("filter_interval", found.filter_interval)?;
    result.set_item(
        "lines",
        found.lines.iter().map(|l| (l.from, l.to, l.frequency, l.amplitude, l.error)).collect::<Vec<_>>(),
    )?;
    result.set_item("highest", found.highest)?;
    result.set_item("alike_from", found.alike_from)?;
    result.set_item("ramp", drift(&found.ramp))?;
    result.set_item("ramp_observed", found.ramp_observed)?;
    result.set_item("warm_up", found.warm_up.as_ref().map(|(t, d, gain)| (*t, d.value, d.error, *gain)))?;
    result.set_item("regressors", found.regressors.iter().map(drift).collect::<Vec<_>>())?;
    result.set_item("p_value", found.p_value)?;
    result.set_item("widened", found.widened)?;
    result.set_item("bands", found.bands.clone())?;
    result.set_item("discrepancy", found.discrepancy.clone())?;
    result.set_item("unsteadiness", found.unsteadiness)?;
    result.set_item("kurtosis", found.kurtosis)?;
    let names: Vec<&str> = found.parameters.iter().map(|&part| name(part)).collect();
    result.set_item("parameters", names)?;
    let n = found.covariance.len().isqrt();
    result.set_item("covariance", found.covariance.clone().into_pyarray(py).reshape([n, n])?)?;
    let flat: Vec<f64> = found.bins.iter().flatten().copied().collect();
    let bins: Bound<'py, PyArray2<f64>> = flat.into_pyarray(py).reshape([found.bins.len(), 4])?;
    result.set_item("bins", bins)?;
    Ok(result)
}

fn name(part: Part) -> &'static str {
    match part {
        Part::Quantization => "quantization",
        Part::RandomWalk => "random_walk",
        Part::BiasInstability => "bias_instability",
        Part::RateRandomWalk => "rate_random_walk",
        Part::GaussMarkov { .. } => "gauss_markov",
        Part::Resonance { .. } => "resonance",
    }
}
