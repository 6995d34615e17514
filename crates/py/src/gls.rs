//! Least squares on Allan variances: the fit of a curve, and its parts for planning and tests.

use crate::allan::{sizes, value_error};
use crate::channel_fit::{GaussMarkovEstimate, Parameter, TermEstimate};
use crate::frozen_class::{FromCore, frozen_class};
use crate::pool::detached;
use crate::terms::named_term;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyFloatingPointError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyTuple, PyType};
use sigmatau_core::gls::{self, Base, Failed, Shape, Terms, Theta};
use std::sync::Arc;

type Floats<'py> = Bound<'py, PyArray1<f64>>;

/// Terms of a record at some cluster sizes.
#[pyclass(frozen, module = "sigmatau._core")]
pub struct GlsComponents(gls::Components);

#[pymethods]
impl GlsComponents {
    #[new]
    fn new(
        py: Python<'_>,
        n: usize,
        m: PyReadonlyArray1<'_, i64>,
        correlation_time: Option<f64>,
        frequency: Option<f64>,
    ) -> PyResult<Self> {
        let sizes = sizes(&m)?;
        let shape = frequency.map(Shape::Sinusoid).or(correlation_time.map(Shape::GaussMarkov));
        let found = detached(py, || gls::Components::new(n, &sizes, shape));
        found.map(Self).map_err(|error| value_error(&error))
    }

    /// Expected Allan variances for θ = 1, one row per term.
    fn design<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::design)
    }

    /// Covariance of the ramps for θ = 1, one matrix per term.
    fn slopes<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::slopes)
    }

    /// Power of the modes for θ = 1, divided by n; one row per term.
    fn spectra<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::spectrum)
    }

    /// Number of modes that each mode represents.
    fn modes<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.0.base.multiplicities().to_vec().into_pyarray(py)
    }

    fn degrees_of_freedom<'py>(&self, py: Python<'py>, theta: Vec<f64>, ramp: f64) -> PyResult<Floats<'py>> {
        Ok(self.0.degrees_of_freedom(0, &self.theta(&theta)?, ramp).into_pyarray(py))
    }

    /// The smallest θ of a term that a test detects with probability `power`.
    fn detectable(
        &self,
        py: Python<'_>,
        term: usize,
        others: Vec<f64>,
        level: f64,
        power: f64,
    ) -> PyResult<f64> {
        let others = self.theta(&others)?;
        let term = self.term(term)?;
        detached(py, || gls::detectable(&self.0, term, &others, level, power)).map_err(failed)
    }

    /// The smallest ramp per sample that a test detects with probability `power`.
    fn least_ramp(&self, py: Python<'_>, theta: Vec<f64>, level: f64, power: f64) -> PyResult<f64> {
        let theta = self.theta(&theta)?;
        detached(py, || gls::least_ramp(&self.0, &theta, level, power)).map_err(failed)
    }
}

impl GlsComponents {
    fn of_terms<'py>(&self, py: Python<'py>, part: fn(&gls::Components, usize) -> &[f64]) -> Floats<'py> {
        (0..self.0.terms()).flat_map(|term| part(&self.0, term)).copied().collect::<Vec<_>>().into_pyarray(py)
    }

    fn theta(&self, given: &[f64]) -> PyResult<Theta> {
        if given.len() != self.0.terms() {
            return Err(PyValueError::new_err(format!("{} terms, not {}", self.0.terms(), given.len())));
        }
        Ok(std::array::from_fn(|p| given.get(p).copied().unwrap_or(0.0)))
    }

    fn term(&self, term: usize) -> PyResult<usize> {
        (term < self.0.terms())
            .then_some(term)
            .ok_or_else(|| PyValueError::new_err(format!("no term {term}")))
    }

    fn terms(&self, given: &[usize]) -> PyResult<Terms> {
        given.iter().try_for_each(|&term| self.term(term).map(drop))?;
        Ok(Terms::of(given))
    }
}

/// The least squares problem of one curve.
#[pyclass(frozen, module = "sigmatau._core")]
pub struct Gls {
    parts: GlsComponents,
    gls: gls::Gls,
}

