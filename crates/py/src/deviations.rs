//! Deviations other than the Allan deviation, and their degrees of freedom.

use crate::allan::{error_in_channel, sizes, value_error};
use crate::pool::detached;
use crate::terms::in_order;
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use sigmatau_core::allan::Overlap;
use sigmatau_core::deviations::freedom::{self, Coefficients, Stationary};
use sigmatau_core::deviations::{self, Kind, quadratic};
use std::collections::HashMap;

type Floats<'py> = Bound<'py, PyArray1<f64>>;

fn kind_of(name: &str, overlapped: bool) -> PyResult<Kind> {
    let overlap = if overlapped { Overlap::Full } else { Overlap::None };
    match name {
        "modified" => Ok(Kind::Modified),
        "hadamard" => Ok(Kind::Hadamard(overlap)),
        "total" => Ok(Kind::Total),
        "parabolic" => Ok(Kind::Parabolic),
        "modified_total" => Ok(Kind::ModifiedTotal),
        "hadamard_total" => Ok(Kind::HadamardTotal),
        "theo1" => Ok(Kind::Theo1),
        "mtie" => Ok(Kind::Mtie),
        "tie_rms" => Ok(Kind::TieRms),
        _ => Err(PyValueError::new_err(format!("no estimator {name}"))),
    }
}

/// Smallest and largest cluster size for a record, and the smallest number of samples that has a cluster size.
#[pyfunction]
pub fn deviation_limits(kind: &str, samples: usize) -> PyResult<(usize, usize, usize)> {
    let kind = kind_of(kind, true)?;
    Ok((kind.smallest(), kind.largest(samples), kind.least_samples()))
}

#[pyfunction]
pub fn deviations_of_channels<'py>(
    py: Python<'py>,
    kind: &str,
    columns: Vec<PyReadonlyArray1<'py, f64>>,
    m: PyReadonlyArray1<'py, i64>,
    overlapped: bool,
    threads: usize,
) -> PyResult<(Vec<Floats<'py>>, Bound<'py, PyArray1<i64>>)> {
    let kind = kind_of(kind, overlapped)?;
    let columns = columns.iter().map(|c| c.as_slice()).collect::<Result<Vec<_>, _>>()?;
    let sizes = sizes(&m)?;
    let threads = (threads > 0).then_some(threads);
    let channels = detached(py, || deviations::deviations_of_channels(kind, &columns, &sizes, threads))
        .map_err(|error| error_in_channel(&columns, error))?;
    let terms: Vec<i64> = channels.first().into_iter().flatten().map(|d| d.terms as i64).collect();
    let by_channel = channels
        .iter()
        .map(|channel| channel.iter().map(|d| d.deviation).collect::<Vec<_>>().into_pyarray(py))
        .collect();
    Ok((by_channel, terms.into_pyarray(py)))
}

/// Expected variances and degrees of freedom for coefficients of all terms.
#[pyfunction]
pub fn stationary_moments<'py>(
    py: Python<'py>,
    kind: &str,
    overlapped: bool,
    samples: usize,
    m: PyReadonlyArray1<'py, i64>,
    coefficients: HashMap<String, f64>,
    tau0: f64,
) -> PyResult<(Floats<'py>, Floats<'py>)> {
    let overlap = if overlapped { Overlap::Full } else { Overlap::None };
    let kind = match kind {
        "allan" => Stationary::Allan(overlap),
        "modified" => Stationary::Modified,
        "hadamard" => Stationary::Hadamard(overlap),
        _ => return Err(PyValueError::new_err(format!("no stationary terms in {kind}"))),
    };
    let sizes = sizes(&m)?;
    let coefficients = Coefficients::at_interval(in_order(coefficients)?, tau0);
    let moments = detached(py, || freedom::moments(kind, samples, &sizes, &coefficients))
        .map_err(|error| value_error(&error))?;
    let of =
        |part: fn(&freedom::Moments) -> f64| moments.iter().map(part).collect::<Vec<_>>().into_pyarray(py);
    Ok((of(|moments| moments.variance), of(|moments| moments.edf)))
}

/// Degrees of freedom of an estimator without stationary terms.
#[pyfunction]
pub fn quadratic_edf<'py>(
    py: Python<'py>,
    kind: &str,
    samples: usize,
    m: PyReadonlyArray1<'py, i64>,
    coefficients: HashMap<String, f64>,
    tau0: f64,
) -> PyResult<Floats<'py>> {
    let kind = kind_of(kind, true)?;
    let sizes = sizes(&m)?;
    let coefficients = Coefficients::at_interval(in_order(coefficients)?, tau0);
    let edf = detached(py, || quadratic::degrees_of_freedom(kind, samples, &sizes, &coefficients))
        .map_err(|error| value_error(&error))?;
    Ok(edf.into_pyarray(py))
}

/// Expected Theo1 variances for coefficients of all terms.
#[pyfunction]
pub fn theo1_expectation<'py>(
    py: Python<'py>,
    m: PyReadonlyArray1<'py, i64>,
    coefficients: HashMap<String, f64>,
    tau0: f64,
) -> PyResult<Floats<'py>> {
    let sizes = sizes(&m)?;
    let coefficients = Coefficients::at_interval(in_order(coefficients)?, tau0);
    let expected: Vec<f64> =
        detached(py, || sizes.iter().map(|&m| freedom::theo1_expectation(m, &coefficients)).collect());
    Ok(expected.into_pyarray(py))
}

/// Expected variances of a total estimator over those of the estimator that it extends.
#[pyfunction]
pub fn total_bias<'py>(
    py: Python<'py>,
    kind: &str,
    m: PyReadonlyArray1<'py, i64>,
    coefficients: HashMap<String, f64>,
    tau0: f64,
) -> PyResult<Floats<'py>> {
    let kind = kind_of(kind, true)?;
    let sizes = sizes(&m)?;
    let coefficients = Coefficients::at_interval(in_order(coefficients)?, tau0);
    let bias =
        detached(py, || quadratic::bias(kind, &sizes, &coefficients)).map_err(|error| value_error(&error))?;
    Ok(bias.into_pyarray(py))
}
