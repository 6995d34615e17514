//! The likelihood of a channel: one pass over its samples, then the analysis of the summary.

use crate::allan::value_error;
use crate::channel_fit::{ChannelFit, JointChannelFit, LineEstimate};
use crate::frozen_class::FromCore;
use crate::pool::detached;
use crate::terms::named_term;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sigmatau_core::likelihood::{self, Contribution, Options};
use sigmatau_core::terms::NOISE_TERMS;

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

/// Summary of a channel from one pass.
#[pyclass(module = "sigmatau._core", frozen)]
pub struct LikelihoodSummary(likelihood::Summary);

impl LikelihoodSummary {
    /// Converts curves, which must have one value per block of the record.
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

    /// Smallest two-sided density of the periodogram. [(rate unit)²/Hz]
    #[getter]
    fn floor(&self) -> f64 {
        self.0.density[1..].iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// Frequency step of the periodogram. [Hz]
    #[getter]
    fn spacing(&self) -> f64 {
        self.0.frequency(1)
    }

    /// Whether both are summaries of the same samples.
    fn is_same(&self, other: &Self) -> bool {
        self.0.samples == other.0.samples && self.0.density == other.0.density
    }

    /// Number of samples over which the weights of a run should fall to 0 at its ends in another pass, and the same for a
    /// run of differences if differences should replace the samples.
    fn weighting(&self, py: Python<'_>) -> (f64, Option<f64>) {
        let found = detached(py, || self.0.weighting());
        (found.taper, found.differences)
    }

    /// Fits the channel. `samples`: length of the record, if samples are missing at its ends.
    #[allow(clippy::too_many_arguments, clippy::fn_params_excessive_bools)] // one argument per option
    #[pyo3(signature = (
        *, samples=None, terms=None, filter=true, processes=true, resonances=true, lines=true, drifts=true,
        times=Vec::new(), matern=false, regressors=Vec::new(), level=0.95, most_quantization=f64::INFINITY
    ))]
    fn fit<'py>(
        &self,
        py: Python<'py>,
        samples: Option<usize>,
        terms: Option<Vec<String>>,
        filter: bool,
        processes: bool,
        resonances: bool,
        lines: bool,
        drifts: bool,
        times: Vec<f64>,
        matern: bool,
        regressors: Vec<PyReadonlyArray1<'py, f64>>,
        level: f64,
        most_quantization: f64,
    ) -> PyResult<ChannelFit> {
        let terms = terms.map_or(Ok([true; NOISE_TERMS]), |terms| chosen(&terms))?;
        let (regressors, samples) = (self.curves(&regressors)?, samples.unwrap_or(self.0.samples));
        let options = Options {
            terms,
            filter,
            processes,
            resonances,
            lines,
            drifts,
            times,
            matern,
            regressors,
            level,
            most_quantization,
        };
        Ok(ChannelFit::from_core(detached(py, || likelihood::fit_channel(&self.0, &options, samples))))
    }
}

/// Contribution of one run to a joint fit: its summary, the regressors of its mean, its number of samples including those
/// missing at its ends, and the lines of its separate fit.
type Run<'py> = (PyRef<'py, LikelihoodSummary>, Vec<PyReadonlyArray1<'py, f64>>, usize, Vec<LineEstimate>);

/// Fits one model to several runs of a channel.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // one argument per option
#[pyo3(signature = (runs, *, terms, common, processes=true, drifts=true, times=Vec::new(), level=0.95))]
pub fn fit_jointly(
    py: Python<'_>,
    runs: Vec<Run<'_>>,
    terms: Vec<String>,
    common: Vec<String>,
    processes: bool,
    drifts: bool,
    times: Vec<f64>,
    level: f64,
) -> PyResult<JointChannelFit> {
    let (terms, common) = (chosen(&terms)?, chosen(&common)?);
    let mut contributions = Vec::new();
    for (summary, regressors, samples, lines) in &runs {
        contributions.push(Contribution {
            record: &summary.0,
            regressors: summary.curves(regressors)?,
            samples: *samples,
            lines: lines.iter().cloned().map(Into::into).collect(),
        });
    }
    if contributions.is_empty() {
        return Err(PyValueError::new_err("no runs"));
    }
    let options =
        Options { terms, processes, resonances: processes, drifts, times, level, ..Options::default() };
    Ok(JointChannelFit::from_core(detached(py, || likelihood::fit_jointly(&contributions, &options, common))))
}

/// Which of the noise terms are in `names`.
fn chosen(names: &[String]) -> PyResult<[bool; NOISE_TERMS]> {
    let mut chosen = [false; NOISE_TERMS];
    for name in names {
        let index = named_term(name)?.index();
        *chosen
            .get_mut(index)
            .ok_or_else(|| PyValueError::new_err(format!("{name} is not a noise term")))? = true;
    }
    Ok(chosen)
}