#[pymethods]
impl Gls {
    #[new]
    fn new(parts: &GlsComponents, avar: PyReadonlyArray1<'_, f64>, candidates: Vec<usize>) -> PyResult<Self> {
        let avar = avar.as_slice()?;
        let order = parts.0.base.sizes().len();
        if avar.len() != order {
            return Err(PyValueError::new_err(format!("{} variances at {order} cluster sizes", avar.len())));
        }
        let gls = gls::Gls::new(&parts.0, 0, avar, parts.terms(&candidates)?, None);
        Ok(Self { parts: GlsComponents(parts.0.clone()), gls })
    }

    /// Expected Allan variances for θ.
    fn expected<'py>(&self, py: Python<'py>, theta: Vec<f64>) -> PyResult<Floats<'py>> {
        Ok(self.gls.expectation(&self.parts.theta(&theta)?).into_pyarray(py))
    }

    fn covariance<'py>(&self, py: Python<'py>, theta: Vec<f64>) -> PyResult<Floats<'py>> {
        Ok(self.gls.covariance(&self.parts.theta(&theta)?).into_pyarray(py))
    }

    fn fit(&self, active: Option<Vec<usize>>, start: Option<Vec<f64>>) -> PyResult<Vec<f64>> {
        let active = active.map(|active| self.parts.terms(&active)).transpose()?;
        let start = start.map(|start| self.parts.theta(&start)).transpose()?;
        self.known(self.gls.fit(active, None, start.as_ref()))
    }

    fn covariance_of_theta<'py>(
        &self,
        py: Python<'py>,
        theta: Vec<f64>,
        active: Vec<usize>,
    ) -> PyResult<Floats<'py>> {
        let (theta, active) = (self.parts.theta(&theta)?, self.parts.terms(&active)?);
        Ok(self.gls.covariance_of_theta(&theta, active).map_err(failed)?.into_pyarray(py))
    }

    /// Probability of a larger estimate of a term than that of the curve if a trial value is true, the standard error and
    /// the skewness of the estimate, and its weights.
    fn score<'py>(&self, py: Python<'py>, term: usize, trial: f64) -> PyResult<(f64, f64, f64, Floats<'py>)> {
        let found = self.gls.score(self.parts.term(term)?, trial, None).map_err(failed)?;
        Ok((found.above, found.sigma, found.skewness, found.weights.into_pyarray(py)))
    }

    fn evidence(&self, term: usize, theta: Vec<f64>, level: f64) -> PyResult<(f64, f64, f64)> {
        let (term, theta) = (self.parts.term(term)?, self.parts.theta(&theta)?);
        let found = self.gls.evidence(term, &theta, level).map_err(failed)?;
        Ok((found.p_value, found.low, found.high))
    }

    fn p_value(&self, theta: Vec<f64>) -> PyResult<f64> {
        self.gls.p_value(&self.parts.theta(&theta)?).map_err(failed)
    }

    fn deviance(&self, theta: Vec<f64>) -> PyResult<f64> {
        self.gls.deviance(&self.parts.theta(&theta)?).map_err(failed)
    }

    /// Weights of the mean of the ramps with the smallest variance.
    fn ramp_weights<'py>(&self, py: Python<'py>, theta: Vec<f64>) -> PyResult<Floats<'py>> {
        let weights = self.gls.least_variance(&self.parts.theta(&theta)?).map_err(failed)?;
        Ok(weights.into_pyarray(py))
    }

    /// The problem after the removal of a ramp.
    fn without_ramp(
        &self,
        weights: PyReadonlyArray1<'_, f64>,
        ramps: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Self> {
        let (weights, ramps) = (weights.as_slice()?, ramps.as_slice()?);
        if weights.len() != self.gls.order() || ramps.len() != self.gls.order() {
            return Err(PyValueError::new_err("one weight and one ramp for each cluster size"));
        }
        Ok(Self { parts: GlsComponents(self.parts.0.clone()), gls: self.gls.without_ramp(weights, ramps) })
    }

    #[getter]
    fn avar<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.gls.variances().to_vec().into_pyarray(py)
    }
}

impl Gls {
    fn known(&self, theta: Result<Theta, Failed>) -> PyResult<Vec<f64>> {
        Ok(theta.map_err(failed)?[..self.parts.0.terms()].to_vec())
    }
}

