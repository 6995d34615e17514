//! Least squares on Allan variances: the fit of a curve, and its parts for planning and tests.

use crate::allan::{sizes, value_error};
use crate::pool::detached;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyFloatingPointError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sigmatau_core::gls::{self, Base, Data, Described, Failed, Found, Outcome, Shape, Terms, Theta};

type Floats<'py> = Bound<'py, PyArray1<f64>>;

/// Terms of a record of some length at some cluster sizes.
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

    /// Expected Allan variances for θ = 1, a row a term.
    fn design<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::design)
    }

    /// Covariance of the ramps for θ = 1, a matrix a term.
    fn slopes<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::slopes)
    }

    /// Power of the modes for θ = 1, over n; a row a term.
    fn spectra<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.of_terms(py, gls::Components::spectrum)
    }

    /// Number of modes that each represents.
    fn modes<'py>(&self, py: Python<'py>) -> Floats<'py> {
        self.0.base.modes().to_vec().into_pyarray(py)
    }

    fn degrees_of_freedom<'py>(&self, py: Python<'py>, theta: Vec<f64>, ramp: f64) -> PyResult<Floats<'py>> {
        Ok(self.0.degrees_of_freedom(0, &self.theta(&theta)?, ramp).into_pyarray(py))
    }

    /// The smallest θ of a term that a test finds with a probability.
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

    /// The ramp per sample that a test finds with a probability.
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

    /// Weights of the ramps whose mean has the smallest variance.
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

/// Non-negative coefficients of columns, given one after the other.
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

/// The fit of a curve, in samples; θ are squared coefficients.
#[allow(clippy::too_many_arguments)] // one for each part of the data
#[pyfunction]
pub fn fit_curve<'py>(
    py: Python<'py>,
    n: usize,
    m: PyReadonlyArray1<'py, i64>,
    avar: PyReadonlyArray1<'py, f64>,
    ramps: PyReadonlyArray1<'py, f64>,
    candidates: Vec<usize>,
    with_ramp: bool,
    first: Option<usize>,
    level: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let (sizes, avar, ramps) = (sizes(&m)?, avar.as_slice()?.to_vec(), ramps.as_slice()?.to_vec());
    if avar.len() != sizes.len() || ramps.len() != sizes.len() || first.unwrap_or(0) >= sizes.len() {
        return Err(PyValueError::new_err("sizes, variances and ramps differ in length"));
    }
    if candidates.is_empty() || candidates.iter().any(|&term| term >= gls::LINEAR) {
        return Err(PyValueError::new_err("no noise term"));
    }
    let candidates = Terms::of(&candidates);
    let found = detached(py, || {
        let base = Base::new(n, &sizes)?;
        Ok(gls::fit(&Data { base, avar, ramps, candidates, with_ramp, first }, level))
    });
    match found.map_err(|error| value_error(&error))?.map_err(failed)? {
        Outcome::Found(found) => stated(py, &found),
        Outcome::Described(found) => described(py, &found),
    }
}

fn stated<'py>(py: Python<'py>, found: &Found) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("first", found.first)?;
    result.set_item("p_value", found.p_value)?;
    result.set_item("evidence", found.evidence.map(|e| e.map(|e| (e.p_value, e.low, e.high))))?;
    result.set_item("observed", numbers(found.observed))?;
    result.set_item("unclear", found.unclear.map(numbers))?;
    result.set_item("theta", found.theta)?;
    result.set_item("covariance", found.covariance.clone())?;
    result.set_item("ramp", found.ramp.map(|r| (r.value, r.half_width, r.p_value, r.undecided)))?;
    result.set_item("process", found.process)?;
    result.set_item("left_out", found.left_out)?;
    Ok(result)
}

fn described<'py>(py: Python<'py>, found: &Described) -> PyResult<Bound<'py, PyDict>> {
    let result = PyDict::new(py);
    result.set_item("first", found.first)?;
    result.set_item("p_value", found.p_value)?;
    result.set_item("no_covariance", found.no_covariance)?;
    result.set_item("theta", found.theta)?;
    result.set_item("needed", numbers(found.needed))?;
    result.set_item("worst", found.worst)?;
    Ok(result)
}

fn numbers(terms: Terms) -> Vec<usize> {
    terms.iter().collect()
}

fn failed(error: Failed) -> PyErr {
    PyFloatingPointError::new_err(error.to_string())
}
