//! Closed forms for arrays.

use crate::allan::sizes;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sigmatau_core::bandlimited::{self, Filter};
use sigmatau_core::matern;
use sigmatau_core::psd;
use sigmatau_core::resonance::Resonance;
use sigmatau_core::terms::{self, Term};

type Floats<'py> = PyResult<Bound<'py, PyArray1<f64>>>;

/// The term with a name.
pub fn named_term(name: &str) -> PyResult<Term> {
    Term::from_name(name).ok_or_else(|| PyValueError::new_err(format!("unknown term {name}")))
}

/// Puts coefficients by name into the order of [`Term::ALL`]; a missing one is 0.
pub fn in_order(by_name: impl IntoIterator<Item = (String, f64)>) -> PyResult<[f64; Term::ALL.len()]> {
    let mut coefficients = [0.0; Term::ALL.len()];
    for (name, value) in by_name {
        coefficients[named_term(&name)?.index()] = value;
    }
    Ok(coefficients)
}

#[pyfunction]
pub fn term_avar<'py>(
    py: Python<'py>,
    term: &str,
    coefficient: f64,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
    cutoff: Option<f64>,
    averaged: bool,
) -> Floats<'py> {
    let c = coefficient;
    let form: Box<dyn Fn(usize) -> f64> = match (named_term(term)?, cutoff, averaged) {
        (term, None, false) => Box::new(move |m| term.avar(c, tau0, m)),
        (Term::BiasInstability, Some(f0), false) => {
            Box::new(move |m| terms::bias_instability_avar_cutoff(c, f0, m as f64 * tau0))
        }
        (Term::RateRandomWalk, None, true) => {
            Box::new(move |m| terms::rate_random_walk_avar_averaged(c, m as f64 * tau0))
        }
        _ => {
            return Err(PyValueError::new_err(format!(
                "{term} has no form with cutoff = {cutoff:?}, averaged = {averaged}"
            )));
        }
    };
    Ok(sizes(&m)?.into_iter().map(form).collect::<Vec<_>>().into_pyarray(py))
}

#[pyfunction]
pub fn term_psd<'py>(
    py: Python<'py>,
    term: &str,
    coefficient: f64,
    f: PyReadonlyArray1<'py, f64>,
    tau0: Option<f64>,
) -> Floats<'py> {
    let c = coefficient;
    let form: Box<dyn Fn(f64) -> f64> = match (named_term(term)?, tau0) {
        (term, Some(tau0)) => Box::new(move |f| term.psd(c, tau0, f)),
        (Term::Quantization, None) => {
            return Err(PyValueError::new_err(
                "the spectrum of quantization noise needs the sample interval tau0",
            ));
        }
        (Term::RandomWalk, None) => Box::new(move |_| psd::random_walk(c)),
        (Term::BiasInstability, None) => Box::new(move |f| psd::bias_instability(c, None, f)),
        (Term::RateRandomWalk, None) => Box::new(move |f| psd::rate_random_walk(c, f)),
        (Term::RateRamp, None) => Box::new(move |f| psd::rate_ramp(c, f)),
    };
    Ok(f.as_slice()?.iter().copied().map(form).collect::<Vec<_>>().into_pyarray(py))
}

#[pyfunction]
pub fn gauss_markov_avar<'py>(
    py: Python<'py>,
    sigma: f64,
    time: f64,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
    averaged: bool,
) -> Floats<'py> {
    let form = |m: usize| {
        if averaged {
            terms::gauss_markov_avar_averaged(sigma, time, m as f64 * tau0)
        } else {
            terms::gauss_markov_avar_sampled(sigma, time, tau0, m)
        }
    };
    Ok(sizes(&m)?.into_iter().map(form).collect::<Vec<_>>().into_pyarray(py))
}

#[pyfunction]
pub fn sinusoid_avar<'py>(
    py: Python<'py>,
    amplitude: f64,
    frequency: f64,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
) -> Floats<'py> {
    let form = |m: usize| terms::sinusoid_avar(amplitude, frequency, tau0, m);
    Ok(sizes(&m)?.into_iter().map(form).collect::<Vec<_>>().into_pyarray(py))
}

