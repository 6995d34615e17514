//! A fit for a given shortest averaging time, with or without a Gauss-Markov process.

use crate::gls::components::{Base, Components, Extra, Shape, process_avar};
use crate::gls::ramp::Ramp;
use crate::gls::step::{Gls, Work};
use crate::gls::{Failed, LINEAR, QUANTIZATION, Terms, Theta};
use std::sync::Arc;

/// Step of the logarithm of a correlation time, for a derivative.
const STEP: f64 = 1e-4;

/// The data of a fit, in samples and in a unit in which the variances are near 1.
#[derive(Debug, Clone)]
pub struct Data {
    /// The noise terms at the averaging times.
    pub base: Arc<Base>,
    /// Allan variances.
    pub avar: Vec<f64>,
    /// Ramps per sample from the mean second differences.
    pub ramps: Vec<f64>,
    /// Noise terms that are fitted.
    pub candidates: Terms,
    /// Whether a ramp is fitted.
    pub with_ramp: bool,
    /// Index of the shortest averaging time, if it is given.
    pub first: Option<usize>,
    /// Relative covariance of the errors of the variances from reading a figure, in row order.
    pub digitising: Option<Arc<Vec<f64>>>,
}

impl Data {
    /// The data at some of the averaging times.
    pub(crate) fn at_sizes(&self, indices: &[usize]) -> Self {
        let values = |all: &[f64]| indices.iter().map(|&k| all[k]).collect();
        Self {
            base: Arc::new(self.base.at_sizes(indices)),
            avar: values(&self.avar),
            ramps: values(&self.ramps),
            first: None,
            digitising: self.digitising.as_ref().map(|errors| {
                let rows = indices.iter().map(|&k| &errors[k * self.avar.len()..]);
                Arc::new(rows.flat_map(|row| indices.iter().map(|&k| row[k])).collect())
            }),
            ..self.clone()
        }
    }

    pub(crate) fn sizes(&self) -> &[usize] {
        self.base.sizes()
    }

    /// Components at all averaging times; `time`: correlation time of a Gauss-Markov process. \[samples\]
    pub(crate) fn parts(&self, time: Option<f64>) -> Result<Components, Failed> {
        let extra = time.map(|time| Extra::new(&self.base, Shape::GaussMarkov(time))).transpose();
        Ok(Components { base: Arc::clone(&self.base), extra: extra.map_err(|_| Failed)? })
    }

    /// The least squares problem for averaging times from number `first`.
    pub(crate) fn gls(&self, first: usize, time: Option<f64>) -> Result<Gls, Failed> {
        let candidates = if time.is_some() { self.candidates.with(LINEAR) } else { self.candidates };
        let gls = Gls::new(&self.parts(time)?, first, &self.avar[first..], candidates, None);
        Ok(Gls { digitising: self.digitising.clone(), ..gls })
    }

    /// Derivative of the variances of a process of variance 1 by the logarithm of its correlation time. \[samples\]
    pub(crate) fn by_time(&self, first: usize, time: f64) -> Vec<f64> {
        let at = |step: f64| process_avar(&self.sizes()[first..], time * step.exp());
        at(STEP).iter().zip(at(-STEP)).map(|(after, before)| (after - before) / (2.0 * STEP)).collect()
    }

    /// Whether quantization noise of θ exceeds a variance before size number `first`.
    pub(crate) fn exceeded_by_quantization(&self, first: usize, theta: f64) -> bool {
        let parts = Components { base: Arc::clone(&self.base), extra: None };
        let expected = parts.design(QUANTIZATION);
        expected.iter().zip(&self.avar).take(first).any(|(design, avar)| theta * design > *avar)
    }
}

/// The best θ for averaging times from number `first`, with its goodness of fit.
#[derive(Debug, Clone)]
pub(crate) struct Attempt {
    /// Index of the shortest averaging time.
    pub first: usize,
    /// The least squares problem, with the ramp removed if it is significant.
    pub gls: Gls,
    pub theta: Theta,
    /// P-value of the goodness of fit.
    pub p_value: f64,
    pub ramp: Option<Ramp>,
    /// The problem with the ramp removed, significant or not, and its θ.
    pub ramp_removed: Option<(Gls, Theta)>,
    /// Correlation time of the Gauss-Markov process. \[samples\]
    pub time: Option<f64>,
}

impl Attempt {
    /// If the shortest averaging times were left out: the index of the time with the largest difference, and the ratio of
    /// the measured to the expected deviation.
    pub(crate) fn left_out(&self, data: &Data) -> Option<(usize, f64)> {
        if self.first == 0 || data.first.is_some() {
            return None;
        }
        let slope = self.ramp.map_or(0.0, |ramp| ramp.used);
        let parts = &self.gls.parts;
        let ratio = |k: usize| {
            let noise: f64 = (0..parts.terms()).map(|term| self.theta[term] * parts.design(term)[k]).sum();
            (data.avar[k] / (noise + 0.5 * slope * slope * data.base.squares()[k])).sqrt()
        };
        largest((0..self.first).map(|k| (k, ratio(k), ratio(k).ln().abs())))
    }
}

/// The number and the ratio of the entry with the largest size, the first of equal ones.
pub(crate) fn largest(ratios: impl Iterator<Item = (usize, f64, f64)>) -> Option<(usize, f64)> {
    let better = |best: (usize, f64, f64), one: (usize, f64, f64)| if one.2 > best.2 { one } else { best };
    ratios.reduce(better).map(|(k, ratio, _)| (k, ratio))
}

/// The fit for averaging times from number `first`; None if it fails.
pub(crate) fn attempt(
    data: &Data,
    first: usize,
    level: f64,
    time: Option<f64>,
    work: &mut Work,
) -> Option<Attempt> {
    let found = with_candidates(data, first, level, time, work).ok()?;
    // Quantization noise that exceeds the measured variance at the times left out is not quantization noise. The other
    // terms may exceed it, because they may be filtered there.
    if !data.exceeded_by_quantization(first, found.theta[QUANTIZATION]) {
        return Some(found);
    }
    let others = Data { candidates: data.candidates.without(QUANTIZATION), ..data.clone() };
    if others.candidates.is_empty() {
        return None;
    }
    with_candidates(&others, first, level, time, work).ok()
}

fn with_candidates(
    data: &Data,
    first: usize,
    level: f64,
    time: Option<f64>,
    work: &mut Work,
) -> Result<Attempt, Failed> {
    let mut gls = data.gls(first, time)?;
    let mut theta = gls.fit_in(gls.candidates, None, None, work)?;
    if let Some(time) = time {
        let size = theta[LINEAR];
        gls.tangent = Some(data.by_time(first, time).iter().map(|x| size * x).collect());
    }
    let (mut ramp, mut ramp_removed) = (None, None);
    if data.with_ramp {
        let (found, without, theta_without) = gls.ramp(&theta, &data.ramps[first..], level, work)?;
        if found.used != 0.0 {
            gls.clone_from(&without);
            theta = theta_without;
        }
        (ramp, ramp_removed) = (Some(found), Some((without, theta_without)));
    }
    let p_value = gls.p_value_in(&theta, work)?;
    Ok(Attempt { first, gls, theta, p_value, ramp, ramp_removed, time })
}