/// Non-negative coefficients of columns, which are concatenated.
#[pyfunction]
pub fn non_negative<'py>(
    py: Python<'py>,
    columns: PyReadonlyArray1<'py, f64>,
    target: PyReadonlyArray1<'py, f64>,
) -> PyResult<Floats<'py>> {
    let (columns, target) = (columns.as_slice()?, target.as_slice()?);
    if target.is_empty() || columns.len() % target.len() != 0 {
        return Err(PyValueError::new_err("columns and target differ in length"));
    }
    let columns: Vec<&[f64]> = columns.chunks_exact(target.len()).collect();
    Ok(gls::non_negative(&columns, target).map_err(failed)?.into_pyarray(py))
}

frozen_class! {
    /// The fit of a curve.
    CurveFit from gls::CurveFit {
        /// Whether a model is adequate. Otherwise the coefficients of `model` describe the curve to a few per cent.
        adequate: bool,
        /// Index of the shortest averaging time that was used.
        first: usize,
        /// P-value of the goodness of fit; the largest of all models if none is adequate, None if no model could be fitted.
        p_value: Option<f64>,
        /// Whether a model was adequate, but its covariance is not positive definite.
        no_covariance: bool,
        /// Terms that were fitted, by name; none if no model is adequate. [SI]
        terms: Vec<(String, TermEstimate)>,
        /// Coefficients that together describe the curve, by name. [SI]
        model: Vec<(String, f64)>,
        /// Terms of which at least one is present, although none is significant given the others.
        unclear: Vec<String>,
        /// A Gauss-Markov process in place of a term.
        gauss_markov: Vec<GaussMarkovEstimate>,
        /// Names of the rows of `covariance`.
        parameters: Vec<Parameter>,
        /// Covariance of the coefficients of noise in row order. [SI]
        covariance: Vec<f64>,
        /// The averaging time with the largest difference from the model, if times were left out or no model is adequate:
        /// its index, and the measured deviation over that of the model.
        worst: Option<(usize, f64)>,
    }
}

/// The fit of a curve. `scale`: a typical variance. `digitising`: relative covariance of the errors of the variances from
/// reading a figure, in row order.
#[allow(clippy::too_many_arguments)] // one argument per part of the data
#[pyfunction]
#[pyo3(signature = (n, m, avar, ramps, *, tau0, scale, terms, first, level, digitising))]
pub fn fit_curve(
    py: Python<'_>,
    n: usize,
    m: PyReadonlyArray1<'_, i64>,
    avar: PyReadonlyArray1<'_, f64>,
    ramps: PyReadonlyArray1<'_, f64>,
    tau0: f64,
    scale: f64,
    terms: Vec<String>,
    first: Option<usize>,
    level: f64,
    digitising: Option<PyReadonlyArray1<'_, f64>>,
) -> PyResult<CurveFit> {
    let (sizes, avar, ramps) = (sizes(&m)?, avar.as_slice()?.to_vec(), ramps.as_slice()?.to_vec());
    if avar.len() != sizes.len() || ramps.len() != sizes.len() || first.unwrap_or(0) >= sizes.len() {
        return Err(PyValueError::new_err("sizes, variances and ramps differ in length"));
    }
    let digitising =
        digitising.map(|errors| Ok::<_, PyErr>(Arc::new(errors.as_slice()?.to_vec()))).transpose()?;
    if digitising.as_ref().is_some_and(|errors| errors.len() != sizes.len() * sizes.len()) {
        return Err(PyValueError::new_err("one error for each pair of sizes"));
    }
    let terms = terms.iter().map(|name| Ok(named_term(name)?.index())).collect::<PyResult<Vec<usize>>>()?;
    let noise: Vec<usize> = terms.iter().copied().filter(|&term| term < gls::LINEAR).collect();
    if noise.is_empty() {
        return Err(PyValueError::new_err("no noise term"));
    }
    let (candidates, with_ramp) = (Terms::of(&noise), noise.len() < terms.len());
    let fit = detached(py, || {
        let base = Base::new(n, &sizes)?;
        Ok(gls::Curve { base, tau0, avar, scale, ramps, candidates, with_ramp, first, digitising }.fit(level))
    });
    Ok(CurveFit::from_core(fit.map_err(|error| value_error(&error))?.map_err(failed)?))
}

fn failed(error: Failed) -> PyErr {
    PyFloatingPointError::new_err(error.to_string())
}