#[pyfunction]
pub fn band_limited_avar<'py>(
    py: Python<'py>,
    random_walk: f64,
    shape: &str,
    corner: f64,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
) -> Floats<'py> {
    let filter = match (shape, order_of(shape)) {
        (_, Some(order)) => Filter::Butterworth(order),
        ("brick_wall", _) => Filter::BrickWall,
        _ => return Err(PyValueError::new_err(format!("unknown filter {shape}"))),
    };
    let sizes = sizes(&m)?;
    let avar = py.detach(|| bandlimited::band_limited_avar(random_walk, filter, corner, tau0, &sizes));
    Ok(avar.into_pyarray(py))
}

/// Order of `butterworth1` … `butterworth9`; `first_order` is the same as `butterworth1`.
fn order_of(shape: &str) -> Option<u8> {
    if shape == "first_order" {
        return Some(1);
    }
    shape.strip_prefix("butterworth")?.parse().ok().filter(|order| (1..10).contains(order))
}

/// The Matérn process of unit variance as a sum of Gauss-Markov processes: variances and correlation times in samples.
#[pyfunction]
#[allow(clippy::type_complexity)] // two columns
pub fn matern_processes(
    py: Python<'_>,
    smoothness: f64,
    time: f64,
    step: f64,
) -> (Bound<'_, PyArray1<f64>>, Bound<'_, PyArray1<f64>>) {
    let (variances, times): (Vec<f64>, Vec<f64>) =
        matern::processes(smoothness, time, step).into_iter().unzip();
    (variances.into_pyarray(py), times.into_pyarray(py))
}

#[pyfunction]
pub fn gauss_markov_psd<'py>(
    py: Python<'py>,
    sigma: f64,
    time: f64,
    f: PyReadonlyArray1<'py, f64>,
    tau0: Option<f64>,
) -> Floats<'py> {
    let form = |&f: &f64| match tau0 {
        Some(tau0) => psd::gauss_markov_sampled(sigma, time, tau0, f),
        None => psd::gauss_markov(sigma, time, f),
    };
    Ok(f.as_slice()?.iter().map(form).collect::<Vec<_>>().into_pyarray(py))
}

#[pyfunction]
pub fn band_limited_psd<'py>(
    py: Python<'py>,
    random_walk: f64,
    order: u8,
    corner: f64,
    f: PyReadonlyArray1<'py, f64>,
    tau0: Option<f64>,
) -> Floats<'py> {
    let form = |&f: &f64| match tau0 {
        Some(tau0) => psd::band_limited_sampled(random_walk, order, corner, tau0, f),
        None => psd::band_limited(random_walk, Filter::Butterworth(order), corner, f),
    };
    Ok(f.as_slice()?.iter().map(form).collect::<Vec<_>>().into_pyarray(py))
}

/// Allan variances of a resonance: of its samples, or without the part that sampling folds from above half the rate.
#[pyfunction]
pub fn resonance_avar<'py>(
    py: Python<'py>,
    sigma: f64,
    frequency: f64,
    width: f64,
    m: PyReadonlyArray1<'py, i64>,
    tau0: f64,
    folded: bool,
) -> Floats<'py> {
    let (band, sizes) = (Resonance { sigma, frequency, width }, sizes(&m)?);
    let avar = if folded {
        sizes.into_iter().map(|m| band.avar_sampled(tau0, m)).collect()
    } else {
        py.detach(|| band.avar_unfolded(tau0, &sizes))
    };
    Ok(avar.into_pyarray(py))
}

#[pyfunction]
pub fn resonance_psd<'py>(
    py: Python<'py>,
    sigma: f64,
    frequency: f64,
    width: f64,
    f: PyReadonlyArray1<'py, f64>,
) -> Floats<'py> {
    let band = Resonance { sigma, frequency, width };
    Ok(f.as_slice()?.iter().map(|&f| band.psd(f)).collect::<Vec<_>>().into_pyarray(py))
}

/// Whether sampling a resonance adds to the white noise at low frequencies.
#[pyfunction]
pub fn resonance_folds(sigma: f64, frequency: f64, width: f64, tau0: f64, random_walk: f64) -> bool {
    Resonance { sigma, frequency, width }.folds(tau0, random_walk)
}
